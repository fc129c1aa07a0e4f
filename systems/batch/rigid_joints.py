"""The rigid joints of a batch, on lanes."""

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from drakesep.systems import vectors
from drakesep.systems.batch.lane_blocks import LaneBlocks, lane_rows
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode, Settler, pick
from drakesep.systems.batch.mated_places import BatchPlaces
from drakesep.systems.batch.wrenches import WrenchSum
from drakesep.systems.equations.articulated_inertia import (
    Massive,
    matrix_of,
    shifted_inertia,
    shifted_wrench,
)
from drakesep.systems.equations.block_elimination import plan_elimination
from drakesep.systems.equations.joint_loops import holding_wrenches
from drakesep.systems.equations.joint_tree import (
    Branch,
    Carried,
    Group,
    hold_tree,
    plan_tree,
)
from drakesep.systems.equations.mated_stack import axis_on_A
from drakesep.systems.equations.relative_motion import BodyState, Wrench, reaction
from drakesep.systems.equations.rigid_joints import (
    JointPlace,
    RigidJoint,
    RigidJoints,
    joined,
    joint_equations,
    joint_places,
)
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


class _Kind(NamedTuple):
    """Joints of one type, on an axis of lanes."""

    joints: list[RigidJoint]
    axis_A: Vector
    """x axis, or y of a universal joint, fixed in A at first, of (k, 1)."""
    place: JointPlace
    """Of (k, 1)."""

    @property
    def type(self) -> Any:
        """Their type."""
        return self.joints[0].type


class BatchRigidJoints:
    """The wrenches of those rigid joints of a separation that may hold, on lanes."""

    def __init__(
        self,
        separation: Separation,
        joints: RigidJoints,
        may_hold: Sequence[RigidJoint],
        places: BatchPlaces,
    ):
        """Prepare.

        Args:
            separation: whose joints they are.
            joints: all of them.
            may_hold: some of them.
            places: of its bodies while mated.
        """
        self._joints = joints
        self._places = places
        tree = self._tree = plan_tree(
            may_hold, [separation.bodies[i].mass for i in joints.bodies], alone=False
        )
        self._branches = [_kind(separation, branch.joints) for branch in tree.branches]
        self._loops = [
            _kind(separation, [joint for joint in tree.loops if joint.type == type])
            for type in dict.fromkeys(joint.type for joint in tree.loops)
        ]
        roots = tree.groups[0]
        self._loop_edges = sorted({joint.edge for joint in tree.loops})
        ends = [joints.edges[edge] for edge in self._loop_edges]
        self._ends = [(roots.index(a), roots.index(b)) for a, b in ends]
        self._plan = plan_elimination(len(roots), self._ends)

    def wrenches(
        self, bodies: BodyState, others: Wrench, params: BatchParameters, mode: Mode
    ) -> Wrench:
        """Return the wrenches of the joints that hold.

        Args:
            bodies: of (m, n).
            others: all else that acts on them.
            params: of the batch.
            mode: what has happened.
        """
        tree = self._tree
        held = jnp.isinf(mode.released)
        groups = [
            Group(
                pick_rows(bodies, index),
                Massive(
                    *pick_rows((params.mass, params.p_BoBcm_B, params.I_BBcm_B), index)
                ),
                pick_rows(others, index),
            )
            for index in (self._indices(group) for group in tree.groups)
        ]
        roots, x = groups[0].bodies, bodies.q_WB[0][0]
        of_branches, on_roots = hold_tree(
            tree,
            groups,
            [self._place(kind, params) for kind in self._branches],
            _LaneRows(held, x),
            lambda carried: self._hold_loops(
                carried[0], roots, params, held, LaneBlocks(x)
            ),
        )
        total = WrenchSum(bodies)
        for branch, (outboard, inboard) in zip(tree.branches, of_branches, strict=True):
            carriers = [tree.groups[branch.inboard][row] for row in branch.rows]
            for k, (b, a) in enumerate(
                zip(tree.groups[branch.group], carriers, strict=True)
            ):
                total.add(self._joints.bodies[b], pick(outboard, k))
                total.add(self._joints.bodies[a], pick(inboard, k))
        for k, wrench in on_roots.items():
            total.add(self._joints.bodies[tree.groups[0][k]], wrench)
        return total.wrench

    def _indices(self, group: Sequence[int]) -> list[int]:
        """Return the bodies' places in the batch."""
        return [self._joints.bodies[body] for body in group]

    def _place(self, kind: _Kind, params: BatchParameters) -> JointPlace:
        """Return where joints are, of (k, n); of a weld of pads, between these."""
        members = [joint.attachments for joint in kind.joints]

        def middle(pads: Vector) -> Vector:
            x, y, z = (
                jnp.stack([sum(entry[i] for i in each) / len(each) for each in members])
                for entry in pads
            )
            return x, y, z

        place = kind.place._replace(
            p_AoPad_A=middle(params.p_AoPad_A), p_BoPad_B=middle(params.p_BoPad_B)
        )
        if not self._places.vary:
            return place
        ends = [self._indices([joint.a, joint.b]) for joint in kind.joints]
        each = [self._places.orientation(a, b, params) for a, b in ends]
        w, x, y, z = (jnp.stack(entries) for entries in zip(*each, strict=True))
        R_AB = vectors.rotation_matrix((w, x, y, z))
        axis_B = vectors.unrotate(R_AB, kind.axis_A)
        return place._replace(axis_B=axis_B, q_AB=(w, x, y, z))

    # Loops.

    def _hold_loops(
        self,
        carried: Carried,
        roots: BodyState,
        params: BatchParameters,
        held: Lanes,
        lanes: LaneBlocks,
    ) -> tuple[list[Wrench], dict[int, Wrench]]:
        """Return what loops do to the roots, of (r, n); and of (n,), to each."""
        if not self._ends:
            return [], {}
        p_WO = pick(roots.p_WBo, slice(0, 1))
        arm = vectors.subtract(roots.p_WBo, p_WO)
        torque, force = shifted_wrench(carried.wrench, arm)
        M = matrix_of(shifted_inertia(carried.inertia, arm))
        stiffness, rest = self._loop_equations(roots, p_WO, params, held, lanes)
        found = holding_wrenches(
            self._plan,
            self._ends,
            lanes.settled(lane_rows(M)),
            lanes.settled(lane_rows([*torque, *force])),
            lanes.settled(stiffness),
            lanes.settled(rest),
            lanes,
        )
        total = WrenchSum(roots)
        for k, (a, b) in enumerate(self._ends):
            wrench = Wrench(tuple(found[:3, k]), tuple(found[3:, k]))
            total.add(b, _moved(wrench, arm, b))
            total.add(a, _moved(reaction(wrench), arm, a))
        summed = total.wrench
        each = {k: pick(summed, k) for k in range(len(self._tree.groups[0]))}
        return [summed], each

    def _loop_equations(
        self,
        roots: BodyState,
        p_WO: Vector,
        params: BatchParameters,
        held: Lanes,
        lanes: LaneBlocks,
    ) -> tuple[Lanes, Lanes]:
        """Return (6, 6, e, n) stiffness of the edges, and (6, e, n) the rest."""
        count, places = len(self._loop_edges), self._tree.groups[0]
        stiffness: Any = 0.0
        rest: Any = 0.0
        for kind in self._loops:
            edges = [joint.edge for joint in kind.joints]
            A, B = (
                pick_rows(roots, [places.index(body) for body in ends])
                for ends in zip(*((j.a, j.b) for j in kind.joints), strict=True)
            )
            place = self._place(kind, params)
            motion = joined(kind.type, place, A, B)
            scales = np.array([self._joints.scales[edge] for edge in edges])
            gains, arm = scales.T[:, :, None]
            J, beside = joint_equations(kind.type, motion, p_WO, arm)
            ways = np.array([joint.way for joint in kind.joints])[:, None]
            k = jnp.where(_hold(kind.joints, held), gains, 0.0)
            rows = lanes.settled(lane_rows(J))
            blocks = lanes.multiply(lanes.transpose(k * rows), rows)
            forces = lanes.apply(lanes.transpose(rows), k * ways * lane_rows(beside))
            targets = [self._loop_edges.index(edge) for edge in edges]
            stiffness = stiffness + lanes.sum_to(blocks, targets, count)
            rest = rest + lanes.sum_to(forces, targets, count)
        return stiffness, rest


class _LaneRows(Settler):
    """Bodies of a group on an axis of lanes (k, n)."""

    def __init__(self, held: Lanes, x: Lanes):
        """Prepare.

        Args:
            held: (a, n) whether each attachment holds.
            x: as `Settler` has it.
        """
        super().__init__(x)
        self._held = held

    def outward(self, values: Any, branch: Branch) -> Any:
        """Return what inboard bodies have, for each outboard body of a branch."""
        return _outward(values, branch)

    def inward(self, branch: Branch, count: int) -> Callable[[Any], Any]:
        """Return how outboard bodies give something to so many inboard ones."""
        of_each = [
            [k for k, row in enumerate(branch.rows) if row == inboard]
            for inboard in range(count)
        ]

        def total(x: Lanes) -> Lanes:
            # Written out: as a sum over an axis XLA takes five times as long.
            sums = [
                sum((x[k : k + 1] for k in mine), start=jnp.zeros_like(x[:1]))
                for mine in of_each
            ]
            return sums[0] if count == 1 else jnp.concatenate(sums)

        return lambda values: jax.tree.map(total, self.held(values, branch))

    def law(self, law: Callable[..., Any], *fixed: Any) -> Callable[..., Any]:
        """Return a law, some of whose first arguments are fixed."""
        return functools.partial(law, *fixed)

    def held(self, values: Any, branch: Branch) -> Any:
        """Return values where a joint of a branch holds, and zero elsewhere."""
        holds = _hold(branch.joints, self._held)
        return jax.tree.map(lambda x: jnp.where(holds, x, 0.0), values)


def _outward(values: Any, branch: Branch) -> Any:
    if not any(branch.rows):
        return pick(values, slice(0, 1))  # the same for all
    return pick_rows(values, branch.rows)


def _hold(joints: Sequence[RigidJoint], held: Lanes) -> Lanes:
    """Return (k, n) whether each joint holds: by any of its attachments."""
    rows = []
    for joint in joints:
        first, *others = (held[i] for i in joint.attachments)
        for other in others:
            first = first | other
        rows.append(first)
    return jnp.stack(rows)


def _moved(wrench: Wrench, arm: Vector, root: int) -> Wrench:
    """Return a wrench about O, of (n,), about the origin of a root."""
    return shifted_wrench(wrench, vectors.negate(pick(arm, root)))


def pick_rows(lanes: Any, index: Sequence[int]) -> Any:
    """Return some rows of tuples of lanes (k, n); neighbours without a copy."""
    first, last = index[0], index[-1] + 1
    if list(index) == list(range(first, last)):
        return pick(lanes, slice(first, last))
    return pick(lanes, np.array(index))


def _kind(separation: Separation, joints: list[RigidJoint]) -> _Kind:
    """Return joints of one type, on an axis of lanes."""
    places = joint_places(separation)
    first = [joint.first for joint in joints]
    axes = [axis_on_A(separation.attachments[i].joint) for i in first]
    of_each = [places[i] for i in first]
    rows = [tuple(np.array(x).T[..., None]) for x in zip(*of_each, strict=True)]
    return _Kind(joints, tuple(np.array(axes).T[..., None]), JointPlace(*rows))
