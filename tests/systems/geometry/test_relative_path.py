"""Bounds on how fast a body moves, against the path itself between its samples."""

import numpy as np
import pytest
from flights import trajectory
from scipy.spatial.transform import Rotation
from tumbling import Tumbling

from drakesep.systems.geometry.relative_path import RelativePath


SLIGHTLY = 1e-3
"""By which differences over 1e-4 s may exceed what they stand for, relative."""
CLOSER = 1e-4
"""Between moments at which differences are taken, s."""


def test_turning_between_samples_at_which_it_rests():
    """Half a rad from rest to rest: the cubic is 1.5 times as fast in the middle."""
    time = np.array([0.0, 1.0, 2.0])
    angle, rate = np.array([0.0, 0.5, 0.5]), np.zeros(3)
    path = RelativePath(
        trajectory(time, np.zeros((3, 3)), np.zeros((3, 3)), angle=angle, rate=rate),
        "lower",
        "upper",
    )
    assert path.bounds(0.0, 1.0).angular_speed >= 0.75 * (1.0 - SLIGHTLY)
    assert path.bounds(1.0, 2.0).angular_speed == 0.0  # not of the stretch before


def test_acceleration_of_a_cubic():
    """x = 3 t^2 - 2 t^3: 6 m/s^2 at both ends, and nothing of the sample after."""
    time = np.array([0.0, 1.0, 2.0])
    places = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]])
    path = RelativePath(trajectory(time, places, np.zeros((3, 3))), "lower", "upper")
    assert path.bounds(0.0, 1.0).acceleration == pytest.approx(6.0)
    assert path.bounds(1.0, 2.0).acceleration == 0.0
    assert path.bounds(0.5, 1.5).acceleration == pytest.approx(6.0)


@pytest.mark.parametrize("t", [0.0, 0.01, 0.25, 0.5, 0.9, 1.0])
def test_two_samples_tell_where_a_body_is_between_them(t):
    """The cubic between two samples is theirs alone: bit for bit as of the whole."""
    flown = Tumbling(0).trajectory(np.linspace(0.0, 1.0, 9))
    whole = RelativePath(flown, "lower", "upper").at(t)
    alone = RelativePath(flown.around(t), "lower", "upper").at(t)
    assert len(flown.around(t).time) == 2
    for mine, theirs in zip(alone, whole, strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("seed", range(8))
def test_bounds_hold_between_samples(seed):
    """A tumbling body, sampled a few times a turn."""
    motion = Tumbling(seed)
    time = np.linspace(0.0, 1.0, 7)
    path = RelativePath(motion.trajectory(time), "lower", "upper")
    point = np.array([0.3, -0.2, 0.5])
    for start, end in ((0.0, 1.0), (0.1, 0.3), (0.4, 0.45), (0.8, 1.0)):
        bounds = path.bounds(start, end)
        moments = np.arange(start, end, CLOSER)
        R_AB, p_AoBo_A = path.places(moments)
        steps = Rotation.from_matrix(R_AB[1:]) * Rotation.from_matrix(R_AB[:-1]).inv()
        fastest = steps.magnitude().max() / CLOSER
        assert fastest <= bounds.angular_speed * (1.0 + SLIGHTLY)
        inner = slice(1, -1)
        whole = np.diff(p_AoBo_A, n=2, axis=0)[inner] / CLOSER**2
        largest = np.linalg.norm(whole, axis=1).max()
        assert largest <= bounds.acceleration * (1.0 + SLIGHTLY)
        turned = np.diff(R_AB @ point, n=2, axis=0)[inner] / CLOSER**2
        bent = np.linalg.norm(turned, axis=1).max() / np.linalg.norm(point)
        assert bent <= bounds.bending * (1.0 + SLIGHTLY)
