"""Options of integrals are above the integrals of signals with known ones."""

import numpy as np
import pytest

from drakesep.analysis.bounds.grid import Grid
from drakesep.analysis.bounds.integrals import by_mean, by_sign
from drakesep.analysis.bounds.jets import Jet
from drakesep.analysis.bounds.quantities import _followed


GRID = Grid(np.linspace(0.0, 2.0, 41), 10)
COAST = 10
START, END = GRID.times[:-1], GRID.times[1:]


def line(at_0: float, slope: float) -> tuple[Jet, Jet]:
    """A signal at_0 + slope t, which grows with at_0, and its derivative by time."""
    ends = at_0 + slope * START, at_0 + slope * END
    ones, none = np.ones_like(START), np.zeros_like(START)
    x = Jet(
        np.array([np.minimum(*ends), ones])[:, None],
        np.array([np.maximum(*ends), ones])[:, None],
    )
    rate = np.array([slope * ones, none])[:, None]
    return x, Jet(rate, rate)


@pytest.mark.parametrize("at_0", [-0.9, -0.2, 0.0, 0.3, 1.1])
@pytest.mark.parametrize("slope", [-0.1, 0.02, 0.4])
def test_options_are_above_the_integrals_of_lines(at_0, slope):
    x, change = line(at_0, slope)
    t = np.linspace(0.0, 2.0, 20001)
    exact = at_0 + slope * t
    magnitude = by_sign(x, GRID, COAST).value.hi.max()
    # The rule's error where the line crosses zero is below a step squared.
    assert np.trapezoid(np.abs(exact), t) <= magnitude + 1e-8
    square = by_mean(x, change, GRID, COAST, (-0.5, 0.0, 0.5)).value.hi.max()
    integral = ((at_0 + 2.0 * slope) ** 3 - at_0**3) / (3.0 * slope)
    assert integral <= square
    # What pieces of 0.05 s cost, beside Wirtinger's 12 / pi^2 for a line.
    most = np.abs(exact).max()
    moved = slope**2 * 1.5**3 / 12.0
    assert square <= integral + 0.05 * abs(slope) * most * 4.0 + 0.22 * moved


def test_of_a_constant_the_cell_of_its_mean_is_all_of_its_square():
    x, change = line(0.7, 0.0)
    found = by_mean(x, change, GRID, COAST, (0.5, 1.0))
    assert found.value.hi.max() == pytest.approx(2.0 * 0.49, rel=1e-12)
    # Of the cell below, the tangent at its end: 2 l x - l^2.
    below = 0.5 * 0.49 + 1.5 * (2.0 * 0.5 * 0.7 - 0.25)
    assert found.value.hi[0, 0] == pytest.approx(below, rel=1e-12)
    assert found.slopes.lo[0, 0, 1] == pytest.approx(2.0 * 2.0 * 0.7, rel=1e-12)


def test_an_angle_is_not_known_again_once_it_may_have_left():
    """Over time it goes on beyond half a turn: a whole one later it is another."""
    values = np.array([[[0.1, np.nan, 0.2]], [[1.0, np.nan, 1.0]]])
    angle = _followed(Jet(values, values))
    assert np.isfinite(angle.lo[..., 0]).all()
    assert np.isnan(angle.lo[..., 1:]).all() and np.isnan(angle.hi[..., 1:]).all()
