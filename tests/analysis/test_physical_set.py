"""The physical part of a box, against the inertia's own condition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from separations import vega

from drakesep.analysis.dispersions import Box
from drakesep.analysis.physical_set import PhysicalSet
from drakesep.systems.inertia import physical_margin
from drakesep.systems.parameters import with_values


INERTIA = {
    f"payload.inertia_{entry}": tolerance
    for entry, tolerance in {
        "xx": 70.0,
        "yy": 320.0,
        "zz": 330.0,
        "xy": 130.0,
        "xz": 130.0,
        "yz": 130.0,
    }.items()
}
BOX = Box.around(vega(), {"payload.mass": 20.0, **INERTIA})
PHYSICAL = PhysicalSet(vega(), BOX)
points = st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7).map(np.array)


def margin(u):
    """Of the inertia itself, over its nominal trace of Sigma."""
    values = BOX.values(u)
    entries = [values[f"payload.inertia_{e}"] for e in ("xx", "yy", "zz")]
    entries += [values[f"payload.inertia_{e}"] for e in ("xy", "xz", "yz")]
    return physical_margin(entries) / (0.5 * (669.0 + 3136.0 + 3265.0))


@given(u=points)
def test_contains_what_is_physical(u):
    if abs(margin(u)) > 1e-8:  # the set stays 1e-9 inside
        assert PHYSICAL.contains(u) == (margin(u) > 0.0)


@given(u=points)
def test_drawn_back_points_can_be_flown(u):
    drawn = PHYSICAL.draw_back(u)
    with_values(vega(), BOX.values(drawn))  # raises if the inertia is impossible
    assert drawn[0] == u[0]
    if PHYSICAL.contains(u):
        assert drawn == pytest.approx(u, abs=1e-11)
    else:
        assert margin(drawn) == pytest.approx(0.0, abs=1e-8)  # on the boundary
        ratio = drawn[1:] @ u[1:] / (u[1:] @ u[1:])
        assert drawn[1:] == pytest.approx(ratio * u[1:], abs=1e-12)  # on the line


def test_derivatives_of_the_margins():
    rng = np.random.default_rng(9)
    u, h = rng.uniform(-1.0, 1.0, size=7), 1e-6
    differences = [
        (PHYSICAL.margins(u + h * e) - PHYSICAL.margins(u - h * e)) / (2.0 * h)
        for e in np.eye(7)
    ]
    jacobian = PHYSICAL.margins_jacobian(u)
    # eps / h of round-off
    assert jacobian == pytest.approx(np.array(differences).T, abs=1e-9)


def test_a_box_without_inertias_has_no_margins():
    box = Box.around(vega(), {"payload.mass": 20.0})
    physical = PhysicalSet(vega(), box)
    assert physical.margins(np.ones(1)).size == 0
    assert physical.contains(np.ones(1))
    assert physical.draw_back(np.ones(1)).tolist() == [1.0]
