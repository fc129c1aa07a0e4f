"""Places and orientations of the mated stack."""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from drakesep.systems.equations.joints import HeldJoint
from drakesep.systems.model.carriers import carriers
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.separation import Attachment, Body, Separation
from drakesep.systems.vectors import (
    Ops,
    Quaternion,
    Scalar,
    Vector,
    add,
    conjugate,
    cross,
    multiply,
    quaternion,
    rotate,
    rotation_matrix,
    scale,
    subtract,
    unrotate,
)


class Place(NamedTuple):
    """Where a body is in the mated stack, whose frame S is that of A."""

    q_SB: Quaternion
    p_SBo: Vector
    """m."""


Shift: TypeAlias = tuple[Vector, Vector]
"""How a body is displaced while mated: offset, m, and roll, pitch and yaw, rad."""


def nominal_place(body: Body) -> Place:
    """Return where a body is meant to be in the mated stack."""
    return Place(quaternion(body.rpy_AB, math), body.p_ABo)


def mated_places(
    separation: Separation,
    shifts: Mapping[str, Shift] | None = None,
    ops: Ops = math,
) -> dict[str, Place]:
    """Return where each body is in the mated stack, with what hangs on a displaced one.

    Args:
        separation: with the bodies.
        shifts: of bodies that are displaced, by name; the separation's own if None.
        ops: module of the elementary functions, of the shifts.
    """
    places = {body.name: nominal_place(body) for body in separation.bodies}
    if shifts is None:
        shifts = {
            body.name: (body.mated_offset, body.mated_misalignment)
            for body in separation.bodies
            if any((*body.mated_offset, *body.mated_misalignment))
        }
    if not shifts:
        return places
    moved: dict[str | None, Place | None] = {None: None}
    for name, carrier in carriers(separation).items():
        place, moved[name] = places[name], moved[carrier]
        if name in shifts:
            offset, turn = shifts[name]
            q_SB = multiply(place.q_SB, quaternion(turn, ops))
            place = Place(q_SB, add(place.p_SBo, offset))
        by = moved[carrier]
        if by is not None:
            place = _compose(by, place)
        if name in shifts:
            moved[name] = _compose(place, _inverse(places[name]))
        places[name] = place
    return places


def _compose(outer: Place, inner: Place) -> Place:
    p = add(outer.p_SBo, rotate(rotation_matrix(outer.q_SB), inner.p_SBo))
    return Place(multiply(outer.q_SB, inner.q_SB), p)


def _inverse(place: Place) -> Place:
    back = conjugate(place.q_SB)
    p = rotate(rotation_matrix(back), place.p_SBo)
    return Place(back, subtract((0.0, 0.0, 0.0), p))


def place_in_stack(place: Place, p_BoQ_B: Vector) -> Vector:
    """Return where a point fixed in a body lies in the mated stack, p_SoQ_S, m."""
    return add(place.p_SBo, rotate(rotation_matrix(place.q_SB), p_BoQ_B))


def place_in_A(A: Place, B: Place, p_BoQ_B: Vector) -> Vector:
    """Return where a point fixed in a body B lies in a body A while mated, m."""
    p_SQ = place_in_stack(B, p_BoQ_B)
    return unrotate(rotation_matrix(A.q_SB), subtract(p_SQ, A.p_SBo))


def pad_on_B(A: Place, B: Place, p_AoPad_A: Vector) -> Vector:
    """Return where on an attachment's B the pad lies that is at a place in its A, m."""
    return place_in_A(B, A, p_AoPad_A)


def axis_on_A(joint: Joint) -> Vector:
    """Return the x axis of a joint in its A, y of a universal one: it is fixed in B."""
    return joint.y_axis_A if joint.type == "universal" else joint.x_axis_A


def axis_on_B(A: Place, B: Place, joint: Joint) -> Vector:
    """Return the same axis in its B."""
    return unrotate(rotation_matrix(mated_orientation(A, B)), axis_on_A(joint))


def mated_orientation(A: Place, B: Place) -> Quaternion:
    """Return the orientation q_AB of one body in another while mated."""
    return multiply(conjugate(A.q_SB), B.q_SB)


def mated_ends(separation: Separation, attachment: Attachment) -> tuple[Place, Place]:
    """Return where an attachment's A and B are in the mated stack."""
    places = mated_places(separation)
    return places[attachment.A], places[attachment.B]


def held_joint(separation: Separation, attachment: Attachment) -> HeldJoint:
    """Return the joint of an attachment, as it stands while mated."""
    joint, pad_A = attachment.joint, attachment.p_AoPad_A
    ends = mated_ends(separation, attachment)
    return HeldJoint(
        joint.type,
        joint.R_AJ_if_turned,
        *joint.held_gains(),
        pad_A,
        pad_on_B(*ends, pad_A),
        axis_on_B(*ends, joint),
    )


class Spin(NamedTuple):
    """How a body spins in the mated stack, whose frame is S."""

    rate: Scalar
    """rad/s."""
    axis_S: Vector
    p_SPad: Vector
    """A point of the axis, m."""


def mated_spin(
    separation: Separation,
    body: Body,
    places: Sequence[Place],
    pads_A: Sequence[Vector],
    rate: Scalar,
) -> Spin | None:
    """Return how a body spins in the mated stack; None if its joints do not let it.

    Args:
        separation: with the body.
        body: of it.
        places: of all bodies in the stack, in their order.
        pads_A: place of each attachment's pad in its A, m.
        rate: of the spin, rad/s.
    """
    attachment = separation.spins_on(body)
    if attachment is None:
        return None
    a, _ = separation.ends(attachment)
    axis_S = rotate(rotation_matrix(places[a].q_SB), attachment.joint.x_axis_A)
    pad_A = pads_A[separation.attachments.index(attachment)]
    return Spin(rate, axis_S, place_in_stack(places[a], pad_A))


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
    places: Iterable[Place],
    rpy_WA: Vector,
    w_WA_A: Vector,
    p_AoAcm_A: Vector,
    ops: Ops,
    spins: Iterable[Spin | None] = (),
) -> list[MatedMotion]:
    """Return the motion of bodies of the mated stack.

    It moves as one rigid body, with A's origin at W's and A's CG at rest, but for what
    spins in it.

    Args:
        places: of the bodies in the stack.
        rpy_WA: roll, pitch and yaw of A in W, rad.
        w_WA_A: angular velocity of A in W, in A, rad/s.
        p_AoAcm_A: A's CG, m.
        ops: module of the elementary functions.
        spins: of the bodies; none if empty.
    """
    q_WA = quaternion(rpy_WA, ops)
    R_WA = rotation_matrix(q_WA)
    w_W = rotate(R_WA, w_WA_A)
    motions = []
    for (q_SB, p_SBo), spin in itertools.zip_longest(places, spins):
        w, v = w_W, cross(w_W, rotate(R_WA, subtract(p_SBo, p_AoAcm_A)))
        if spin is not None:
            own = rotate(R_WA, scale(spin.rate, spin.axis_S))
            w = add(w, own)
            v = add(v, cross(own, rotate(R_WA, subtract(p_SBo, spin.p_SPad))))
        motions.append(MatedMotion(multiply(q_WA, q_SB), rotate(R_WA, p_SBo), w, v))
    return motions
