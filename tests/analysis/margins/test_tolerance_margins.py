"""How far tolerances may grow, on functions whose worst cases are known."""

import math

import numpy as np
import pytest
from runs import fly_nothing
from separations import generic_pair

from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.margins.tolerance_margins import (
    MOST,
    Limit,
    grow,
    grow_along_rays,
)
from drakesep.analysis.metrics.objectives import About, Needs, Objective, of_run
from drakesep.analysis.search.problem import Problem
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.sides import Sides
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.run import Run, RunStatus


PAIR = generic_pair()
NAMES = ("upper.cg_x", "upper.cg_y", "upper.mass")
BOX = ToleranceBox.around(PAIR, dict(zip(NAMES, (0.02, 0.01, 400.0), strict=True)))
SET = ToleranceSet(PAIR, BOX)
VALUES = parameters(PAIR)


def problem(function, tolerances=SET):
    """A function of deviations in units of the tolerances, which may exceed 1."""
    fly, box = fly_nothing(PAIR), tolerances.box

    def deviation(run):
        values = parameters(run.separation)
        return function(box.scaled({name: values[name] for name in box.names}))

    evaluator = RunEvaluator(
        lambda rows: fly([dict(zip(box.names, row, strict=True)) for row in rows]),
        box.names,
        [of_run(deviation, "f")],
    )
    return Problem(tolerances=tolerances, evaluator=evaluator)


@pytest.mark.slow
def test_sides_grow_in_proportion_about_the_nominal():
    """-1 to +4, none to +400 kg: the sum of what each gives at its worse bound."""
    sides = (Sides(minus=0.005, plus=0.02), 0.01, Sides(minus=0.0, plus=400.0))
    box = ToleranceBox.around(PAIR, dict(zip(NAMES, sides, strict=True)))
    g = np.array([-1.0, 2.0, -0.5])  # worse at -0.25, 1 and 0 of the larger sides
    u = (-0.25, 1.0, 0.0)
    limits = [
        Limit(objective=0, value=4.5, u=u),
        *(Limit(objective=0, value=4.5, u=u, parameter=i) for i in range(3)),
    ]
    asked = problem(lambda v: g @ v, ToleranceSet(PAIR, box))
    together, x, y, mass = grow(asked, limits)
    assert together.factor == pytest.approx(4.5 / 2.25, rel=1e-5)
    assert together.values == pytest.approx(
        # CG y is -20 mm nominally.
        dict(zip(NAMES, (VALUES["upper.cg_x"] - 0.01, 0.0, 1200.0), strict=True)),
        abs=1e-6,
    )
    assert y.factor == pytest.approx((4.5 - 0.25) / 2.0, rel=1e-5)
    # 0.25 k = 2.5 is at k = 10, beyond the factors that are looked at.
    assert math.isinf(x.factor)
    # The bound that matters is the nominal, however large the tolerance; and there is
    # no lower one where the mass would be negative.
    assert math.isinf(mass.factor)
    assert mass.most == MOST


def test_linear_function():
    """|g| k reaches the limit."""
    g = np.array([1.0, -2.0, 0.5])
    limits = [
        Limit(objective=0, value=7.0, u=(1.0, -1.0, 1.0)),
        *(
            Limit(objective=0, value=7.0, u=(1.0, -1.0, 1.0), parameter=i)
            for i in range(3)
        ),
    ]
    told = []
    together, x, y, mass = grow(
        problem(lambda v: g @ v),
        limits,
        on_progress=lambda done, total: told.append((done, total)),
    )
    assert (told[0], told[-1]) == ((0, 4), (4, 4))
    assert told == sorted(told)
    assert together.factor == pytest.approx(7.0 / 3.5, rel=1e-5)
    assert together.values == pytest.approx(BOX.values([2.0, -2.0, 2.0]))
    assert x.factor == pytest.approx(7.0 - 2.5, rel=1e-5)
    assert y.factor == pytest.approx((7.0 - 1.5) / 2.0, rel=1e-5)
    # 0.5 k = 4 lies beyond where the mass would be negative, at k = 3
    assert math.isinf(mass.factor)
    assert together.most == MOST
    assert mass.most == pytest.approx(1200.0 / 400.0, rel=1e-3)
    assert mass.values == {}


@pytest.mark.slow
def test_worst_case_that_turns_over_as_tolerances_grow():
    """v_x up to k = 1, then -v_x^2 + ... : max(v_x, 0.5 v_x^2) changes sides.

    f = v_x for small k, with its maximum at +k; f = 0.4 v_y^2 overtakes it at 2.5. The
    growth that begins at the corner of v_x must find the other.
    """

    def function(v):
        return v[0] + 0.4 * v[1] ** 2 - 3.0 * v[2] ** 2

    found = grow(problem(function), [Limit(objective=0, value=5.0, u=(1.0, 0.3, 0.2))])
    k = (-1.0 + math.sqrt(1.0 + 4.0 * 0.4 * 5.0)) / (2.0 * 0.4)
    assert found[0].factor == pytest.approx(k, rel=2e-3)


@pytest.mark.slow
def test_limit_beyond_reach():
    limit = Limit(objective=0, value=2.0 * MOST, u=(1.0, 0.0, 0.0))
    [far] = grow(problem(lambda v: v[0]), [limit])
    assert math.isinf(far.factor)


def test_limit_already_passed():
    limit = Limit(objective=0, value=-1.0, u=(1.0, 0.0, 0.0))
    [passed] = grow(problem(lambda v: v[0]), [limit])
    assert passed.factor == 0.0


def test_violated_already_within_the_tolerances():
    [growth] = grow(
        problem(lambda v: v[0]), [Limit(objective=0, value=0.25, u=(1.0, 0.0, 0.0))]
    )
    assert growth.factor == pytest.approx(0.25, rel=1e-5)


def test_nothing_to_do():
    assert grow(problem(lambda v: v[0]), []) == []


@pytest.mark.slow
def test_limit_that_is_passed_only_in_between():
    """A ridge inside the box: below the limit at no growth, and at five times."""

    def ridge(v):
        return math.exp(-(((v[0] - 0.9) / 0.1) ** 2)) + 1e-3 * v[1]

    [growth] = grow(problem(ridge), [Limit(objective=0, value=0.5, u=(0.9, 1.0, 0.0))])
    assert growth.factor <= 1.0


@pytest.mark.slow
def test_parameter_that_does_not_go_on_does_not_stop_the_others():
    """The mass ends at 3 times its tolerance; the rest reaches 5 - 1.5 at 3.5."""
    [growth] = grow(
        problem(lambda v: v[0] + 0.5 * v[2]),
        [Limit(objective=0, value=5.0, u=(1.0, 0.0, 1.0))],
    )
    assert growth.factor == pytest.approx(3.5, rel=1e-3)
    assert growth.values["upper.mass"] == pytest.approx(2400.0, rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_failed_runs_do_not_hide_what_was_found(seed):
    """Runs fail beyond four times the tolerance of x."""
    asked = problem(lambda v: v[0] + 1e-3 * v[1])
    inner = asked.evaluator

    def fly(rows):
        return [
            Run(separation=run.separation, status=RunStatus.FAILED, message="boom")
            if row[0] > BOX.nominal[0] + 4.0 * BOX.tolerance[0]
            else run
            for row, run in zip(rows, inner._fly(rows), strict=True)
        ]

    evaluator = RunEvaluator(fly, BOX.names, inner.objectives)
    [growth] = grow(
        Problem(tolerances=SET, evaluator=evaluator),
        [Limit(objective=0, value=2.0, u=(1.0, 1.0, 0.0))],
        corners=64,
        seed=seed,
    )
    assert growth.factor == pytest.approx(2.0, rel=2e-3)
    assert growth.message == "boom"


@pytest.mark.parametrize("value", [0.35, 3.5, 5.25, 8.75])
def test_along_the_ray_of_a_linear_function(value):
    """|g| k reaches the limit, to a hundredth and not before; downward too."""
    g = np.array([1.0, -2.0, 0.5])
    limit = Limit(objective=0, value=value, u=(1.0, -1.0, 1.0))
    [found] = grow_along_rays(problem(lambda v: g @ v), [limit])
    assert found.along_ray
    # Beyond 3, where there would be no mass left, the others go on alone.
    assert value / 3.5 - 1e-9 <= found.factor <= value / 3.5 + 1e-2
    assert found.values == pytest.approx(BOX.values(found.factor * np.array(limit.u)))


def test_along_the_ray_a_plateau_is_reached_where_it_begins():
    """As a clearance, which is 0 from contact on, however deep: at k = 1.73."""
    touching = problem(lambda v: min(v[0] - 1.73, 0.0))
    [found] = grow_along_rays(
        touching, [Limit(objective=0, value=0.0, u=(1.0, 0.0, 0.0))]
    )
    assert 1.73 <= found.factor <= 1.74


def test_along_the_ray_what_is_never_or_always_beyond():
    u = (1.0, 0.0, 0.0)
    limits = [Limit(objective=0, value=value, u=u) for value in (9.0, -1.0)]
    never, always = grow_along_rays(problem(lambda v: v[0]), limits)
    assert math.isinf(never.factor) and never.values == {}
    assert always.factor == 0.0


@pytest.mark.parametrize("fails_from", [0.0, 1.2, 1.9])
def test_along_the_ray_a_run_that_fails_is_no_violation(fails_from):
    """The limit is at 1.7, which is hidden by runs that fail; at 3 it is passed."""

    def fly(rows):
        moved = (rows[:, 0] - BOX.nominal[0]) / BOX.tolerance[0]
        flown = fly_nothing(PAIR)([{NAMES[0]: x} for x in rows[:, 0].tolist()])
        lost = Run(separation=PAIR, status=RunStatus.FAILED, message="lost")
        return [
            lost if fails_from <= x < 2.5 else run
            for x, run in zip(moved, flown, strict=True)
        ]

    objectives = problem(lambda v: v[0]).evaluator.objectives
    evaluator = RunEvaluator(fly, NAMES, objectives)
    limit = Limit(objective=0, value=1.7, u=(1.0, 0.0, 0.0))
    [found] = grow_along_rays(Problem(tolerances=SET, evaluator=evaluator), [limit])
    assert (found.factor, found.message) == (3.0, "lost")


def failing(function, fails):
    """The problem of a function whose runs fail where x, in tolerances, says so."""
    inner = problem(function).evaluator

    def fly(rows):
        moved = (rows[:, 0] - BOX.nominal[0]) / BOX.tolerance[0]
        lost = Run(separation=PAIR, status=RunStatus.FAILED, message="lost")
        return [
            lost if fails(x) else run
            for x, run in zip(moved, inner._fly(rows), strict=True)
        ]

    evaluator = RunEvaluator(fly, BOX.names, inner.objectives)
    return Problem(tolerances=SET, evaluator=evaluator)


@pytest.mark.parametrize(
    ("fails_from", "searched", "on_ray"),
    [(1.2, 1.0, 1.0), (2.2, 2.0, 2.0), (9.0, MOST, MOST)],
)
def test_growth_is_looked_at_as_far_as_runs_tell(fails_from, searched, on_ray):
    """No limit is reached, but runs fail from some growth on: nothing is known there.

    Growths of the grids below 1.2 and 2.2 are 1 and 2; all are below 9.
    """
    asked = failing(lambda v: v[0] + 1e-3 * v[1], lambda x: x >= fails_from)
    limit = Limit(objective=0, value=9.0, u=(1.0, 1.0, 0.0))
    [together] = grow(asked, [limit], corners=16)
    [ray] = grow_along_rays(asked, [limit])
    assert math.isinf(together.factor) and math.isinf(ray.factor)
    assert (together.looked_up_to, ray.looked_up_to) == (searched, on_ray)


def test_growth_of_which_no_run_tells_is_none():
    asked = failing(lambda v: v[0], lambda x: True)
    limit = Limit(objective=0, value=9.0, u=(1.0, 0.0, 0.0))
    for growth in (*grow(asked, [limit], corners=4), *grow_along_rays(asked, [limit])):
        assert math.isnan(growth.factor) and math.isnan(growth.looked_up_to)
        assert growth.message == "lost"


class EndsTooSoon(Objective):
    """v_x, of a window whose end is not reached from some v_x on."""

    name, needs = "f", Needs.MEASUREMENT

    def __init__(self, from_x):
        self._from_x = from_x

    def of_run(self, run, limits):
        values = parameters(run.separation)
        return float(BOX.scaled({name: values[name] for name in NAMES})[0])

    def about(self, run, limits):
        x = self.of_run(run, limits)
        return About(x, lambda other: self.of_run(other, limits), x < self._from_x)


@pytest.mark.parametrize(
    ("from_x", "limit", "factor", "looked_up_to"),
    [
        (1.2, 9.0, math.inf, 1.0),  # nothing found, and not looked beyond 1
        (0.0, 9.0, math.nan, math.nan),  # not even the nominal tells
        (1.2, 2.5, 3.0, MOST),  # beyond the limit before its end: a violation
        (4.0, 2.5, 2.5, MOST),
    ],
)
def test_what_ends_too_soon_is_not_within_a_limit(from_x, limit, factor, looked_up_to):
    evaluator = RunEvaluator(
        lambda rows: fly_nothing(PAIR)([{NAMES[0]: x} for x in rows[:, 0].tolist()]),
        NAMES,
        [EndsTooSoon(from_x)],
    )
    [found] = grow_along_rays(
        Problem(tolerances=SET, evaluator=evaluator),
        [Limit(objective=0, value=limit, u=(1.0, 0.0, 0.0))],
    )
    # To a hundredth, where it may be halved: below 3 nothing tells.
    assert found.factor == pytest.approx(factor, abs=1e-2, nan_ok=True)
    assert found.looked_up_to == pytest.approx(looked_up_to, nan_ok=True)
    assert not found.message
