"""The worst cases flown in Drake, and held against what searches say of them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.objective import CLEARANCE, LowestClearance
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.engines.jax.batch import TOLERANCE
from drakesep.analysis.metrics.objectives import OBJECTIVES, Objective
from drakesep.analysis.metrics.of_run import METRICS
from drakesep.analysis.search.judge import WorstCase
from drakesep.analysis.search.problem import OnProgress, SearchProgress
from drakesep.analysis.search.sqp import SearchStatus
from drakesep.studies.worst_case.result import WorstCases
from drakesep.systems.model.run import Run, RunStatus
from drakesep.tables.labelled_run import LabelledRun, labelled_run


_CONFIRMED = 1e-4
"""By how much Drake may differ at its accuracy, of the objective's value or nominal; or
by as much as errors of the runs make, which counts where the objective is zero."""


def confirm(study: WorstCases, pool: DrakePool, on_progress: OnProgress) -> None:
    """Fly what was found in Drake, and hold it against what the search says."""
    case = study.case
    ends = [
        c
        for c in study.from_nominal
        if study.objectives[c.objective].name in OBJECTIVES
    ]
    variations: list[Mapping[str, float]] = [case.box.values(c.u) for c in ends]
    variations += [found.values for found in study.worst]
    runs = pool.fly(
        variations,
        lambda done, total: on_progress(
            SearchProgress(search="confirmation", done=done, total=total)
        ),
    )
    for end, run in zip(ends, runs, strict=False):
        assert end.ascent is not None
        name = study.objectives[end.objective].name
        study.runs.append(
            labelled_run(
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
    for found, run in zip(study.worst, runs[len(ends) :], strict=True):
        study.runs.append(_confirmed(study, found, run, points))
    if study.clearance is not None:
        _look_for_nearer(study, study.clearance)


def _look_for_nearer(study: WorstCases, clearance: LowestClearance) -> None:
    """Look whether a run of another worst case comes nearer than those measured.

    Then the search for the worst clearance has failed, and its worst case says so.
    """
    least = min(f.nearest.minimum for f in study.runs if f.nearest is not None)
    label = ""
    looked: dict[int, Clearance | None] = {}
    for i, labelled in enumerate(study.runs):
        if labelled.nearest is None and labelled.run.motion is not None:
            run = id(labelled.run)  # of what is worst for several, there is one
            if run not in looked:
                looked[run] = clearance.nearer(labelled.run, least)
            nearer = looked[run]
            if nearer is not None:
                metrics = {**labelled.metrics, CLEARANCE: nearer.minimum}
                study.runs[i] = replace(labelled, nearest=nearer, metrics=metrics)
                if nearer.minimum < least:
                    least, label = nearer.minimum, labelled.label
    if label:
        study.runs[:] = [
            replace(f, status=f"failed: {label} comes nearer, to {1e3 * least:.3f} mm")
            if f.objective == clearance.name
            else f
            for f in study.runs
        ]


def _status(status: SearchStatus, message: str) -> str:
    return f"failed: {message}" if status is SearchStatus.FAILED else status.value


def _confirmed(
    study: WorstCases, found: WorstCase, run: Run, points: int
) -> LabelledRun:
    objective = study.objectives[found.objective]
    labelled = labelled_run(
        f"worst_{found.name}",
        run,
        study.case,
        study.clearance if objective is study.clearance else None,
        objective=found.name,
        evaluations=points,
        status="confirmed",
    )
    if run.status is RunStatus.FAILED:
        return labelled
    in_drake = _value(study, objective, labelled)
    nominal = _value(study, objective, study.runs[0])
    status = labelled.status
    within = _CONFIRMED * max(abs(found.value), abs(nominal))
    within += objective.resolution(_accuracy(study.case))
    if not abs(in_drake - found.value) <= within:
        status = (
            f"failed: Drake gives {in_drake:.9g} where the search found "
            f"{found.value:.9g} (SI)"
        )
    return replace(labelled, status=status, objective_in_drake=in_drake)


def _accuracy(case: AnalysisCase) -> float:
    """Return that of the motion of runs, in SI: what steps err adds up over a run."""
    steps = case.integration.accuracy * max(1.0, case.separation.duration)
    return max(steps, TOLERANCE)


def _value(study: WorstCases, objective: Objective, labelled: LabelledRun) -> float:
    if objective.of_metrics_alone:
        metrics_ = np.array([labelled.metrics[name] for name in METRICS])
        return float(objective.of_metrics(metrics_))
    if objective is study.clearance:
        return -labelled.metrics[CLEARANCE]
    return objective.of_run(labelled.run, study.case.deviation_limits)
