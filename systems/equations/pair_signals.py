"""What is said of the motion of a pair along and about its direction.

Functions of a vector of the motion (see `drakesep.systems.model.run.Motion`) and of
the pair as it is mated, on floats or on lanes. Moduli are told by their squares, and
cones by the square of the sine of half their angle, which are smooth where the others
have kinks.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from drakesep.systems.model.separation import Pair, Separation
from drakesep.systems.vectors import (
    Ops,
    Rotation,
    Scalar,
    Symmetric,
    Vector,
    apply,
    compose,
    dot,
    quaternion,
    roll_pitch_yaw,
    rotate,
    rotation_matrix,
    scale,
    subtract,
    transpose,
    unrotate,
)


_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class PairFacts(NamedTuple):
    """A pair as it is mated."""

    direction_A: Vector
    """In which B leaves, fixed in A."""
    direction_B: Vector
    """The same, fixed in B."""
    direction_S: Vector
    """The same in the nominal stack, whose axes are W's."""
    R_SB: Rotation
    """Orientation of B in the nominal stack."""
    I_BBcm_B: Symmetric
    """Inertia of B about its CG, kg m^2; floats or lanes."""

    @classmethod
    def of(cls, separation: Separation, pair: Pair) -> "PairFacts":
        """Return those of a separation."""
        A, B = separation.body(pair.A), separation.body(pair.B)
        R_SA, R_SB = (rotation_matrix(quaternion(x.rpy_AB, math)) for x in (A, B))
        direction_S = rotate(R_SA, pair.direction)
        return cls(
            pair.direction,
            unrotate(R_SB, direction_S),
            direction_S,
            R_SB,
            B.I_BBcm_B,
        )


def from_mated(angle: Vector, facts: PairFacts, ops: Ops) -> Vector:
    """Return roll, pitch and yaw of B from its attitude in the nominal stack, rad.

    Args:
        angle: roll, pitch and yaw of B in W, rad.
        facts: of its pair.
        ops: module of the elementary functions.
    """
    if facts.R_SB == _IDENTITY:
        return angle
    R_WB = rotation_matrix(quaternion(angle, ops))
    return roll_pitch_yaw(compose(transpose(facts.R_SB), R_WB), ops)


def along(vector_A: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return the component of a vector in A along the direction."""
    return (dot(vector_A, facts.direction_A),)


def across_squared(vector_A: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return the square of what a vector in A has across the direction."""
    return (_across_squared(vector_A, facts.direction_A),)


def about(vector_B: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return the component of a vector in B along the direction as mated."""
    return (dot(vector_B, facts.direction_B),)


def transverse_squared(vector_B: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return the square of what a vector in B has across the direction as mated."""
    return (_across_squared(vector_B, facts.direction_B),)


def length_squared(vector: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return the square of the length of a vector."""
    return (dot(vector, vector),)


def length(vector: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return the length of a vector; its derivative at zero, a kink, is zero."""
    square: Any = dot(vector, vector)
    none = square == 0.0
    return ((square + none) ** 0.5 * (1.0 - none),)


def force_squared(load: Sequence[Scalar], facts: Any, ops: Ops) -> tuple[Scalar]:
    """Return the square of the force of a joint's load, torque first."""
    return (dot((load[3], load[4], load[5]), (load[3], load[4], load[5])),)


def torque_squared(load: Sequence[Scalar], facts: Any, ops: Ops) -> tuple[Scalar]:
    """Return the square of the torque of a joint's load, torque first."""
    return (dot((load[0], load[1], load[2]), (load[0], load[1], load[2])),)


def tip_off(angle: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return sin^2 of half the angle between B's axis and its mated direction in W.

    B's axis is the direction as mated, fixed in B; the mated direction is that of the
    nominal stack.

    Args:
        angle: roll, pitch and yaw of B in W, rad.
        facts: of its pair.
        ops: module of the elementary functions.
    """
    R_WB = rotation_matrix(quaternion(angle, ops))
    apart = subtract(rotate(R_WB, facts.direction_B), facts.direction_S)
    return (0.25 * dot(apart, apart),)


def nutation(rate: Vector, facts: PairFacts, ops: Ops) -> tuple[Scalar]:
    """Return sin^2 of half the angle between B's angular momentum and its axis.

    The axis is that of the direction as mated, to the side to which B spins about it.
    Without angular momentum there is no such angle: 0.

    Args:
        rate: of B in W, in B, rad/s.
        facts: of its pair.
        ops: module of the elementary functions.
    """
    h = apply(facts.I_BBcm_B, rate)
    axis: Any = facts.direction_B
    square = dot(h, h)
    spin = dot(h, axis)
    none = square == 0.0
    length = (square + none) ** 0.5
    unit = scale(1.0 / length, h)
    side = 1.0 - 2.0 * (spin < 0.0)
    apart = subtract(unit, scale(side, axis))
    return (0.25 * dot(apart, apart) * (1.0 - none),)


def _across_squared(vector: Vector, direction: Vector) -> Scalar:
    across = subtract(vector, scale(dot(vector, direction), direction))
    return dot(across, across)
