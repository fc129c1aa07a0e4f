"""Joints by constraint forces (Eq. 1-4): deviations, forces, torques, energies.

Their form, and the paper whose equations they number, are those of `relative_motion`.
"""

from typing import NamedTuple

from drakesep.systems.equations.relative_motion import BodyState, PairState
from drakesep.systems.model.joints import JointType, holds_all_rotations
from drakesep.systems.vectors import (
    TINY,
    Ops,
    Quaternion,
    Rotation,
    Scalar,
    Vector,
    add,
    conjugate,
    cross,
    dot,
    multiply,
    negate,
    rotate,
    rotation_vector,
    scale,
    subtract,
    unrotate,
)


_ZERO = (0.0, 0.0, 0.0)
_SMALL = 1e-2
"""Square of an angle, rad^2, below which a series stands for 0/0: neither the quotient
nor its derivative loses digits."""


class Deviation(NamedTuple):
    """How far a joint has been pulled from its mated place, and how fast."""

    value: Vector
    """m, or rad."""
    rate: Vector
    """m/s, or rad/s."""


def translation_deviation(
    pair: PairState, p_AoPad_A: Vector, p_BoPad_B: Vector
) -> tuple[Deviation, Vector]:
    """Return the deviation of B's attachment point, in A (Eq. 1), and its lever.

    Args:
        pair: the motion of B as seen from A.
        p_AoPad_A: attachment point fixed in A, m.
        p_BoPad_B: attachment point fixed in B, m.

    Returns:
        The deviation, and the point of B from B's origin, in A, m.
    """
    r = rotate(pair.R_AB, p_BoPad_B)
    return (
        Deviation(
            subtract(add(pair.p_AoBo, r), p_AoPad_A),  # Eq. 1
            add(pair.v_ABo, cross(pair.w_AB, r)),
        ),
        r,
    )


def constraint_force(
    deviation: Vector, rate: Vector, K: Vector, D: Vector
) -> tuple[Vector, Scalar]:
    """Return the force, or moment, of a joint's springs and dampers, and their energy.

    Args:
        deviation: in the joint's frame, m or rad.
        rate: of the deviation, m/s or rad/s.
        K: stiffness along x, y and z, N/m or N m/rad; zero where the joint is free.
        D: damping likewise, N s/m or N m s/rad.
    """
    (x, y, z), (vx, vy, vz) = deviation, rate
    fx, fy, fz = K[0] * x, K[1] * y, K[2] * z
    force = -fx - D[0] * vx, -fy - D[1] * vy, -fz - D[2] * vz  # Eq. 3 and 4
    return force, 0.5 * (fx * x + fy * y + fz * z)


class Turn(NamedTuple):
    """Rotation of B from its mated orientation, in A: vector, rad, and its rate.

    The rate is J w with J = 1 - [theta]/2 + c [theta]^2, so that a torque -J^T K theta
    has the potential theta^T K theta / 2, whatever the gains along the axes.
    """

    theta: Vector
    c: Scalar
    rate: Vector


NO_TURN = Turn(_ZERO, 0.0, _ZERO)
"""Where no joint asks for it."""


def rotation_from_mated(
    q_WA: Quaternion, q_WB: Quaternion, q_AB: Quaternion
) -> Quaternion:
    """Return the rotation of B from its mated orientation q_AB in A, in A."""
    return multiply(multiply(conjugate(q_WA), q_WB), conjugate(q_AB))


def rotation_deviation(
    A: BodyState, B: BodyState, q_AB: Quaternion, w_AB_A: Vector, ops: Ops
) -> Turn:
    """Return the rotation of B from its mated orientation; unique below 180 deg.

    Args:
        A: first body.
        B: second body.
        q_AB: orientation of B in A while mated.
        w_AB_A: angular velocity of B in A, in A, rad/s.
        ops: module of the elementary functions.
    """
    turned = rotation_from_mated(A.q_WB, B.q_WB, q_AB)
    theta = rotation_vector(turned, ops)  # Eq. 2
    c = _curvature(dot(theta, theta), ops)
    wt = cross(theta, w_AB_A)
    rate = add(subtract(w_AB_A, scale(0.5, wt)), scale(c, cross(theta, wt)))
    return Turn(theta, c, rate)


def _curvature(angle2: Scalar, ops: Ops) -> Scalar:
    """Return (1 - (angle/2) cot(angle/2)) / angle^2."""
    small = angle2 < _SMALL
    safe = angle2 + small
    half = 0.5 * ops.sqrt(safe)
    # Round-off of this difference meets angle^2 again.
    closed = (1.0 - half * ops.cos(half) / ops.sin(half)) / safe
    z = angle2
    series = (1 + z * (1 + z * (1 + z * (1 + z / 39.6) / 40) / 42) / 60) / 12
    return small * series + (1 - small) * closed


def twist_angle(
    q_WA: Quaternion, q_WB: Quaternion, q_AB: Quaternion, axis_A: Vector, ops: Ops
) -> Scalar:
    """Return by how much B has turned in A about an axis, from -pi to pi, rad.

    Args:
        q_WA: orientation of A.
        q_WB: orientation of B.
        q_AB: orientation of B in A while mated.
        axis_A: the axis, in A.
        ops: module of the elementary functions.
    """
    w, x, y, z = rotation_from_mated(q_WA, q_WB, q_AB)
    sine = ops.copysign(1.0, w) * dot(axis_A, (x, y, z))
    return 2.0 * ops.atan2(sine, abs(w))


def turning_torque(turn: Turn, moment: Vector) -> Vector:
    """Return J^T moment: the torque on B of a moment conjugate to `Turn.theta`."""
    tm = cross(turn.theta, moment)
    bent = scale(turn.c, cross(turn.theta, tm))
    return add(add(moment, scale(0.5, tm)), bent)  # Eq. 4


def swing_torque(
    x_B_J: Vector, w_J: Vector, K_T: Vector, D_T: Vector, ops: Ops
) -> tuple[Vector, Scalar]:
    """Return the torque on B that keeps an axis of it along the joint's x axis.

    The deviation is the angle between the axes, times the direction about which one
    turns into the other; turning about the axis itself is free. Unique below 180 deg.

    Args:
        x_B_J: the joint's x axis fixed in B, in the joint's frame J, fixed in A.
        w_J: angular velocity of B in A, in J, rad/s.
        K_T: stiffness, of which y and z are used, N m/rad.
        D_T: damping likewise, N m s/rad.
        ops: module of the elementary functions.

    Returns:
        Torque in J, N m, and energy, J.
    """
    x, y, z = x_B_J
    wx, wy, wz = w_J
    f, df = _swing(x, y * y + z * z, ops)
    theta_y, theta_z = -z * f, y * f  # Eq. 2
    # d theta / dt = G w, with the rates of the axis w x (x, y, z)
    dx_y, dx_z = z, -y
    G_y = -f * y, f * x - z * df * dx_y, -z * df * dx_z
    G_z = -f * z, y * df * dx_y, f * x + y * df * dx_z
    m_y = K_T[1] * theta_y + D_T[1] * (G_y[0] * wx + G_y[1] * wy + G_y[2] * wz)
    m_z = K_T[2] * theta_z + D_T[2] * (G_z[0] * wx + G_z[1] * wy + G_z[2] * wz)
    energy = 0.5 * (K_T[1] * theta_y * theta_y + K_T[2] * theta_z * theta_z)
    return negate(add(scale(m_y, G_y), scale(m_z, G_z))), energy  # Eq. 4


def _swing(cosine: Scalar, sine2: Scalar, ops: Ops) -> tuple[Scalar, Scalar]:
    """Return an angle over its sine, and the derivative of that with the cosine."""
    small = (sine2 < _SMALL) * (cosine > 0.0)
    safe = sine2 + small
    sine = ops.sqrt(safe + TINY)
    closed = ops.atan2(sine, cosine) / sine
    closed_slope = (cosine * closed - 1.0) / (safe + TINY)
    # Both series are hypergeometric: ratios of their terms, from the last inwards.
    f = slope = 1.0
    for k in range(7, 0, -1):
        f = 1.0 + (2 * k - 1) ** 2 / (2 * k * (2 * k + 1)) * sine2 * f
        slope = 1.0 + 2 * k / (2 * k + 3) * sine2 * slope
    return (
        small * f + (1 - small) * closed,
        small * slope / -3.0 + (1 - small) * closed_slope,
    )


def universal_torque(
    y_B_J: Vector, w_J: Vector, K_T: Vector, D_T: Vector, ops: Ops
) -> tuple[Vector, Scalar]:
    """Return the torque on B that keeps its y axis at a right angle to A's x axis.

    Eq. 2 with e_A the joint's x axis and e_B its y axis. The deviation is the angle by
    which they miss the right angle; at 90 deg the axes fall together and it locks.

    Args:
        y_B_J: the joint's y axis fixed in B, in the joint's frame J, fixed in A.
        w_J: angular velocity of B in A, in J, rad/s.
        K_T: stiffness, of which z is used, N m/rad.
        D_T: damping likewise, N m s/rad.
        ops: module of the elementary functions.

    Returns:
        Torque in J, N m, and energy, J.
    """
    x, y, z = y_B_J
    cosine = ops.sqrt(y * y + z * z + TINY)
    theta = ops.atan2(-x, cosine)  # Eq. 2
    # About the normal of both axes, x_A cross y_B.
    n_y, n_z = -z / cosine, y / cosine
    m = K_T[2] * theta + D_T[2] * (n_y * w_J[1] + n_z * w_J[2])
    return (0.0, -m * n_y, -m * n_z), 0.5 * K_T[2] * theta * theta  # Eq. 4


class HeldJoint(NamedTuple):
    """A joint that holds."""

    type: JointType
    R_AJ: Rotation | None
    """Orientation of its frame J in A; None if it is that of A."""
    K_F: Vector
    D_F: Vector
    K_T: Vector
    D_T: Vector
    p_AoPad_A: Vector
    p_BoPad_B: Vector
    axis_B: Vector
    """Its x axis, or y of a universal one, fixed in B."""

    def in_J(self, v_A: Vector) -> Vector:
        """Return a vector given in A."""
        return v_A if self.R_AJ is None else unrotate(self.R_AJ, v_A)

    def in_A(self, v_J: Vector) -> Vector:
        """Return a vector given in J."""
        return v_J if self.R_AJ is None else rotate(self.R_AJ, v_J)


class Pull(NamedTuple):
    """What a joint does to B, in its frame J, and the energy that it holds."""

    force: Vector
    torque: Vector
    """About B's pad, but for `moment`, N m."""
    moment: Vector
    """Of a joint that holds all rotations, conjugate to `Turn.theta`; else zero."""
    energy: Scalar


def joint_pull(
    joint: HeldJoint, motion: PairState, turn: Turn, ops: Ops
) -> tuple[Vector, Pull]:
    """Return B's pad from B's origin, in A, m, and what a joint does to B.

    Args:
        joint: the joint.
        motion: of B as seen from A.
        turn: of B in A, for a joint that holds all rotations.
        ops: module of the elementary functions.
    """
    (dx_A, v_A), r_A = translation_deviation(motion, joint.p_AoPad_A, joint.p_BoPad_B)
    force, energy = constraint_force(
        joint.in_J(dx_A), joint.in_J(v_A), joint.K_F, joint.D_F
    )
    torque = moment = _ZERO
    if holds_all_rotations(joint.type):
        moment, elastic = constraint_force(
            joint.in_J(turn.theta), joint.in_J(turn.rate), joint.K_T, joint.D_T
        )
        energy = energy + elastic
    elif joint.type != "spherical":
        law = universal_torque if joint.type == "universal" else swing_torque
        axis_J = joint.in_J(rotate(motion.R_AB, joint.axis_B))
        torque, elastic = law(
            axis_J, joint.in_J(motion.w_AB), joint.K_T, joint.D_T, ops
        )
        energy = energy + elastic
    return r_A, Pull(force, torque, moment, energy)


def joint_load(joint: HeldJoint, turn: Turn, pull: Pull) -> tuple[Vector, Vector]:
    """Return the torque about B's pad, N m, and the force, N, on B, in the frame J.

    Args:
        joint: the joint.
        turn: of B in A.
        pull: what it does.
    """
    moment_A = turning_torque(turn, joint.in_A(pull.moment))
    return add(pull.torque, joint.in_J(moment_A)), pull.force


def pull_at_origin(
    joint: HeldJoint, r_A: Vector, pull: Pull
) -> tuple[Vector, Vector, Vector]:
    """Return the force, the torque about B's origin and the moment on B, in A.

    Args:
        joint: the joint.
        r_A: B's pad from B's origin, in A, m.
        pull: what it does, in its frame.
    """
    force = joint.in_A(pull.force)
    torque = add(cross(r_A, force), joint.in_A(pull.torque))
    return force, torque, joint.in_A(pull.moment)
