"""Points where an expensive objective may be worst although its slope does not say so.

A clearance is the smallest of many distances. Where a gap that nothing changes is the
smallest, no slope leads away; and a distance that is not the smallest at the nominal
may become it elsewhere. So all of them are looked at in the nominal run: to first
order, each is worst in the corner of the box that its own slopes point to.
"""

from collections.abc import Sequence

import numpy as np

from drakesep.analysis.metrics.objectives import LargestOfParts
from drakesep.analysis.search.problem import Problem
from drakesep.systems.arrays import Array
from drakesep.systems.model.run import RunStatus


_STEP = 0.1
"""Of differences, in tolerances: rates of a part hardly bend over it."""
_BENDS = 1.25
"""By how much more than its slopes say a part may rise."""


def linearised_corners(problem: Problem, k: int) -> list[Array]:
    """Return the corners (n,) where parts of an objective may be worst, worst first.

    One for each part that may rise above what is highest at the nominal; empty if the
    objective has no parts, or a run failed.

    Args:
        problem: the objectives and the set.
        k: which of the objectives.
    """
    set_, objective = problem.tolerances, problem.evaluator.objectives[k]
    box = set_.box
    if not isinstance(objective, LargestOfParts):
        return []
    n = len(set_)
    farther = np.where(box.upper >= -box.lower, 1.0, -1.0)
    around = set_.draw_back(np.vstack([np.zeros(n), _STEP * np.diag(farther)]))
    runs = problem.evaluator.runs(set_.rows(around), k)
    if any(run.status is RunStatus.FAILED for run in runs):
        return []
    steps = np.diag(around[1:])
    reach = _BENDS * np.maximum(-box.lower, box.upper) / np.abs(steps)
    values, changes = objective.linearised_parts(runs[0], runs[1:], reach)
    slopes = changes / steps
    rises = np.maximum(slopes * box.lower, slopes * box.upper).sum(axis=2)
    at = (values + rises).argmax(axis=1)
    parts = np.arange(len(values))
    most = values[parts, at] + _BENDS * rises[parts, at]
    rising = most > values.max() + objective.resolution(0.0)
    order = [i for i in np.argsort(-most, kind="stable") if rising[i]]
    return different([set_.draw_back(box.corners(slopes[i, at[i]])) for i in order])


def different(points: Sequence[Array]) -> list[Array]:
    """Return points (n,) without those that stand before."""
    return [np.array(u) for u in dict.fromkeys(tuple(u.tolist()) for u in points)]
