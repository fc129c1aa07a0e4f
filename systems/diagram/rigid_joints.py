"""The rigid joints as a Drake system."""

import math
from typing import NamedTuple

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
)

from drakesep.systems.checks import InputError
from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import BodyStates, StateLayout
from drakesep.systems.diagram.wrenches import WrenchSum
from drakesep.systems.equations import rigid_joints as rigid_joint_laws
from drakesep.systems.equations.articulated_inertia import Massive
from drakesep.systems.equations.holding_joints import HoldingJoints, joints_that_hold
from drakesep.systems.equations.load_sharing import joint_shares
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.rigid_joints import (
    gap_of,
    joint_places,
    rigid_joints,
)
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation


_APART = 1e-3
"""How far bodies may be from where a joint holds them at the start, m and rad: it would
bring them there as slowly as they turn."""


class _Holds(NamedTuple):
    """The rigid joints that hold."""

    joints: rigid_joint_laws.RigidJoints
    holding: HoldingJoints

    def solve(
        self, bodies: BodyStates, others: WrenchSum
    ) -> tuple[dict[int, BodyState], dict[int, tuple[Wrench, Wrench]]]:
        """Return the bodies that they hold, and the wrenches on A and B of each edge.

        Args:
            bodies: of the separation.
            others: all else that acts on them.
        """
        places = [(body, self.joints.bodies[body]) for body in self.holding.bodies]
        held = {body: bodies[i] for body, i in places}
        wrenches = {body: others.wrenches[i] for body, i in places}
        return held, self.holding.wrenches(held, wrenches)

    def __call__(self, bodies: BodyStates, t: float, total: WrenchSum) -> None:
        _, edges = self.solve(bodies, total)
        for edge, on_ends in edges.items():
            for body, wrench in zip(self.joints.edges[edge], on_ends, strict=True):
                total.add(self.joints.bodies[body], wrench)


class RigidJoints(LeafSystem):
    """Holds B to A exactly where joints are rigid, until their release.

    The wrenches that Eq. 1 and 2 need follow from all else that acts on the bodies. So
    this system takes it from where it is computed, which knows no accelerations: there
    is no algebraic loop.

    Where bodies are at the start the joints must hold them.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        released: (n,) s: time of each attachment's release; infinite while it holds.
        other_wrenches: (6 m,) N m and N in W: torque about the origin, then force, on
            each of the m bodies: of all else that acts on them.

    Output ports:
        acting: abstract: what acts until an event changes it, for a `ForceSum`, after
            all else.
        loads: (6 n,) N m and N in the joints' frames: torque and force of each joint on
            B at its pad; zero after release, and where it is not rigid.

    Parameters:
        0: for each attachment the `JointPlace` of its joint.
        1: for each joined body its `Massive`.
        2: for each two bodies that are joined the `Scale` of their equations.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        """Prepare.

        Args:
            separation: some of whose joints are rigid.
            layout: where `plant_state` holds the motion of each body.
        """
        super().__init__()
        self._joints = rigid_joints(separation)
        self._names = [attachment.name for attachment in separation.attachments]
        self._layout = layout
        size, count = 6 * len(separation.bodies), len(separation.attachments)
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort("released", count)
        self._others = self.DeclareVectorInputPort("other_wrenches", size)
        self._places = Rows(self, joint_places(separation))
        self._masses = Rows(self, self._mass_rows(separation))
        self._scales = Rows(self, self._joints.scales)

        self._acting = self.DeclareAbstractOutputPort(
            "acting",
            lambda: Value[object](),
            self._calc_acting,
            {self._released.ticket(), self.all_parameters_ticket()},
        )
        self.DeclareInitializationPublishEvent(self._check_start)
        self.DeclareVectorOutputPort("loads", 6 * count, self._calc_loads)

    def set_joints(self, context: Context, separation: Separation) -> None:
        """Write the joints and bodies of a separation into this system's Context."""
        self._places.write(context, joint_places(separation))
        self._masses.write(context, self._mass_rows(separation))
        self._scales.write(context, rigid_joints(separation).scales)

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        bodies = [separation.bodies[i] for i in self._joints.bodies]
        return {
            *names_of(separation.attachments, ["p_AoPad_A"]),
            *names_of(bodies, Massive._fields),
        }

    def _mass_rows(self, separation: Separation) -> list[Massive]:
        bodies = [separation.bodies[i] for i in self._joints.bodies]
        return [Massive(b.mass, b.p_BoBcm_B, tuple(b.I_BBcm_B)) for b in bodies]

    def _calc_acting(self, context: Context, output: AbstractValue) -> None:
        held = joints_that_hold(
            self._joints, self._places.read(context), self._held(context)
        )
        if not held:
            output.set_value([])
            return
        joints = self._joints._replace(scales=self._scales.read(context))
        holding = HoldingJoints(joints, self._masses.read(context), held)
        output.set_value([_Holds(joints, holding)])

    def _held(self, context: Context) -> frozenset[int]:
        """Return which attachments hold."""
        released = self._released.Eval(context).tolist()
        return frozenset(i for i, t in enumerate(released) if math.isinf(t))

    def _check_start(self, context: Context) -> EventStatus:
        x, places = self._state.Eval(context).tolist(), self._places.read(context)
        held = self._held(context)
        for joint in self._joints.joints:
            ends = (self._joints.bodies[end] for end in (joint.a, joint.b))
            A, B = (self._layout.read_one(x, body) for body in ends)
            for i in sorted(held.intersection(joint.attachments)):
                moved, turned = gap_of(joint.type, places[i], A, B)
                if not max(moved, turned) <= _APART:
                    raise InputError(
                        f"{self._names[i]}: its bodies must be where the rigid joint "
                        f"holds them, got them {moved:.3g} m and "
                        f"{math.degrees(math.asin(min(turned, 1.0))):.3g} deg away"
                    )
        return EventStatus.DidNothing()

    def _calc_loads(self, context: Context, output: BasicVector) -> None:
        loads = [0.0] * output.size()
        for holds in self._acting.Eval(context):
            bodies = self._layout.bodies(self._state.Eval(context).tolist())
            others = WrenchSum(len(self._layout.starts))
            others.add_entries(self._others.Eval(context).tolist())
            held, edges = holds.solve(bodies, others)
            shares = joint_shares(
                self._joints,
                self._places.read(context),
                self._held(context),
                held,
                edges,
            )
            for i, (torque, force) in shares.items():
                loads[6 * i : 6 * i + 6] = [*torque, *force]
        output.SetFromVector(loads)
