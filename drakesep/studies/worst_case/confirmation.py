"""The worst cases flown in Drake, and held against what searches say of them."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias, TypeVar

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.of_pair import ACCURACY, Clearance
from drakesep.analysis.engines.jax.batch import TOLERANCE
from drakesep.analysis.metrics.objectives import OBJECTIVES, Objective
from drakesep.analysis.search.judge import WorstCase
from drakesep.analysis.search.problem import Candidate
from drakesep.analysis.search.sqp import SearchStatus
from drakesep.studies.worst_case.result import WorstCases
from drakesep.systems.model.run import Run
from drakesep.tables.labelled_run import (
    LabelledRun,
    clearance_told,
    measured,
    nominal_of,
)
from drakesep.tables.roles import (
    CONFIRMED,
    Ending,
    Outcome,
    SearchEnd,
    Worst,
    failed,
    label_of,
)


_Study = TypeVar("_Study", bound=WorstCases)

_CONFIRMED = 1e-4
"""By how much Drake may differ at its accuracy, of the objective's value or nominal; or
by as much as errors of the runs make, which counts where the objective is zero."""
_ENDINGS = {
    SearchStatus.CONVERGED: Ending.CONVERGED,
    SearchStatus.STALLED: Ending.STALLED,
    SearchStatus.ITERATION_LIMIT: Ending.ITERATION_LIMIT,
    SearchStatus.FAILED: Ending.FAILED,
}


Fly: TypeAlias = Callable[
    [Sequence[Mapping[str, float]], Callable[[int, int], None]], list[Run]
]
"""Flies variations in Drake, as `DrakePool.fly` does."""


def confirmed(
    study: _Study,
    fly: Fly,
    on_progress: Callable[[int, int], None] = lambda *_: None,
    *,
    of: Sequence[WorstCase] | None = None,
) -> _Study:
    """Return a study with the runs in Drake of what was found, held against that.

    Args:
        study: with its worst cases.
        fly: flies them.
        on_progress: told how many are done, and of how many.
        of: worst cases that are flown; all if None.
    """
    case, worst = study.case, study.worst if of is None else of
    ends = [
        end
        for end in study.from_nominal
        if study.objectives[end.objective].name in OBJECTIVES
    ]
    found: list[Mapping[str, float]] = [case.box.values(end.u) for end in ends]
    found += [one.values for one in worst]

    flown = fly(found, on_progress)
    runs = [
        *study.runs,
        *(_search_end(study, *one) for one in zip(ends, flown, strict=False)),
        *(
            _confirmed(study, *one)
            for one in zip(worst, flown[len(ends) :], strict=True)
        ),
    ]
    for clearance in study.clearances.values():
        runs = _nearest_looked_for(runs, clearance)
    return replace(study, runs=tuple(runs))


def _search_end(study: WorstCases, end: Candidate, run: Run) -> LabelledRun:
    """Return the run at which the search from the nominal has ended."""
    assert end.ascent is not None
    name = study.objectives[end.objective].name
    labelled = measured(SearchEnd(end.search, name), run, study.case)
    outcome = Outcome(_ENDINGS[end.ascent.status], end.ascent.message)
    return replace(
        labelled,
        outcome=labelled.outcome if labelled.outcome.failed else outcome,
        iterations=end.ascent.iterations,
        evaluations=end.ascent.evaluations,
    )


def _confirmed(study: WorstCases, found: WorstCase, run: Run) -> LabelledRun:
    """Return the run of a worst case, with whether Drake says the same of it."""
    objective = study.objectives[found.objective]
    mine = [one for one in study.clearances.values() if one is objective]
    labelled = replace(
        measured(Worst(found.name), run, study.case, mine, likely=-found.value),
        evaluations=sum(searched.points for searched in study.searched),
    )
    if labelled.outcome.failed:
        return labelled
    in_drake = _value(study, objective, labelled)
    nominal = _value(study, objective, nominal_of(study.runs))
    within = may_differ(objective, study.case, found.value, nominal)
    outcome = CONFIRMED
    if not abs(in_drake - found.value) <= within:
        outcome = failed(
            f"Drake gives {in_drake:.9g} where the search found {found.value:.9g} (SI)"
        )
    return replace(labelled, outcome=outcome, objective_in_drake=in_drake)


def may_differ(
    objective: Objective, case: AnalysisCase, value: float, nominal: float
) -> float:
    """Return by how much two engines may differ, each at its accuracy.

    Args:
        objective: in question.
        case: that is flown.
        value: of the objective.
        nominal: its nominal.
    """
    within = _CONFIRMED * max(abs(value), abs(nominal))
    return within + objective.resolution(_accuracy(case))


def _value(study: WorstCases, objective: Objective, labelled: LabelledRun) -> float:
    for metric, nearest in labelled.nearest.items():
        if objective is study.clearances[metric]:
            return -nearest.minimum
    return objective.of_run(labelled.run, study.case.limits_of_pairs)


def _accuracy(case: AnalysisCase) -> float:
    """Return that of the motion of runs, in SI: what steps err adds up over a run."""
    steps = case.integration.accuracy * max(1.0, case.separation.duration)
    return max(steps, TOLERANCE)


def _nearest_looked_for(
    runs: Sequence[LabelledRun], clearance: LowestClearance
) -> list[LabelledRun]:
    """Return runs with how near they come, where it is nearer than those measured.

    Where another run comes nearer than the worst clearance, by more than both may be
    off, the search for that has failed, and its run says so. A run whose window does
    not end tells nothing.
    """
    metric = clearance.metric
    least = min(o.nearest[metric].minimum for o in runs if metric in o.nearest)
    missed_below = least - 2.0 * ACCURACY
    nearest: LabelledRun | None = None
    looked: dict[int, Clearance | None] = {}
    measured_runs = []
    for one in runs:
        if metric not in one.nearest and one.run.motion is not None:
            key = id(one.run)  # of what is worst for several, there is one
            if key not in looked:
                looked[key] = clearance.nearer(one.run, least)
            nearer = looked[key]
            if not clearance.is_window_ended(one.run):  # what follows is not known
                one = replace(one, metrics={**one.metrics, metric: math.nan})
            if nearer is not None:
                told = clearance_told(one.run, nearer, clearance)
                one = replace(
                    one,
                    nearest={**one.nearest, metric: nearer},
                    metrics={**one.metrics, metric: told},
                )
                if nearer.minimum < least:
                    least, nearest = nearer.minimum, one
        measured_runs.append(one)
    if nearest is None or least >= missed_below:
        return measured_runs
    why = f"{nearest.label} comes nearer, to {1e3 * least:.3f} mm"
    return _beaten(measured_runs, clearance.name, nearest.label, why)


def functions_compared(study: _Study) -> _Study:
    """Return a study in which each worst case of a function is held against all runs.

    Where another run within the tolerances is worse, by more than both may be off, the
    search has failed, and the run of the worst case says so.
    """
    runs: list[LabelledRun] = list(study.runs)
    told = [one for one in runs if one.of_functions and one.published is None]
    for function in study.functions:
        values = {one.label: one.of_functions[function.name] for one in told}
        for limit, objective in zip(function.limits, function.objectives, strict=True):
            own = values.get(label_of(Worst(objective.name)))
            if own is None:
                continue
            margins = {label: limit.margin(value) for label, value in values.items()}
            worst = min(margins, key=margins.__getitem__)
            nominal = values[nominal_of(runs).label]
            within = may_differ(objective, study.case, own, nominal)
            if margins[worst] < limit.margin(own) - within:
                why = f"{worst} is worse, {values[worst]:.6g} {function.unit}".strip()
                runs = _beaten(runs, objective.name, worst, why)
    return replace(study, runs=tuple(runs))


def _beaten(
    runs: Sequence[LabelledRun], objective: str, by: str, why: str
) -> list[LabelledRun]:
    """Return runs, of which the worst case of an objective has failed."""
    worst = Worst(objective)
    return [
        replace(o, outcome=failed(why), beaten_by=by) if o.role == worst else o
        for o in runs
    ]
