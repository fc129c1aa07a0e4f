"""The motion of bodies, in W and as seen from each other, and wrenches on them.

Pure functions on tuples of scalars: floats, or arrays whose lanes are samples (see
`drakesep.systems.vectors`), so that a LeafSystem, which integrates, and the analysis of
a whole trajectory run through the same lines. Numbered equations are those of Simplicio
and Bennani, "Worst-case Launch Vehicle Stage Separation Analysis". SI and radians.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.vectors import (
    Ops,
    Quaternion,
    Rotation,
    Scalar,
    Vector,
    add,
    compose,
    cross,
    negate,
    roll_pitch_yaw,
    rotate,
    rotation_matrix,
    subtract,
    transpose,
    unrotate,
)


State: TypeAlias = Sequence[Scalar] | NDArray[np.float64]
"""State of a plant: (n,) scalars, or rows of lanes."""


class BodyState(NamedTuple):
    """Pose and velocity of a body B in the world W."""

    q_WB: Quaternion
    """Orientation; its length is not assumed to be one."""
    R_WB: Rotation
    """The same as a matrix."""
    p_WBo: Vector
    """Position of B's origin in W, m."""
    w_WB: Vector
    """Angular velocity in W, expressed in W, rad/s."""
    v_WBo: Vector
    """Velocity of B's origin in W, m/s."""


class Wrench(NamedTuple):
    """A torque and a force on a body, expressed in W."""

    torque: Vector
    """Torque about the body's origin, N m."""
    force: Vector
    """Force, N."""


def add_wrenches(first: Wrench, second: Wrench) -> Wrench:
    """Return the sum of two wrenches about the same origin."""
    return Wrench(add(first.torque, second.torque), add(first.force, second.force))


def subtract_wrenches(first: Wrench, second: Wrench) -> Wrench:
    """Return the first of two wrenches about the same origin, less the second."""
    return Wrench(
        subtract(first.torque, second.torque), subtract(first.force, second.force)
    )


def reaction(wrench: Wrench) -> Wrench:
    """Return the opposite of a wrench, about the same origin."""
    return Wrench(negate(wrench.torque), negate(wrench.force))


def body_state(x: State, q: int, v: int) -> BodyState:
    """Read a floating body from a plant's state.

    Args:
        x: (nq + nv,) state of the plant, or (nq + nv, n) for n samples.
        q: where the body's quaternion and position begin in x.
        v: where its angular and linear velocity begin in x.
    """
    q_WB = x[q], x[q + 1], x[q + 2], x[q + 3]
    return BodyState(
        q_WB,
        rotation_matrix(q_WB),
        (x[q + 4], x[q + 5], x[q + 6]),
        (x[v], x[v + 1], x[v + 2]),
        (x[v + 3], x[v + 4], x[v + 5]),
    )


def velocity_at(body: BodyState, r_W: Vector) -> Vector:
    """Return the velocity in W of the body's point at r_W from its origin, m/s."""
    return add(body.v_WBo, cross(body.w_WB, r_W))


class PairState(NamedTuple):
    """Motion of body B as seen from body A, expressed in A."""

    R_AB: Rotation
    """Orientation of B."""
    p_AoBo: Vector
    """Place of B's origin, m."""
    w_AB: Vector
    """Angular velocity of B in A, rad/s."""
    v_ABo: Vector
    """Velocity of B's origin in A, m/s."""


def pair_state(A: BodyState, B: BodyState) -> PairState:
    """Return the motion of B as seen from A."""
    p_W = subtract(B.p_WBo, A.p_WBo)
    v_W = subtract(subtract(B.v_WBo, A.v_WBo), cross(A.w_WB, p_W))
    return PairState(
        compose(transpose(A.R_WB), B.R_WB),
        unrotate(A.R_WB, p_W),
        unrotate(A.R_WB, subtract(B.w_WB, A.w_WB)),
        unrotate(A.R_WB, v_W),
    )


def wrenches_at_origin(
    A: BodyState, p_AoBo_A: Vector, force_A: Vector, torque_A: Vector
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on A and on B of an interaction given at B's origin, in A.

    Both bodies feel it at the same point in space, so that linear and angular momentum
    are conserved exactly.

    Args:
        A: the body that feels the reaction.
        p_AoBo_A: B's origin from A's, in A, m.
        force_A: force on B, in A, N.
        torque_A: torque on B about its origin, in A, N m.
    """
    force = rotate(A.R_WB, force_A)
    on_A = rotate(A.R_WB, add(torque_A, cross(p_AoBo_A, force_A)))
    return (
        Wrench(negate(on_A), negate(force)),
        Wrench(rotate(A.R_WB, torque_A), force),
    )


class RelativeMotion(NamedTuple):
    """Motion of body B, in W and as seen from A."""

    rate: Vector
    """Angular velocity of B in W, in B, rad/s."""
    relative_rate: Vector
    """Angular velocity of B in A, in B, rad/s."""
    angle: Vector
    """Roll, pitch and yaw of B in W, rad."""
    relative_position: Vector
    """B's CG from its mated place, in A, m."""
    relative_velocity: Vector
    """Velocity of B's CG as seen from A, in A, m/s."""


def relative_motion(
    A: BodyState, B: BodyState, p_BoBcm_B: Vector, mated_p_AoBcm_A: Vector, ops: Ops
) -> RelativeMotion:
    """Return the motion of B in W and relative to A.

    Args:
        A: body pushed from.
        B: body pushed away.
        p_BoBcm_B: B's CG, m.
        mated_p_AoBcm_A: place of B's CG in A while mated, m.
        ops: module of the elementary functions.
    """
    p_BoBcm_W = rotate(B.R_WB, p_BoBcm_B)
    p_AoBcm_W = subtract(add(B.p_WBo, p_BoBcm_W), A.p_WBo)
    v_ABcm_W = subtract(velocity_at(B, p_BoBcm_W), velocity_at(A, p_AoBcm_W))
    return RelativeMotion(
        unrotate(B.R_WB, B.w_WB),
        unrotate(B.R_WB, subtract(B.w_WB, A.w_WB)),
        roll_pitch_yaw(B.R_WB, ops),
        subtract(unrotate(A.R_WB, p_AoBcm_W), mated_p_AoBcm_A),
        unrotate(A.R_WB, v_ABcm_W),
    )


def cg_acceleration(
    B: BodyState, p_BoBcm_B: Vector, alpha_WB: Vector, a_WBo: Vector
) -> Vector:
    """Return the acceleration of B's CG in W, m/s^2.

    Args:
        B: the body.
        p_BoBcm_B: its CG, m.
        alpha_WB: its angular acceleration in W, rad/s^2.
        a_WBo: the acceleration of its origin in W, m/s^2.
    """
    r = rotate(B.R_WB, p_BoBcm_B)
    centripetal = cross(B.w_WB, cross(B.w_WB, r))
    return add(a_WBo, add(cross(alpha_WB, r), centripetal))


def momentum_rate(
    B: BodyState, p_BoBcm_B: Vector, wrench: Wrench
) -> tuple[Vector, Vector]:
    """Return the rates of the momentum given to B by springs, in B.

    Args:
        B: the body.
        p_BoBcm_B: its CG, m.
        wrench: of all springs on B.

    Returns:
        d(delta p_B)/dt, N, and d(delta L_B)/dt about the CG, N m.
    """
    force_B = unrotate(B.R_WB, wrench.force)  # Eq. 8; integrand of Eq. 6
    torque_B = unrotate(B.R_WB, wrench.torque)
    return force_B, subtract(torque_B, cross(p_BoBcm_B, force_B))  # of Eq. 7
