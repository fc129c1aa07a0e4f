"""Thrusters, retro-rockets and disturbances: forces and torques over time."""

import math
from bisect import bisect_right

from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    WitnessFunction,
    WitnessFunctionDirection,
)

from drakesep.systems import laws
from drakesep.systems.checks import Vector3
from drakesep.systems.load_tables import Load
from drakesep.systems.model import Separation
from drakesep.systems.state_layout import StateLayout
from drakesep.systems.vectors import Vector, add, scale
from drakesep.systems.wrenches import WrenchSum


_FIELDS = 5
"""Of a load's parameters: see `Loads`."""


class Loads(LeafSystem):
    """Acts on bodies with the forces and torques of tables over time.

    Witness functions end a step where a load sets in or ceases, so that no pulse is
    stepped over; the Context of the whole diagram needs an accuracy.

    Input ports:
        plant_state: state of the plant.
        released: (n,) time of each attachment's release, s; infinite while held.

    Output port:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.

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
        self._witnesses = [
            [self._make_witness(k, edge) for edge in load.edges]
            for k, load in enumerate(self._loads)
        ]

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

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        for k, load in enumerate(self._loads):
            t = self._elapsed(context, k)
            if load.times[0] <= t < load.times[-1]:
                x, y, z, _, factor = self._row(context, k)
                b = self._bodies[k]
                body = self._layout.read_one(self._state.Eval(context).tolist(), b)
                force, torque = _interpolate(load, t, factor)
                in_body = load.axes == "body"
                total.add(b, laws.load_wrench(body, (x, y, z), force, torque, in_body))
        total.write(output)

    def _make_witness(self, k: int, edge: float) -> WitnessFunction:
        # The sign changes just after the edge: see `Release`.
        return self.MakeWitnessFunction(
            f"{self._loads[k].name} at {edge:g} s",
            WitnessFunctionDirection.kNegativeThenNonNegative,
            lambda context: 1.0 if self._elapsed(context, k) > edge else -1.0,
        )

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return the witness of the next edge of each load."""
        witnesses = []
        for k, load in enumerate(self._loads):
            t = self._elapsed(context, k)
            following = bisect_right(load.edges, t)
            if math.isfinite(t) and following < len(load.edges):
                witnesses.append(self._witnesses[k][following])
        return witnesses


def _interpolate(load: Load, t: float, factor: float) -> tuple[Vector, Vector]:
    i = bisect_right(load.times, t) - 1
    s = (t - load.times[i]) / (load.times[i + 1] - load.times[i])
    before, after = (1.0 - s) * factor, s * factor

    def between(rows: tuple[Vector3, ...]) -> Vector:
        return add(scale(before, rows[i]), scale(after, rows[i + 1]))

    return between(load.forces), between(load.torques)
