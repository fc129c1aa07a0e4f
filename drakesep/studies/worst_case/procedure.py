"""The study of the worst cases: fly the references, search, confirm, write down.

A step takes a study as far as it has come, and returns it with what it has found. What
it has found is written down after it, so that an interrupted study leaves that.
"""

import copy
import functools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar, Unpack

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.analysis.search.judge import find_worst_cases
from drakesep.analysis.search.problem import Problem, Searched
from drakesep.analysis.search.sqp import Start, slopes_at
from drakesep.case_file.case import Case
from drakesep.case_file.objectives import Wanted, choose_objectives, clearances_of
from drakesep.plots.pictures import Tornado
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import WORST_CASE
from drakesep.results.folder import Output, ResultsFolder, results_folder
from drakesep.results.recorded_runs import save_runs
from drakesep.studies.background_process import BackgroundProcess
from drakesep.studies.worst_case.confirmation import confirmed, functions_compared
from drakesep.studies.worst_case.effort import CONFIRMATION
from drakesep.studies.worst_case.plan import OnProgress, StudyPlan
from drakesep.studies.worst_case.result import WorstCases
from drakesep.studies.worst_case.searches import WantedSearches
from drakesep.studies.worst_case.session import Session, session
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run
from drakesep.tables.evidence_tables import BATCH, BATCH_RUNS, DRAKE_RUNS, Flown
from drakesep.tables.labelled_run import LabelledRun, measured, told_by
from drakesep.tables.roles import Nominal, Published, Role


_Study = TypeVar("_Study", bound=WorstCases)


@typed
def worst_case(
    case: Case | AnalysisCase | str | Path,
    objectives: Wanted | None = None,
    *,
    searches: Sequence[str] | None = None,
    output: Output | None = None,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
    minutes: float | None = None,
    resume: bool = False,
    **effort: Unpack[Effort],
) -> WorstCases:
    """Find the worst cases of a case over its tolerances.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        objectives: names (see `case_objectives`), objectives, or functions of a run;
            what leads out of each requirement if None, and the paper's if the case
            says so.
        searches: names out of `SEARCHES`, in the order in which they go; or
            ``["drake"]``, which flies Drake alone; what suits the case if None.
        output: folder that receives tables and plots, tables as the study goes on.
        workers: number of processes that fly Drake; one per core if None; with 1, the
            caller's does all.
        on_progress: called as the study goes on.
        minutes: that it may take, from when the plan is told; None: ten, or as long as
            the searches take, if `searches` names them.
        resume: whether to go on from what a study that ended early has finished in
            `output`, which must be the same: it ends as that would have. Without one,
            the study begins.
        effort: `starts`, `samples`, `vertices`, `flips`, `generations` and `seed` of
            `SearchSettings`; the speed of runs, as it is measured, decides what is
            left out: see `WorstCases.effort`.

    Raises:
        ValueError: the case, an objective or a search is wrong, it takes longer than
            it may, the folder cannot be written, or has another study to resume.
        RuntimeError: the nominal run fails.
    """
    asked = Asked.of(
        WORST_CASE,
        case,
        {
            "objectives": objectives,
            "searches": searches,
            "minutes": minutes,
            **effort,
        },
        seed=SearchSettings(**effort).seed,
    )
    if not asked.case.tolerances:
        raise InputError("dispersions: a worst case needs some, got none")
    chosen = choose_objectives(asked.case, objectives)
    with results_folder(output, WORST_CASE) as folder:
        plan = StudyPlan(
            asked=asked,
            objectives=chosen,
            searches=WantedSearches.named(searches, asked.case.separation),
            effort=effort,
            minutes=minutes,
            workers=workers,
            clearances=clearances_of(chosen),
            resume=resume,
            folder=folder,
        )
        study = WorstCases(asked=asked, objectives=chosen, clearances=plan.clearances)
        with (
            BackgroundProcess(workers=1) as none,  # what little is drawn, is drawn here
            session(plan, none, on_progress) as under_way,
        ):
            study = carried_out(study, under_way)
        return ended(study, folder)


def ended(study: _Study, folder: ResultsFolder | None) -> _Study:
    """Return a study that is over; its folder says how it ended."""
    study = replace(study, asked=study.asked.over())
    if folder is not None:
        folder.end(failed=study.failure, verdict=study.verdict)
    return study


def carried_out(study: _Study, under_way: Session) -> _Study:
    """Return a study with its references, worst cases and their runs; begin to draw.

    Without objectives, the nominal and the published runs are all there is.
    """
    study = told(with_references(study, under_way))
    under_way.begin()
    under_way.write_down(study)
    _record(study.runs, under_way)
    if study.objectives:
        references = len(study.runs)
        study = searched(study, under_way)
        under_way.draw(Tornado(study.nearest_sensitivities).save)
        flown = confirmed(study, under_way.pool.fly, under_way.telling(CONFIRMATION))
        study = functions_compared(told(flown))
        study = under_way.write_down(study)
        _record(study.runs[references:], under_way)
    under_way.draw(study.pictures.save)
    return study


def told(study: _Study) -> _Study:
    """Return a study whose runs have what required functions tell of them."""
    if not study.functions:
        return study
    runs = tuple(told_by(study.functions, one) for one in study.runs)
    return replace(study, runs=runs)


def _record(runs: Sequence[LabelledRun], under_way: Session) -> None:
    nominal, folder = under_way.plan.case.separation, under_way.plan.folder
    under_way.draw(functools.partial(save_runs, runs, nominal))
    if folder is not None:
        folder.keep([one.label for one in runs])


def with_references(study: _Study, under_way: Session) -> _Study:
    """Return a study with its nominal and published runs, and their metrics."""
    case, clearances = study.case, [*study.clearances.values()]
    roles: list[Role] = [Nominal(), *map(Published, case.published)]
    flown = [under_way.nominal, *under_way.published]
    background = under_way.background
    if not clearances or not background.is_another:
        return replace(study, runs=_measured(roles, flown, case, clearances))
    # Copies: they are sent while our own are prepared, which warn of doubtful meshes.
    there = [copy.copy(clearance) for clearance in clearances]
    runs = background.submit(_measured, roles, flown, case, there)
    for clearance in clearances:
        clearance.prepare()
    return replace(study, runs=runs.result())


def _measured(
    roles: Sequence[Role],
    flown: Sequence[Run],
    case: AnalysisCase,
    clearances: Sequence[LowestClearance],
) -> tuple[LabelledRun, ...]:
    return tuple(
        measured(role, run, case, clearances)
        for role, run in zip(roles, flown, strict=True)
    )


def searched(study: _Study, under_way: Session) -> _Study:
    """Return a study with its worst cases; each search is written down as it ends."""
    problem, effort = under_way.problem, under_way.effort
    under_way.tell_plan()
    done = list(under_way.finished)

    def keep(found: Searched) -> None:
        done.append(found)
        under_way.keep_search(found)
        under_way.write_down(replace(study, searched=tuple(done)))

    worst = find_worst_cases(
        problem,
        effort.searches,
        effort.settings,
        finished=under_way.finished,
        on_progress=under_way.tell,
        on_search=keep,
    )
    return replace(
        study,
        effort=effort,
        searched=tuple(done),
        worst=tuple(worst),
        nominal_slopes=_slopes_at_nominal(problem),
        flown=_flown(under_way),
    )


def _flown(under_way: Session) -> dict[str, Flown]:
    """Return how searches were told each objective, by its name."""
    evaluator = under_way.evaluator
    whole = DRAKE_RUNS if under_way.batch is None else BATCH_RUNS
    flown: dict[str, Flown] = {}
    for k, objective in enumerate(evaluator.objectives):
        count = evaluator.run_by_run(k)
        earlier = sum(dict(one.run_by_run).get(k, 0) for one in under_way.finished)
        told = Flown(BATCH, 0) if count is None else Flown(whole, count + earlier)
        flown[objective.name] = told
    return flown


def _slopes_at_nominal(problem: Problem) -> Array:
    """Return (m, n) the slopes of the objectives, with the scaled parameters."""
    nominal = np.zeros(len(problem.tolerances))
    return slopes_at(
        [
            Start(objective=k, tolerances=problem.tolerances, u=nominal)
            for k in range(len(problem.evaluator.objectives))
        ],
        problem.evaluator,
    )
