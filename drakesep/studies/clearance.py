"""The study of how near bodies come to each other: tables, plot, verdict."""

import functools
import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.clearance.of_run import PARTED, ClearanceAnalysis
from drakesep.case_file.case import Case
from drakesep.case_file.values import values_in_si
from drakesep.plots.approach import Curve
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import CLEARANCE
from drakesep.results.folder import Output, ResultsFolder, begun
from drakesep.results.recorded_runs import save_runs
from drakesep.studies.remarks import Remark, remarks, save_remarks
from drakesep.studies.saved import SavedStudy
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.part_pairs import Names, owners_of
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair, Separation, leaving_among
from drakesep.systems.simulation.shared_simulation import shared_simulation
from drakesep.tables.columns import in_units, write_csv
from drakesep.tables.labelled_run import LabelledRun, measured
from drakesep.tables.roles import Changed, Nominal
from drakesep.units import unit_of, with_unit


@dataclass(frozen=True, kw_only=True)
class Clearances(SavedStudy):
    """How near the parts of a case come in one run."""

    asked: Asked = field(repr=False)
    """With the case."""
    labelled: LabelledRun
    """The run, with its metrics."""
    values: Mapping[str, float]
    """What was changed, by parameter name with unit."""

    analysis: ClearanceAnalysis = field(repr=False)
    """That has measured it."""
    found: tuple[Clearance, ...]
    """The smallest distance of each pair, over continuous time."""

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.asked.case

    @property
    def run(self) -> Run:
        """The run itself."""
        return self.labelled.run

    @functools.cached_property
    def distances(self) -> Array:
        """(n, k) of each of the k pairs at the n sample times, m."""
        return self.analysis.over_time(self.run)

    @functools.cached_property
    def separations(self) -> dict[str, Array]:
        """(n,) how far each body that leaves has moved in its direction, m.

        By its origin, as seen from the body that it leaves.
        """
        return {p.B: self._moved(p, self._time) for p in self.run.separation.pairs}

    @property
    def _time(self) -> Array:
        return self.run.completed_trajectory.time

    def _moved(self, pair: Pair, times: Array) -> Array:
        return self._paths[pair.B].moved(times, pair.direction)

    @functools.cached_property
    def _paths(self) -> dict[str, RelativePath]:
        flown = self.run.completed_trajectory
        return {p.B: RelativePath(flown, p.A, p.B) for p in self.run.separation.pairs}

    def _leaving(self, one: Clearance) -> Pair:
        """Return by which pair it is said how far the bodies of two parts moved."""
        bodies = owners_of(self.run.separation)
        ends = bodies[one.first], bodies[one.second]
        return leaving_among(self.run.separation.pairs, ends)

    @property
    def over_time(self) -> pd.DataFrame:
        """A row for each sample time: how near each pair is."""
        mm = unit_of("clearance")
        columns = {with_unit("time"): self._time}
        for body, moved in self.separations.items():
            of = "" if body == self.run.separation.B else f"{body}."
            columns[f"{of}{with_unit('separation')}"] = moved * mm.per_si
        for (a, b), distances in zip(
            self.analysis.names, self.distances.T, strict=True
        ):
            columns[f"{a}_to_{b}_{mm.suffix}"] = distances * mm.per_si
        return pd.DataFrame(columns)

    @property
    def summary(self) -> pd.DataFrame:
        """A row for each pair, the nearest first: how near it comes, when and where."""
        bodies = owners_of(self.run.separation)
        roles = {e.name: e.role for b in self.run.separation.bodies for e in b.parts}
        rows = []
        touching = set(map(frozenset, self.case.clearance.touching))

        touched = dict(
            zip(self.analysis.names, self.distances[0] <= PARTED, strict=True)
        )

        def parted(one: Clearance) -> bool:
            names = (one.first, one.second)
            return frozenset(names) in touching and bool(touched[names])

        # Of those the distance only says that they have left each other.
        for one in sorted(self.found, key=lambda one: (parted(one), one.minimum)):
            row: dict[str, object] = {}
            for side, name in (("first", one.first), ("second", one.second)):
                row |= {
                    side: name,
                    f"{side}_body": bodies[name],
                    f"{side}_role": roles[name],
                }
            at = {
                "clearance": one.minimum,
                "time": one.time,
                "separation": float(
                    self._moved(self._leaving(one), np.array([one.time]))[0]
                ),
            }
            for side, point in (("first", one.p_AoCa_A), ("second", one.p_BoCb_B)):
                for axis, x in zip("xyz", point, strict=True):
                    at[f"{side}_position_{axis}"] = x
            touch = one.contact
            at["contact_time"] = np.nan if touch is None else touch.time
            at["closing_speed"] = np.nan if touch is None else touch.closing_speed
            row |= in_units(at)
            left = "parted" if parted(one) else "clear"
            row["status"] = left if touch is None else "contact"
            rows.append(row)
        return pd.DataFrame(rows)

    @property
    def remarks(self) -> list[Remark]:
        """What should be told of the run."""
        return remarks({self.labelled.label: self.run})

    @property
    def clear(self) -> bool:
        """Whether nothing touches."""
        return all(one.contact is None for one in self.found)

    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
        # Half a second to import, where it is drawn.
        from drakesep.plots.clearance_plots import save_clearance
        from drakesep.plots.swept_volume import save_swept

        folder = results.path
        save_runs([self.labelled], self.case.separation, folder)
        results.keep([self.labelled.label])
        save_remarks(self.remarks, folder)
        write_csv(self.summary, folder / "clearance_summary.csv")
        write_csv(self.over_time, folder / "clearance.csv")
        save_clearance(self._time, self._curves, folder)
        save_swept(self.run, self.analysis.names, folder)
        results.end(verdict="clear" if self.clear else "contact")

    @property
    def _curves(self) -> dict[str, Curve]:
        """How near parts are, by the name of the pair."""
        return {
            one.pair: Curve(self.separations[self._leaving(one).B], distances, one)
            for one, distances in zip(self.found, self.distances.T, strict=True)
        }


@typed
def clearance(
    case: Case | AnalysisCase | str | Path,
    values: Mapping[str, float] | None = None,
    *,
    output: Output | None = None,
    on_progress: Callable[[str], None] | None = None,
) -> Clearances:
    """Fly a case once, and measure how near its bodies' geometry comes.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        values: new values by parameter name with unit, ``payload.mass_kg``.
        output: folder that receives tables and plots.
        on_progress: told in words of each step before it is done.

    Raises:
        ValueError: the case or a value is wrong, no two bodies have geometry, some of
            it overlaps while mated, or the folder cannot be written.
        RuntimeError: the run fails.
    """
    asked = Asked.of(CLEARANCE, case, {"values": values})
    case, values = asked.case, values or {}
    check_geometry(case.separation)
    changed = values_in_si(case.separation, values)
    flown = with_values(case.separation, changed)
    of = case.clearance
    tell = on_progress or (lambda step: None)
    tell("cutting parts into convex pieces")
    analysis = ClearanceAnalysis(flown, of.pairs, touching=of.touching)
    tell("measuring parts while mated")
    analysis.check_apart()
    measured_pairs = itertools.count(1)

    def on_pair(names: Names) -> None:
        first, second = names
        which = f"pair {next(measured_pairs)} of {len(analysis.names)}"
        tell(f"measuring {first} to {second}, {which}")

    with begun(output, asked) as folder:  # what is refused leaves it alone
        tell("flying")
        run = shared_simulation(case.separation, case.integration).run(changed)
        if run.motion is None:
            raise RuntimeError(f"the run failed: {run.message}")
        role = Changed() if values else Nominal()
        study = Clearances(
            labelled=measured(role, run, case),
            values=values,
            analysis=analysis,
            found=tuple(analysis.of(run, on_pair=on_pair)),
            asked=asked.over(),
        )
        if folder is not None:
            tell("measuring at the sample times of the run, and drawing")
            study.write(folder)
    return study


def check_geometry(separation: Separation) -> None:
    """Raise InputError unless two bodies of a separation have geometry."""
    if len({*owners_of(separation).values()}) < 2:
        raise InputError("bodies: a clearance needs geometry on two of them")
