"""Joints held exactly: which there are, and Eq. 1 and 2 twice differentiated.

NASA's own form of the Constraint Force Equations: Eq. 1 and 2, differentiated twice,
are linear in the accelerations of the bodies, and so in the wrenches that hold the
joints (Toniolo, Tartabini, Pamadi and Hotchko, AIAA 2008-219; NASA/TP-2016-219326).
`joint_tree` solves for these where bodies hang on one another, `joint_loops` where
they form loops, or several joints hold the same two.
"""

import math
from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

from drakesep.systems.equations.mated_stack import (
    held_joint,
    mated_ends,
    mated_orientation,
    mated_places,
    place_in_stack,
)
from drakesep.systems.equations.relative_motion import BodyState, velocity_at
from drakesep.systems.model.joints import (
    CONSTRAINTS,
    JointType,
    holds_all_rotations,
)
from drakesep.systems.model.separation import Attachment, Separation
from drakesep.systems.vectors import (
    TINY,
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
    rotate,
    scale,
    subtract,
    transpose,
)


_STIFFNESS = 1e4
"""Of joints of loops to accelerations, over what they hold: each round of `joint_loops`
leaves this part less of the error, and round-off of accelerations is this many times as
large in wrenches."""


_W: Rotation = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


# What there is.


class RigidJoint(NamedTuple):
    """A rigid joint, or all fixed ones of two bodies: together they hold as one."""

    attachments: list[int]
    """Indices of those that it stands for."""
    type: JointType
    a: int
    """Place of its A among the joined bodies."""
    b: int
    edge: int
    way: float
    """1 if its A is that of the edge; -1 if its B is."""

    @property
    def first(self) -> int:
        """Index of the first of them, which stands for the joint."""
        return self.attachments[0]


class JointPlace(NamedTuple):
    """Where a joint is in its bodies."""

    R_AJ: Rotation
    """Orientation of its frame in A: of a fixed one, of any of those it stands for."""
    p_AoPad_A: Vector
    """m."""
    p_BoPad_B: Vector
    """m."""
    axis_B: Vector
    """Its x axis, or y of a universal one, fixed in B."""
    q_AB: Quaternion
    """Orientation of B in A while mated."""


class Scale(NamedTuple):
    """What a joint of a loop holds, by which its equations are scaled."""

    stiffness: float
    """To accelerations, kg."""
    arm: float
    """m: its stiffness to rotation is that times this, squared."""


class RigidJoints(NamedTuple):
    """The rigid joints of a separation."""

    joints: list[RigidJoint]
    bodies: list[int]
    """Indices of the bodies that they join."""
    edges: list[tuple[int, int]]
    """Of each two bodies that are joined their places in `bodies`: A and B."""
    scales: Sequence[Scale]
    """Of each edge."""


def rigid_joints(separation: Separation) -> RigidJoints:
    """Return the rigid joints of a separation."""
    attachments = [a for a in separation.attachments if a.joint.rigid]
    bodies = sorted({body for a in attachments for body in separation.ends(a)})
    alike: dict[Any, list[Attachment]] = {}
    for attachment in attachments:
        alone = () if attachment.joint.type == "fixed" else attachment.name
        alike.setdefault((separation.ends(attachment), alone), []).append(attachment)
    joints: list[RigidJoint] = []
    edges: dict[tuple[int, int], Attachment] = {}
    for (ends, _), members in alike.items():
        a, b = (bodies.index(end) for end in ends)
        # Two bodies are one edge, whichever of them is A of a joint.
        edge = (b, a) if (b, a) in edges else (a, b)
        edges.setdefault(edge, members[0])
        way = 1.0 if edge == (a, b) else -1.0
        k = list(edges).index(edge)
        indices = [separation.attachments.index(member) for member in members]
        joints.append(RigidJoint(indices, members[0].joint.type, a, b, k, way))
    scales = [_scale(separation, edges.values(), edge) for edge in edges.values()]
    return RigidJoints(joints, bodies, list(edges), scales)


def joint_places(separation: Separation) -> list[JointPlace]:
    """Return where each attachment's joint is in its bodies."""
    places = []
    for attachment in separation.attachments:
        held = held_joint(separation, attachment)
        q_AB = mated_orientation(*mated_ends(separation, attachment))
        pads = held.p_AoPad_A, held.p_BoPad_B
        places.append(JointPlace(attachment.joint.R_AJ, *pads, held.axis_B, q_AB))
    return places


def _scale(
    separation: Separation, edges: Collection[Attachment], edge: Attachment
) -> Scale:
    """Return the scale of an edge, from what it holds.

    Of the lighter of the sides that it holds together.
    """
    sides = _sides(separation, [(x.A, x.B) for x in edges], (edge.A, edge.B))
    masses = [_mass(separation, side) for side in sides]
    places = mated_places(separation)
    pad = place_in_stack(places[edge.A], edge.p_AoPad_A)
    inertia = 0.0
    for name in sides[masses[1] < masses[0]]:
        body = separation.body(name)
        arm = subtract(pad, place_in_stack(places[name], body.p_BoBcm_B))
        inertia += sum(body.I_BBcm_B[:3]) / 3.0 + body.mass * dot(arm, arm)
    stiffness = _STIFFNESS / sum(1.0 / mass for mass in masses)
    return Scale(stiffness, math.sqrt(inertia / min(masses)))


def _sides(
    separation: Separation, edges: Sequence[tuple[str, str]], edge: tuple[str, str]
) -> tuple[set[str], set[str]]:
    """Return the bodies that an edge holds together.

    All that hangs on either of its ends. In a loop a light body, as a strut, may carry
    heavy ones: the heaviest body, with what hangs on it, and all others.
    """
    A, B = (_reached([x for x in edges if x != edge], end) for end in edge)
    if edge[1] not in A:
        return A, B
    around = [x for x in edges if x[1] in _reached([y for y in edges if y != x], x[0])]
    loop = _reached(around, edge[0])
    hanging = [x for x in edges if not loop.issuperset(x)]
    parts = [_reached(hanging, name) for name in sorted(loop)]
    heaviest = max(parts, key=lambda part: _mass(separation, part))
    return heaviest, set().union(*parts) - heaviest


def _mass(separation: Separation, names: Collection[str]) -> float:
    return sum(separation.body(name).mass for name in names)


def _reached(edges: Sequence[tuple[str, str]], start: str) -> set[str]:
    """Return the bodies that edges lead to from one."""
    reached, front = {start}, [start]
    while front:
        name = front.pop()
        for edge in edges:
            if name in edge:
                new = {*edge} - reached
                reached |= new
                front += new
    return reached


# Laws, on floats or lanes.


class Joined(NamedTuple):
    """How B moves from A at a joint, but for what the bodies' accelerations give.

    Of the accelerations the joint allows none: `a`, `alpha` and `turning` are what is
    to be taken from B. That is what rates give; and what brings B back from where an
    integrator has let it drift.
    """

    p_WPad: Vector
    """m."""
    axes: tuple[Vector, Vector, Vector]
    """Of the joint's frame, in W; W's own for a fixed one, which holds along any."""
    a: Vector
    """Of B's pad as seen from A, m/s^2; along directions that the joint holds."""
    alpha: Vector
    """rad/s^2; likewise."""
    hinge: Vector | None
    """y axis of a universal joint, in W, fixed in B."""
    turning: Vector | None
    """What B's rates give its second derivative as seen from A, rad/s^2."""


def joined(type: JointType, place: JointPlace, A: BodyState, B: BodyState) -> Joined:
    """Return how B moves from A at a joint.

    Args:
        type: of the joint.
        place: of it.
        A: first body.
        B: second body.
    """
    r_B = rotate(B.R_WB, place.p_BoPad_B)
    p_WPad = add(B.p_WBo, r_B)
    r_A = subtract(p_WPad, A.p_WBo)
    v = subtract(velocity_at(B, r_B), velocity_at(A, r_A))
    w_AB = subtract(B.w_WB, A.w_WB)
    a = subtract(
        subtract(cross(B.w_WB, cross(B.w_WB, r_B)), cross(A.w_WB, cross(A.w_WB, r_A))),
        scale(2.0, cross(A.w_WB, v)),
    )
    R = _W if type == "fixed" else compose(A.R_WB, place.R_AJ)
    x, y, z = ((R[i], R[3 + i], R[6 + i]) for i in range(3))
    # Baumgarte: g'' + 2 w g' + w^2 g = 0 of each gap g, as fast as the bodies turn.
    # Integrators err at that pace; a faster w would rule their steps.
    w2 = dot(A.w_WB, A.w_WB) + dot(B.w_WB, B.w_WB)
    damping = 2.0 * (w2 + TINY) ** 0.5
    gap = subtract(r_A, rotate(A.R_WB, place.p_AoPad_A))
    a = add(a, add(scale(damping, v), scale(w2, gap)))
    alpha = add(cross(w_AB, A.w_WB), scale(damping, w_AB))
    alpha = add(alpha, scale(w2, _turn(type, place, A, B, x)))
    hinge = turning = None
    if type == "universal":
        hinge = rotate(B.R_WB, place.axis_B)
        turning = cross(w_AB, cross(w_AB, hinge))
    return Joined(p_WPad, (x, y, z), a, alpha, hinge, turning)


def _turn(
    type: JointType, place: JointPlace, A: BodyState, B: BodyState, x: Vector
) -> Vector:
    """Return by how little B has turned where the joint holds it, in W, rad (Eq. 2).

    Args:
        type: of the joint.
        place: of it.
        A: first body.
        B: second body.
        x: axis of the joint's frame in A, in W.
    """
    if type == "spherical":
        return scale(0.0, x)
    if holds_all_rotations(type):
        mated = multiply(A.q_WB, place.q_AB)
        turned = w, i, j, k = multiply(B.q_WB, conjugate(mated))
        return scale(2.0 * w / sum(c * c for c in turned), (i, j, k))
    axis = rotate(B.R_WB, place.axis_B)
    turn = cross(x, axis)
    # Of a universal joint, about the normal of both: cosine times sine of their angle.
    return scale(-dot(x, axis), turn) if type == "universal" else turn


def gap_of(
    type: JointType, place: JointPlace, A: BodyState, B: BodyState
) -> tuple[float, float]:
    """Return how far B is from where a joint holds it: m, and the sine of an angle.

    Args:
        type: of the joint.
        place: of it.
        A: first body, on floats.
        B: second body.
    """
    pads = (
        add(body.p_WBo, rotate(body.R_WB, pad))
        for body, pad in ((A, place.p_AoPad_A), (B, place.p_BoPad_B))
    )
    R = compose(A.R_WB, place.R_AJ)
    moved_J = rotate(transpose(R), subtract(*pads))
    held = CONSTRAINTS[type].translation
    moved = math.hypot(*(m for m, holds in zip(moved_J, held, strict=True) if holds))
    x = R[0], R[3], R[6]
    if type == "universal":
        return moved, abs(dot(x, rotate(B.R_WB, place.axis_B)))
    return moved, math.hypot(*_turn(type, place, A, B, x))


def held_turns(type: JointType, motion: Joined) -> list[tuple[Vector, Scalar]]:
    """Return directions e and rests of e . (alpha_WB - alpha_WA) + rest = 0 (Eq. 2)."""
    if motion.hinge is not None and motion.turning is not None:
        x_A = motion.axes[0]
        e = cross(motion.hinge, x_A)
        return [(e, dot(e, motion.alpha) + dot(x_A, motion.turning))]
    return [
        (e, dot(e, motion.alpha))
        for e, held in zip(motion.axes, CONSTRAINTS[type].rotation, strict=True)
        if held
    ]


class Equations(NamedTuple):
    """Eq. 1 and 2 of a joint, differentiated twice: J (V_B - V_A) + rest = 0.

    Accelerations V, first of rotation, are those of the bodies' points at a place O,
    without what the bodies' angular velocities give.
    """

    J: list[list[Scalar]]
    """Six numbers for each equation."""
    rest: list[Scalar]


def joint_equations(
    type: JointType, motion: Joined, p_WO: Vector, arm: Scalar
) -> Equations:
    """Return the equations of a joint.

    Args:
        type: of the joint.
        motion: of B from A at it.
        p_WO: place of O in W, m.
        arm: by which equations of rotation are multiplied, m.
    """
    p_OPad = subtract(motion.p_WPad, p_WO)
    zero = 0.0 * motion.a[0]
    J, rest = [], []
    for e, held in zip(motion.axes, CONSTRAINTS[type].translation, strict=True):
        if held:
            J.append([*cross(p_OPad, e), *(x + zero for x in e)])
            rest.append(dot(e, motion.a))  # Eq. 1
    for e, beside in held_turns(type, motion):
        J.append([*(x + zero for x in scale(arm, e)), zero, zero, zero])
        rest.append(arm * beside)  # Eq. 2
    return Equations(J, rest)
