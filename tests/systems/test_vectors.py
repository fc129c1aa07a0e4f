"""The tuple algebra against scipy's rotations."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drakesep.systems import vectors


EPS = np.finfo(float).eps
angle = st.floats(-1.5, 1.5)
component = st.floats(-10.0, 10.0)
vector = st.tuples(component, component, component)


def scipy_rotation(q):
    return Rotation.from_quat([*q[1:], q[0]])


@given(rpy=st.tuples(angle, angle, angle))
def test_roll_pitch_yaw_there_and_back(rpy):
    q = vectors.quaternion(rpy, math)
    expected = Rotation.from_euler("xyz", rpy).as_matrix()
    R = np.reshape(vectors.rotation_matrix(q), (3, 3))
    assert R == pytest.approx(expected, abs=16 * EPS)
    # cos(1.5) = 0.07 multiplies the round-off of roll and yaw by 14
    back = vectors.roll_pitch_yaw(vectors.rotation_matrix(q), math)
    assert back == pytest.approx(rpy, abs=64 * EPS)


@given(rpy=st.tuples(angle, angle, angle), v=vector, length=st.floats(0.1, 10.0))
def test_rotation_does_not_depend_on_the_quaternions_length(rpy, v, length):
    q = vectors.quaternion(rpy, math)
    R = vectors.rotation_matrix(tuple(length * c for c in q))
    rotated = vectors.rotate(R, v)
    assert rotated == pytest.approx(scipy_rotation(q).apply(v), abs=32 * EPS * 20)
    assert vectors.unrotate(R, rotated) == pytest.approx(v, abs=32 * EPS * 20)


@given(a=st.tuples(angle, angle, angle), b=st.tuples(angle, angle, angle))
def test_product_of_quaternions(a, b):
    p, q = vectors.quaternion(a, math), vectors.quaternion(b, math)
    product = vectors.multiply(p, q)
    expected = (scipy_rotation(p) * scipy_rotation(q)).as_matrix()
    R = np.reshape(vectors.rotation_matrix(product), (3, 3))
    assert R == pytest.approx(expected, abs=16 * EPS)
    identity = vectors.multiply(p, vectors.conjugate(p))
    assert identity == pytest.approx((1, 0, 0, 0), abs=8 * EPS)


@given(v=st.tuples(*[st.floats(-1.7, 1.7)] * 3), sign=st.sampled_from([1.0, -1.0]))
def test_rotation_vector_below_180_degrees(v, sign):
    """Both quaternions of a rotation give its vector, also at no rotation at all."""
    x, y, z, w = Rotation.from_rotvec(v).as_quat()
    result = vectors.rotation_vector((sign * w, sign * x, sign * y, sign * z), math)
    # The angle comes from an atan2 whose arguments carry a rounding each.
    assert result == pytest.approx(v, abs=16 * EPS)


def test_lanes_give_what_floats_give():
    rng = np.random.default_rng(0)
    lanes = rng.normal(size=(3, 5))
    q = vectors.quaternion(tuple(lanes), np)
    together = vectors.roll_pitch_yaw(vectors.rotation_matrix(q), np)
    for k in range(5):
        one = vectors.quaternion(tuple(lanes[:, k].tolist()), math)
        alone = vectors.roll_pitch_yaw(vectors.rotation_matrix(one), math)
        assert [lane[k] for lane in together] == pytest.approx(alone, abs=16 * EPS)
