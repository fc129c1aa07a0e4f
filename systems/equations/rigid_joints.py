"""Joints held exactly: the wrenches that keep Eq. 1 and 2, solved for at each moment.

NASA's own form of the Constraint Force Equations: Eq. 1 and 2, differentiated twice,
are linear in the accelerations of the bodies, and so in the wrenches that hold the
joints (Toniolo, Tartabini, Pamadi and Hotchko, AIAA 2008-219; NASA/TP-2016-219326).
These are found by the method of multipliers: in a few rounds with joints that are stiff
to accelerations, each of which begins where the last one has come to. However many
joints hold the same directions, this is well posed, and of all wrenches that hold them
it finds those of equal joints (Carpentier, Budhiraja and Mansard, "Proximal and sparse
resolution of constrained dynamic equations", RSS 2021).

Wrenches and accelerations are about a common point O, in W: six numbers, of which the
first three are of rotation. The acceleration of a body is that of its point at O,
without what its angular velocity gives.
"""

import math
from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.equations.block_elimination import (
    Algebra,
    Blocks,
    Factorized,
    Matrices,
    Plan,
    plan_elimination,
)
from drakesep.systems.equations.mated_stack import mated_places, place_in_stack
from drakesep.systems.equations.relative_motion import (
    BodyState,
    Wrench,
    velocity_at,
)
from drakesep.systems.model.joints import CONSTRAINTS, JointType
from drakesep.systems.model.separation import Attachment, Separation
from drakesep.systems.vectors import (
    Rotation,
    Scalar,
    Symmetric,
    Vector,
    add,
    apply,
    compose,
    cross,
    dot,
    rotate,
    scale,
    subtract,
)


_STIFFNESS = 1e4
"""Of joints to accelerations, over what they hold: each round leaves this part less of
the error, and round-off of accelerations is this many times as large in wrenches."""
_ROUNDS = 3


# What there is.


class RigidJoint(NamedTuple):
    """A rigid joint, or all fixed ones of two bodies: together they hold as one."""

    frames: dict[int, Rotation]
    """Orientation R_AJ of each that it stands for, by the attachment's index."""
    type: JointType
    a: int
    """Place of its A among the joined bodies."""
    b: int
    edge: int
    way: float
    """1 if its A is that of the edge; -1 if its B is."""

    @property
    def attachments(self) -> list[int]:
        """Indices of those that it stands for."""
        return list(self.frames)

    @property
    def R_AJ(self) -> Rotation:
        """Orientation of its frame in A: of a fixed one, any of them."""
        return next(iter(self.frames.values()))


class RigidJoints(NamedTuple):
    """The rigid joints of a separation."""

    joints: list[RigidJoint]
    bodies: list[int]
    """Indices of the bodies that they join."""
    edges: list[tuple[int, int]]
    """Of each two bodies that are joined their places in `bodies`: A and B."""
    stiffness: Array
    """Of each edge to accelerations, kg."""
    arm: Array
    """Of each edge, m: its stiffness to rotation is that times this, squared."""
    plan: Plan
    """In which order their equations are solved."""


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
        frames = {
            separation.attachments.index(member): member.joint.R_AJ
            for member in members
        }
        joints.append(RigidJoint(frames, members[0].joint.type, a, b, k, way))
    scales = [_scale(separation, edges.values(), edge) for edge in edges.values()]
    stiffness, arm = np.reshape(scales, (-1, 2)).T
    plan = plan_elimination(len(bodies), list(edges))
    return RigidJoints(joints, bodies, list(edges), stiffness, arm, plan)


def _scale(
    separation: Separation, edges: Collection[Attachment], edge: Attachment
) -> tuple[float, float]:
    """Return the stiffness of an edge, kg, and its arm, m, from what it holds.

    Of the lighter of the sides that it holds together: of all that hangs on it.
    """
    others = [(x.A, x.B) for x in edges if x is not edge]
    sides = [_reached(others, end) for end in (edge.A, edge.B)]
    if edge.B in sides[0]:  # of a loop
        sides = [{edge.A}, {edge.B}]
    bodies = [[b for b in separation.bodies if b.name in side] for side in sides]
    masses = [sum(body.mass for body in side) for side in bodies]
    places = mated_places(separation)
    pad = place_in_stack(places[edge.A], edge.p_AoPad_A)
    inertia = 0.0
    for body in bodies[masses[1] < masses[0]]:
        arm = subtract(pad, place_in_stack(places[body.name], body.p_BoBcm_B))
        inertia += sum(body.I_BBcm_B[:3]) / 3.0 + body.mass * dot(arm, arm)
    stiffness = _STIFFNESS / sum(1.0 / mass for mass in masses)
    return stiffness, math.sqrt(inertia / min(masses))


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


class Equations(NamedTuple):
    """Eq. 1 and 2 of a joint, differentiated twice: J (V_B - V_A) + rest = 0."""

    J: list[list[Scalar]]
    """Six numbers for each equation."""
    rest: list[Scalar]


def joint_equations(
    type: JointType,
    R_AJ: Rotation,
    A: BodyState,
    B: BodyState,
    p_BoPad_B: Vector,
    axis_B: Vector,
    p_WO: Vector,
    arm: Scalar,
) -> Equations:
    """Return the equations of a joint.

    Args:
        type: of the joint.
        R_AJ: orientation of its frame in A.
        A: first body.
        B: second body.
        p_BoPad_B: its place in B, m.
        axis_B: y axis of a universal joint, fixed in B.
        p_WO: place of O in W, m.
        arm: by which equations of rotation are multiplied, m.
    """
    r_B = rotate(B.R_WB, p_BoPad_B)
    p_WPad = add(B.p_WBo, r_B)
    r_A = subtract(p_WPad, A.p_WBo)
    v = subtract(velocity_at(B, r_B), velocity_at(A, r_A))
    w_AB = subtract(B.w_WB, A.w_WB)
    # As seen from A, without what the accelerations of the bodies give.
    a = subtract(
        subtract(cross(B.w_WB, cross(B.w_WB, r_B)), cross(A.w_WB, cross(A.w_WB, r_A))),
        scale(2.0, cross(A.w_WB, v)),
    )
    alpha = cross(w_AB, A.w_WB)
    R = compose(A.R_WB, R_AJ)
    axes = [(R[i], R[3 + i], R[6 + i]) for i in range(3)]
    p_OPad = subtract(p_WPad, p_WO)
    zero = 0.0 * a[0]
    J, rest = [], []
    translation, rotation = CONSTRAINTS[type]
    for e, held in zip(axes, translation, strict=True):
        if held:
            J.append([*cross(p_OPad, e), *e])
            rest.append(dot(e, a))  # Eq. 1
    for e, held in zip(axes, rotation, strict=True):
        if held:
            beside = dot(e, alpha)
            if type == "universal":
                x_A, y_B = axes[0], rotate(B.R_WB, axis_B)
                e = cross(y_B, x_A)
                turning = cross(w_AB, cross(w_AB, y_B))
                beside = dot(e, alpha) + dot(x_A, turning)
            J.append([*scale(arm, e), zero, zero, zero])
            rest.append(arm * beside)  # Eq. 2
    return Equations(J, rest)


class Massive(NamedTuple):
    """Mass properties of a body."""

    mass: Scalar
    """kg."""
    p_BoBcm_B: Vector
    """m."""
    I_BBcm_B: Symmetric
    """kg m^2."""


def spatial_inertia(
    B: BodyState, massive: Massive, p_WO: Vector
) -> tuple[list[list[Scalar]], list[Scalar]]:
    """Return the inertia of a body about O, and its wrench of inertia without V.

    Args:
        B: the body.
        massive: its mass properties.
        p_WO: place of O in W, m.

    Returns:
        Six rows M and six numbers h of M V + h = wrench (Newton and Euler).
    """
    m, w = massive.mass, B.w_WB
    r = rotate(B.R_WB, massive.p_BoBcm_B)
    c = x, y, z = add(subtract(B.p_WBo, p_WO), r)
    inertia = xx, yy, zz, xy, xz, yz = _turned(B.R_WB, massive.I_BBcm_B)
    mx, my, mz = scale(m, c)
    zero = 0.0 * mx
    M = [
        [xx + my * y + mz * z, xy - mx * y, xz - mx * z, zero, -mz, my],
        [xy - mx * y, yy + mx * x + mz * z, yz - my * z, mz, zero, -mx],
        [xz - mx * z, yz - my * z, zz + mx * x + my * y, -my, mx, zero],
        [zero, mz, -my, m + zero, zero, zero],
        [-mz, zero, mx, zero, m + zero, zero],
        [my, -mx, zero, zero, zero, m + zero],
    ]
    force = scale(m, cross(w, cross(w, r)))
    torque = add(cross(w, apply(inertia, w)), cross(c, force))
    return M, [*torque, *force]


def _turned(R: Rotation, S: Symmetric) -> Symmetric:
    """Return R S R^T."""
    x, y, z = R[:3], R[3:6], R[6:]
    Sx, Sy, Sz = (apply(S, row) for row in (x, y, z))
    return dot(x, Sx), dot(y, Sy), dot(z, Sz), dot(x, Sy), dot(x, Sz), dot(y, Sz)


def moved(wrench: Wrench, arm: Vector) -> Wrench:
    """Return a wrench about a point from which its own is at an arm."""
    torque = add(wrench.torque, cross(arm, wrench.force))
    return Wrench(torque, wrench.force)


def wrenches_on_bodies(
    joints: RigidJoints,
    wrenches: Sequence[Wrench],
    p_WO: Vector,
    bodies: Sequence[BodyState],
) -> list[Wrench]:
    """Return what rigid joints do to the joined bodies, about their origins.

    Args:
        joints: of the separation.
        wrenches: on B of each edge, about O.
        p_WO: place of O in W, m.
        bodies: that are joined.
    """
    zero = (0.0, 0.0, 0.0)
    totals = [Wrench(zero, zero)] * len(bodies)
    for (a, b), (torque, force) in zip(joints.edges, wrenches, strict=True):
        before = totals[b]
        totals[b] = Wrench(add(before.torque, torque), add(before.force, force))
        before = totals[a]
        totals[a] = Wrench(
            subtract(before.torque, torque), subtract(before.force, force)
        )
    return [
        moved(total, subtract(p_WO, body.p_WBo))
        for total, body in zip(totals, bodies, strict=True)
    ]


# What holds.


def holding_wrenches(
    joints: RigidJoints,
    inertias: Blocks,
    free: Blocks,
    stiffness: Blocks,
    rest: Blocks,
    algebra: Algebra,
) -> Blocks:
    """Return the wrenches that rigid joints give B of each edge; the reverse A.

    Args:
        joints: that hold.
        inertias: M of each body.
        free: of each body the wrench of all else that acts, less h.
        stiffness: of each edge the sum of J^T k J of the joints that hold.
        rest: of each edge that of J^T k rest.
        algebra: of the engine.
    """
    nodes = len(joints.bodies)
    A, B = ([edge[k] for edge in joints.edges] for k in range(2))

    def sum_up(blocks: Blocks, sign: float) -> Blocks:
        on_A = algebra.sum_to(blocks, A, nodes)
        return algebra.sum_to(blocks, B, nodes) + sign * on_A

    own = inertias + sum_up(stiffness, 1.0)
    system = Factorized(joints.plan, own, -stiffness, algebra)
    wrenches = 0.0 * rest
    V = system.solve(free - sum_up(rest, -1.0))
    for _ in range(_ROUNDS - 1):
        apart = algebra.pick(V, B) - algebra.pick(V, A)
        gap = rest + algebra.apply(stiffness, apart)
        wrenches = wrenches - gap
        # The next round's solution by what it adds: of round-off, too, that is rid.
        left = free - algebra.apply(inertias, V) + sum_up(wrenches - gap, -1.0)
        V = V + system.solve(left)
    apart = algebra.pick(V, B) - algebra.pick(V, A)
    return wrenches - rest - algebra.apply(stiffness, apart)


class Held(NamedTuple):
    """A rigid joint that holds, and where it is in its B."""

    joint: RigidJoint
    p_BoPad_B: Vector
    """m."""
    axis_B: Vector
    """y axis of a universal joint."""


def joints_that_hold(
    joints: RigidJoints,
    p_BoPad_B: Sequence[Vector],
    axis_B: Sequence[Vector],
    held: Collection[int],
) -> list[Held]:
    """Return the joints of which an attachment holds.

    Args:
        joints: of the separation.
        p_BoPad_B: place of each attachment in its B, m.
        axis_B: as `HeldJoint` has it, of each attachment.
        held: indices of attachments that hold.
    """
    found = []
    for joint in joints.joints:
        if any(i in held for i in joint.attachments):
            pads = [p_BoPad_B[i] for i in joint.attachments]
            x, y, z = np.mean(pads, axis=0).tolist()
            found.append(Held(joint, (x, y, z), axis_B[joint.attachments[0]]))
    return found


class HoldingJoints(NamedTuple):
    """The rigid joints that hold, until an event changes that; on floats."""

    joints: RigidJoints
    massive: Sequence[Massive]
    """Mass properties of the joined bodies."""
    held: Sequence[Held]

    def wrenches(
        self, bodies: Sequence[BodyState], others: Sequence[Wrench]
    ) -> tuple[list[Wrench], Vector]:
        """Return the wrenches on B of each edge about O, and the place of O in W.

        Args:
            bodies: that are joined.
            others: all else that acts on them, about their origins.
        """
        p_WO, count = bodies[0].p_WBo, len(self.joints.edges)
        M, free = [], []
        for body, massive, other in zip(bodies, self.massive, others, strict=True):
            inertia, h = spatial_inertia(body, massive, p_WO)
            torque, force = moved(other, subtract(body.p_WBo, p_WO))
            M.append(inertia)
            free.append([x - y for x, y in zip((*torque, *force), h, strict=True)])
        stiffness, rest = np.zeros((count, 6, 6)), np.zeros((count, 6))
        for joint, pad, axis in self.held:
            A, B, edge = bodies[joint.a], bodies[joint.b], joint.edge
            k, arm = self.joints.stiffness[edge], float(self.joints.arm[edge])
            equations = joint_equations(
                joint.type, joint.R_AJ, A, B, pad, axis, p_WO, arm
            )
            J: Array = np.array(equations.J)
            stiffness[edge] += k * (J.T @ J)
            rest[edge] += joint.way * k * (equations.rest @ J)
        found = holding_wrenches(
            self.joints, np.array(M), np.array(free), stiffness, rest, Matrices()
        )
        wrenches = [
            Wrench((*entries[:3],), (*entries[3:],)) for entries in found.tolist()
        ]
        return wrenches, p_WO
