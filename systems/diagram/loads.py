"""Thrusters, retro-rockets and disturbances: forces and torques over time."""

from bisect import bisect_right
from typing import NamedTuple

from pydrake.systems.framework import BasicVector, Context

from drakesep.systems.diagram.event_latch import LatchingSystem
from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.diagram.wrenches import WrenchSum
from drakesep.systems.equations import loads as load_laws
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


_ROUND_OFF = 1e-12
"""Of times that add up to an edge, s."""


class LoadRow(NamedTuple):
    """A load in a Context."""

    p_BoQ_B: Vector
    """Where it acts in its body, m."""
    start: float
    """s."""
    factor: float
    """On its table."""


class Loads(LatchingSystem):
    """Acts on bodies with the forces and torques of tables over time.

    Where in its table a load stands is latched, see `LatchingSystem`: no step straddles
    a row of a table at which its load acts, and no pulse is stepped over.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        released: (n,) s: time of each attachment's release; infinite while it holds.

    Output ports:
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.

    Discrete state:
        (k,) how many rows of its table each load has passed; and the step's start.

    Parameters:
        0: for each load a `LoadRow`.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__([0.0] * len(separation.loads))
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
        self._rows = Rows(self, _rows_of(separation))
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)

    def set_loads(self, context: Context, separation: Separation) -> None:
        """Write where, when and how strongly loads act, and that none has begun."""
        self._reset(context)
        self._rows.write(context, _rows_of(separation))

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        return {*names_of(separation.loads, LoadRow._fields)}

    def _elapsed(self, context: Context, k: int, t: float) -> float:
        """Return how long a load's table has run at a time, s; negative before it."""
        elapsed = t - self._rows.read(context)[k].start
        after = self._after[k]
        return (
            elapsed if after is None else elapsed - self._released.Eval(context)[after]
        )

    def _due(self, context: Context, t: float) -> list[float]:
        passed = self._get_latched(context)
        for k, load in enumerate(self._loads):
            elapsed = self._elapsed(context, k, t) + _ROUND_OFF
            passed[k] = max(passed[k], float(bisect_right(load.times, elapsed)))
        return passed

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        for k, (load, count) in enumerate(
            zip(self._loads, self._get_latched(context), strict=True)
        ):
            row = int(count) - 1  # the last that was passed
            if row >= 0 and load.acts_after(row):
                p_BoQ_B, _, factor = self._rows.read(context)[k]
                b = self._bodies[k]
                body = self._layout.read_one(self._state.Eval(context).tolist(), b)
                elapsed = self._elapsed(context, k, context.get_time())
                start, end = load.times[row : row + 2]
                s = min(max(0.0, (elapsed - start) / (end - start)), 1.0)
                force, torque = (
                    load_laws.between_rows(column[row], column[row + 1], s, factor)
                    for column in (load.forces, load.torques)
                )
                in_body = load.axes == "body"
                total.add(
                    b, load_laws.load_wrench(body, p_BoQ_B, force, torque, in_body)
                )
        total.write(output)


def _rows_of(separation: Separation) -> list[LoadRow]:
    return [LoadRow(load.p_BoQ_B, load.start, load.factor) for load in separation.loads]
