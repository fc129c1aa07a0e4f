"""The study of the worst cases: fly the references, search, confirm, write down."""

import contextlib
import copy
import functools
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.engines.jax.batch_evaluator import BatchEvaluator
from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.analysis.search.expensive_objectives import check_expensive
from drakesep.analysis.search.judge import WorstCase, find_worst_cases
from drakesep.analysis.search.problem import OnProgress as Tell
from drakesep.analysis.search.problem import Problem, Searched, SearchProgress
from drakesep.analysis.search.registry import check_search
from drakesep.analysis.search.sqp import Start, slopes_at
from drakesep.case_file.objectives import the_clearance
from drakesep.plots.pictures import Tornado
from drakesep.studies.background_process import beside, submitted
from drakesep.studies.output import clear_results
from drakesep.studies.worst_case.confirmation import confirm
from drakesep.studies.worst_case.result import WorstCases
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run
from drakesep.systems.simulation.simulation import Simulation
from drakesep.tables.labelled_run import LabelledRun, references


DEFAULT_SEARCHES = ("samples", "vertices", "sqp", "multistart")
"""Chance, then the corners, then uphill from the nominal and from the best of those."""
DRAKE = "drake"
"""The search that flies Drake alone: SQP from the nominal, with differences."""

OnProgress: TypeAlias = Callable[["Progress"], None]

_WHOLE_RUN = 800
"""Steps of a run in Drake that costs what an objective of a whole run does on the
batch engine, which samples its motion."""
_EXPENSIVE: Effort = {"samples": 32, "vertices": 32}
"""Where there are none but expensive objectives, a fraction of a second each."""
_LIGHT = 300
"""Steps of a Drake run up to which it is a light one: derivatives cost less than they
save, and workers take longer to start than to fly."""


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Where a study stands."""

    objectives: tuple[Objective, ...]
    """That are searched."""
    search: SearchProgress
    """The search under way; after them the confirmation in Drake, and growth."""


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
    afterwards: Callable[[Problem, SearchSettings, Tell], None] | None = None,
) -> None:
    """Fly the references of a study, search its worst cases and confirm them.

    Args:
        study: that receives what is found.
        objectives: to be maximised.
        searches: names out of `SEARCHES`, or `DRAKE` alone; `default_searches` if None.
        effort: how hard to search; what is left out, the length of a run decides.
        output: folder that receives the tables as the study goes on.
        workers: number of processes that fly Drake; one per core if None; with 1, the
            caller's does all.
        on_progress: called as the study goes on.
        afterwards: called with the problem, while it can be flown, the settings, and
            what tells of progress; runs are drawn beside it.
    """
    alone = _is_alone(searches)
    # What is wrong is refused before anything is flown.
    SearchSettings(**effort)
    if searches and not alone:
        check_expensive(objectives, searches)
    case = study.case
    if objectives and not alone:
        Batch(case.separation, case.box.names)  # refuses what it does not know, at once
    if output is not None:
        clear_results(output)
    study.objectives = tuple(objectives)
    study.clearance = study.clearance or the_clearance(objectives)

    def tell(progress: SearchProgress) -> None:
        if on_progress is not None:
            on_progress(Progress(objectives=study.objectives, search=progress))

    nominal = Simulation(case.separation, case.integration).run({})
    if nominal.motion is None:
        raise RuntimeError(f"the nominal run failed: {nominal.message}")
    light = nominal.steps <= _LIGHT
    on_batch = bool(objectives) and not alone
    with contextlib.ExitStack() as stack:
        aside = None
        if on_batch and afterwards is not None:
            aside = stack.enter_context(beside(workers))
        flown_here = on_batch and light and workers is None
        pool = stack.enter_context(
            DrakePool(
                case.separation, case.integration, workers=1 if flown_here else workers
            )
        )
        published = pool.fly([p.values for p in case.published])
        # Its programs are compiled beside what comes next.
        batch = _batch(case, objectives, derivatives=light) if on_batch else None
        study.runs += _told(study, [nominal, *published], aside)
        _write_down(study, output)
        drawing = _Drawing(aside, output)
        more: Callable[[], None] = _nothing
        if objectives:
            problem = Problem(
                tolerances=case.tolerance_set,
                evaluator=batch or _drake(case, objectives, pool),
            )
            settings = _affordable(objectives, nominal.steps, effort)
            several = light and not all(o.expensive for o in objectives)
            names = searches or default_searches(len(case.box), settings, light=several)
            names = ["sqp"] if alone else names
            study.worst = _find(study, problem, names, settings, output, tell)
            study.nominal_slopes = _slopes_at_nominal(problem)
            drawing.begin(Tornado(study.nearest_sensitivities).save)
            confirm(study, pool, tell)
            _write_down(study, output)
            if afterwards is not None:
                more = functools.partial(afterwards, problem, settings, tell)
        drawing.begin(study.pictures.save)
        try:
            more()  # which changes nothing about the runs that are drawn
        finally:
            drawing.wait()  # what has been begun is not lost
        _write_down(study, output)  # whatever becomes of the pictures
        drawing.check()


def _told(
    study: WorstCases, runs: Sequence[Run], aside: Executor | None
) -> list[LabelledRun]:
    """Return the nominal and the published runs with their metrics."""
    if study.clearance is None or aside is None:
        return references(study.case, runs, study.clearance)
    # A copy: it is sent while the study's own is prepared, whose warnings are ours.
    told = submitted(aside, references, study.case, runs, copy.copy(study.clearance))
    study.clearance.prepare()
    return told.result()


class _Drawing:
    """Pictures that are drawn while the study goes on; none without a folder."""

    def __init__(self, aside: Executor | None, folder: Path | None):
        self._aside = aside
        self._folder = folder
        self._begun: list[Future[None]] = []

    def begin(self, save: Callable[[Path], None]) -> None:
        if self._folder is not None:
            folder = self._folder.absolute()
            self._begun.append(submitted(self._aside, save, folder))

    def wait(self) -> None:
        wait(self._begun)

    def check(self) -> None:
        """Raise what one of them has raised."""
        for picture in self._begun:
            picture.result()


def _is_alone(searches: Sequence[str] | None) -> bool:
    """Return whether Drake searches alone.

    Raises:
        ValueError: there is none, one is unknown, or Drake is beside others.
    """
    if searches is None:
        return False
    if not len(searches):
        raise InputError("searches: must be one or more, got none")
    alone = list(searches) == [DRAKE]
    if isinstance(searches, str) or (DRAKE in searches and not alone):
        raise InputError(
            f"searches: must be a list, and {DRAKE!r} stands alone in it, "
            f"got {searches!r}"
        )
    for name in () if alone else searches:
        check_search(name, also=[DRAKE])
    return alone


def _write_down(study: WorstCases, output: Path | None) -> None:
    if output is not None:
        study.save_tables(output)


def _affordable(
    objectives: Sequence[Objective], steps: int, effort: Effort
) -> SearchSettings:
    """Return how hard to search, by what takes longest of what searches fly."""
    if all(o.expensive for o in objectives):
        chosen: Effort = _EXPENSIVE | effort
        return SearchSettings.affordable(steps, **chosen)
    whole_runs = any(not (o.of_metrics_alone or o.expensive) for o in objectives)
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
    tell: Tell,
) -> list[WorstCase]:
    """Find the worst cases, and write down what each search finds as it ends."""

    def keep(searched: Searched) -> None:
        study.searched.append(searched)
        _write_down(study, output)

    return find_worst_cases(
        problem, searches, settings, on_progress=tell, on_search=keep
    )


def _drake(
    case: AnalysisCase, objectives: Sequence[Objective], pool: DrakePool
) -> RunEvaluator:
    names = case.box.names

    def fly(rows: np.ndarray) -> list[Run]:
        return pool.fly([dict(zip(names, row.tolist(), strict=True)) for row in rows])

    return RunEvaluator(fly, names, objectives, case.deviation_limits)


def _batch(
    case: AnalysisCase, objectives: Sequence[Objective], *, derivatives: bool
) -> BatchEvaluator:
    limits = case.deviation_limits
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
