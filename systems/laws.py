"""The equations of separation, as pure functions on tuples of scalars.

Every function takes floats, or arrays whose lanes are samples (see
`drakesep.systems.vectors`), so that the LeafSystems, which integrate, and the
motion analysis of a whole trajectory run through the same lines. Numbered
equations are those of Simplicio and Bennani, "Worst-case Launch Vehicle Stage
Separation Analysis". SI units and radians throughout.
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
    conjugate,
    cross,
    dot,
    multiply,
    negate,
    roll_pitch_yaw,
    rotate,
    rotation_matrix,
    rotation_vector,
    scale,
    subtract,
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


def action_and_reaction(
    A: BodyState, B: BodyState, p_WQ: Vector, force: Vector, torque: Vector
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on A and on B of an interaction at one point in space.

    Both bodies feel the force on the same line of action, so that linear and
    angular momentum are conserved exactly.

    Args:
        A: the body that feels the reaction.
        B: the body that feels `force` and `torque`.
        p_WQ: the point, from W's origin, m.
        force: force on B, in W, N.
        torque: torque on B, in W, N m.
    """
    moment_A = cross(subtract(p_WQ, A.p_WBo), force)
    moment_B = cross(subtract(p_WQ, B.p_WBo), force)
    return (
        Wrench(negate(add(moment_A, torque)), negate(force)),
        Wrench(add(moment_B, torque), force),
    )


def spring_force(
    elapsed: Scalar, force_max: Scalar, frequency: Scalar, ops: Ops
) -> Scalar:
    """Return a spring's force between release and the end of its stroke, N.

    Args:
        elapsed: time since release, s, from 0 to pi / (2 frequency).
        force_max: force at release, N.
        frequency: sqrt(force_max / (design_mass stroke)), rad/s.
        ops: module of the elementary functions.
    """
    return force_max * ops.cos(frequency * elapsed)  # Eq. 5


def spring_displacement(
    A: BodyState,
    B: BodyState,
    p_AoPad_A: Sequence[Scalar],
    p_BoPad_B: Sequence[Scalar],
) -> tuple[Scalar, Scalar]:
    """Return how far, m, and how fast, m/s, B's pad has moved along A's x axis.

    Args:
        A: body pushed from.
        B: body pushed away.
        p_AoPad_A: mated place of the pad in A, m.
        p_BoPad_B: the pad, fixed in B, m.
    """
    r_B = rotate(B.R_WB, (p_BoPad_B[0], p_BoPad_B[1], p_BoPad_B[2]))
    r_A = subtract(add(B.p_WBo, r_B), A.p_WBo)
    v_APad = subtract(velocity_at(B, r_B), velocity_at(A, r_A))
    e_xA = A.R_WB[0], A.R_WB[3], A.R_WB[6]
    return dot(e_xA, r_A) - p_AoPad_A[0], dot(e_xA, v_APad)


def linear_spring_force(
    displacement: Scalar,
    speed: Scalar,
    force_max: Scalar,
    stroke: Scalar,
    damping: Scalar,
) -> Scalar:
    """Return the force of a spring and damper within its stroke, N.

    With `spring_displacement` as its argument, the spring's work is exactly what its
    energy loses: the force acts along the axis on which displacement is measured.
    """
    return force_max * (1.0 - displacement / stroke) - damping * speed


def linear_spring_energy(
    displacement: Scalar, force_max: Scalar, stroke: Scalar
) -> Scalar:
    """Return the energy that a linear spring stores within its stroke, J."""
    return 0.5 * force_max / stroke * (stroke - displacement) ** 2


def springs_wrenches(
    A: BodyState, B: BodyState, forces: Sequence[tuple[Scalar, Sequence[Scalar]]]
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on A and B of springs that push along A's x axis.

    Each force acts on B at its pad and on A at the same point in space. They are
    parallel, so their sum and their first moment in B are all it takes.

    Args:
        A: body pushed from; it gives the direction.
        B: body pushed away.
        forces: of each spring its force, N, and its pad, fixed in B, m.
    """
    total = moment_x = moment_y = moment_z = 0.0
    for force, (x, y, z) in forces:
        total = total + force
        moment_x = moment_x + force * x
        moment_y = moment_y + force * y
        moment_z = moment_z + force * z
    e_xA = A.R_WB[0], A.R_WB[3], A.R_WB[6]
    force_W = scale(total, e_xA)
    torque_B = cross(rotate(B.R_WB, (moment_x, moment_y, moment_z)), e_xA)
    torque_A = add(torque_B, cross(subtract(B.p_WBo, A.p_WBo), force_W))
    return Wrench(negate(torque_A), negate(force_W)), Wrench(torque_B, force_W)


class JointDeviation(NamedTuple):
    """How far a joint has been pulled from its mated place, expressed in A."""

    translation: Vector
    """Of B's attachment point from A's, m."""
    rotation: Vector
    """Rotation vector of B from its mated orientation, rad."""
    velocity: Vector
    """Rate of change of `translation` as seen from A, m/s."""
    rate: Vector
    """Angular velocity of B in A, rad/s."""


def joint_deviation(
    A: BodyState,
    B: BodyState,
    p_AoPad_A: Vector,
    p_BoPad_B: Vector,
    q_AB: Quaternion,
    ops: Ops,
) -> tuple[JointDeviation, Vector]:
    """Return a joint's deviation, and where in W it acts: B's attachment point.

    Args:
        A: first body.
        B: second body.
        p_AoPad_A: attachment point fixed in A, m.
        p_BoPad_B: attachment point fixed in B, m.
        q_AB: orientation of B in A while mated.
        ops: module of the elementary functions.
    """
    r_B = rotate(B.R_WB, p_BoPad_B)
    p_WPad = add(B.p_WBo, r_B)
    r_A = subtract(p_WPad, A.p_WBo)
    v_ABpad = subtract(velocity_at(B, r_B), velocity_at(A, r_A))
    q_error = multiply(multiply(conjugate(A.q_WB), B.q_WB), conjugate(q_AB))
    deviation = JointDeviation(
        subtract(unrotate(A.R_WB, r_A), p_AoPad_A),
        rotation_vector(q_error, ops),
        unrotate(A.R_WB, v_ABpad),
        unrotate(A.R_WB, subtract(B.w_WB, A.w_WB)),
    )
    return deviation, p_WPad


def joint_wrenches(
    A: BodyState,
    B: BodyState,
    deviation: JointDeviation,
    p_WPad: Vector,
    gains: Sequence[Scalar],
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on A and B of a fixed joint by constraint forces.

    Args:
        A: first body.
        B: second body.
        deviation: from `joint_deviation`.
        p_WPad: from `joint_deviation`.
        gains: K_F, N/m, D_F, N s/m, K_T, N m/rad, and D_T, N m s/rad.
    """
    K_F, D_F, K_T, D_T = gains
    dx, dtheta, v, w = deviation
    force_A = add(scale(-K_F, dx), scale(-D_F, v))  # Eq. 3
    torque_A = add(scale(-K_T, dtheta), scale(-D_T, w))  # Eq. 4
    return action_and_reaction(
        A, B, p_WPad, rotate(A.R_WB, force_A), rotate(A.R_WB, torque_A)
    )


def joint_energy(deviation: JointDeviation, K_F: Scalar, K_T: Scalar) -> Scalar:
    """Return the elastic energy held by a fixed joint, J."""
    dx, dtheta = deviation.translation, deviation.rotation
    return 0.5 * K_F * dot(dx, dx) + 0.5 * K_T * dot(dtheta, dtheta)


def orbit_position(t: Scalar, radius: Scalar, mean_motion: Scalar, ops: Ops) -> Vector:
    """Return W's origin from the centre of the Earth, in W, m.

    At t = 0, W's x axis lies along the velocity and z to the centre.
    """
    angle = mean_motion * t
    return radius * ops.sin(angle), 0.0 * angle, -radius * ops.cos(angle)


def differential_gravity(d: Vector, r_W: Vector, mu: Scalar) -> Vector:
    """Return the inverse-square field at d from W's origin, less that at it, m/s^2.

    Encke's form: no difference of two large numbers (Battin, "An Introduction to
    the Mathematics and Methods of Astrodynamics", section 8.3).

    Args:
        d: position in W, m.
        r_W: W's origin from the centre of the Earth, in W, m.
        mu: gravitational parameter, m^3/s^2.
    """
    (x, y, z), (X, Y, Z) = d, r_W
    r2 = X * X + Y * Y + Z * Z
    e = (x * (2.0 * X + x) + y * (2.0 * Y + y) + z * (2.0 * Z + z)) / r2
    s = (1.0 + e) ** 1.5
    g = e * (3.0 + e * (3.0 + e)) / (s * (s + 1.0))  # 1 - (1 + e)^(-3/2)
    k = mu / r2**1.5
    return k * (g * (X + x) - x), k * (g * (Y + y) - y), k * (g * (Z + z) - z)


def gravity_gradient_torque(
    r_B: Vector, I_BBcm_B: Sequence[Scalar], mu: Scalar
) -> Vector:
    """Return the gravity-gradient torque about a body's CG, in B, N m.

    Args:
        r_B: the CG from the centre of the Earth, in B, m.
        I_BBcm_B: central inertia, matrix entries xx, yy, zz, xy, xz, yz, kg m^2.
        mu: gravitational parameter, m^3/s^2.
    """
    x, y, z = r_B
    xx, yy, zz, xy, xz, yz = I_BBcm_B
    Ir = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
    return scale(3.0 * mu / (x * x + y * y + z * z) ** 2.5, cross(r_B, Ir))


def gravity_wrench(
    B: BodyState,
    mass: Scalar,
    p_BoBcm_B: Vector,
    I_BBcm_B: Sequence[Scalar],
    r_W: Vector,
    mu: Scalar,
) -> Wrench:
    """Return the wrench of differential gravity on a body.

    Args:
        B: the body.
        mass: its mass, kg.
        p_BoBcm_B: its CG, m.
        I_BBcm_B: its central inertia, as in `gravity_gradient_torque`.
        r_W: W's origin from the centre of the Earth, in W, m.
        mu: gravitational parameter, m^3/s^2.
    """
    p_BoBcm_W = rotate(B.R_WB, p_BoBcm_B)
    p_WBcm = add(B.p_WBo, p_BoBcm_W)
    force = scale(mass, differential_gravity(p_WBcm, r_W, mu))
    r_B = unrotate(B.R_WB, add(r_W, p_WBcm))
    torque = rotate(B.R_WB, gravity_gradient_torque(r_B, I_BBcm_B, mu))
    return Wrench(add(cross(p_BoBcm_W, force), torque), force)


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
