"""Places and orientations of the mated stack."""

import math
from typing import NamedTuple

from drakesep.systems.checks import Vector3
from drakesep.systems.equations.joints import HeldJoint
from drakesep.systems.model.separation import Attachment, Body, Pair, Separation
from drakesep.systems.vectors import (
    Ops,
    Quaternion,
    Vector,
    add,
    conjugate,
    cross,
    multiply,
    quaternion,
    rotate,
    rotation_matrix,
    subtract,
    unrotate,
)


def place_in_stack(body: Body, p_BoQ_B: Vector) -> Vector:
    """Return where a point fixed in a body lies in the mated stack, p_AoQ_A, m."""
    R_AB = rotation_matrix(quaternion(body.rpy_AB, math))
    return add(body.p_ABo, rotate(R_AB, p_BoQ_B))


def place_in_A(separation: Separation, pair: Pair, p_BoQ_B: Vector) -> Vector:
    """Return where a point fixed in a pair's B lies in its A while mated, m."""
    A = separation.body(pair.A)
    p_SQ = place_in_stack(separation.body(pair.B), p_BoQ_B)
    R_SA = rotation_matrix(quaternion(A.rpy_AB, math))
    return unrotate(R_SA, subtract(p_SQ, A.p_ABo))


def pad_on_B(
    separation: Separation, attachment: Attachment, p_AoPad_A: Vector
) -> Vector:
    """Return where on an attachment's B the pad lies that is at a place in its A, m."""
    p_SPad = place_in_stack(separation.body(attachment.A), p_AoPad_A)
    B = separation.body(attachment.B)
    R_SB = rotation_matrix(quaternion(B.rpy_AB, math))
    return unrotate(R_SB, subtract(p_SPad, B.p_ABo))


def axis_on_B(separation: Separation, attachment: Attachment) -> Vector3:
    """Return the x axis of an attachment's joint, or y of a universal one, in its B."""
    joint = attachment.joint
    axis_A = joint.y_axis_A if joint.type == "universal" else joint.x_axis_A
    A, B = separation.body(attachment.A), separation.body(attachment.B)
    return unrotate(rotation_matrix(mated_orientation(A, B)), axis_A)


def mated_orientation(A: Body, B: Body) -> Quaternion:
    """Return the orientation q_AB of one body in another while mated."""
    q_SA, q_SB = quaternion(A.rpy_AB, math), quaternion(B.rpy_AB, math)
    return multiply(conjugate(q_SA), q_SB)


def held_joint(separation: Separation, attachment: Attachment) -> HeldJoint:
    """Return the joint of an attachment, as it stands while mated."""
    joint, pad_A = attachment.joint, attachment.p_AoPad_A
    return HeldJoint(
        joint.type,
        joint.R_AJ_if_turned,
        *joint.held_gains(),
        pad_A,
        pad_on_B(separation, attachment, pad_A),
        axis_on_B(separation, attachment),
    )


class MatedMotion(NamedTuple):
    """Motion of a body in the mated stack, in W."""

    q_WB: Quaternion
    p_WBo: Vector
    """m."""
    w_WB: Vector
    """rad/s."""
    v_WBo: Vector
    """m/s."""


def mated_motion(
    separation: Separation,
    rpy_WA: Vector,
    w_WA_A: Vector,
    p_AoAcm_A: Vector,
    ops: Ops,
) -> list[MatedMotion]:
    """Return the motion of each body of the mated stack.

    It moves as one rigid body, with A's origin at W's and A's CG at rest.

    Args:
        separation: with the bodies and their mated places.
        rpy_WA: roll, pitch and yaw of A in W, rad.
        w_WA_A: angular velocity of A in W, in A, rad/s.
        p_AoAcm_A: A's CG, m.
        ops: module of the elementary functions.
    """
    q_WA = quaternion(rpy_WA, ops)
    R_WA = rotation_matrix(q_WA)
    w_W = rotate(R_WA, w_WA_A)
    motions = []
    for body in separation.bodies:
        p_AcmBo_W = rotate(R_WA, subtract(body.p_ABo, p_AoAcm_A))
        motions.append(
            MatedMotion(
                multiply(q_WA, quaternion(body.rpy_AB, math)),
                rotate(R_WA, body.p_ABo),
                w_W,
                cross(w_W, p_AcmBo_W),
            )
        )
    return motions
