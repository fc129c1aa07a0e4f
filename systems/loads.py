"""Thrusters, retro-rockets and disturbances: forces and torques over time."""

from bisect import bisect_right

from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    LeafSystem,
    WitnessFunction,
    WitnessFunctionDirection,
)

from drakesep.systems import motion_laws
from drakesep.systems.checks import Vector3
from drakesep.systems.load_tables import Load
from drakesep.systems.model import Separation
from drakesep.systems.state_layout import StateLayout
from drakesep.systems.vectors import Vector, add, scale
from drakesep.systems.wrenches import WrenchSum


_FIELDS = 5
"""Of a load's parameters: see `Loads`."""
_ROUND_OFF = 1e-12
"""Of times that add up to an edge, s."""


class Loads(LeafSystem):
    """Acts on bodies with the forces and torques of tables over time.

    Whether a load acts is latched at the start of every step, and a witness function
    ends a step where it sets in or ceases: no step straddles a jump, and no pulse is
    stepped over. The Context of the whole diagram needs an accuracy.

    Input ports:
        plant_state: state of the plant.
        released: (n,) time of each attachment's release, s; infinite while held.

    Output port:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.

    Discrete state:
        (k,) how many edges of its table each load has passed; see `Load.edges`.

    Parameters:
        0: (5 k,) for each load where it acts in its body, m, its start, s, and the
            factor on its table.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        self._count = len(separation.bodies)
        bodies = [body.name for body in separation.bodies]
        attachments = [attachment.name for attachment in separation.attachments]
        self._loads = separation.loads
        self._bodies = [bodies.index(load.body) for load in self._loads]
        self._after = [
            None if load.after is None else attachments.index(load.after)
            for load in self._loads
        ]
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort("released", len(attachments))
        self._places = self.DeclareNumericParameter(
            BasicVector(_FIELDS * len(self._loads))
        )
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)
        self._passed = self.DeclareDiscreteState(len(self._loads))
        self.DeclareInitializationDiscreteUpdateEvent(self._pass_edges)
        self.DeclarePerStepDiscreteUpdateEvent(self._pass_edges)
        self._witness = self.MakeWitnessFunction(
            "edge of a load",
            WitnessFunctionDirection.kNegativeThenNonNegative,
            lambda context: 1.0 if self._is_past_an_edge(context) else -1.0,
        )

    def set_loads(self, context: Context, separation: Separation) -> None:
        """Write where, when and how strongly loads act into this system's Context."""
        rows: list[float] = []
        for load in separation.loads:
            rows += [*load.p_BoQ_B, load.start, load.factor]
        context.get_mutable_numeric_parameter(self._places).SetFromVector(rows)

    def _row(self, context: Context, k: int) -> list[float]:
        p = context.get_numeric_parameter(self._places).value().tolist()
        return p[_FIELDS * k : _FIELDS * (k + 1)]

    def _elapsed(self, context: Context, k: int) -> float:
        """Return the time in the load's table, s; negative before it begins."""
        t = context.get_time() - self._row(context, k)[3]
        after = self._after[k]
        return t if after is None else t - self._released.Eval(context)[after]

    def _count_passed(self, context: Context, k: int) -> int:
        return bisect_right(
            self._loads[k].edges, self._elapsed(context, k) + _ROUND_OFF
        )

    def _pass_edges(self, context: Context, update: DiscreteValues) -> EventStatus:
        passed = [self._count_passed(context, k) for k in range(len(self._loads))]
        if passed == context.get_discrete_state(self._passed).value().tolist():
            return EventStatus.DidNothing()  # spares a new evaluation of the forces
        update.set_value(self._passed, passed)
        return EventStatus.Succeeded()

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        passed = context.get_discrete_state(self._passed).value().tolist()
        for k, load in enumerate(self._loads):
            count = int(passed[k])
            if count % 2:  # the edges are by turns those where it sets in and ceases
                x, y, z, _, factor = self._row(context, k)
                first, last = load.edges[count - 1], load.edges[count]
                t = min(max(first, self._elapsed(context, k)), last)
                b = self._bodies[k]
                body = self._layout.read_one(self._state.Eval(context).tolist(), b)
                force, torque = _interpolate(load, t, factor)
                in_body = load.axes == "body"
                total.add(
                    b, motion_laws.load_wrench(body, (x, y, z), force, torque, in_body)
                )
        total.write(output)

    def _is_past_an_edge(self, context: Context) -> bool:
        # Just after the edge: see `Release`.
        passed = context.get_discrete_state(self._passed).value().tolist()
        return any(
            int(count) < len(load.edges)
            and self._elapsed(context, k) > load.edges[int(count)] + _ROUND_OFF
            for k, (load, count) in enumerate(zip(self._loads, passed, strict=True))
        )

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return one for all: Drake does not ask again after every step."""
        return [self._witness]


def _interpolate(load: Load, t: float, factor: float) -> tuple[Vector, Vector]:
    i = min(bisect_right(load.times, t), len(load.times) - 1) - 1
    s = (t - load.times[i]) / (load.times[i + 1] - load.times[i])
    before, after = (1.0 - s) * factor, s * factor

    def between(rows: tuple[Vector3, ...]) -> Vector:
        return add(scale(before, rows[i]), scale(after, rows[i + 1]))

    return between(load.forces), between(load.torques)
