"""The motion of B, in W and relative to A, and the momentum the springs give it."""

import math
from typing import NamedTuple

from pydrake.systems.framework import (
    BasicVector,
    Context,
    ContinuousState,
    LeafSystem,
)

from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.mated_stack import mated_places, place_in_A
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.model.separation import Pair, Separation
from drakesep.systems.vectors import Vector, scale


class Measured(NamedTuple):
    """What the motion analysis knows of the measured body B."""

    p_BoBcm_B: Vector
    """B's CG, m."""
    mated_p_AoBcm_A: Vector
    """Place of B's CG in A while mated, m."""
    mass: float
    """kg."""
    inertia: float
    """Mean of the principal moments, kg m^2."""

    @classmethod
    def of(cls, separation: Separation, pair: Pair) -> "Measured":
        """Return that of a pair of a separation."""
        B, places = separation.body(pair.B), mated_places(separation)
        return cls(
            B.p_BoBcm_B,
            place_in_A(places[pair.A], places[pair.B], B.p_BoBcm_B),
            B.mass,
            sum(B.I_BBcm_B[:3]) / 3.0,
        )


class MotionAnalysis(LeafSystem):
    """Measures the motion of B.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        plant_acceleration: (6 m,) rad/s^2 and m/s^2 in W: angular acceleration, then
            acceleration of the origin, of each of the m bodies.
        spring_wrenches: (6 m,) N m and N in W: torque about the origin, then force, of
            the springs on each of the m bodies.

    Output ports:
        rate: (3,) rad/s in B: angular velocity of B in W.
        relative_rate: (3,) rad/s in B: angular velocity of B in A.
        angle: (3,) rad: roll, pitch and yaw of B in W.
        relative_position: (3,) m in A: B's CG from its mated place.
        relative_velocity: (3,) m/s in A: velocity of B's CG as seen from A; along the
            direction of the pair it is the longitudinal speed.
        acceleration: (3,) m/s^2 in W: acceleration of B's CG in W.
        linear_momentum_change: (3,) N s in B: given to B by the springs (Eq. 6).
        angular_momentum_change: (3,) N m s in B: given to B by the springs about its CG
            (Eq. 7).

    Parameters:
        0: what is known of B, a row `Measured`.

    Continuous state:
        (6,) the momentum changes over mass and mean moment of inertia. Integrators
        weigh errors absolutely: in N s, of which there are hundreds, the momentum
        alone would dictate the step size.
    """

    def __init__(
        self, separation: Separation, layout: StateLayout, B: str | None = None
    ):
        """Prepare.

        Args:
            separation: in which B leaves.
            layout: where `plant_state` holds the motion of each body.
            B: name of the body; that of the first pair if None.
        """
        super().__init__()
        names = [body.name for body in separation.bodies]
        self._B = separation.B if B is None else B
        self._a = names.index(separation.pair_of(self._B).A)
        self._b = names.index(self._B)
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._acceleration = self.DeclareVectorInputPort(
            "plant_acceleration", 6 * len(names)
        )
        self._springs = self.DeclareVectorInputPort("spring_wrenches", 6 * len(names))
        self._measured = Rows(self, [self._measured_of(separation)])
        self.DeclareContinuousState(6)
        # Stated, so that a command or a thrust may depend on the motion, and not on the
        # acceleration, without an algebraic loop.
        self._measuring = {
            self._state.ticket(),
            self.all_parameters_ticket(),
        }
        for quantity in motion_laws.RelativeMotion._fields:
            self._declare_motion_port(quantity)
        self.DeclareVectorOutputPort(
            "acceleration",
            3,
            self._calc_acceleration,
            {*self._measuring, self._acceleration.ticket()},
        )
        self._declare_momentum_port("linear_momentum_change", 0)
        self._declare_momentum_port("angular_momentum_change", 1)

    def set_measured(self, context: Context, separation: Separation) -> None:
        """Write what is known of the measured body, and that none has pushed it yet."""
        context.SetContinuousState([0.0] * 6)
        self._measured.write(context, [self._measured_of(separation)])

    def _measured_of(self, separation: Separation) -> Measured:
        return Measured.of(separation, separation.pair_of(self._B))

    def _get_measured(self, context: Context) -> Measured:
        [measured] = self._measured.read(context)
        return measured

    def _eval_B(self, context: Context) -> BodyState:
        return self._layout.read_one(self._state.Eval(context).tolist(), self._b)

    def _eval_bodies(self, context: Context) -> tuple[BodyState, BodyState]:
        bodies = self._layout.read(self._state.Eval(context).tolist())
        return bodies[self._a], bodies[self._b]

    def _declare_motion_port(self, quantity: str) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            measured = self._get_measured(context)
            motion = motion_laws.relative_motion(
                *self._eval_bodies(context),
                measured.p_BoBcm_B,
                measured.mated_p_AoBcm_A,
                math,
            )
            output.SetFromVector(getattr(motion, quantity))

        self.DeclareVectorOutputPort(quantity, 3, calc, self._measuring)

    def _calc_acceleration(self, context: Context, output: BasicVector) -> None:
        B = self._eval_B(context)
        vdot = self._acceleration.Eval(context).tolist()
        v = 6 * self._b
        output.SetFromVector(
            motion_laws.cg_acceleration(
                B,
                self._get_measured(context).p_BoBcm_B,
                tuple(vdot[v : v + 3]),
                tuple(vdot[v + 3 : v + 6]),
            )
        )

    def _declare_momentum_port(self, quantity: str, index: int) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            measured = self._get_measured(context)
            z = context.get_continuous_state_vector().CopyToVector().tolist()
            weight = (measured.mass, measured.inertia)[index]
            output.SetFromVector(scale(weight, tuple(z[3 * index : 3 * index + 3])))

        tickets = {self.z_ticket(), self.all_parameters_ticket()}
        self.DeclareVectorOutputPort(quantity, 3, calc, tickets)

    def DoCalcTimeDerivatives(
        self, context: Context, derivatives: ContinuousState
    ) -> None:
        """Set the rates of the momentum given to B."""
        w = self._springs.Eval(context).tolist()[6 * self._b : 6 * self._b + 6]
        if not any(w):
            derivatives.get_mutable_vector().SetZero()
            return
        measured = self._get_measured(context)
        B = self._eval_B(context)
        linear, angular = motion_laws.momentum_rate(
            B, measured.p_BoBcm_B, Wrench(tuple(w[:3]), tuple(w[3:]))
        )
        derivatives.get_mutable_vector().SetFromVector(
            [
                *scale(1.0 / measured.mass, linear),
                *scale(1.0 / measured.inertia, angular),
            ]
        )
