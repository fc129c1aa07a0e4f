"""Thrusters, retro-rockets and disturbances: forces and torques over time."""

from bisect import bisect_right
from typing import NamedTuple

from pydrake.systems.framework import Context

from drakesep.systems.diagram.event_latch import ROUND_OFF, LatchingSystem
from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import BodyStates, StateLayout
from drakesep.systems.diagram.wrenches import Forces, WrenchSum
from drakesep.systems.equations import loads as load_laws
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


class LoadRow(NamedTuple):
    """A load in a Context."""

    p_BoQ_B: Vector
    """Where it acts in its body, m."""
    start: float
    """s."""
    factor: float
    """On its table."""


class _Ramp(NamedTuple):
    """A load between two rows of its table."""

    body: int
    in_body: bool
    """Whether its axes are the body's."""
    p_BoQ_B: Vector
    start: float
    end: float
    """Times of the rows, s."""
    forces: tuple[Vector, ...]
    """Of both rows."""
    torques: tuple[Vector, ...]
    factor: float

    def __call__(self, bodies: BodyStates, t: float, total: WrenchSum) -> None:
        s = min(max(0.0, (t - self.start) / (self.end - self.start)), 1.0)
        force, torque = (
            load_laws.between_rows(before, after, s, self.factor)
            for before, after in (self.forces, self.torques)
        )
        wrench = load_laws.load_wrench(
            bodies[self.body], self.p_BoQ_B, force, torque, self.in_body
        )
        total.add(self.body, wrench)


class Loads(LatchingSystem):
    """Acts on bodies with the forces and torques of tables over time.

    Where in its table a load stands is latched, see `LatchingSystem`: no step straddles
    a row of a table at which its load acts, and no pulse is stepped over.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        released: (n,) s: time of each attachment's release; infinite while it holds.

    Output ports:
        acting: abstract: what acts until an event changes it, for a `ForceSum`.
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.

    Discrete state:
        (k,) how many rows of its table each load has passed; and the step's start.

    Parameters:
        0: for each load a `LoadRow`.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__([0.0] * len(separation.loads))
        bodies = [body.name for body in separation.bodies]
        attachments = [attachment.name for attachment in separation.attachments]
        self._loads = separation.loads
        self._bodies = [bodies.index(load.body) for load in self._loads]
        self._after = [
            None if load.after is None else attachments.index(load.after)
            for load in self._loads
        ]
        state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort("released", len(attachments))
        self._rows = Rows(self, _rows_of(separation))
        Forces(
            self,
            state,
            layout,
            self._find_acting,
            {
                self._latched_ticket,
                self._released.ticket(),
                self.all_parameters_ticket(),
            },
        )

    def set_loads(self, context: Context, separation: Separation) -> None:
        """Write where, when and how strongly loads act, and that none has begun."""
        self._reset(context)
        self._rows.write(context, _rows_of(separation))

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        return {*names_of(separation.loads, LoadRow._fields)}

    def _begins(self, context: Context) -> list[float]:
        """Return when the table of each load begins, s."""
        released = self._released.Eval(context).tolist()
        return [
            row.start + (0.0 if after is None else released[after])
            for row, after in zip(self._rows.read(context), self._after, strict=True)
        ]

    def _is_waiting(self, latched: list[float]) -> bool:
        return any(
            n < len(load.times) for n, load in zip(latched, self._loads, strict=True)
        )

    def _needs_age(self, context: Context) -> bool:
        # Until it has begun, a load after a release may be due with that.
        begun = self._get_latched(context)
        return any(
            after is not None and not n
            for n, after in zip(begun, self._after, strict=True)
        )

    def _due(self, context: Context, latched: list[float], t: float) -> list[float]:
        passed = [*latched]
        for k, (load, begin) in enumerate(
            zip(self._loads, self._begins(context), strict=True)
        ):
            elapsed = t - begin + ROUND_OFF
            passed[k] = max(passed[k], float(bisect_right(load.times, elapsed)))
        return passed

    def _find_acting(self, context: Context) -> list[_Ramp]:
        rows, begins = self._rows.read(context), self._begins(context)
        acting = []
        for k, (load, count) in enumerate(
            zip(self._loads, self._get_latched(context), strict=True)
        ):
            i = int(count) - 1  # the last row that was passed
            if i >= 0 and load.acts_after(i):
                acting.append(
                    _Ramp(
                        self._bodies[k],
                        load.axes == "body",
                        rows[k].p_BoQ_B,
                        begins[k] + load.times[i],
                        begins[k] + load.times[i + 1],
                        load.forces[i : i + 2],
                        load.torques[i : i + 2],
                        rows[k].factor,
                    )
                )
        return acting


def _rows_of(separation: Separation) -> list[LoadRow]:
    return [LoadRow(load.p_BoQ_B, load.start, load.factor) for load in separation.loads]
