"""Inverse-square gravity in a freely falling world.

Their form, and the paper whose equations they number, are those of `relative_motion`.
"""

from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.vectors import (
    Ops,
    Scalar,
    Symmetric,
    Vector,
    add,
    apply,
    cross,
    rotate,
    scale,
    unrotate,
)


def differential_gravity(d: Vector, r_W: Vector, mu: Scalar, ops: Ops) -> Vector:
    """Return the inverse-square field at d from W's origin, less that at it, m/s^2.

    Encke's form: no difference of two large numbers (Battin, "An Introduction to
    the Mathematics and Methods of Astrodynamics", section 8.3).

    Args:
        d: position in W, m.
        r_W: W's origin from the centre of the Earth, in W, m.
        mu: gravitational parameter, m^3/s^2.
        ops: module of the elementary functions.
    """
    (x, y, z), (X, Y, Z) = d, r_W
    r2 = X * X + Y * Y + Z * Z
    e = (x * (2.0 * X + x) + y * (2.0 * Y + y) + z * (2.0 * Z + z)) / r2
    s = (1.0 + e) * ops.sqrt(1.0 + e)
    g = e * (3.0 + e * (3.0 + e)) / (s * (s + 1.0))  # 1 - (1 + e)^(-3/2)
    k = mu / (r2 * ops.sqrt(r2))
    return k * (g * (X + x) - x), k * (g * (Y + y) - y), k * (g * (Z + z) - z)


def gravity_gradient_torque(
    r_B: Vector, I_BBcm_B: Symmetric, mu: Scalar, ops: Ops
) -> Vector:
    """Return the gravity-gradient torque about a body's CG, in B, N m.

    Args:
        r_B: the CG from the centre of the Earth, in B, m.
        I_BBcm_B: central inertia, matrix entries xx, yy, zz, xy, xz, yz, kg m^2.
        mu: gravitational parameter, m^3/s^2.
        ops: module of the elementary functions.
    """
    x, y, z = r_B
    r2 = x * x + y * y + z * z
    return scale(3.0 * mu / (r2 * r2 * ops.sqrt(r2)), cross(r_B, apply(I_BBcm_B, r_B)))


def gravity_wrench(
    B: BodyState,
    mass: Scalar,
    p_BoBcm_B: Vector,
    I_BBcm_B: Symmetric,
    r_W: Vector,
    mu: Scalar,
    ops: Ops,
) -> Wrench:
    """Return the wrench of differential gravity on a body.

    Args:
        B: the body.
        mass: its mass, kg.
        p_BoBcm_B: its CG, m.
        I_BBcm_B: its central inertia, as in `gravity_gradient_torque`.
        r_W: W's origin from the centre of the Earth, in W, m.
        mu: gravitational parameter, m^3/s^2.
        ops: module of the elementary functions.
    """
    p_BoBcm_W = rotate(B.R_WB, p_BoBcm_B)
    p_WBcm = add(B.p_WBo, p_BoBcm_W)
    force = scale(mass, differential_gravity(p_WBcm, r_W, mu, ops))
    r_B = unrotate(B.R_WB, add(r_W, p_WBcm))
    torque = rotate(B.R_WB, gravity_gradient_torque(r_B, I_BBcm_B, mu, ops))
    return Wrench(add(cross(p_BoBcm_W, force), torque), force)
