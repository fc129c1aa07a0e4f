"""The studies that users ask for: simulate, worst case, verify."""

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from drakesep import figures, tables
from drakesep.analysis.fleet import Fleet
from drakesep.analysis.metrics import metrics
from drakesep.analysis.objectives import OBJECTIVES
from drakesep.analysis.physical_set import PhysicalSet
from drakesep.analysis.requirements import Finding, assess, deviation_limits
from drakesep.analysis.worst_case import Iteration, find_worst_case
from drakesep.case import Case
from drakesep.case_file import load_case
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.run import Run
from drakesep.systems.simulation import Simulation
from drakesep.tables import Flight


NOMINAL = "nominal"


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Where a study stands."""

    searches: int
    """Searches to be done."""
    done: int
    """Searches ended."""
    objective: str
    """Of the search under way."""
    iteration: Iteration
    """Its latest iterate."""


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """One run of a case."""

    case: Case
    flight: Flight
    values: Mapping[str, float]
    """What was changed, by parameter name with unit."""

    @functools.cached_property
    def summary(self) -> pd.DataFrame:
        """One row, as in `WorstCases.table`, with what was changed."""
        names = (*self.case.box.names, *self.case.values_in_si(self.values))
        return tables.flights_table([self.flight], list(dict.fromkeys(names)))

    @functools.cached_property
    def motion(self) -> pd.DataFrame:
        """The motion over time; empty if the run failed."""
        motion = self.flight.run.motion
        return pd.DataFrame() if motion is None else tables.motion_table(motion)

    @property
    def completed(self) -> bool:
        """Whether the run did not fail."""
        return self.flight.run.motion is not None

    def save(self, directory: str | Path) -> None:
        """Write the tables and figures into a folder."""
        folder = writable_folder(directory)
        tables.write_csv(self.summary, folder / "summary.csv")
        if self.completed:
            tables.write_csv(self.motion, folder / "motion.csv")
            figures.save_figures([self.flight], self.case.limits, folder)


@dataclass(kw_only=True)
class WorstCases:
    """The nominal run, the published worst cases, and the worst found."""

    case: Case
    flights: list[Flight] = field(default_factory=list)
    iterations: dict[str, list[Iteration]] = field(default_factory=dict)
    """Of each search, by objective."""

    @property
    def table(self) -> pd.DataFrame:
        """A row for each run: parameters, figures, and how it was found."""
        return tables.flights_table(self.flights, self.case.box.names)

    @property
    def history(self) -> pd.DataFrame:
        """A row for each iterate of each search."""
        return tables.history_table(self.iterations, self.case.box)

    @property
    def comparison(self) -> pd.DataFrame:
        """For each objective: nominal, published and worst value."""
        return tables.comparison_table(self.flights)

    @property
    def table_4(self) -> pd.DataFrame:
        """The worst cases in the form of the paper's Table 4."""
        return tables.table_4(self.flights, self.case.box)

    @property
    def motions(self) -> dict[str, pd.DataFrame]:
        """The motion of each run that did not fail, by its label."""
        return {
            flight.label: tables.motion_table(flight.run.motion)
            for flight in self.flights
            if flight.run.motion is not None
        }

    @property
    def completed(self) -> bool:
        """Whether no run and no search failed."""
        return not any(flight.status.startswith("failed") for flight in self.flights)

    def save_tables(self, directory: str | Path) -> None:
        """Write the tables into a folder."""
        folder = writable_folder(directory)
        tables.write_csv(self.table, folder / "worst_cases.csv")
        tables.write_csv(self.history, folder / "history.csv")
        if self.iterations:
            tables.write_csv(self.comparison, folder / "comparison.csv")

    def save(self, directory: str | Path) -> None:
        """Write the tables and figures into a folder."""
        self.save_tables(directory)
        shown = [flight for flight in self.flights if flight.run.motion is not None]
        figures.save_figures(shown, self.case.limits, Path(directory))


@dataclass(kw_only=True)
class Verification(WorstCases):
    """The worst cases held against the requirements."""

    @functools.cached_property
    def findings(self) -> list[Finding]:
        """How each requirement fares over all runs."""
        runs = {f.label: f.figures for f in self.flights if f.figures}
        return assess(self.case.limits, runs, NOMINAL)

    @property
    def requirements(self) -> pd.DataFrame:
        """A row for each requirement and axis, with its margin and verdict."""
        return tables.requirements_table(self.findings)

    @property
    def passed(self) -> bool:
        """Whether every requirement is met, with no run and no search failed."""
        return self.completed and all(finding.met for finding in self.findings)

    def save(self, directory: str | Path) -> None:
        """Write the tables, figures and motions into a folder."""
        super().save(directory)
        folder = Path(directory)
        tables.write_csv(self.requirements, folder / "requirements.csv")
        tables.write_csv(self.table_4, folder / "table_4.csv")
        for label, motion in self.motions.items():
            tables.write_csv(motion, folder / f"motion_{label}.csv")


def writable_folder(directory: str | Path) -> Path:
    """Return a folder, made if need be.

    Raises:
        ValueError: it cannot be made or written.
    """
    folder = Path(directory)
    probe = folder / ".drakesep"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(
            f"output: must be a folder that can be written, got {folder} "
            f"({error.strerror})"
        ) from error
    return folder


_RESULTS = (
    *("worst_cases.csv", "history.csv", "comparison.csv"),
    *("requirements.csv", "table_4.csv", "translation.png", "rotation.png"),
)


def _clear(folder: Path) -> None:
    # An interrupted study must not stand beside the verdict of an earlier one.
    for name in _RESULTS:
        (folder / name).unlink(missing_ok=True)


def simulate(
    case: Case | str | Path, values: Mapping[str, float] | None = None
) -> Simulated:
    """Fly a case once.

    Args:
        case: a case, a case file, or the name of a built-in case.
        values: new values by parameter name with unit, ``payload.mass_kg``.

    Raises:
        ValueError: the case or a value is wrong.
    """
    case = _as_case(case)
    run = Simulation(case.separation, case.integration).run(
        case.values_in_si(values or {})
    )
    label = "run" if values else NOMINAL
    return Simulated(case=case, flight=_flight(label, run, case), values=values or {})


def worst_case(
    case: Case | str | Path,
    objectives: Sequence[str] | None = None,
    *,
    output: str | Path | None = None,
    workers: int | None = None,
    on_progress: Callable[[Progress], None] | None = None,
) -> WorstCases:
    """Find the worst cases of a case over its tolerances.

    Args:
        case: a case, a case file, or the name of a built-in case.
        objectives: names out of `OBJECTIVES`; all if None.
        output: folder that receives the tables as the study goes on.
        workers: number of processes; one per core if None.
        on_progress: called with every iterate of every search.

    Raises:
        ValueError: the case or an objective is wrong, or the folder cannot be
            written.
        RuntimeError: the nominal run fails.
    """
    study = WorstCases(case=_as_case(case))
    if not study.case.dispersions:
        raise InputError("dispersions: a worst case needs some, got none")
    _search(study, objectives, output, workers, on_progress)
    if output is not None:
        study.save(output)
    return study


def verify(
    case: Case | str | Path,
    *,
    output: str | Path | None = None,
    workers: int | None = None,
    on_progress: Callable[[Progress], None] | None = None,
) -> Verification:
    """Find every worst case of a case and hold them against its requirements.

    Args:
        case: a case, a case file, or the name of a built-in case.
        output: folder that receives tables and figures, tables as the study goes on.
        workers: number of processes; one per core if None.
        on_progress: called with every iterate of every search.

    Raises:
        ValueError: the case is wrong or has no requirement, or the folder cannot be
            written.
        RuntimeError: the nominal run fails.
    """
    study = Verification(case=_as_case(case))
    if not study.case.limits:
        raise InputError("requirements: a case to verify must have some, got none")
    # Without dispersions, the nominal and the published runs are all there is.
    objectives: Sequence[str] | None = None if study.case.dispersions else []
    _search(study, objectives, output, workers, on_progress)
    if output is not None:
        study.save(output)
    return study


def _as_case(case: Case | str | Path) -> Case:
    return case if isinstance(case, Case) else load_case(case)


def _flight(label: str, run: Run, case: Case, **found: object) -> Flight:
    completed = run.motion is not None
    figures = metrics(run, deviation_limits(case.limits)) if completed else {}
    if not completed:
        found["status"] = f"failed: {run.message}"
    return Flight(label=label, run=run, figures=figures, **found)  # type: ignore[arg-type]


def _search(
    study: WorstCases,
    objectives: Sequence[str] | None,
    output: str | Path | None,
    workers: int | None,
    on_progress: Callable[[Progress], None] | None,
) -> None:
    if isinstance(objectives, str):
        objectives = [objectives]
    names = list(OBJECTIVES if objectives is None else dict.fromkeys(objectives))
    for name in names:
        if name not in OBJECTIVES:
            raise InputError(unknown("objective", name, OBJECTIVES))
    if output is not None:
        _clear(writable_folder(output))

    with Fleet(study.case.separation, study.case.integration, workers=workers) as fleet:
        _fly_references(study, fleet)
        if output is not None:
            study.save_tables(output)
        for done, name in enumerate(names):
            _find(study, name, fleet, done, len(names), output, on_progress)


def _fly_references(study: WorstCases, fleet: Fleet) -> None:
    case = study.case
    [nominal] = fleet.fly([{}])
    study.flights.append(_flight(NOMINAL, nominal, case))
    if nominal.motion is None:
        raise RuntimeError(f"the nominal run failed: {nominal.message}")
    variations = [case.published_values(published) for published in case.published]
    for published, run in zip(case.published, fleet.fly(variations), strict=True):
        flight = _flight(published.label, run, case, published=published)
        study.flights.append(flight)


def _find(
    study: WorstCases,
    name: str,
    fleet: Fleet,
    done: int,
    searches: int,
    output: str | Path | None,
    on_progress: Callable[[Progress], None] | None,
) -> None:
    history: list[Iteration] = []
    study.iterations[name] = history

    def note(iteration: Iteration) -> None:
        history.append(iteration)
        if output is not None:
            tables.write_csv(study.history, Path(output) / "history.csv")
        if on_progress is not None:
            on_progress(
                Progress(
                    searches=searches, done=done, objective=name, iteration=iteration
                )
            )

    case = study.case
    worst = find_worst_case(
        OBJECTIVES[name],
        case.box,
        PhysicalSet(case.separation, case.box),
        fleet.fly,
        on_iteration=note,
    )
    status = worst.status.value
    if status == "failed":
        status = f"failed: {worst.message}"
    study.flights.append(
        _flight(
            f"worst_{name}",
            worst.run,
            case,
            objective=name,
            iterations=worst.iterations,
            evaluations=worst.evaluations,
            status=status,
        )
    )
    if output is not None:
        study.save_tables(output)
