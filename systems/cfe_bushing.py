"""The attachments' joints by constraint forces (CFE)."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from drakesep.systems import joint_laws, motion_laws
from drakesep.systems.geometry import axis_on_B, mated_orientation, pad_on_B
from drakesep.systems.joint_laws import Turn
from drakesep.systems.joints import JointType
from drakesep.systems.model import Separation
from drakesep.systems.motion_laws import BodyState, PairState
from drakesep.systems.state_layout import StateLayout
from drakesep.systems.vectors import (
    Quaternion,
    Rotation,
    Vector,
    add,
    cross,
    rotate,
    unrotate,
)
from drakesep.systems.wrenches import WrenchSum


_FIELDS = 21
"""Of a joint's parameters: see `CfeBushing`."""
_ZERO = (0.0, 0.0, 0.0)
_NO_TURN = Turn(_ZERO, 0.0, _ZERO)
_A_AXES = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class _Joint(NamedTuple):
    """What is fixed of a joint when the system is built."""

    attachment: int
    """Its index."""
    type: JointType
    holds_all_rotations: bool
    R_AJ: Rotation | None
    """Orientation of its frame J in A; None if it is that of A."""

    def in_J(self, v_A: Vector) -> Vector:
        return v_A if self.R_AJ is None else unrotate(self.R_AJ, v_A)

    def in_A(self, v_J: Vector) -> Vector:
        return v_J if self.R_AJ is None else rotate(self.R_AJ, v_J)


class _Pull(NamedTuple):
    """What a joint does to B, in its frame J, and the energy that it holds."""

    force: Vector
    torque: Vector
    """About B's pad, but for `moment`, N m."""
    moment: Vector
    """Of a joint that holds all rotations, conjugate to `Turn.theta`; else zero."""
    energy: float


class _HeldJoint(NamedTuple):
    """A joint that holds, and its parameters."""

    joint: _Joint
    K_F: Vector
    D_F: Vector
    K_T: Vector
    D_T: Vector
    p_AoPad_A: Vector
    p_BoPad_B: Vector
    axis_B: Vector


class _Held(NamedTuple):
    """The joints that hold a pair of bodies."""

    a: int
    b: int
    q_AB: Quaternion
    turns: bool
    """Whether one of them holds all rotations."""
    joints: list[_HeldJoint]


class _HeldPair(NamedTuple):
    """Two bodies that joints still hold."""

    a: int
    b: int
    A: BodyState
    motion: PairState
    turn: Turn
    held: list[tuple[_Joint, Vector, _Pull]]
    """The joints, each with its pad from B's origin, in A, and what it does."""


class CfeBushing(LeafSystem):
    """Holds B to A at each attachment that is not released, Eq. 1-4.

    Each joint holds the directions of its type, in its frame fixed in A. Its forces and
    torques have a potential, whatever the gains. No type has a singularity below 180
    deg of rotation, but for the universal one, which locks when its axes fall together.

    Input ports:
        plant_state: state of the plant.
        released: (n,) time of each attachment's release, s; infinite while held.

    Output ports:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.
        loads: (6 n,) torque, N m, and force, N, of each joint on B at its pad, in the
            joint's frame; zero after release.
        energy: (1,) elastic energy of the joints that hold, J.

    Parameters:
        0: (21 n,) for each attachment its gains K_F, D_F, K_T, D_T along x, y and z of
            the joint's frame, zero where it is free; its place in A and in B; and the
            joint's x axis, or y of a universal one, fixed in B.
        1: (4 p,) for each pair of attached bodies the mated orientation q_AB.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        self._count = len(separation.bodies)
        self._size = len(separation.attachments)
        self._pairs = _pairs(separation)
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort("released", self._size)
        self._joints = self.DeclareNumericParameter(BasicVector(_FIELDS * self._size))
        self._mated = self.DeclareNumericParameter(BasicVector(4 * len(self._pairs)))
        # Parameters are read once, until an attachment lets go: a quarter of the cost.
        self._held = self.DeclareCacheEntry(
            "held joints",
            ValueProducer(allocate=lambda: Value[object](), calc=self._calc_held),
            {self._released.ticket(), self.all_parameters_ticket()},
        )
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)
        self.DeclareVectorOutputPort("loads", 6 * self._size, self._calc_loads)
        self.DeclareVectorOutputPort("energy", 1, self._calc_energy)

    def set_joints(self, context: Context, separation: Separation) -> None:
        """Write the joints of a separation into this system's Context."""
        rows: list[float] = []
        for attachment in separation.attachments:
            joint = attachment.joint
            axis_A = joint.y_axis_A if joint.type == "universal" else joint.x_axis_A
            rows += joint.held_gains()
            rows += [*attachment.p_AoPad_A, *pad_on_B(separation, attachment)]
            rows += axis_on_B(separation, attachment, axis_A)
        context.get_mutable_numeric_parameter(self._joints).SetFromVector(rows)
        bodies = separation.bodies
        orientations: list[float] = []
        for a, b in self._pairs:
            orientations += mated_orientation(bodies[a], bodies[b])
        context.get_mutable_numeric_parameter(self._mated).SetFromVector(orientations)

    def _calc_held(self, context: Context, output: AbstractValue) -> None:
        released = self._released.Eval(context).tolist()
        rows = context.get_numeric_parameter(self._joints).value().tolist()
        mated = context.get_numeric_parameter(self._mated).value().tolist()
        pairs = []
        for i, ((a, b), joints) in enumerate(self._pairs.items()):
            held = []
            for joint in joints:
                if math.isinf(released[joint.attachment]):
                    start = _FIELDS * joint.attachment
                    row = rows[start : start + _FIELDS]
                    vectors = (tuple(row[k : k + 3]) for k in range(0, _FIELDS, 3))
                    held.append(_HeldJoint(joint, *vectors))
            if held:
                turns = any(each.joint.holds_all_rotations for each in held)
                q_AB = tuple(mated[4 * i : 4 * i + 4])
                pairs.append(_Held(a, b, q_AB, turns, held))
        output.set_value(pairs)

    def _held_pairs(self, context: Context) -> Iterator[_HeldPair]:
        pairs = self._held.Eval(context)
        if not pairs:
            return
        bodies = self._layout.read(self._state.Eval(context).tolist())
        for a, b, q_AB, turns, joints in pairs:
            A, B = bodies[a], bodies[b]
            motion = motion_laws.pair_state(A, B)
            turn = _NO_TURN
            if turns:
                turn = joint_laws.rotation_deviation(A, B, q_AB, motion.w_AB, math)
            held = [(joint[0], *_pull(joint, motion, turn)) for joint in joints]
            yield _HeldPair(a, b, A, motion, turn, held)

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        for pair in self._held_pairs(context):
            force, torque, moment = _ZERO, _ZERO, _ZERO
            for joint, r_A, pull in pair.held:
                force_A = joint.in_A(pull.force)
                force = add(force, force_A)
                torque = add(torque, cross(r_A, force_A))
                torque = add(torque, joint.in_A(pull.torque))
                moment = add(moment, joint.in_A(pull.moment))
            torque = add(torque, joint_laws.turning_torque(pair.turn, moment))
            on_A, on_B = motion_laws.wrenches_at_origin(
                pair.A, pair.motion.p_AoBo, force, torque
            )
            total.add(pair.a, on_A)
            total.add(pair.b, on_B)
        total.write(output)

    def _calc_loads(self, context: Context, output: BasicVector) -> None:
        loads = [0.0] * (6 * self._size)
        for pair in self._held_pairs(context):
            for joint, _, pull in pair.held:
                moment_A = joint_laws.turning_torque(pair.turn, joint.in_A(pull.moment))
                torque = add(pull.torque, joint.in_J(moment_A))
                start = 6 * joint.attachment
                loads[start : start + 6] = [*torque, *pull.force]
        output.SetFromVector(loads)

    def _calc_energy(self, context: Context, output: BasicVector) -> None:
        energy = 0.0
        for pair in self._held_pairs(context):
            energy += sum(pull.energy for *_, pull in pair.held)
        output.SetFromVector([energy])


def _pairs(separation: Separation) -> dict[tuple[int, int], list[_Joint]]:
    """Return the joints between each pair of bodies, by the bodies' indices."""
    pairs: dict[tuple[int, int], list[_Joint]] = {}
    for i, attachment in enumerate(separation.attachments):
        joint = attachment.joint
        R_AJ = None if joint.R_AJ == _A_AXES else joint.R_AJ
        ends = separation.ends(attachment)
        turns = all(joint.constraints.rotation)
        pairs.setdefault(ends, []).append(_Joint(i, joint.type, turns, R_AJ))
    return pairs


def _pull(held: _HeldJoint, motion: PairState, turn: Turn) -> tuple[Vector, _Pull]:
    """Return B's pad from B's origin, in A, m, and what the joint does."""
    joint, K_F, D_F, K_T, D_T, p_AoPad_A, p_BoPad_B, axis_B = held
    (dx_A, v_A), r_A = joint_laws.translation_deviation(motion, p_AoPad_A, p_BoPad_B)
    force, energy = joint_laws.constraint_force(
        joint.in_J(dx_A), joint.in_J(v_A), K_F, D_F
    )
    torque = moment = _ZERO
    if joint.holds_all_rotations:
        moment, elastic = joint_laws.constraint_force(
            joint.in_J(turn.theta), joint.in_J(turn.rate), K_T, D_T
        )
        energy += elastic
    elif joint.type != "spherical":
        universal = joint.type == "universal"
        law = joint_laws.universal_torque if universal else joint_laws.swing_torque
        axis_J, w_J = joint.in_J(rotate(motion.R_AB, axis_B)), joint.in_J(motion.w_AB)
        torque, elastic = law(axis_J, w_J, K_T, D_T, math)
        energy += elastic
    return r_A, _Pull(force, torque, moment, energy)
