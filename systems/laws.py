"""The equations of separation, as pure functions on tuples of scalars.

Every function takes floats, or arrays whose lanes are samples (see
`drakesep.systems.vectors`), so that the LeafSystems, which integrate, and the
motion analysis of a whole trajectory run through the same lines. Numbered
equations are those of Simplicio and Bennani, "Worst-case Launch Vehicle Stage
Separation Analysis". SI units and radians throughout.
"""

import itertools
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.vectors import (
    TINY,
    Ops,
    Quaternion,
    Rotation,
    Scalar,
    Vector,
    add,
    compose,
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


def ramps(profile: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return a piecewise straight line as ramps: where each begins, and its slope.

    Args:
        profile: (n, 2) rows of argument and value, joined by straight lines.
    """
    rows, before = [], 0.0
    for (s0, f0), (s1, f1) in itertools.pairwise(profile):
        slope = (f1 - f0) / (s1 - s0)
        rows.append((s0, slope - before))
        before = slope
    return rows


def displacement_spring_force(
    displacement: Scalar,
    speed: Scalar,
    force_max: Scalar,
    stroke: Scalar,
    damping: Scalar,
    start: float,
    ramps: Sequence[tuple[float, float]],
) -> Scalar:
    """Return the force of a spring and damper within its stroke, N.

    With `spring_displacement` as its argument, the spring's work is exactly what its
    energy loses: the force acts along the axis on which displacement is measured.

    Args:
        displacement: of the pad along A's x axis, m.
        speed: its rate, m/s.
        force_max: largest force of the profile, N.
        stroke: m.
        damping: N s/m.
        start: the profile at its start.
        ramps: the profile's `ramps`, over the stroke.
    """
    u = displacement / stroke
    force = start
    for u_i, slope in ramps:
        # Half of x + |x| is the larger of x and 0, on floats and on lanes. The first
        # ramp is a line: a pad pressed in further is pushed harder.
        x = u - u_i
        force = force + slope * (0.5 * (x + abs(x)) if u_i > 0.0 else x)
    return force_max * force - damping * speed


def displacement_spring_energy(
    displacement: Scalar,
    force_max: Scalar,
    stroke: Scalar,
    start: float,
    ramps: Sequence[tuple[float, float]],
) -> Scalar:
    """Return the energy that such a spring stores within its stroke, J.

    Arguments are those of `displacement_spring_force`.
    """
    u = displacement / stroke
    area = start * (1.0 - u)
    for u_i, slope in ramps:
        x = u - u_i
        left = 0.5 * (x + abs(x)) if u_i > 0.0 else x
        area = area + 0.5 * slope * ((1.0 - u_i) ** 2 - left**2)
    return force_max * stroke * area


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


def load_wrench(
    B: BodyState, p_BoQ_B: Vector, force: Vector, torque: Vector, in_body: bool
) -> Wrench:
    """Return the wrench of a force at a point of a body, and of a torque.

    Args:
        B: the body.
        p_BoQ_B: the point, m.
        force: in the axes of the body or of the world, N.
        torque: likewise, N m.
        in_body: whether they are in the axes of the body.
    """
    if in_body:
        force, torque = rotate(B.R_WB, force), rotate(B.R_WB, torque)
    return Wrench(add(torque, cross(rotate(B.R_WB, p_BoQ_B), force)), force)


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
            subtract(add(pair.p_AoBo, r), p_AoPad_A),
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
    error = multiply(multiply(conjugate(A.q_WB), B.q_WB), conjugate(q_AB))
    theta = rotation_vector(error, ops)
    angle2 = dot(theta, theta)
    half = 0.5 * ops.sqrt(angle2 + TINY)
    # (1 - (angle/2) cot(angle/2)) / angle^2: round-off of it meets angle^2 again.
    c = (1.0 - half * ops.cos(half) / ops.sin(half)) / (angle2 + TINY)
    wt = cross(theta, w_AB_A)
    rate = add(subtract(w_AB_A, scale(0.5, wt)), scale(c, cross(theta, wt)))
    return Turn(theta, c, rate)


def twist_angle(
    q_WA: Quaternion, q_WB: Quaternion, q_AB: Quaternion, axis_A: Vector, ops: Ops
) -> Scalar:
    """Return by how much B has turned in A about an axis, from 0 to pi, rad.

    Args:
        q_WA: orientation of A.
        q_WB: orientation of B.
        q_AB: orientation of B in A while mated.
        axis_A: the axis, in A.
        ops: module of the elementary functions.
    """
    w, x, y, z = multiply(multiply(conjugate(q_WA), q_WB), conjugate(q_AB))
    return 2.0 * ops.atan2(abs(dot(axis_A, (x, y, z))), abs(w))


def turning_torque(turn: Turn, moment: Vector) -> Vector:
    """Return J^T moment: the torque on B of a moment conjugate to `Turn.theta`."""
    tm = cross(turn.theta, moment)
    return add(add(moment, scale(0.5, tm)), scale(turn.c, cross(turn.theta, tm)))


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
    sine2 = y * y + z * z + TINY
    sine = ops.sqrt(sine2)
    f = ops.atan2(sine, x) / sine
    df = (x * f - 1.0) / sine2  # of f with the cosine x
    theta_y, theta_z = -z * f, y * f
    # d theta / dt = G w, with the rates of the axis w x (x, y, z)
    dx_y, dx_z = z, -y
    G_y = -f * y, f * x - z * df * dx_y, -z * df * dx_z
    G_z = -f * z, y * df * dx_y, f * x + y * df * dx_z
    m_y = K_T[1] * theta_y + D_T[1] * (G_y[0] * wx + G_y[1] * wy + G_y[2] * wz)
    m_z = K_T[2] * theta_z + D_T[2] * (G_z[0] * wx + G_z[1] * wy + G_z[2] * wz)
    energy = 0.5 * (K_T[1] * theta_y * theta_y + K_T[2] * theta_z * theta_z)
    return negate(add(scale(m_y, G_y), scale(m_z, G_z))), energy


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
    theta = ops.atan2(-x, cosine)
    # About the normal of both axes, x_A cross y_B.
    n_y, n_z = -z / cosine, y / cosine
    m = K_T[2] * theta + D_T[2] * (n_y * w_J[1] + n_z * w_J[2])
    return (0.0, -m * n_y, -m * n_z), 0.5 * K_T[2] * theta * theta


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
