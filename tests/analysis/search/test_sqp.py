"""The ascent, on functions of the parameters whose constrained maxima are known."""

import math

import numpy as np
import pytest
from runs import evaluator_of
from separations import generic_pair, vega

from drakesep.analysis.engines.evaluator import Evaluated
from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.search.sqp import (
    AscentSettings,
    SearchStatus,
    Start,
    ascend,
    slopes_at,
)
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.run import Run, RunStatus


PAIR = generic_pair()
NAMES = ("upper.cg_x", "upper.cg_y", "upper.cg_z", "spring_1.stroke")
BOX = ToleranceBox.around(
    PAIR, dict(zip(NAMES, (0.02, 0.01, 0.005, 0.001), strict=True))
)
SET = ToleranceSet(PAIR, BOX)


def maximise(function, tolerances=SET, start=None, on_iteration=None, **settings):
    u = np.zeros(len(tolerances)) if start is None else start
    [ascent] = ascend(
        [Start(objective=0, tolerances=tolerances, u=u)],
        evaluator_of(function, tolerances=tolerances),
        AscentSettings(**settings),
        on_iteration,
    )
    return ascent


def test_linear_function_ends_in_its_corner():
    """At once, whatever the slopes: each parameter goes to its bound in one step."""
    slopes = np.array([3.0, -1.0, 1e-4, -0.5])
    ascent = maximise(lambda u: 7.0 + slopes @ u)
    assert ascent.u == pytest.approx(np.sign(slopes), abs=1e-12)
    assert ascent.value == pytest.approx(7.0 + np.abs(slopes).sum(), rel=1e-12)
    assert ascent.status is SearchStatus.CONVERGED
    assert ascent.iterations <= 3


def test_maximum_inside_the_box():
    inside = np.array([0.3, -0.6, 0.0, 0.5])
    ascent = maximise(lambda u: 2.0 - ((u - inside) ** 2).sum())
    # one-sided differences shift the maximum by half a step, 1e-3 / 2
    assert ascent.u == pytest.approx(inside, abs=1e-3)


def test_maximum_on_an_ellipsoid():
    """Of g u over u^T C^-1 u <= 1: sqrt(g^T C g), at C g over it."""
    C = np.array([[1.0, 0.6, 0.0], [0.6, 1.0, -0.3], [0.0, -0.3, 1.0]])
    g = np.array([1.0, -2.0, 0.5, 0.25])
    ellipsoid = Ellipsoid(names=NAMES[:3], correlation=tuple(map(tuple, C.tolist())))
    ascent = maximise(lambda u: g @ u, ToleranceSet(PAIR, BOX, [ellipsoid]))
    height = math.sqrt(g[:3] @ C @ g[:3])
    assert ascent.value == pytest.approx(height + 0.25, rel=1e-6)
    # second order in the value, first in the place
    assert ascent.u[:3] == pytest.approx(C @ g[:3] / height, abs=2e-3)
    assert ascent.u[3] == pytest.approx(1.0, abs=1e-12)


def test_maximum_on_the_boundary_of_the_physical_inertias():
    """Drives the largest moment up: the triangle inequality stops it, not the box."""
    names = ("payload.inertia_xx", "payload.inertia_yy", "payload.inertia_zz")
    box = ToleranceBox.around(
        vega(), dict(zip(names, (70.0, 320.0, 330.0), strict=True))
    )

    def difference(u):
        values = box.values(u)
        return values[names[2]] - values[names[1]]

    ascent = maximise(difference, ToleranceSet(vega(), box))
    # zz - yy <= xx <= 739, by the triangle inequality
    assert ascent.value == pytest.approx(739.0, rel=1e-4)
    assert box.values(ascent.u)[names[0]] == pytest.approx(739.0, rel=1e-4)


def test_every_point_is_counted_and_every_iterate_logged():
    calls, seen = [], []

    def function(u):
        calls.append(u)
        return u.sum() - (u**2).sum()

    ascent = maximise(function, on_iteration=lambda i, iterate: seen.append(iterate))
    assert ascent.evaluations == len(calls)
    assert list(ascent.history) == seen
    assert [i.number for i in seen] == list(range(len(seen)))
    assert seen[0].u == (0.0,) * 4
    assert ascent.iterations == seen[-1].number
    assert ascent.value >= seen[-1].value
    assert ascent.value == pytest.approx(function(np.array(ascent.u)), rel=1e-12)


def test_points_stay_in_the_box():
    def function(u):
        assert (np.abs(u) <= 1.0 + 1e-11).all()
        return (u**2).sum() + u[0]

    assert maximise(function, start=np.full(4, 0.9)).value == pytest.approx(5.0)


def test_many_starts_go_up_together_and_find_each_its_own():
    """cos over three periods: a start ends on the hill that it stands on."""

    def hills(u):
        return math.cos(3.0 * math.pi * u[0]) - (u[1:] ** 2).sum()

    tops = [-2.0 / 3.0, 0.0, 2.0 / 3.0]
    starts = [
        Start(objective=0, tolerances=SET, u=np.array([top + 0.05, 0.1, 0.1, 0.1]))
        for top in tops
    ]
    ascents = ascend(starts, evaluator_of(hills, tolerances=SET))
    assert [a.u[0] for a in ascents] == pytest.approx(tops, abs=1e-3)
    alone = [ascend([s], evaluator_of(hills, tolerances=SET))[0] for s in starts]
    assert [a.u for a in alone] == [a.u for a in ascents]


@pytest.mark.slow
def test_more_starts_than_go_side_by_side():
    starts = [Start(objective=i % 2, tolerances=SET, u=np.zeros(4)) for i in range(600)]
    evaluator = evaluator_of(lambda u: u[0], lambda u: -u[0], tolerances=SET)
    ascents = ascend(starts, evaluator)
    assert [a.u[0] for a in ascents] == pytest.approx([1.0, -1.0] * 300)


def test_iteration_limit_is_told():
    ascent = maximise(
        lambda u: -((u - 0.31) ** 4).sum() + u[0] * u[1], max_iterations=2
    )
    assert ascent.status is SearchStatus.ITERATION_LIMIT


def failing(limit):
    """An evaluator whose runs fail from the limit-th on."""
    count = 0
    inner = evaluator_of(lambda u: 1.0 + u.sum(), tolerances=SET)
    fly = inner._fly

    def fly_some(rows):
        nonlocal count
        runs = fly(rows)
        for i, run in enumerate(runs):
            count += 1
            if count >= limit:
                runs[i] = Run(
                    separation=run.separation, status=RunStatus.FAILED, message="boom"
                )
        return runs

    return RunEvaluator(fly_some, BOX.names, inner.objectives)


def test_failed_run_ends_the_ascent_with_what_was_found():
    start = Start(objective=0, tolerances=SET, u=np.zeros(4))
    [ascent] = ascend([start], failing(6))
    assert ascent.status is SearchStatus.FAILED
    assert ascent.message == "a run failed: boom"
    assert ascent.value == 1.0
    [ascent] = ascend([start], failing(1))
    assert ascent.status is SearchStatus.FAILED
    assert math.isnan(ascent.value)


def test_slopes():
    slopes = np.array([3.0, -1.0, 0.2, -0.5])
    points = [
        Start(objective=0, tolerances=SET, u=u) for u in (np.zeros(4), np.ones(4))
    ]
    found = slopes_at(points, evaluator_of(lambda u: slopes @ u, tolerances=SET))
    # eps / step, times the nominal over its tolerance
    assert found == pytest.approx(np.array([slopes, slopes]), abs=1e-10)
    unknown = slopes_at(points, failing(7))
    assert np.isfinite(unknown[0]).all() != np.isfinite(unknown[1]).all()


def test_a_value_that_is_known_is_not_flown():
    """Of slopes, the probes alone are: one a parameter."""
    flown = []

    def function(u):
        flown.append(u)
        return u @ np.array([3.0, -1.0, 0.2, -0.5])

    evaluator = evaluator_of(function, tolerances=SET)
    known = Start(objective=0, tolerances=SET, u=np.zeros(4), value=0.0)
    [slopes] = slopes_at([known], evaluator)
    assert slopes == pytest.approx([3.0, -1.0, 0.2, -0.5], abs=1e-10)
    assert len(flown) == 4


def test_slopes_along_a_curved_edge():
    """No step along a single parameter stays on a circle: probes move two."""
    disc = ToleranceSet(PAIR, BOX, [Ellipsoid(names=NAMES[:2])])

    def function(u):
        return u[0] + 0.3 * u[1]

    start = np.array([1.0, 0.0, 0.0, 0.0])
    [slopes] = slopes_at(
        [Start(objective=0, tolerances=disc, u=start)],
        evaluator_of(function, tolerances=disc),
    )
    assert slopes == pytest.approx([1.0, 0.3, 0.0, 0.0], abs=1e-9)
    ascent = maximise(function, disc, start)
    assert ascent.value == pytest.approx(math.hypot(1.0, 0.3), rel=1e-6)


def test_objective_without_a_number_is_told():
    with pytest.raises(
        ValueError, match=r"objective_0 must be finite for every run, got nan at upper"
    ):
        maximise(lambda u: math.nan if u[0] > 0.5 else u[0])


def test_interrupt_comes_through():
    def interrupt(i, iteration):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        maximise(lambda u: u[0], on_iteration=interrupt)


@pytest.mark.parametrize("start", [np.full(4, 1.5), np.full(4, math.nan), np.ones(3)])
def test_start_outside_the_set(start):
    with pytest.raises(ValueError, match="start must be in the box"):
        maximise(lambda u: 1.0, start=start)


def test_what_is_asked_together_is_answered_together():
    """Ten starts: as many calls as one start alone takes."""

    class Counting(RunEvaluator):
        calls = 0

        def one(self, rows, which) -> Evaluated:
            self.calls += 1
            return super().one(rows, which)

    inner = evaluator_of(lambda u: u.sum(), tolerances=SET)
    calls = []
    for count in (1, 10):
        evaluator = Counting(inner._fly, BOX.names, inner.objectives)
        start = Start(objective=0, tolerances=SET, u=np.zeros(4))
        ascend([start] * count, evaluator)
        calls.append(evaluator.calls)
    assert calls[0] == calls[1]
