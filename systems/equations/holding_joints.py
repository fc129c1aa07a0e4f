"""The rigid joints that hold, until an event changes that: on floats.

As Drake evaluates them, moment by moment.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.equations.articulated_inertia import (
    Massive,
    matrix_of,
    shifted_inertia,
    shifted_wrench,
)
from drakesep.systems.equations.block_elimination import Matrices, plan_elimination
from drakesep.systems.equations.joint_loops import holding_wrenches
from drakesep.systems.equations.joint_tree import (
    Alone,
    Carried,
    Group,
    hold_tree,
    plan_tree,
)
from drakesep.systems.equations.relative_motion import (
    BodyState,
    Wrench,
    add_wrenches,
    reaction,
)
from drakesep.systems.equations.rigid_joints import (
    JointPlace,
    RigidJoint,
    RigidJoints,
    joined,
    joint_equations,
)
from drakesep.systems.vectors import Vector, subtract


_NONE = Wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class Held(NamedTuple):
    """A rigid joint that holds, and where."""

    joint: RigidJoint
    place: JointPlace


def joints_that_hold(
    joints: RigidJoints, places: Sequence[JointPlace], held: Collection[int]
) -> list[Held]:
    """Return the joints of which an attachment holds; beside a weld, no other.

    Args:
        joints: of the separation.
        places: of each attachment's joint.
        held: indices of attachments that hold.
    """
    holding = [j for j in joints.joints if any(i in held for i in j.attachments)]
    welds = {joint.edge for joint in holding if joint.type == "fixed"}
    found = []
    for joint in holding:
        if joint.type == "fixed" or joint.edge not in welds:
            pads_A, pads_B = (
                _middle([getattr(places[i], pad) for i in joint.attachments])
                for pad in ("p_AoPad_A", "p_BoPad_B")
            )
            place = places[joint.first]._replace(p_AoPad_A=pads_A, p_BoPad_B=pads_B)
            found.append(Held(joint, place))
    return found


def _middle(pads: Sequence[Vector]) -> Vector:
    x, y, z = np.mean(pads, axis=0).tolist()
    return x, y, z


class HoldingJoints:
    """The rigid joints that hold, and the bodies that they join."""

    def __init__(
        self, joints: RigidJoints, massive: Sequence[Massive], held: Sequence[Held]
    ):
        """Prepare.

        Args:
            joints: of the separation.
            massive: mass properties of the joined bodies.
            held: the joints that hold.
        """
        self._joints, self._massive = joints, massive
        self._places = {joint.first: place for joint, place in held}
        tree = self._tree = plan_tree(
            [joint for joint, _ in held], [body.mass for body in massive], alone=True
        )
        branches = [branch.joints[0] for branch in tree.branches]
        self._branch_places = [self._places[joint.first] for joint in branches]
        self._roots = [body for [body] in tree.groups[: tree.roots]]
        self._loop_edges = sorted({joint.edge for joint in tree.loops})
        ends = [joints.edges[edge] for edge in self._loop_edges]
        self._ends = [(self._roots.index(a), self._roots.index(b)) for a, b in ends]
        self._plan = plan_elimination(len(self._roots), self._ends)

    @property
    def bodies(self) -> list[int]:
        """Places of the bodies that are held, among the joined ones."""
        return [body for [body] in self._tree.groups]

    def wrenches(
        self, bodies: Mapping[int, BodyState], others: Mapping[int, Wrench]
    ) -> dict[int, tuple[Wrench, Wrench]]:
        """Return the wrenches on A and B of each edge that holds, about their origins.

        Args:
            bodies: by their places among the joined ones, those that are held.
            others: all else that acts on each, about its origin.
        """
        tree = self._tree
        groups = [Group(bodies[i], self._massive[i], others[i]) for [i] in tree.groups]
        of_branches, on_edges = hold_tree(
            tree,
            groups,
            self._branch_places,
            Alone(),
            lambda roots: self._hold_loops(roots, bodies),
        )
        for branch, (outboard, inboard) in zip(tree.branches, of_branches, strict=True):
            [joint], [body] = branch.joints, tree.groups[branch.group]
            is_B = self._joints.edges[joint.edge][1] == body
            ends = (inboard, outboard) if is_B else (outboard, inboard)
            on_edges[joint.edge] = ends
        return on_edges

    def _hold_loops(
        self, roots: Sequence[Carried], bodies: Mapping[int, BodyState]
    ) -> tuple[list[Wrench], dict[int, tuple[Wrench, Wrench]]]:
        """Return what loops do to each root, and on A and B of each of their edges."""
        if not self._ends:
            return [], {}
        states = [bodies[i] for i in self._roots]
        p_WO = states[0].p_WBo
        M, free = [], []
        for (D, wrench), body in zip(roots, states, strict=True):
            arm = subtract(body.p_WBo, p_WO)
            torque, force = shifted_wrench(wrench, arm)
            M.append(matrix_of(shifted_inertia(D, arm)))
            free.append([*torque, *force])
        stiffness, rest = self._loop_equations(bodies, p_WO)
        found = holding_wrenches(
            self._plan,
            self._ends,
            np.array(M),
            np.array(free),
            stiffness,
            rest,
            Matrices(),
        )
        on_roots = [_NONE] * len(states)
        on_edges: dict[int, tuple[Wrench, Wrench]] = {}
        for edge, (a, b), entries in zip(
            self._loop_edges, self._ends, found.tolist(), strict=True
        ):
            wrench = Wrench((*entries[:3],), (*entries[3:],))
            on_A, on_B = (
                shifted_wrench(each, subtract(p_WO, states[k].p_WBo))
                for k, each in ((a, reaction(wrench)), (b, wrench))
            )
            on_edges[edge] = on_A, on_B
            on_roots[b] = add_wrenches(on_roots[b], on_B)
            on_roots[a] = add_wrenches(on_roots[a], on_A)
        return on_roots, on_edges

    def _loop_equations(
        self, bodies: Mapping[int, BodyState], p_WO: Vector
    ) -> tuple[Array, Array]:
        """Return (e, 6, 6) stiffness of the edges of loops, and (e, 6) the rest."""
        count = len(self._loop_edges)
        stiffness, rest = np.zeros((count, 6, 6)), np.zeros((count, 6))
        for joint in self._tree.loops:
            A, B, place = bodies[joint.a], bodies[joint.b], self._places[joint.first]
            k, arm = self._joints.scales[joint.edge]
            motion = joined(joint.type, place, A, B)
            equations = joint_equations(joint.type, motion, p_WO, arm)
            J: Array = np.array(equations.J)
            edge = self._loop_edges.index(joint.edge)
            stiffness[edge] += k * (J.T @ J)
            rest[edge] += joint.way * k * (equations.rest @ J)
        return stiffness, rest
