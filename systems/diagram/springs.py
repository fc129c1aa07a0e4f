"""The separation springs, and whatever else pushes."""

import math
from typing import Any, NamedTuple

from pydrake.systems.framework import BasicVector, Context, WitnessFunction

from drakesep.systems.checks import X_AXIS
from drakesep.systems.diagram.event_latch import LatchingSystem
from drakesep.systems.diagram.rows import Rows
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.diagram.wrenches import WrenchSum
from drakesep.systems.equations.pushers import (
    AXIS,
    positive_part,
    push_displacement,
    push_place,
    push_wrenches,
    values_of,
)
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


class PushRow(NamedTuple):
    """A pusher in a Context."""

    values: Any
    """Its parameters, as its law takes them."""
    p_AoPad_A: Vector
    """Place of its pad in A, while mated, m."""
    p_BoPad_B: Vector
    """Place of its pad in B, m."""
    axis_A: Vector

    @property
    def axis(self) -> Vector | None:
        """Its axis in A; None if it is A's x axis."""
        return None if self.axis_A == X_AXIS else self.axis_A


class Springs(LatchingSystem):
    """Pushes B from A by the spring of each released attachment.

    Its law says how, see `PushLaw`: a `Spring` is driven by time (Eq. 5), a
    `DisplacementSpring` by the displacement of its pad along its axis, tilted if it is
    misaligned. The force acts on B at the pad fixed in B, along that
    axis; the reaction acts on A at the same point in space. A spring whose stroke was
    reached has let go of its pad: it does not push again, wherever the bodies go.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        released: (n,) s: time of each attachment's release; infinite while it holds.

    Output ports:
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.
        forces: (k,) N: force of each spring.
        energy: (1,) J: energy that the springs driven by displacement store.

    Discrete state:
        (k,) 1 for each spring that has let go of its pad; and the step's start.

    Parameters:
        0: for each spring a `PushRow`.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__([0.0] * len(separation.springs))
        self._count = len(separation.bodies)
        attachments = [attachment for attachment, _ in separation.pushing]
        self._attachments = [separation.attachments.index(a) for a in attachments]
        self._ends = [separation.ends(attachment) for attachment in attachments]
        self._groups: dict[tuple[int, int], list[int]] = {}
        for k, ends in enumerate(self._ends):
            self._groups.setdefault(ends, []).append(k)
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort(
            "released", len(separation.attachments)
        )
        self._laws = [law_of(spring) for spring in separation.springs]
        self._by_stroke = [k for k, law in enumerate(self._laws) if not law.by_time]
        self._rows = Rows(self, self._rows_of(separation))
        # Force that is left at the end of a stroke is a jump, at which a step ends.
        self._abrupt = any(law.ends_in_jump for law in self._laws)
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)
        self.DeclareVectorOutputPort("forces", len(self._laws), self._calc_forces)
        self.DeclareVectorOutputPort("energy", 1, self._calc_energy)

    def set_springs(self, context: Context, separation: Separation) -> None:
        """Write the springs of a separation, and that none has let go of its pad."""
        self._reset(context)
        self._rows.write(context, self._rows_of(separation))

    def _rows_of(self, separation: Separation) -> list[PushRow]:
        return [
            PushRow(values_of(law, spring), *push_place(separation, attachment, spring))
            for law, (attachment, spring) in zip(
                self._laws, separation.pushing, strict=True
            )
        ]

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the rows are made of."""
        names: set[str] = set()
        for row, (attachment, spring) in zip(
            self._rows_of(separation), separation.pushing, strict=True
        ):
            names |= {*names_of([attachment], ["p_AoPad_A"])}
            names |= {*names_of([spring], [*row.values._fields, *AXIS])}
        return names

    def _read_bodies(self, context: Context) -> list[BodyState]:
        return self._layout.read(self._state.Eval(context).tolist())

    def _displacement(
        self, bodies: list[BodyState], k: int, row: PushRow
    ) -> tuple[float, float]:
        a, b = self._ends[k]
        return push_displacement(
            bodies[a], bodies[b], row.p_AoPad_A, row.p_BoPad_B, row.axis
        )

    def _pushing(self, context: Context) -> list[int]:
        """Return the springs that are released, and have not let go of their pad."""
        released = self._released.Eval(context).tolist()
        spent = self._get_latched(context)
        return [
            k
            for k, i in enumerate(self._attachments)
            if not spent[k] and math.isfinite(released[i])
        ]

    def _needs_age(self, context: Context) -> bool:
        return self._abrupt

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return that of strokes, if one of them ends in a jump."""
        return super().DoGetWitnessFunctions(context) if self._abrupt else []

    def _due(self, context: Context, t: float) -> list[float]:
        """Return 1 for each spring whose stroke has been reached."""
        spent = self._get_latched(context)
        pushing = self._pushing(context)
        if not pushing:
            return spent
        rows = self._rows.read(context)
        released = self._released.Eval(context).tolist()
        bodies: list[BodyState] = []
        for k in pushing:
            if self._laws[k].by_time:
                at = t - released[self._attachments[k]]
            else:
                bodies = bodies or self._read_bodies(context)
                at, _ = self._displacement(bodies, k, rows[k])
            spent[k] = float(at >= self._laws[k].end(rows[k].values, math))
        return spent

    def _forces(
        self, context: Context, pushing: list[int], rows: list[PushRow]
    ) -> tuple[dict[int, float], list[BodyState]]:
        """Return the forces before the ends, and the bodies if they had to be read."""
        bodies: list[BodyState] = []
        forces: dict[int, float] = {}
        released, t = self._released.Eval(context).tolist(), context.get_time()
        for k in pushing:
            law, values = self._laws[k], rows[k].values
            if law.by_time:
                at, speed = t - released[self._attachments[k]], 0.0
            else:
                bodies = bodies or self._read_bodies(context)
                at, speed = self._displacement(bodies, k, rows[k])
            if at < law.end(values, math):
                passed = law.passed(values, at, math)
                force = law.force(values, at, speed, passed, math)
                forces[k] = force if law.by_time else positive_part(force)
        return forces, bodies

    def _calc_forces(self, context: Context, output: BasicVector) -> None:
        pushing = self._pushing(context)
        forces, _ = self._forces(context, pushing, self._rows.read(context))
        output.SetFromVector([forces.get(k, 0.0) for k in range(len(self._ends))])

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        pushing = self._pushing(context)
        if not pushing:
            output.SetZero()
            return
        total = WrenchSum(self._count)
        rows = self._rows.read(context)
        forces, bodies = self._forces(context, pushing, rows)
        if forces:
            bodies = bodies or self._read_bodies(context)
            for (a, b), springs in self._groups.items():
                on_A, on_B = push_wrenches(
                    bodies[a],
                    bodies[b],
                    [
                        (forces[k], rows[k].p_BoPad_B, rows[k].axis)
                        for k in springs
                        if k in forces
                    ],
                )
                total.add(a, on_A)
                total.add(b, on_B)
        total.write(output)

    def _calc_energy(self, context: Context, output: BasicVector) -> None:
        energy = 0.0
        bodies, rows = self._read_bodies(context), self._rows.read(context)
        spent = self._get_latched(context)
        for k in self._by_stroke:
            law, values = self._laws[k], rows[k].values
            displacement, _ = self._displacement(bodies, k, rows[k])
            if displacement < law.end(values, math) and not spent[k]:
                energy += law.energy(values, displacement)
        output.SetFromVector([energy])
