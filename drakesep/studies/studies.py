"""The studies that users ask for: simulate, worst case, verify."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.objectives import AnyObjective
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.analysis.search.problem import OnProgress as Tell
from drakesep.analysis.search.problem import Problem
from drakesep.case_file.case import Case
from drakesep.case_file.objectives import choose_objectives, the_clearance
from drakesep.case_file.reader import analysis_case_of
from drakesep.case_file.values import values_in_si
from drakesep.studies.clearance import Clearances, check_geometry
from drakesep.studies.output import writable_folder
from drakesep.studies.verification import Verification
from drakesep.studies.worst_case.procedure import DRAKE, OnProgress, search
from drakesep.studies.worst_case.result import WorstCases
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run
from drakesep.systems.simulation.simulation import Simulation
from drakesep.tables.columns import write_csv
from drakesep.tables.contact_tables import contact_forces_table, contacts_table
from drakesep.tables.labelled_run import NOMINAL, LabelledRun, labelled_run
from drakesep.tables.run_tables import motion_table, runs_table


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """One run of a case."""

    case: AnalysisCase
    labelled: LabelledRun
    values: Mapping[str, float]
    """What was changed, by parameter name with unit."""

    @property
    def run(self) -> Run:
        """The run itself."""
        return self.labelled.run

    @functools.cached_property
    def summary(self) -> pd.DataFrame:
        """One row, as in `WorstCases.table`, with what was changed."""
        names = (*self.case.box.names, *values_in_si(self.case.separation, self.values))
        return runs_table([self.labelled], list(dict.fromkeys(names)))

    @functools.cached_property
    def motion(self) -> pd.DataFrame:
        """The motion over time; empty if the run failed."""
        motion = self.run.motion
        return pd.DataFrame() if motion is None else motion_table(motion)

    @property
    def contacts(self) -> pd.DataFrame:
        """A row for each contact after separation, if the case has recontact."""
        return contacts_table(self.run)

    @property
    def completed(self) -> bool:
        """Whether the run did not fail."""
        return self.run.motion is not None

    def save(self, directory: str | Path) -> None:
        """Write the tables and plots into a folder."""
        folder = writable_folder(directory)
        for name in ("contacts.csv", "contact_forces.csv"):  # of an earlier run
            (folder / name).unlink(missing_ok=True)
        write_csv(self.summary, folder / "summary.csv")
        if self.completed:
            write_csv(self.motion, folder / "motion.csv")
            if self.run.separation.recontact is not None:
                write_csv(self.contacts, folder / "contacts.csv")
                forces = contact_forces_table(self.run)
                write_csv(forces, folder / "contact_forces.csv")
            # Half a second to import, where something is drawn.
            from drakesep.plots.motion import save_motion

            save_motion([self.labelled], self.case.requirements, folder)


def simulate(
    case: Case | AnalysisCase | str | Path, values: Mapping[str, float] | None = None
) -> Simulated:
    """Fly a case once.

    Args:
        case: a case, a case file, or the name of a built-in case.
        values: new values by parameter name with unit, ``payload.mass_kg``.

    Raises:
        ValueError: the case or a value is wrong.
    """
    case = analysis_case_of(case)
    run = Simulation(case.separation, case.integration).run(
        values_in_si(case.separation, values or {})
    )
    label = "run" if values else NOMINAL
    return Simulated(
        case=case, labelled=labelled_run(label, run, case), values=values or {}
    )


def clearance(
    case: Case | AnalysisCase | str | Path, values: Mapping[str, float] | None = None
) -> Clearances:
    """Fly a case once, and measure how near its bodies' geometry comes.

    Args:
        case: a case, a case file, or the name of a built-in case.
        values: new values by parameter name with unit, ``payload.mass_kg``.

    Raises:
        ValueError: the case or a value is wrong, no two bodies have geometry, or some
            of it overlaps while mated.
        RuntimeError: the run fails.
    """
    case = analysis_case_of(case)
    check_geometry(case)
    run = Simulation(case.separation, case.integration).run(
        values_in_si(case.separation, values or {})
    )
    if run.motion is None:
        raise RuntimeError(f"the run failed: {run.message}")
    study = Clearances(case=case, run=run, values=values or {})
    _ = study.found
    return study


def animate(
    case: Case | AnalysisCase | str | Path,
    runs: Mapping[str, Mapping[str, float]] | None = None,
    *,
    output: str | Path,
) -> list[str]:
    """Write an HTML page that animates runs of a case, to be opened in a browser.

    Args:
        case: a case, a case file, or the name of a built-in case.
        runs: values by parameter name with unit, by the runs' labels; they are shown
            after the nominal run. The published ones if None.
        output: the file.

    Returns:
        The labels of the runs that it shows.

    Raises:
        ValueError: the case or a value is wrong, or no two bodies have geometry.
        RuntimeError: a run fails.
    """
    case = analysis_case_of(case)
    check_geometry(case)
    simulation = Simulation(case.separation, case.integration)
    values: dict[str, Mapping[str, float]] = {NOMINAL: {}}
    values |= (
        {p.label: p.values for p in case.published}
        if runs is None
        else {label: values_in_si(case.separation, run) for label, run in runs.items()}
    )
    flown = {label: simulation.run(run) for label, run in values.items()}
    from drakesep.plots.animation import animation

    chosen, separation = case.clearance, case.separation
    page = animation(
        flown,
        chosen.pairs,
        touching=chosen.touching,
        title=f"{case.name}: separation of {separation.B} from {separation.A}",
    )
    file = Path(output)
    writable_folder(file.parent)
    file.write_text(page, encoding="utf-8")
    return list(flown)


def worst_case(
    case: Case | AnalysisCase | str | Path,
    objectives: Sequence[AnyObjective] | AnyObjective | None = None,
    *,
    searches: Sequence[str] | None = None,
    output: str | Path | None = None,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
    **effort: Unpack[Effort],
) -> WorstCases:
    """Find the worst cases of a case over its tolerances.

    Args:
        case: a case, a case file, or the name of a built-in case.
        objectives: names (see `case_objectives`), objectives, or functions of a run;
            the paper's and those of the requirements if None.
        searches: names out of `SEARCHES`, in the order in which they go; or
            ``["drake"]``, which flies Drake alone; `default_searches` if None.
        output: folder that receives the tables as the study goes on.
        workers: number of processes that fly Drake; one per core if None; with 1, the
            caller's does all.
        on_progress: called as the study goes on.
        effort: `starts`, `samples`, `vertices`, `generations` and `seed` of
            `SearchSettings`; the length of a run decides what is left out.

    Raises:
        ValueError: the case, an objective or a search is wrong, or the folder cannot
            be written.
        RuntimeError: the nominal run fails.
    """
    study = WorstCases(case=analysis_case_of(case))
    if not study.case.tolerances:
        raise InputError("dispersions: a worst case needs some, got none")
    folder = None if output is None else writable_folder(output)
    search(
        study,
        choose_objectives(study.case, objectives),
        searches=searches,
        effort=effort,
        output=folder,
        workers=workers,
        on_progress=on_progress,
    )
    return study


def verify(
    case: Case | AnalysisCase | str | Path,
    *,
    searches: Sequence[str] | None = None,
    growth: bool | None = None,
    output: str | Path | None = None,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
    **effort: Unpack[Effort],
) -> Verification:
    """Find every worst case of a case and hold them against its requirements.

    Args:
        case: a case, a case file, or the name of a built-in case.
        searches: as `worst_case` takes them.
        growth: whether to find how far tolerances may grow; None: unless Drake flies
            alone or its nominal run takes more than 2000 steps.
        output: folder that receives tables and plots, tables as the study goes on.
        workers: number of processes that fly Drake; one per core if None; with 1, the
            caller's does all.
        on_progress: called as the study goes on.
        effort: `starts`, `samples`, `vertices`, `generations`, `corners` and `seed` of
            `SearchSettings`; the length of a run decides what is left out.

    Raises:
        ValueError: the case is wrong or has no requirement, a search is wrong, or the
            folder cannot be written.
        RuntimeError: the nominal run fails.
    """
    study = Verification(case=analysis_case_of(case))
    if not study.case.requirements:
        raise InputError("requirements: a case to verify must have some, got none")
    folder = None if output is None else writable_folder(output)
    objectives = choose_objectives(study.case, None)
    study.clearance = the_clearance(objectives)

    def grow(problem: Problem, settings: SearchSettings, tell: Tell) -> None:
        light = DRAKE not in (searches or ()) and study.runs[0].run.steps <= _GROWABLE
        if growth or (growth is None and light):
            study.find_growths(problem, settings, tell)

    search(
        study,
        # Without dispersions, the nominal and the published runs are all there is.
        objectives if study.case.tolerances else (),
        searches=searches,
        effort=effort,
        output=folder,
        workers=workers,
        on_progress=on_progress,
        afterwards=grow,
    )
    return study


_GROWABLE = 2000
"""Steps of the nominal run in Drake up to which growth is looked for unasked."""
