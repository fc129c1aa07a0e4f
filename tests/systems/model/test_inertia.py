"""The condition on an inertia against the triangle inequality, and against Drake."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.tree import RotationalInertia, SpatialInertia

from drakesep.systems.model.inertia import physical_margin


def test_twenty_corners_of_table_2_are_impossible():
    nominal = np.array([669.0, 3136.0, 3265.0, 0.0, 0.0, 0.0])
    tolerance = np.array([70.0, 320.0, 330.0, 130.0, 130.0, 130.0])
    corners = nominal + tolerance * list(itertools.product((-1, 1), repeat=6))
    assert (physical_margin(corners) < 0).sum() == 20


@given(
    moments=st.tuples(*[st.floats(0.1, 5.0)] * 3),
    products=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
)
def test_margin_is_the_triangle_inequality(moments, products):
    entries = (*moments, *products)
    xx, yy, zz, xy, xz, yz = entries
    a, b, c = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    slack = 0.5 * (a + b - c)  # the largest moment against the others
    assert abs(physical_margin(entries) - slack) < 1e-13


@given(
    moments=st.tuples(*[st.floats(0.1, 5.0)] * 3),
    products=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
)
def test_drake_takes_what_is_physical(moments, products):
    entries = (*moments, *products)
    margin = physical_margin(entries)
    if abs(margin) < 1e-6:  # Drake's own tolerance decides there
        return
    try:
        SpatialInertia.MakeFromCentralInertia(
            1.0, [0.1, -0.2, 0.3], RotationalInertia(*entries)
        )
        accepted = True
    except RuntimeError:
        accepted = False
    assert accepted == (margin > 0)
