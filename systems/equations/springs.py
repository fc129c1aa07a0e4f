"""The forces of separation springs (Eq. 5), by time and by displacement.

Their form, and the paper whose equations they number, are those of `motion_laws`.
"""

import itertools
from collections.abc import Sequence
from typing import TypeAlias

from drakesep.systems.equations.relative_motion import BodyState, Wrench, velocity_at
from drakesep.systems.vectors import (
    Ops,
    Scalar,
    Vector,
    add,
    cross,
    dot,
    negate,
    rotate,
    scale,
    subtract,
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


def push_axis(tilt_y: Scalar, tilt_z: Scalar, ops: Ops) -> Vector:
    """Return the axis in A along which a spring pushes: Rz(tilt_z) Ry(tilt_y) x.

    Args:
        tilt_y: about A's y axis, rad.
        tilt_z: about A's z axis, then, rad.
        ops: module of the elementary functions.
    """
    c = ops.cos(tilt_y)
    return c * ops.cos(tilt_z), c * ops.sin(tilt_z), -ops.sin(tilt_y)


def _axis_W(A: BodyState, axis_A: Vector | None) -> Vector:
    if axis_A is None:
        return A.R_WB[0], A.R_WB[3], A.R_WB[6]
    return rotate(A.R_WB, axis_A)


def spring_displacement(
    A: BodyState,
    B: BodyState,
    p_AoPad_A: Sequence[Scalar],
    p_BoPad_B: Sequence[Scalar],
    axis_A: Vector | None = None,
) -> tuple[Scalar, Scalar]:
    """Return how far, m, and how fast, m/s, B's pad has moved along the push's axis.

    Args:
        A: body pushed from.
        B: body pushed away.
        p_AoPad_A: mated place of the pad in A, m.
        p_BoPad_B: the pad, fixed in B, m.
        axis_A: of the push, in A; A's x axis if None.
    """
    r_B = rotate(B.R_WB, (p_BoPad_B[0], p_BoPad_B[1], p_BoPad_B[2]))
    r_A = subtract(add(B.p_WBo, r_B), A.p_WBo)
    v_APad = subtract(velocity_at(B, r_B), velocity_at(A, r_A))
    axis_W = _axis_W(A, axis_A)
    x, y, z = p_AoPad_A
    mated = x if axis_A is None else dot(axis_A, (x, y, z))
    return dot(axis_W, r_A) - mated, dot(axis_W, v_APad)


def positive_part(x: Scalar) -> Scalar:
    """Return the larger of x and 0, of floats and of lanes."""
    return 0.5 * (x + abs(x))


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

    Where it is negative the pad has lifted off: the spring never pulls. With
    `spring_displacement` as its argument, the spring's work is exactly what its energy
    loses: the force acts along the axis on which displacement is measured.

    Args:
        displacement: of the pad along the push's axis, m.
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
        # The first ramp is a line: a pad pressed in further is pushed harder.
        x = u - u_i
        force = force + slope * (positive_part(x) if u_i > 0.0 else x)
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
        left = positive_part(x) if u_i > 0.0 else x
        area = area + 0.5 * slope * ((1.0 - u_i) ** 2 - left**2)
    return force_max * stroke * area


Push: TypeAlias = tuple[Scalar, Sequence[Scalar], Vector | None]
"""A spring's force, N, its pad, fixed in B, m, and its axis in A; None: A's x axis."""


def springs_wrenches(
    A: BodyState, B: BodyState, pushes: Sequence[Push]
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on A and B of springs.

    Each force acts on B at its pad and on A at the same point in space. Those along A's
    x axis are parallel, so their sum and their first moment in B are all it takes.

    Args:
        A: body pushed from; it gives the directions.
        B: body pushed away.
        pushes: of the springs.
    """
    total = moment_x = moment_y = moment_z = 0.0
    tilted = []
    for force, (x, y, z), axis_A in pushes:
        if axis_A is not None:
            tilted.append((scale(force, rotate(A.R_WB, axis_A)), (x, y, z)))
            continue
        total = total + force
        moment_x = moment_x + force * x
        moment_y = moment_y + force * y
        moment_z = moment_z + force * z
    e_xA = _axis_W(A, None)
    force_W = scale(total, e_xA)
    torque_B = cross(rotate(B.R_WB, (moment_x, moment_y, moment_z)), e_xA)
    for push_W, pad_B in tilted:
        force_W = add(force_W, push_W)
        torque_B = add(torque_B, cross(rotate(B.R_WB, pad_B), push_W))
    torque_A = add(torque_B, cross(subtract(B.p_WBo, A.p_WBo), force_W))
    return Wrench(negate(torque_A), negate(force_W)), Wrench(torque_B, force_W)
