"""The study of the worst cases: what was flown and found, and why to believe it."""

import functools
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import pandas as pd

from drakesep import evidence_tables, tables
from drakesep.analysis.ascent import Iteration, SearchStatus, Start, slopes_at
from drakesep.analysis.batch import Batch
from drakesep.analysis.evaluators import BatchEvaluator, RunEvaluator
from drakesep.analysis.fleet import Fleet
from drakesep.analysis.lowest_clearance import CLEARANCE, LowestClearance
from drakesep.analysis.metrics import METRICS, metrics
from drakesep.analysis.objectives import (
    OBJECTIVES,
    AnyObjective,
    Objective,
    as_objective,
)
from drakesep.analysis.requirements import deviation_limits
from drakesep.analysis.search import (
    Candidate,
    Effort,
    Problem,
    Searched,
    SearchProgress,
    SearchSettings,
)
from drakesep.analysis.searches import check_search
from drakesep.analysis.worst_case import WorstCase, find_worst_cases
from drakesep.case import Case
from drakesep.folder import writable_folder
from drakesep.systems.checks import InputError
from drakesep.systems.run import Run, RunStatus
from drakesep.systems.simulation import Simulation
from drakesep.tables import Flight


if TYPE_CHECKING:
    from drakesep.clearance_figures import Approach

NOMINAL = "nominal"
DEFAULT_SEARCHES = ("samples", "vertices", "sqp", "multistart")
"""Chance, then the corners, then uphill from the nominal and from the best of those."""
DRAKE = "drake"
"""The search that flies Drake alone: SQP from the nominal, with differences."""

OnProgress: TypeAlias = Callable[["Progress"], None]

_CONFIRMED = 1e-4
"""By how much Drake may differ at its accuracy, of the objective's value or nominal."""
_WHOLE_RUN = 800
"""Steps of a run in Drake that costs what an objective of a whole run does on the
batch engine, which samples its motion."""
_COSTLY: Effort = {"samples": 32, "vertices": 32}
"""Where there are none but costly objectives, a fraction of a second each."""
_LIGHT = 300
"""Steps of a Drake run up to which it is a light one: derivatives cost less than they
save, and workers take longer to start than to fly."""


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Where a study stands."""

    objectives: tuple[Objective, ...]
    """That are searched."""
    search: SearchProgress
    """The search under way."""


@dataclass(kw_only=True)
class WorstCases:
    """The nominal run, the published worst cases, and the worst found."""

    case: Case
    objectives: tuple[Objective, ...] = ()
    flights: list[Flight] = field(default_factory=list)
    searched: list[Searched] = field(default_factory=list)
    """What each search found, in their order."""
    worst: list[WorstCase] = field(default_factory=list)
    """The worst case of each objective, with its evidence."""
    nominal_slopes: np.ndarray | None = field(default=None, repr=False)
    """(m, n) of the objectives at the nominal, with the scaled parameters."""
    clearance: LowestClearance | None = field(default=None, repr=False)
    """That tells how near the nominal and published runs come; None if not asked."""

    @functools.cached_property
    def share_unphysical(self) -> float:
        """The share of the tolerances whose inertias no body can have."""
        return self.case.tolerance_set.share_unphysical()

    @property
    def table(self) -> pd.DataFrame:
        """A row for each run: parameters, figures, and how it was found."""
        return tables.flights_table(self.flights, self.case.box.names)

    @property
    def history(self) -> pd.DataFrame:
        """A row for each iterate of each search from the nominal."""
        return tables.history_table(self.iterations, self.case.box)

    @property
    def iterations(self) -> dict[Objective, tuple[Iteration, ...]]:
        """Iterates of the search from the nominal, by objective."""
        return {
            self.objectives[c.objective]: c.ascent.history
            for c in self._from_nominal
            if c.ascent is not None
        }

    @property
    def _from_nominal(self) -> list[Candidate]:
        return [c for s in self.searched if s.search == "sqp" for c in s.candidates]

    @property
    def comparison(self) -> pd.DataFrame:
        """For each of the paper's objectives: nominal, published, SQP and worst."""
        return tables.comparison_table(self.flights)

    @property
    def table_4(self) -> pd.DataFrame:
        """The worst cases in the form of the paper's Table 4."""
        shown = [f for f in self.flights if f.objective is None or _of_paper(f)]
        return tables.table_4(shown, self.case.box)

    @property
    def worst_points(self) -> pd.DataFrame:
        """A row for each parameter: M, m or its value, at each worst case."""
        return evidence_tables.worst_points(self.worst, self.case.box)

    @property
    def evidence(self) -> pd.DataFrame:
        """A row for each worst case, with why it may be believed."""
        return evidence_tables.evidence(self.worst, self.objectives, self.flights)

    @property
    def searches(self) -> pd.DataFrame:
        """A row for each search: what it looked at."""
        return evidence_tables.searches(self.searched, self.share_unphysical)

    @property
    def candidates(self) -> pd.DataFrame:
        """A row for the best point of each search, for each objective."""
        return evidence_tables.candidates(self.searched, self.objectives, self.case.box)

    @property
    def sensitivities(self) -> pd.DataFrame:
        """What each tolerance does to each objective, at the nominal and the worst."""
        slopes = self.nominal_slopes
        assert slopes is not None or not self.worst
        return evidence_tables.sensitivities(
            self.worst, self.objectives, slopes, self.case.box
        )

    @property
    def _nearest_sensitivities(self) -> pd.DataFrame:
        """Those of the paper's objectives, and of a requirement's worse direction."""
        left_out = set()
        values = {case.name: case.value for case in self.worst}
        for requirement in self.case.limits:
            names = [o.name for o in self.case.towards(requirement)]
            known = [name for name in names if name in values]
            left_out |= set(known) - {max(known, key=values.__getitem__, default="")}
        frame = self.sensitivities
        return frame[~frame["objective"].isin(left_out)]

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
        """Whether no run failed, and Drake confirmed every worst case."""
        return not any(flight.status.startswith("failed") for flight in self.flights)

    def save_tables(self, directory: str | Path) -> None:
        """Write the tables, as far as there are any, into a folder."""
        folder = writable_folder(directory)
        tables.write_csv(self.table, folder / "worst_cases.csv")
        if self.searched:
            tables.write_csv(self.searches, folder / "searches.csv")
            tables.write_csv(self.candidates, folder / "candidates.csv")
        if self.iterations:
            tables.write_csv(self.history, folder / "history.csv")
        if self.worst:
            tables.write_csv(self.evidence, folder / "evidence.csv")
            tables.write_csv(self.worst_points, folder / "worst_points.csv")
            tables.write_csv(self.sensitivities, folder / "sensitivities.csv")
        if any(map(_of_paper, self.flights)):
            tables.write_csv(self.comparison, folder / "comparison.csv")

    def save(self, directory: str | Path) -> None:
        """Write the tables, and what shows the runs, into a folder."""
        self.save_tables(directory)
        self.save_runs(directory)

    def save_runs(self, directory: str | Path) -> None:
        """Write the figures into a folder."""
        from drakesep import clearance_figures, figures  # half a second, when drawn

        folder = Path(directory)
        shown = [f for f in self.flights if f.run.motion is not None and _shown(f)]
        figures.save_figures(shown, self.case.limits, folder)
        if self.worst:
            figures.save_tornado(self._nearest_sensitivities, folder)
        if self._approaches:
            limits = [r.limit for r in self.case.limits if r.metric == CLEARANCE]
            limit = limits[0] if limits else None
            clearance_figures.save_approaches(self._approaches, limit, folder)

    @functools.cached_property
    def _approaches(self) -> "list[Approach]":
        """Of the nominal run and of the worst clearance, if it was looked for."""
        from drakesep.clearance_figures import Approach

        if self.clearance is None:
            return []
        approaches = []
        for flight in self.flights:
            found = flight.nearest
            if found is None or flight.published is not None:
                continue
            x, distances = self.clearance.approach(flight.run, found)
            pair = f"{found.first} to {found.second}".replace("_", " ")
            approaches.append(Approach(flight.label, pair, x, distances))
        return approaches


def _of_paper(flight: Flight) -> bool:
    return flight.objective in OBJECTIVES


def _shown(flight: Flight) -> bool:
    """Return whether a flight is in the figures of the motion."""
    return flight.objective is None or (
        _of_paper(flight) and flight.label.startswith("worst_")
    )


def case_objectives(case: Case) -> dict[str, Objective]:
    """Return the objectives of a case by name: the paper's, and each requirement's."""
    objectives = [*OBJECTIVES.values(), *case.requirement_objectives]
    return {objective.name: objective for objective in objectives}


def choose_objectives(
    case: Case, wanted: Sequence[AnyObjective] | AnyObjective | None
) -> tuple[Objective, ...]:
    """Return the objectives that are wanted; all of the case if None.

    Raises:
        ValueError: one is unknown, or two have the same name.
    """
    known = case_objectives(case)
    if wanted is None:
        return tuple(known.values())
    if case.has_clearance:
        clearance = case.lowest_clearance()
        known.setdefault(clearance.name, clearance)
    listed = [wanted] if isinstance(wanted, str) or callable(wanted) else wanted
    if "lowest_clearance" in listed and not case.has_clearance:
        raise InputError(
            "lowest_clearance: needs geometry on two bodies that does not touch while "
            "mated, got none"
        )
    if not listed:
        raise InputError("objectives: must be one or more, got none")
    chosen = [
        known[objective]
        if isinstance(objective, str) and objective in known
        else as_objective(objective, known)
        for objective in dict.fromkeys(listed)
    ]
    names = [objective.name for objective in chosen]
    for objective in chosen:
        if objective.name in known and objective is not known[objective.name]:
            raise InputError(
                f"objectives: {objective.name!r} is the name of one of the case's own; "
                "give yours another with objective.named(...)"
            )
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"objectives: names must differ, got {name!r} twice; "
                "give one another with objective.named(...)"
            )
    return tuple(chosen)


def the_clearance(objectives: Sequence[Objective]) -> LowestClearance | None:
    """Return the first of objectives that is a clearance; None if there is none."""
    return next((o for o in objectives if isinstance(o, LowestClearance)), None)


def as_flight(
    label: str,
    run: Run,
    case: Case,
    clearance: LowestClearance | None = None,
    **found: object,
) -> Flight:
    """Return a run with its figures, and how near it comes if that is asked for."""
    figures_: dict[str, float] = {}
    if run.motion is None:
        found["status"] = f"failed: {run.message}"
    else:
        limits = deviation_limits(case.limits)
        figures_ |= metrics(run, limits)
        if clearance is not None:
            found["nearest"] = nearest = clearance.nearest(run)
            figures_[CLEARANCE] = nearest.minimum
    return Flight(label=label, run=run, figures=figures_, **found)  # type: ignore[arg-type]


def _nothing(*_: object) -> None:
    """Do nothing."""


def search(
    study: WorstCases,
    objectives: Sequence[Objective],
    *,
    searches: Sequence[str] | None,
    effort: Effort,
    output: Path | None,
    workers: int | None,
    on_progress: OnProgress | None,
    afterwards: Callable[[Problem, SearchSettings], None] = _nothing,
) -> None:
    """Fly the references of a study, search its worst cases and confirm them.

    Args:
        study: that receives what is found.
        objectives: to be maximised.
        searches: names out of `SEARCHES`, or `DRAKE` alone; `default_searches` if None.
        effort: how hard to search; what is left out, the length of a run decides.
        output: folder that receives the tables as the study goes on.
        workers: number of processes that fly Drake; one per core if None.
        on_progress: called as the searches go on.
        afterwards: called with the problem, while it can be flown, and the settings.
    """
    alone = searches is not None and list(searches) == [DRAKE]
    if isinstance(searches, str) or (searches and DRAKE in searches and not alone):
        raise InputError(
            f"searches: must be a list, and {DRAKE!r} stands alone in it, "
            f"got {searches!r}"
        )
    for name in searches if searches and not alone else ():
        check_search(name, also=[DRAKE])
    if searches is not None and not len(searches):
        raise InputError("searches: must be one or more, got none")
    SearchSettings(**effort)  # refuses what is wrong before anything is flown
    case = study.case
    if objectives and not alone:
        Batch(case.separation, case.box.names)  # refuses what it does not know, at once
    study.objectives = tuple(objectives)
    study.clearance = study.clearance or the_clearance(objectives)
    nominal = Simulation(case.separation, case.integration).run({})
    if nominal.motion is None:
        raise RuntimeError(f"the nominal run failed: {nominal.message}")
    light = nominal.steps <= _LIGHT
    batch = None
    if objectives and not alone:
        # First of all: its programs are compiled beside what comes next.
        batch = _batch(case, objectives, derivatives=light)
        workers = 1 if light and workers is None else workers
    study.flights.append(as_flight(NOMINAL, nominal, case, study.clearance))
    with Fleet(case.separation, case.integration, workers=workers) as fleet:
        _fly_published(study, fleet)
        if output is not None:
            study.save_tables(output)
        more: Callable[[], None] = _nothing
        if objectives:
            problem = Problem(
                tolerances=case.tolerance_set,
                evaluator=batch or _drake(case, objectives, fleet),
            )
            settings = _affordable(objectives, nominal.steps, effort)
            several = light and not all(o.costly for o in objectives)
            names = searches or default_searches(len(case.box), settings, light=several)
            names = ["sqp"] if alone else names
            worst = _find(study, problem, names, settings, output, on_progress)
            study.nominal_slopes = _slopes_at_nominal(problem)
            _confirm(study, worst, fleet)
            study.worst = worst
            if output is not None:
                study.save_tables(output)
            more = functools.partial(afterwards, problem, settings)
        _save_runs_beside(study, output, more)


def _save_runs_beside(
    study: WorstCases, output: Path | None, more: Callable[[], None]
) -> None:
    """Draw the runs while more is found, which changes nothing about them."""
    with ThreadPoolExecutor(1) as beside:
        if output is not None:
            saved = beside.submit(study.save_runs, output)
        more()
    if output is not None:
        study.save_tables(output)  # whatever becomes of the pictures
        saved.result()


def _affordable(
    objectives: Sequence[Objective], steps: int, effort: Effort
) -> SearchSettings:
    """Return how hard to search, by what takes longest of what searches fly."""
    if all(o.costly for o in objectives):
        chosen: Effort = _COSTLY | effort
        return SearchSettings.affordable(steps, **chosen)
    whole_runs = any(not (o.of_figures_alone or o.costly) for o in objectives)
    return SearchSettings.affordable(
        max(steps, _WHOLE_RUN if whole_runs else 0), **effort
    )


def default_searches(
    parameters: int, settings: SearchSettings, *, light: bool
) -> tuple[str, ...]:
    """Return the searches of a study that is not told which.

    Vertices, while all are affordable; else differential evolution, if runs are light.

    Args:
        parameters: how many are dispersed.
        settings: what is affordable.
        light: whether very many runs are.
    """
    instead = ("evolution",) if light else ()
    wide = ("vertices",) if 2**parameters <= settings.vertices else instead
    return tuple(
        name
        for wanted in DEFAULT_SEARCHES
        for name in (wide if wanted == "vertices" else (wanted,))
    )


def _find(
    study: WorstCases,
    problem: Problem,
    searches: Sequence[str],
    settings: SearchSettings,
    output: Path | None,
    on_progress: OnProgress | None,
) -> list[WorstCase]:
    """Find the worst cases, and write down what each search finds as it ends."""

    def tell(progress: SearchProgress) -> None:
        if on_progress is not None:
            on_progress(Progress(objectives=study.objectives, search=progress))

    def keep(searched: Searched) -> None:
        study.searched.append(searched)
        if output is not None:
            study.save_tables(output)

    return find_worst_cases(
        problem, searches, settings, on_progress=tell, on_search=keep
    )


def _fly_published(study: WorstCases, fleet: Fleet) -> None:
    case = study.case
    variations = [case.published_values(published) for published in case.published]
    for published, run in zip(case.published, fleet.fly(variations), strict=True):
        flight = as_flight(
            published.label, run, case, study.clearance, published=published
        )
        study.flights.append(flight)


def _drake(case: Case, objectives: Sequence[Objective], fleet: Fleet) -> RunEvaluator:
    names = case.box.names

    def fly(rows: np.ndarray) -> list[Run]:
        return fleet.fly([dict(zip(names, row.tolist(), strict=True)) for row in rows])

    return RunEvaluator(fly, names, objectives, deviation_limits(case.limits))


def _batch(
    case: Case, objectives: Sequence[Objective], *, derivatives: bool
) -> BatchEvaluator:
    limits = deviation_limits(case.limits)
    batch = Batch(case.separation, case.box.names, deviation_limits=limits)
    evaluator = BatchEvaluator(batch, objectives, limits, derivatives=derivatives)
    evaluator.prepare()
    return evaluator


def _slopes_at_nominal(problem: Problem) -> np.ndarray:
    """Return (m, n) the slopes of the objectives, with the scaled parameters."""
    nominal = np.zeros(len(problem.tolerances))
    return slopes_at(
        [
            Start(objective=k, tolerances=problem.tolerances, u=nominal)
            for k in range(len(problem.evaluator.objectives))
        ],
        problem.evaluator,
    )


def _confirm(study: WorstCases, worst: Sequence[WorstCase], fleet: Fleet) -> None:
    """Fly what was found in Drake, and hold it against what the search says."""
    case = study.case
    ends = [
        c
        for c in study._from_nominal
        if study.objectives[c.objective].name in OBJECTIVES
    ]
    variations: list[Mapping[str, float]] = [case.box.values(c.u) for c in ends]
    variations += [case.values for case in worst]
    runs = fleet.fly(variations)
    for end, run in zip(ends, runs, strict=False):
        assert end.ascent is not None
        name = study.objectives[end.objective].name
        study.flights.append(
            as_flight(
                f"sqp_{name}",
                run,
                case,
                objective=name,
                iterations=end.ascent.iterations,
                evaluations=end.ascent.evaluations,
                status=_status(end.ascent.status, end.ascent.message),
            )
        )
    points = sum(searched.points for searched in study.searched)
    for found, run in zip(worst, runs[len(ends) :], strict=True):
        study.flights.append(_confirmed(study, found, run, points))


def _status(status: SearchStatus, message: str) -> str:
    return f"failed: {message}" if status is SearchStatus.FAILED else status.value


def _confirmed(study: WorstCases, found: WorstCase, run: Run, points: int) -> Flight:
    objective = study.objectives[found.objective]
    flight = as_flight(
        f"worst_{found.name}",
        run,
        study.case,
        study.clearance if objective is study.clearance else None,
        objective=found.name,
        evaluations=points,
        status="confirmed",
    )
    if run.status is RunStatus.FAILED:
        return flight
    in_drake = _value(study, objective, flight)
    nominal = _value(study, objective, study.flights[0])
    status = flight.status
    within = _CONFIRMED * max(abs(found.value), abs(nominal)) + objective.accuracy
    if not abs(in_drake - found.value) <= within:
        status = (
            f"failed: Drake gives {in_drake:.9g} where the search found "
            f"{found.value:.9g} (SI)"
        )
    return replace(flight, status=status, objective_in_drake=in_drake)


def _value(study: WorstCases, objective: Objective, flight: Flight) -> float:
    if objective.of_figures_alone:
        figures_ = np.array([flight.figures[name] for name in METRICS])
        return float(objective.of_figures(figures_))
    if objective is study.clearance:
        return -flight.figures[CLEARANCE]
    return objective.of_run(flight.run, deviation_limits(study.case.limits))
