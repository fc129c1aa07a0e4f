"""The motion of a body that floats in W under a wrench, by Newton and Euler.

Drake's plant has these equations of its own; the batch engine takes them from here.
Their form is that of `relative_motion`.
"""

from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.vectors import (
    Quaternion,
    Scalar,
    Symmetric,
    Vector,
    apply,
    cross,
    multiply,
    rotate,
    scale,
    subtract,
    unrotate,
)


def inverse(S: Symmetric) -> Symmetric:
    """Return the inverse of a symmetric matrix, by its adjugate."""
    xx, yy, zz, xy, xz, yz = S
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    d = 1.0 / (xx * a + xy * b + xz * c)
    return (
        a * d,
        (xx * zz - xz * xz) * d,
        (xx * yy - xy * xy) * d,
        b * d,
        c * d,
        (xy * xz - xx * yz) * d,
    )


def quaternion_rate(q_WB: Quaternion, w_WB: Vector) -> Quaternion:
    """Return the rate of a body's quaternion, 1/s: half of (0, w_WB) q_WB."""
    x, y, z = w_WB
    w, i, j, k = multiply((0.0, x, y, z), q_WB)
    return 0.5 * w, 0.5 * i, 0.5 * j, 0.5 * k


def accelerations(
    B: BodyState,
    mass: Scalar,
    p_BoBcm_B: Vector,
    I_BBcm_B: Symmetric,
    inverse_I_BBcm_B: Symmetric,
    wrench: Wrench,
) -> tuple[Vector, Vector]:
    """Return the accelerations that a wrench gives to a free body.

    Args:
        B: the body.
        mass: kg.
        p_BoBcm_B: its CG, m.
        I_BBcm_B: its inertia about the CG, kg m^2.
        inverse_I_BBcm_B: the inverse of that, 1/(kg m^2).
        wrench: torque about the origin and force, in W.

    Returns:
        Angular acceleration, rad/s^2, and acceleration of the origin, m/s^2, in W.
    """
    w = unrotate(B.R_WB, B.w_WB)
    force = unrotate(B.R_WB, wrench.force)
    torque = subtract(unrotate(B.R_WB, wrench.torque), cross(p_BoBcm_B, force))
    gyroscopic = cross(w, apply(I_BBcm_B, w))
    alpha = apply(inverse_I_BBcm_B, subtract(torque, gyroscopic))  # Euler
    a_Bcm = scale(1.0 / mass, force)  # Newton
    centripetal = cross(w, cross(w, p_BoBcm_B))
    a_Bo = subtract(subtract(a_Bcm, cross(alpha, p_BoBcm_B)), centripetal)
    return rotate(B.R_WB, alpha), rotate(B.R_WB, a_Bo)
