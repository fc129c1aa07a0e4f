"""Loads by tables over time, and the wrench of a force at a point of a body."""

from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.vectors import Scalar, Vector, add, cross, rotate, scale


def between_rows(before: Vector, after: Vector, s: Scalar, factor: Scalar) -> Vector:
    """Return a load on the straight line between two rows of its table.

    Args:
        before: force, N, or torque, N m, of the first row.
        after: that of the next row.
        s: where between them, 0 to 1.
        factor: on the load.
    """
    return add(scale((1.0 - s) * factor, before), scale(s * factor, after))


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
