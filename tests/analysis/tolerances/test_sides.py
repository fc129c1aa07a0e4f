"""Tolerances whose nominal is not the middle: the box, its corners, its growth."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from separations import generic_pair, vega

from drakesep.analysis.tolerances.box import Dispersion, ToleranceBox
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.sides import Sides
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet


PAIR = generic_pair()
TOLERANCES = {
    "upper.mass": 20.0,  # of 1200
    "upper.cg_y": Sides(minus=0.003, plus=0.012),  # of -0.02
    "upper.cg_z": Sides(minus=0.008, plus=0.0),
    "attachment_1.release_time": Sides(minus=0.0, plus=0.01),  # of 0
}
BOX = ToleranceBox.around(PAIR, TOLERANCES)
SET = ToleranceSet(PAIR, BOX)
LOWER, UPPER = np.array([-1.0, -0.25, -1.0, 0.0]), np.array([1.0, 1.0, 0.0, 1.0])
sides = st.floats(0.0, 1e3)


def test_scale_is_the_larger_side():
    assert BOX.tolerance.tolist() == [20.0, 0.012, 0.008, 0.01]
    assert (BOX.lower == LOWER).all()
    assert (BOX.upper == UPPER).all()
    low, high = BOX.values(LOWER), BOX.values(UPPER)
    assert low["upper.cg_y"] == pytest.approx(-0.023, rel=1e-15)
    assert high["upper.cg_y"] == pytest.approx(-0.008, rel=1e-15)
    assert low["attachment_1.release_time"] == 0.0  # a delay begins at none


def test_corners_and_what_is_opposite():
    signs = [[1, 1, 1, 1], [-1, -1, -1, -1], [0, 0, 0, 0], [2.5, -0.1, 0, 7]]
    corners = BOX.corners(signs)
    assert (corners[:3] == [UPPER, LOWER, np.zeros(4)]).all()
    assert corners[3].tolist() == [1.0, -0.25, 0.0, 1.0]
    assert (BOX.opposite(UPPER) == LOWER).all()
    assert (BOX.opposite(LOWER) == UPPER).all()


def test_at_which_bound_a_point_is():
    assert BOX.sides_of(UPPER, 1e-6).tolist() == [1, 1, 1, 1]
    assert BOX.sides_of(LOWER, 1e-6).tolist() == [-1, -1, -1, -1]
    # Of two parameters the nominal is itself a bound.
    assert BOX.sides_of(np.zeros(4), 1e-6).tolist() == [0, 0, 1, -1]
    assert BOX.sides_of([0.5, -1.0, -0.5, 1.1], 1e-6).tolist() == [0, 0, 0, 0]


@given(
    u=st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=4),
    factor=st.floats(1e-3, 5.0),
)
def test_drawn_into_the_box_and_grown_about_the_nominal(u, factor):
    drawn = SET.draw_back(u)
    assert (drawn == np.clip(u, LOWER, UPPER)).all()
    assert SET.contains(drawn)
    assert SET.contains(u) == bool((drawn == u).all())
    grown = SET.grown(factor)
    # Each side by as much, about the nominal: a product is rounded once.
    assert grown.box.tolerance == pytest.approx(factor * BOX.tolerance, rel=1e-15)
    assert grown.box.lower == pytest.approx(LOWER, rel=1e-15)
    assert grown.box.upper == pytest.approx(UPPER, rel=1e-15)
    assert (grown.box.nominal == BOX.nominal).all()


@given(nominal=sides, minus=sides, plus=sides)
def test_round_off_does_not_lead_beyond_a_bound(nominal, minus, plus):
    """Beyond it a parameter may not exist."""
    larger = max(minus, plus)
    if larger < 1e-15 or nominal + larger == nominal - larger:
        return  # refused
    box = ToleranceBox(
        [Dispersion(name="a", nominal=nominal, tolerance=Sides(minus=minus, plus=plus))]
    )
    [low], [high] = (list(box.values(u).values()) for u in (box.lower, box.upper))
    assert nominal - minus <= low <= nominal <= high <= nominal + plus
    # The share of the larger side is rounded, or the next below, and so is the product.
    close = 4.0 * np.finfo(float).eps * (nominal + minus + plus) + 1e-300
    assert low == pytest.approx(nominal - minus, rel=0.0, abs=close)
    assert high == pytest.approx(nominal + plus, rel=0.0, abs=close)


def test_samples_fill_the_box():
    points = SET.draw(20_000, np.random.default_rng(0))
    assert (points >= LOWER).all()
    assert (points <= UPPER).all()
    # Uniform: the mean of 20 000 of width w is within 4 w / sqrt(12 * 20 000).
    width = UPPER - LOWER
    assert (np.abs(points.mean(axis=0) - (LOWER + UPPER) / 2.0) < 0.0082 * width).all()


def test_inertia_stays_physical():
    """Each of two is possible at its bound, and both together are not."""
    tolerances = {
        "payload.inertia_xx": Sides(minus=10.0, plus=300.0),
        "payload.inertia_yz": Sides(minus=0.0, plus=250.0),
        "payload.inertia_yy": Sides(minus=400.0, plus=30.0),
    }
    box = ToleranceBox.around(vega(), tolerances)
    physical = ToleranceSet(vega(), box)
    assert 0.0 < physical.share_unphysical(10_000) < 0.5
    drawn = physical.draw_back(box.corners([-1.0, 1.0, -1.0]))
    assert physical.contains(drawn)
    assert (np.abs(drawn) < np.abs(box.corners([-1.0, 1.0, -1.0]))).all()


def test_an_ellipsoid_needs_the_middle():
    names = ("upper.mass", "upper.cg_y")
    with pytest.raises(ValueError, match=r"ellipsoid: upper.cg_y must have the same"):
        ToleranceSet(PAIR, BOX, [Ellipsoid(names=names)])


@pytest.mark.parametrize(
    ("minus", "plus", "message"),
    [
        (-1.0, 1.0, "minus must be >= 0, got -1"),
        (1.0, -1.0, "plus must be >= 0, got -1"),
        (0.0, 0.0, "minus or plus must be > 0, got 0 for both"),
        (math.nan, 1.0, "minus must be finite, got nan"),
        (1.0, math.inf, "plus must be finite, got inf"),
        ("a", 1.0, "minus must be a number, got 'a'"),
    ],
)
def test_what_is_no_tolerance(minus, plus, message):
    with pytest.raises(ValueError, match=message):
        Sides(minus=minus, plus=plus)


def test_reach_beyond_what_exists():
    tolerances = {"upper.mass": Sides(minus=1200.0, plus=1.0)}
    with pytest.raises(ValueError, match=r"upper.mass: tolerance must keep to phys"):
        ToleranceBox.around(PAIR, tolerances)
    tolerances = {"attachment_1.release_time": Sides(minus=0.1, plus=1.0)}
    with pytest.raises(ValueError, match=r"release_time: tolerance must keep to phys"):
        ToleranceBox.around(PAIR, tolerances)
