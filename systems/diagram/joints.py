"""The attachments' joints by constraint forces (CFE)."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import BodyStates, StateLayout
from drakesep.systems.diagram.wrenches import Forces, WrenchSum
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.joints import NO_TURN, HeldJoint, Pull, Turn
from drakesep.systems.equations.mated_stack import (
    held_joint,
    mated_orientation,
    mated_places,
)
from drakesep.systems.equations.relative_motion import BodyState, PairState, Wrench
from drakesep.systems.equations.straight_line import LINE_OPS, straight_line
from drakesep.systems.model.joints import JointType, holds_all_rotations
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Ops, Quaternion, Rotation, Vector, add


_ZERO = (0.0, 0.0, 0.0)


class JointRow(NamedTuple):
    """A joint in a Context."""

    K_F: Vector
    """Gains along x, y and z of the joint's frame, zero where it is free."""
    D_F: Vector
    K_T: Vector
    D_T: Vector
    p_AoPad_A: Vector
    """Its place in A, m."""
    p_BoPad_B: Vector
    """Its place in B, m."""
    axis_B: Vector
    """Its x axis, or y of a universal one, fixed in B."""


class MatedRow(NamedTuple):
    """A pair of attached bodies in a Context."""

    q_AB: Quaternion
    """Orientation of B in A while mated."""


class _Joint(NamedTuple):
    """What is fixed of a joint when the system is built."""

    attachment: int
    """Its index."""
    type: JointType
    R_AJ: Rotation | None
    """Orientation of its frame J in A; None if it is that of A."""


class _Pulled(NamedTuple):
    """What joints do to two bodies."""

    motion: PairState
    turn: Turn
    pulls: list[tuple[Vector, Pull]]
    """Of each joint its pad from B's origin, in A, and what it does."""


_Kinds: TypeAlias = tuple[tuple[JointType, bool], ...]
"""Of joints: the type, and whether their frames are A's."""


class _Held(NamedTuple):
    """The joints that hold a pair of bodies."""

    a: int
    b: int
    q_AB: Quaternion
    attachments: list[int]
    """Index of each joint's attachment."""
    joints: list[HeldJoint]
    numbers: tuple[Any, ...]
    """Of each joint all but its type."""
    line: Callable[..., tuple[Wrench, Wrench]]

    @classmethod
    def of(
        cls, a: int, b: int, q_AB: Quaternion, held: list[tuple[int, HeldJoint]]
    ) -> "_Held":
        """Return them together."""
        attachments, joints = map(list, zip(*held, strict=True))
        kinds = tuple((joint.type, joint.R_AJ is None) for joint in joints)
        numbers = tuple(joint[1:] for joint in joints)
        line = straight_line(_wrenches, LINE_OPS, kinds)
        return cls(a, b, q_AB, attachments, joints, numbers, line)

    def pulled(self, bodies: BodyStates) -> _Pulled:
        """Return what they do."""
        return _pulled(math, self.joints, bodies[self.a], bodies[self.b], self.q_AB)

    def __call__(self, bodies: BodyStates, t: float, total: WrenchSum) -> None:
        A, B = bodies[self.a], bodies[self.b]
        on_A, on_B = self.line(A, B, self.q_AB, self.numbers)
        total.add(self.a, on_A)
        total.add(self.b, on_B)


def _pulled(
    ops: Ops,
    joints: Sequence[HeldJoint],
    A: BodyState,
    B: BodyState,
    q_AB: Quaternion,
) -> _Pulled:
    motion = motion_laws.pair_state(A, B)
    turn = NO_TURN
    if any(holds_all_rotations(joint.type) for joint in joints):
        turn = joint_laws.rotation_deviation(A, B, q_AB, motion.w_AB, ops)
    pulls = [joint_laws.joint_pull(joint, motion, turn, ops) for joint in joints]
    return _Pulled(motion, turn, pulls)


def _wrenches(
    ops: Ops,
    kinds: _Kinds,
    A: BodyState,
    B: BodyState,
    q_AB: Quaternion,
    numbers: Sequence[Any],
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on two bodies of the joints between them."""
    joints = [
        HeldJoint(type, *each) for (type, _), each in zip(kinds, numbers, strict=True)
    ]
    motion, turn, pulls = _pulled(ops, joints, A, B, q_AB)
    force, torque, moment = _ZERO, _ZERO, _ZERO
    for joint, (r_A, pull) in zip(joints, pulls, strict=True):
        each = joint_laws.pull_at_origin(joint, r_A, pull)
        force, torque, moment = map(add, (force, torque, moment), each)
    torque = add(torque, joint_laws.turning_torque(turn, moment))
    return motion_laws.wrenches_at_origin(A, motion.p_AoBo, force, torque)


class CfeBushing(LeafSystem):
    """Holds B to A at each attachment that is not released, Eq. 1-4.

    Each joint holds the directions of its type, in its frame fixed in A. Its forces and
    torques have a potential, whatever the gains. No type has a singularity below 180
    deg of rotation, but for the universal one, which locks when its axes fall together.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        released: (n,) s: time of each attachment's release; infinite while it holds.

    Output ports:
        acting: abstract: what acts until an event changes it, for a `ForceSum`.
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.
        loads: (6 n,) N m and N in the joints' frames: torque and force of each joint on
            B at its pad; zero after release.
        energy: (1,) J: elastic energy of the joints that hold.

    Parameters:
        0: for each attachment a `JointRow`.
        1: for each pair of attached bodies a `MatedRow`.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        self._size = len(separation.attachments)
        self._pairs = _pairs(separation)
        state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort("released", self._size)
        self._joints = Rows(self, _joint_rows(separation))
        self._mated = Rows(self, self._mated_rows(separation))
        self._forces = Forces(
            self,
            state,
            layout,
            self._find_held,
            {self._released.ticket(), self.all_parameters_ticket()},
        )
        self.DeclareVectorOutputPort("loads", 6 * self._size, self._calc_loads)
        self.DeclareVectorOutputPort("energy", 1, self._calc_energy)

    def set_joints(self, context: Context, separation: Separation) -> None:
        """Write the joints of a separation into this system's Context."""
        self._joints.write(context, _joint_rows(separation))
        self._mated.write(context, self._mated_rows(separation))

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        return {*names_of(separation.attachments, JointRow._fields)}

    def _mated_rows(self, separation: Separation) -> list[MatedRow]:
        places = [*mated_places(separation).values()]
        return [
            MatedRow(mated_orientation(places[a], places[b])) for a, b in self._pairs
        ]

    def _find_held(self, context: Context) -> list[_Held]:
        released = self._released.Eval(context).tolist()
        rows, mated = self._joints.read(context), self._mated.read(context)
        pairs = []
        for ((a, b), joints), (q_AB,) in zip(self._pairs.items(), mated, strict=True):
            held = []
            for joint in joints:
                if math.isinf(released[joint.attachment]):
                    row = rows[joint.attachment]._asdict()
                    each = HeldJoint(type=joint.type, R_AJ=joint.R_AJ, **row)
                    held.append((joint.attachment, each))
            if held:
                pairs.append(_Held.of(a, b, q_AB, held))
        return pairs

    def _pulled(self, context: Context) -> Iterator[tuple[_Held, _Pulled]]:
        bodies = self._forces.read_bodies(context)
        return ((pair, pair.pulled(bodies)) for pair in self._forces.eval(context))

    def _calc_loads(self, context: Context, output: BasicVector) -> None:
        loads = [0.0] * (6 * self._size)
        for held, (_, turn, pulls) in self._pulled(context):
            for i, joint, (_, pull) in zip(
                held.attachments, held.joints, pulls, strict=True
            ):
                torque, force = joint_laws.joint_load(joint, turn, pull)
                loads[6 * i : 6 * i + 6] = [*torque, *force]
        output.SetFromVector(loads)

    def _calc_energy(self, context: Context, output: BasicVector) -> None:
        energy = 0.0
        for _, pulled in self._pulled(context):
            energy += sum(pull.energy for _, pull in pulled.pulls)
        output.SetFromVector([energy])


def _joint_rows(separation: Separation) -> list[JointRow]:
    joints = [held_joint(separation, each) for each in separation.attachments]
    return [
        JointRow(*(getattr(joint, name) for name in JointRow._fields))
        for joint in joints
    ]


def _pairs(separation: Separation) -> dict[tuple[int, int], list[_Joint]]:
    """Return the joints between each pair of bodies, by the bodies' indices."""
    pairs: dict[tuple[int, int], list[_Joint]] = {}
    for i, attachment in enumerate(separation.attachments):
        joint = attachment.joint
        if joint.rigid:
            continue
        ends = separation.ends(attachment)
        pairs.setdefault(ends, []).append(_Joint(i, joint.type, joint.R_AJ_if_turned))
    return pairs
