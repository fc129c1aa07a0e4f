"""What is said of how far tolerances may grow, flown in Drake.

At the growth that is told, the worst case of a requirement lies on its limit; at 1 %
less nothing is beyond it, and at 1 % more something is: for limits from above and from
below, of all tolerances and of single ones.
"""

import itertools
import math

import numpy as np
import pytest
from recomputed import metrics

from drakesep.systems.model.integration import Integration
from drakesep.systems.simulation.simulation import Simulation


pytestmark = pytest.mark.slow  # compiles programs of its own, for minutes


LIMITS = (math.inf,) * 3
ON_IT = 2e-3
"""How near to its limit, as a part of what growth from nothing takes it by: a growth is
told to 1e-3, beside the curvature of what it makes."""


@pytest.fixture(scope="module")
def excess(small_study):
    """How far a point goes beyond a requirement, scaled: 0 on the limit, -1 nominally.

    Of a point in units of the case's own tolerances.
    """
    study, _ = small_study
    box = study.case.box
    simulation = Simulation(study.case.separation, Integration(accuracy=1e-8))
    known = {}

    def value(requirement, u):
        if tuple(u) not in known:
            values = box.nominal + box.tolerance * np.array(u)
            si = dict(zip(box.names, values.tolist(), strict=True))
            known[tuple(u)] = metrics(simulation.run(si), LIMITS)
        metric = requirement.metric
        if metric.startswith("longitudinal"):
            return known[tuple(u)][f"{metric}_m_s"]
        rate = metric.startswith("rate")
        return math.radians(
            known[tuple(u)][f"{metric}_deg_s" if rate else f"{metric}_deg"]
        )

    def excess(requirement, u):
        sign = 1.0 if requirement.sense == "<=" else -1.0
        beyond = sign * (value(requirement, u) - requirement.limit)
        room = sign * (requirement.limit - value(requirement, (0.0,) * len(box)))
        assert room > 0.0
        return beyond / room

    return excess


def corners(factors):
    return itertools.product(*([-f, f] for f in factors))


def worst(excess, requirement, factors):
    """Of all vertices of the grown box."""
    return max(excess(requirement, u) for u in corners(factors))


def reached(growths):
    return [(r, g) for r, g in growths if math.isfinite(g.factor)]


def point_of(growth, box):
    """Where the limit is reached, scaled, and by what each tolerance has grown."""
    values = np.array([growth.values[name] for name in box.names])
    factors = np.ones(len(box))
    which = growth.limit.parameter
    factors[slice(None) if which is None else which] = growth.factor
    return (values - box.nominal) / box.tolerance, factors


def test_both_senses_are_reached(small_study):
    study, _ = small_study
    for growths in (study.growths, study.single_growths):
        assert {r.sense for r, _ in reached(growths)} == {"<=", ">="}
    assert len(reached(study.growths)) == 6
    assert len(reached(study.single_growths)) > 6
    assert all(g.factor > 1.0 for _, g in (*study.growths, *study.single_growths))


def test_where_the_limit_is_reached(small_study, excess):
    """The point that is told lies on the limit, within the grown tolerances."""
    study, _ = small_study
    for requirement, growth in reached((*study.growths, *study.single_growths)):
        u, factors = point_of(growth, study.case.box)
        assert (np.abs(u) <= factors * (1.0 + 1e-9)).all()
        assert abs(excess(requirement, u.tolist())) <= ON_IT, requirement.metric


@pytest.mark.parametrize("change", [0.99, 1.01])
def test_all_tolerances_a_little_less_and_a_little_more(small_study, excess, change):
    study, _ = small_study
    for requirement, growth in reached(study.growths):
        factors = [change * growth.factor] * len(study.case.box)
        beyond = worst(excess, requirement, factors) > 0.0
        assert beyond == (change > 1.0), requirement.metric


def test_one_tolerance_a_little_less_and_a_little_more(small_study, excess):
    """From the point that is told, along the one parameter."""
    study, _ = small_study
    for requirement, growth in reached(study.single_growths):
        u, _ = point_of(growth, study.case.box)
        for change in (0.99, 1.01):
            moved = u.copy()
            moved[growth.limit.parameter] *= change
            beyond = excess(requirement, moved.tolist()) > 0.0
            assert beyond == (change > 1.0), (requirement.metric, moved)


def test_what_is_not_reached_is_not(small_study, excess):
    """Nor at five times the tolerances, up to which was looked."""
    study, _ = small_study
    for requirement, growth in (*study.growths, *study.single_growths):
        if math.isfinite(growth.factor):
            continue
        factors = np.ones(len(study.case.box))
        which = growth.limit.parameter
        factors[slice(None) if which is None else which] = 5.0
        assert worst(excess, requirement, factors.tolist()) < 0.0, requirement.metric
