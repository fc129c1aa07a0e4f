"""What is said of a body's motion by its pair, on bodies mated at an attitude."""

import dataclasses
import math

import pytest
from scipy.spatial.transform import Rotation
from separations import generic_pair

from drakesep.systems.equations.pair_signals import PairFacts, from_mated


MATED = (0.4, -0.7, 1.1)
"""Roll, pitch and yaw of B in A, rad: far from any axis."""
ROUND_OFF = 1e-12


def mated_at(rpy_AB):
    pair = generic_pair()
    upper = dataclasses.replace(pair.body("upper"), rpy_AB=rpy_AB)
    pair = dataclasses.replace(pair, bodies=(pair.body("lower"), upper))
    return PairFacts.of(pair, pair.pairs[0])


def turned(rpy):
    """By roll, pitch and yaw, about axes that turn along."""
    return Rotation.from_euler("ZYX", rpy[::-1])


@pytest.mark.parametrize("axis", range(3))
def test_deviation_from_the_mated_attitude_is_about_the_bodys_axes(axis):
    """Mated askew, then turned about an axis of its own."""
    deviation = [0.0, 0.0, 0.0]
    deviation[axis] = 0.2
    yaw, pitch, roll = (turned(MATED) * turned(deviation)).as_euler("ZYX")
    found = from_mated((roll, pitch, yaw), mated_at(MATED), math)
    assert found == pytest.approx(deviation, abs=ROUND_OFF)


def test_as_mated_there_is_no_deviation():
    assert from_mated(MATED, mated_at(MATED), math) == pytest.approx(
        (0.0, 0.0, 0.0), abs=ROUND_OFF
    )
