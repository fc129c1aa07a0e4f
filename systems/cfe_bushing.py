"""The attachments' joints by constraint forces (CFE)."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from drakesep.systems import laws
from drakesep.systems.geometry import mated_orientation, pad_on_B
from drakesep.systems.laws import BodyState, JointDeviation
from drakesep.systems.model import Separation
from drakesep.systems.state_layout import StateLayout
from drakesep.systems.vectors import Quaternion, Vector
from drakesep.systems.wrenches import WrenchSum


_FIELDS = 14
"""Of a joint's parameters: the gains, the pads on A and B, the mated orientation."""


class _Joint(NamedTuple):
    """A joint's parameters, and the indices of its bodies."""

    a: int
    b: int
    gains: Sequence[float]
    p_AoPad_A: Vector
    p_BoPad_B: Vector
    q_AB: Quaternion

    def deviation(self, A: BodyState, B: BodyState) -> tuple[JointDeviation, Vector]:
        return laws.joint_deviation(
            A, B, self.p_AoPad_A, self.p_BoPad_B, self.q_AB, math
        )


class CfeBushing(LeafSystem):
    """Holds B to A at each attachment that is not released, Eq. 1-4.

    All six directions are held. The stiffness and damping are isotropic in
    translation and in rotation, in the frame of A, so that the elastic energy is
    exact; the rotation vector has no singularity below 180 deg.

    Input ports:
        plant_state: state of the plant.
        released: (n,) time of each attachment's release, s; infinite while held.

    Output ports:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.
        energy: (1,) elastic energy of the joints that hold, J.

    Parameters:
        0: (14 n,) for each attachment K_F, D_F, K_T, D_T, its place in A and in B,
            and the orientation quaternion of B in A while mated.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        self._count = len(separation.bodies)
        index = {body.name: i for i, body in enumerate(separation.bodies)}
        self._ends = [(index[a.A], index[a.B]) for a in separation.attachments]
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort("released", len(self._ends))
        self._joints = self.DeclareNumericParameter(
            BasicVector(_FIELDS * len(self._ends))
        )
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)
        self.DeclareVectorOutputPort("energy", 1, self._calc_energy)

    def set_joints(self, context: Context, separation: Separation) -> None:
        """Write the joints of a separation into this system's Context."""
        rows: list[float] = []
        for attachment in separation.attachments:
            joint = attachment.joint
            rows += [joint.K_F, joint.D_F, joint.K_T, joint.D_T]
            rows += [*attachment.p_AoPad_A, *pad_on_B(separation, attachment)]
            rows += mated_orientation(separation, attachment)
        context.get_mutable_numeric_parameter(self._joints).SetFromVector(rows)

    def _held(self, context: Context) -> Iterator[tuple[_Joint, list[BodyState]]]:
        released = self._released.Eval(context).tolist()
        held = [j for j, time in enumerate(released) if math.isinf(time)]
        if held:
            bodies = self._layout.read(self._state.Eval(context).tolist())
            rows = context.get_numeric_parameter(self._joints).value().tolist()
            for j in held:
                row = rows[_FIELDS * j : _FIELDS * (j + 1)]
                yield (
                    _Joint(*self._ends[j], row[:4], row[4:7], row[7:10], row[10:14]),
                    bodies,
                )

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        for joint, bodies in self._held(context):
            A, B = bodies[joint.a], bodies[joint.b]
            deviation, p_WPad = joint.deviation(A, B)
            on_A, on_B = laws.joint_wrenches(A, B, deviation, p_WPad, joint.gains)
            total.add(joint.a, on_A)
            total.add(joint.b, on_B)
        total.write(output)

    def _calc_energy(self, context: Context, output: BasicVector) -> None:
        energy = 0.0
        for joint, bodies in self._held(context):
            deviation, _ = joint.deviation(bodies[joint.a], bodies[joint.b])
            K_F, _, K_T, _ = joint.gains
            energy += laws.joint_energy(deviation, K_F, K_T)
        output.SetFromVector([energy])
