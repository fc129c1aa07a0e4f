"""Laws as straight lines: the numbers of the laws themselves, to the last bit."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drakesep.systems.equations import articulated_inertia as laws
from drakesep.systems.equations.pushers import positive_part
from drakesep.systems.equations.relative_motion import Wrench, body_state
from drakesep.systems.equations.rigid_joints import JointPlace, joined
from drakesep.systems.equations.straight_line import (
    LINE_OPS,
    line_if_straight,
    straight_line,
)
from drakesep.systems.model.joints import JOINT_TYPES


class Pair(NamedTuple):
    first: float
    second: tuple[float, float]


def numbers(seed, count):
    return tuple(np.random.default_rng(seed).normal(size=count).tolist())


def body(seed):
    return body_state(numbers(seed, 13), 0, 7)


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_numbers_are_those_of_the_law(seed):
    B, (p, q) = body(seed), (numbers(seed + k, 3) for k in (1, 2))
    massive = laws.Massive(3.0, p, numbers(seed + 3, 6))
    D, wrench = laws.inertia_of_body(B, massive)
    S, given = laws.Acceleration(p, q), Wrench(q, p)
    for law, arguments in (
        (laws.inertia_of_body, (B, massive)),
        (laws.acceleration_by, (D, given)),
        (laws.without_direction, (D, wrench, S)),
        (laws.shifted_inertia, (D, p)),
    ):
        assert straight_line(law)(*arguments) == law(*arguments)


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_what_is_fixed_may_be_branched_on(type):
    A, B, R = body(1), body(2), body(3).R_WB
    place = JointPlace(R, *(numbers(k, 3) for k in (4, 5, 6)), numbers(7, 4))
    assert straight_line(joined, type)(place, A, B) == joined(type, place, A, B)


def mixed(pair, x):
    """Constants on either side, what is used twice, and more than a line bears."""
    first, (a, b) = pair
    total = 0.0
    for k in range(60):
        total = (total + a * k) * 0.5 - 1.0 / (2.0 - x)
    return Pair(-(first**2), (3.0 * total + total, 0.0 * b)), (1.0, x - 0.0)


def test_structures_and_constants():
    arguments = Pair(1.5, (0.25, -2.0)), 0.75
    got = straight_line(mixed)(*arguments)
    assert got == mixed(*arguments)
    assert isinstance(got[0], Pair)


def kinked(ops, placed, x, place):
    """Magnitudes, comparisons, elementary functions, and a place that may be none."""
    inside = (x < 0.5) + (2.0 > x) * (x >= -1.0) + (1 - (x <= 0.0))
    bent = positive_part(x) * inside + ops.sqrt(x * x) * ops.atan2(x, 2.0)
    if placed:
        bent = bent + ops.cos(place[0]) * ops.sqrt(2.0)
    return bent, (abs(bent), None)


@pytest.mark.parametrize("x", [-2.0, -0.5, 0.0, 0.5, 0.7, 3.0])
@pytest.mark.parametrize("place", [None, (0.3,)])
def test_kinks_and_functions(x, place):
    placed = place is not None
    wanted = kinked(math, placed, x, place)
    assert straight_line(kinked, LINE_OPS, placed)(x, place) == wanted
    assert kinked(LINE_OPS, placed, x, place) == wanted


NO_LINES = {
    "truth": lambda x: 1.0 if x else 2.0,
    "larger": lambda x: max(x, 1.0),
    "equal": lambda x: 1.0 if x == 0.5 else 2.0,
    "of another module": lambda x: math.sqrt(x),
    "numpy": lambda x: float(np.sqrt(x)),
}


@pytest.mark.parametrize("law", NO_LINES.values(), ids=NO_LINES)
def test_what_is_no_line_is_refused_or_left_as_it_is(law):
    with pytest.raises(TypeError):
        straight_line(law)(0.5)
    left = line_if_straight(law)
    assert [left(x) for x in (0.5, 0.75)] == [law(x) for x in (0.5, 0.75)]


def test_what_has_no_hash_may_be_fixed():
    assert line_if_straight(lambda fixed, x: fixed[0] * x, [3.0])(0.5) == 1.5
