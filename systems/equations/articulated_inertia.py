"""What it takes to accelerate a body, with all that hangs on it by joints.

Articulated inertias (Featherstone, "Rigid Body Dynamics Algorithms", 2008, chapter 7),
in W and about the body's origin: a torque is I alpha + H a, a force H^T alpha + M a.
The acceleration of a body is that of its origin, without what its angular velocity
gives.
"""

from typing import NamedTuple

from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.rigid_body import inverse
from drakesep.systems.vectors import (
    Rotation,
    Scalar,
    Symmetric,
    Vector,
    add,
    apply,
    cross,
    dot,
    rotate,
    scale,
    subtract,
    unrotate,
)


class Massive(NamedTuple):
    """Mass properties of a body."""

    mass: Scalar
    """kg."""
    p_BoBcm_B: Vector
    """m."""
    I_BBcm_B: Symmetric
    """kg m^2."""


class Acceleration(NamedTuple):
    """Of a body; or one of its directions of motion."""

    alpha: Vector
    """rad/s^2."""
    a: Vector
    """Of its origin, m/s^2."""


class Inertia(NamedTuple):
    """From the acceleration of a body to the wrench about its origin."""

    I: Symmetric  # noqa: E741
    """kg m^2."""
    H: Rotation
    """kg m: any 3 by 3 matrix."""
    M: Symmetric
    """kg."""


def inertia_of_body(B: BodyState, massive: Massive) -> tuple[Inertia, Wrench]:
    """Return the inertia of a body, and its wrench of inertia without acceleration.

    Args:
        B: the body.
        massive: its mass properties.

    Returns:
        D and h of D V + h = wrench (Newton and Euler).
    """
    m, w = massive.mass, B.w_WB
    c = x, y, z = rotate(B.R_WB, massive.p_BoBcm_B)
    inertia = xx, yy, zz, xy, xz, yz = _turned(B.R_WB, massive.I_BBcm_B)
    mx, my, mz = scale(m, c)
    zero = 0.0 * mx
    about_origin = (
        xx + my * y + mz * z,
        yy + mx * x + mz * z,
        zz + mx * x + my * y,
        xy - mx * y,
        xz - mx * z,
        yz - my * z,
    )
    H = (zero, -mz, my, mz, zero, -mx, -my, mx, zero)
    D = Inertia(about_origin, H, (m + zero, m + zero, m + zero, zero, zero, zero))
    force = scale(m, cross(w, cross(w, c)))
    torque = add(cross(w, apply(inertia, w)), cross(c, force))
    return D, Wrench(torque, force)


def _turned(R: Rotation, S: Symmetric) -> Symmetric:
    """Return R S R^T."""
    x, y, z = R[:3], R[3:6], R[6:]
    Sx, Sy, Sz = (apply(S, row) for row in (x, y, z))
    return dot(x, Sx), dot(y, Sy), dot(z, Sz), dot(x, Sy), dot(x, Sz), dot(y, Sz)


def wrench_for(D: Inertia, V: Acceleration) -> Wrench:
    """Return the wrench that gives an acceleration."""
    torque = add(apply(D.I, V.alpha), rotate(D.H, V.a))
    return Wrench(torque, add(unrotate(D.H, V.alpha), apply(D.M, V.a)))


def acceleration_by(D: Inertia, wrench: Wrench) -> Acceleration:
    """Return the acceleration that a wrench gives."""
    M_1 = inverse(D.M)
    rows = D.H[:3], D.H[3:6], D.H[6:]
    G = [apply(M_1, row) for row in rows]
    xx, yy, zz, xy, xz, yz = D.I
    (a, b, c), (x, y, z) = rows, G
    left = (
        xx - dot(a, x),
        yy - dot(b, y),
        zz - dot(c, z),
        xy - dot(a, y),
        xz - dot(a, z),
        yz - dot(b, z),
    )
    G_force = (dot(x, wrench.force), dot(y, wrench.force), dot(z, wrench.force))
    alpha = apply(inverse(left), subtract(wrench.torque, G_force))
    return Acceleration(alpha, apply(M_1, subtract(wrench.force, unrotate(D.H, alpha))))


def without_direction(
    D: Inertia, wrench: Wrench, S: Acceleration
) -> tuple[Inertia, Wrench]:
    """Return what is left of an inertia, and of a wrench, where a joint lets go.

    In that direction the body moves as the wrench has it: nothing of either is carried
    through the joint.

    Args:
        D: the inertia.
        wrench: on the body.
        S: the direction.
    """
    u, v = wrench_for(D, S)
    part = 1.0 / (dot(S.alpha, u) + dot(S.a, v))
    p, q = scale(part, u), scale(part, v)
    H = [x - y for x, y in zip(D.H, (i * j for i in p for j in v), strict=True)]
    left = Inertia(_less(D.I, p, u), tuple(H), _less(D.M, q, v))
    taken = dot(S.alpha, wrench.torque) + dot(S.a, wrench.force)
    torque = subtract(wrench.torque, scale(taken, p))
    return left, Wrench(torque, subtract(wrench.force, scale(taken, q)))


def _less(S: Symmetric, p: Vector, u: Vector) -> Symmetric:
    """Return S - p u^T, of p along u."""
    xx, yy, zz, xy, xz, yz = S
    (a, b, c), (x, y, z) = p, u
    return xx - a * x, yy - b * y, zz - c * z, xy - a * y, xz - a * z, yz - b * z


def sum_of_inertias(first: Inertia, second: Inertia) -> Inertia:
    """Return the inertia of two bodies that move as one, about the same point."""
    I, H, M = (  # noqa: E741
        tuple(x + y for x, y in zip(*entries, strict=True))
        for entries in zip(first, second, strict=True)
    )
    return Inertia(I, H, M)


def matrix_of(D: Inertia) -> list[list[Scalar]]:
    """Return an inertia as six rows."""
    xx, yy, zz, xy, xz, yz = D.I
    a, b, c, d, e, f, g, h, i = D.H
    XX, YY, ZZ, XY, XZ, YZ = D.M
    return [
        [xx, xy, xz, a, b, c],
        [xy, yy, yz, d, e, f],
        [xz, yz, zz, g, h, i],
        [a, d, g, XX, XY, XZ],
        [b, e, h, XY, YY, YZ],
        [c, f, i, XZ, YZ, ZZ],
    ]


def shifted_inertia(D: Inertia, arm: Vector) -> Inertia:
    """Return an inertia about a point from which its own is at an arm."""
    xx, yy, zz, xy, xz, yz = D.M
    columns = [cross(arm, each) for each in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))]
    H = tuple(D.H[3 * i + j] + columns[j][i] for i in range(3) for j in range(3))
    # I + A H^T - (H + A M) A, with A of the cross product with the arm.
    x, y, z = (cross(arm, row) for row in (D.H[:3], D.H[3:6], D.H[6:]))
    a, b, c = (cross(row, arm) for row in (H[:3], H[3:6], H[6:]))
    xx, yy, zz, xy, xz, yz = D.I
    about = (
        xx + x[0] - a[0],
        yy + y[1] - b[1],
        zz + z[2] - c[2],
        xy + y[0] - a[1],
        xz + z[0] - a[2],
        yz + z[1] - b[2],
    )
    return Inertia(about, H, D.M)


def shifted_wrench(wrench: Wrench, arm: Vector) -> Wrench:
    """Return a wrench about a point from which its own is at an arm."""
    torque = add(wrench.torque, cross(arm, wrench.force))
    return Wrench(torque, wrench.force)


def shifted_acceleration(V: Acceleration, arm: Vector) -> Acceleration:
    """Return the acceleration of a point at an arm."""
    return Acceleration(V.alpha, add(V.a, cross(V.alpha, arm)))
