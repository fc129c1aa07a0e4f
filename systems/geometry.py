"""Places and orientations of the mated stack."""

import math

from drakesep.systems.checks import Vector3
from drakesep.systems.model import Attachment, Body, Separation
from drakesep.systems.vectors import (
    Quaternion,
    add,
    conjugate,
    multiply,
    quaternion,
    rotate,
    rotation_matrix,
    subtract,
    unrotate,
)


def place_in_stack(body: Body, p_BoQ_B: Vector3) -> Vector3:
    """Return where a point fixed in a body lies in the mated stack, p_AoQ_A, m."""
    R_AB = rotation_matrix(quaternion(body.rpy_AB, math))
    return add(body.p_ABo, rotate(R_AB, p_BoQ_B))


def pad_on_B(separation: Separation, attachment: Attachment) -> Vector3:
    """Return the place, in the attachment's body B, of the pad on it, m."""
    p_SPad = place_in_stack(separation.body(attachment.A), attachment.p_AoPad_A)
    B = separation.body(attachment.B)
    R_SB = rotation_matrix(quaternion(B.rpy_AB, math))
    return unrotate(R_SB, subtract(p_SPad, B.p_ABo))


def axis_on_B(
    separation: Separation, attachment: Attachment, axis_A: Vector3
) -> Vector3:
    """Return, in the attachment's body B, an axis given in A, while mated."""
    A, B = separation.body(attachment.A), separation.body(attachment.B)
    return unrotate(rotation_matrix(mated_orientation(A, B)), axis_A)


def mated_orientation(A: Body, B: Body) -> Quaternion:
    """Return the orientation q_AB of one body in another while mated."""
    q_SA, q_SB = quaternion(A.rpy_AB, math), quaternion(B.rpy_AB, math)
    return multiply(conjugate(q_SA), q_SB)
