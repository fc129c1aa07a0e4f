"""First-order conditions and bounds by chance, against closed forms."""

import math

import numpy as np
import pytest
from scipy.stats import binom
from separations import generic_pair

from drakesep.analysis.search.optimality import (
    fraction_beyond,
    local_maxima,
    optimality,
)
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet


NAMES = ("upper.cg_x", "upper.cg_y", "upper.cg_z")
BOX = ToleranceBox.around(generic_pair(), {name: 0.01 for name in NAMES})
SET = ToleranceSet(generic_pair(), BOX)


def test_slope_into_a_corner_is_all_multipliers():
    found = optimality(SET, np.array([1.0, -1.0, 1.0]), np.array([2.0, -3.0, 0.5]))
    assert found.active == ("M", "m", "M")
    assert found.multipliers == pytest.approx((2.0, 3.0, 0.5))
    assert found.residual == pytest.approx(0.0, abs=1e-15)


def test_slope_back_into_the_box_is_residual():
    """One bound is left inwards: 0.5 of a slope of length sqrt(9.25)."""
    found = optimality(SET, np.array([1.0, 1.0, 0.2]), np.array([3.0, -0.5, 0.0]))
    assert found.active == ("M", "M", "")
    assert found.multipliers == pytest.approx((3.0, 0.0, 0.0))
    assert found.residual == pytest.approx(0.5 / math.hypot(3.0, 0.5))


def test_multiplier_of_an_ellipsoid():
    """max g u over |u| <= 1: g = mu 2 u, with mu = |g| / 2."""
    tolerances = ToleranceSet(generic_pair(), BOX, [Ellipsoid(names=NAMES)])
    g = np.array([1.0, -2.0, 2.0])
    found = optimality(tolerances, g / 3.0, g)
    [(label, multiplier)] = found.constraints
    assert label == "ellipsoid of upper.cg_x upper.cg_y upper.cg_z"
    assert multiplier == pytest.approx(1.5)
    assert found.residual == pytest.approx(0.0, abs=1e-12)


def test_flat_objective_is_optimal_anywhere():
    found = optimality(SET, np.zeros(3), np.zeros(3))
    assert found.residual == 0.0
    assert found.active == ("", "", "")


def test_slope_inside_the_box_is_all_residual():
    assert optimality(SET, np.zeros(3), np.ones(3)).residual == pytest.approx(1.0)


def test_local_maxima_are_counted():
    values = [1.0, 2.0, 2.0 - 1e-8, 0.5, 1.0 + 1e-9]
    assert local_maxima(values) == ((2.0, 2), (1.0 + 1e-9, 2), (0.5, 1))
    assert local_maxima([]) == ()


def test_none_beyond_is_the_rule_of_three():
    assert fraction_beyond(0, 100_000, 0.95) == pytest.approx(
        1.0 - 0.05**1e-5, rel=1e-9
    )
    assert fraction_beyond(0, 100_000, 0.95) == pytest.approx(3e-5, rel=2e-3)


@pytest.mark.parametrize(("beyond", "samples"), [(0, 10), (3, 50), (49, 50)])
def test_bound_is_that_of_the_binomial(beyond, samples):
    """At the bound, so few are seen with a chance of 5 %."""
    p = fraction_beyond(beyond, samples, 0.95)
    assert binom.cdf(beyond, samples, p) == pytest.approx(0.05, rel=1e-9)


def test_all_beyond():
    assert fraction_beyond(5, 5, 0.95) == 1.0
