"""The set of tolerances, against the inertia's own condition and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from separations import generic_pair, vega

from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.parameters import with_values


ENTRIES = {"xx": 70.0, "yy": 320.0, "zz": 330.0, "xy": 130.0, "xz": 130.0, "yz": 130.0}
INERTIA = {f"payload.inertia_{entry}": value for entry, value in ENTRIES.items()}
BOX = ToleranceBox.around(vega(), {"payload.mass": 20.0, **INERTIA})
PHYSICAL = ToleranceSet(vega(), BOX)
points = st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7).map(np.array)

CG = ("upper.cg_x", "upper.cg_y", "upper.cg_z")
CORRELATION = ((1.0, 0.8), (0.8, 1.0))
PAIR_BOX = ToleranceBox.around(generic_pair(), {name: 0.01 for name in CG})
PAIR = ToleranceSet(
    generic_pair(), PAIR_BOX, [Ellipsoid(names=CG[:2], correlation=CORRELATION)]
)


def margin(u):
    """Of the inertia itself, over its nominal trace of Sigma."""
    values = BOX.values(u)
    xx, yy, zz, xy, xz, yz = (values[f"payload.inertia_{e}"] for e in ENTRIES)
    a, b, c = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    # The largest moment against the others: the triangle inequality.
    return 0.5 * (a + b - c) / (0.5 * (669.0 + 3136.0 + 3265.0))


@given(u=points)
def test_contains_what_is_physical(u):
    if abs(margin(u)) > 1e-7:  # the set stays 1e-8 inside
        assert PHYSICAL.contains(u) == (margin(u) > 0.0)


@pytest.mark.slow
@given(u=points)
def test_drawn_back_points_can_be_flown(u):
    drawn = PHYSICAL.draw_back(u)
    with_values(vega(), BOX.values(drawn))  # raises if the inertia is impossible
    assert drawn[0] == u[0]
    assert PHYSICAL.contains(drawn)
    if PHYSICAL.contains(u):
        assert drawn == pytest.approx(u, abs=1e-11)
    else:
        assert margin(drawn) == pytest.approx(0.0, abs=1e-7)  # on the boundary
        ratio = drawn[1:] @ u[1:] / (u[1:] @ u[1:])
        assert drawn[1:] == pytest.approx(ratio * u[1:], abs=1e-12)  # on the line


def test_many_points_are_each_as_alone():
    rng = np.random.default_rng(5)
    many = rng.uniform(-1.5, 1.5, size=(50, 7))
    drawn = PHYSICAL.draw_back(many)
    assert np.array_equal(drawn, [PHYSICAL.draw_back(u) for u in many])
    assert PHYSICAL.contains(drawn).all()
    assert np.abs(drawn).max() <= 1.0


@pytest.mark.parametrize("tolerances", [PHYSICAL, PAIR])
def test_derivatives_of_the_margins(tolerances):
    rng = np.random.default_rng(9)
    n = len(tolerances)
    u, h = rng.uniform(-0.5, 0.5, size=n), 1e-6
    differences = [
        (tolerances.margins(u + h * e) - tolerances.margins(u - h * e)) / (2.0 * h)
        for e in np.eye(n)
    ]
    # eps / h of round-off
    assert tolerances.jacobian(u) == pytest.approx(np.array(differences).T, abs=1e-9)
    assert len(tolerances.margin_labels) == len(tolerances.margins(u))


def test_a_box_without_inertias_has_no_margins():
    box = ToleranceBox.around(vega(), {"payload.mass": 20.0})
    tolerances = ToleranceSet(vega(), box)
    assert tolerances.margins(np.ones(1)).size == 0
    assert tolerances.contains(np.ones(1))
    assert tolerances.draw_back(np.ones(1)).tolist() == [1.0]
    assert tolerances.share_unphysical() == 0.0


def test_share_that_is_unphysical():
    """The triangle inequality: xx + yy >= zz, a plane that cuts a corner off a cube.

    Of u in [-1, 1]^3 it keeps c + a (u_x + u_y - u_z) >= 0; each moment alone stays
    possible, since c > a, and the corner (-1, -1, 1) lacks what is beyond.
    """
    c, a = 100.0, 80.0
    data = vega()
    body = data.bodies[1]
    nominal = with_values(
        data,
        dict(
            zip(
                (f"payload.inertia_{e}" for e in ("xx", "yy", "zz")),
                (1000.0, 1000.0, 2000.0 - c),
                strict=True,
            )
        ),
    )
    box = ToleranceBox.around(
        nominal, {f"payload.inertia_{e}": a for e in ("xx", "yy", "zz")}
    )
    side = 3.0 - c / a  # of the corner's edges, of length 2 in u
    corner = (side**3 - 0.0) / 6.0 if side <= 2.0 else math.nan
    share = ToleranceSet(nominal, box).share_unphysical(200_000)
    assert body.name == "payload"
    # four standard deviations of a share of 200 000 samples
    assert share == pytest.approx(corner / 8.0, abs=4 * math.sqrt(0.09 * 0.91 / 2e5))


def test_samples_are_uniform_in_an_ellipsoid():
    rng = np.random.default_rng(1)
    u = PAIR.draw(40_000, rng)
    assert PAIR.contains(u).all()
    # uniform in a disc: the covariance is C / 4; in the box's own direction 1 / 3
    close = 4.0 / math.sqrt(40_000)
    assert np.cov(u[:, :2].T) == pytest.approx(np.array(CORRELATION) / 4.0, abs=close)
    assert u[:, 2].var() == pytest.approx(1.0 / 3.0, abs=close)


def test_samples_are_those_of_the_seed():
    drawn = [PHYSICAL.draw(100, np.random.default_rng(3)) for _ in range(2)]
    assert np.array_equal(*drawn)
    assert PHYSICAL.contains(drawn[0]).all()


@given(u=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).map(np.array))
def test_ellipsoid_is_reached_on_the_line_to_the_nominal(u):
    drawn = PAIR.draw_back(u)
    v = u[:2]
    size = math.sqrt(v @ np.linalg.inv(CORRELATION) @ v)
    assert drawn[:2] == pytest.approx(v / max(size, 1.0), abs=1e-11)
    assert drawn[2] == u[2]


def test_each_parameter_alone_reaches_its_tolerance():
    """The support of the ellipsoid along each axis is 1, whatever the correlation."""
    C = np.array(CORRELATION)
    for i in range(2):
        u = np.zeros(3)
        u[:2] = C[i]  # the point of u^T C^-1 u = 1 farthest along the axis
        assert u[i] == 1.0
        assert PAIR.margins(u)[0] == pytest.approx(0.0, abs=1e-15)


def test_growth_moves_points_and_keeps_them_possible():
    u = np.array([1.0, -1.0, -1.0, 1.0, 1.0, 1.0, -1.0])
    grown = PHYSICAL.grown(3.0)
    assert grown.box.tolerance == pytest.approx(3.0 * BOX.tolerance)
    drawn = PHYSICAL.grown_points(u, 3.0)
    assert drawn[0] == 3.0
    with_values(vega(), BOX.values(drawn))
    assert PHYSICAL.rows(drawn) == pytest.approx(grown.rows(grown.draw_back(u)))


@pytest.mark.parametrize(
    ("ellipsoids", "message"),
    [
        ([("upper.cg_x",)], "must have two different parameters or more"),
        ([("upper.cg_x", "upper.cg_x")], "must have two different parameters or more"),
        ([("upper.cg_x", "upper.mass")], "unknown dispersed parameter 'upper.mass'"),
        ([CG[:2], CG[1:]], "upper.cg_y must stand in one of them, got two"),
    ],
)
def test_bad_ellipsoids(ellipsoids, message):
    with pytest.raises(ValueError, match=message):
        ToleranceSet(
            generic_pair(), PAIR_BOX, [Ellipsoid(names=names) for names in ellipsoids]
        )


@pytest.mark.parametrize(
    ("correlation", "message"),
    [
        (((1.0, 0.5),), "must be a matrix of 2 by 2 numbers"),
        (((1.0, math.nan), (math.nan, 1.0)), "must be a matrix of 2 by 2 numbers"),
        (((1.0, 0.5), (0.4, 1.0)), "must be symmetric with 1 on its diagonal"),
        (((2.0, 0.5), (0.5, 1.0)), "must be symmetric with 1 on its diagonal"),
        (((1.0, 1.0), (1.0, 1.0)), "must be positive definite"),
    ],
)
def test_bad_correlations(correlation, message):
    with pytest.raises(ValueError, match=message):
        Ellipsoid(names=CG[:2], correlation=correlation)


def test_a_flat_body_has_no_inertias_around_it():
    """xx + yy = zz: of a disc, at the edge of what is possible."""
    flat = with_values(
        vega(),
        {
            "payload.inertia_xx": 500.0,
            "payload.inertia_yy": 500.0,
            "payload.inertia_zz": 1000.0,
        },
    )
    box = ToleranceBox.around(flat, {"payload.inertia_xy": 1.0})
    with pytest.raises(ValueError, match=r"payload.inertia: the nominal must be"):
        ToleranceSet(flat, box)


def test_a_set_with_hardly_a_physical_point_gives_no_samples():
    """A sliver: products that must be a thousandth of their tolerances."""
    thin = with_values(
        vega(),
        {
            "payload.inertia_xx": 1e-3,
            "payload.inertia_yy": 1000.0,
            "payload.inertia_zz": 1000.0,
        },
    )
    box = ToleranceBox.around(thin, {"payload.inertia_yz": 1e-4})
    wide = ToleranceSet(thin, box).grown(1e5)
    with pytest.raises(ValueError, match="a thousandth is physical"):
        wide.draw(10, np.random.default_rng(0))
