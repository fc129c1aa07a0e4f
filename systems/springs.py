"""The separation springs."""

import math
from typing import TypeAlias

from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    LeafSystem,
    WitnessFunction,
    WitnessFunctionDirection,
)

from drakesep.systems import laws
from drakesep.systems.geometry import pad_on_B
from drakesep.systems.laws import BodyState
from drakesep.systems.model import Separation
from drakesep.systems.pushers import DisplacementSpring, Spring
from drakesep.systems.state_layout import StateLayout
from drakesep.systems.wrenches import WrenchSum


_FIELDS = 10
"""Of a spring's parameters: see `Springs`."""
_Profile: TypeAlias = tuple[float, list[tuple[float, float]]]
"""Where the force over the stroke starts, and its ramps: see `laws`."""


class Springs(LeafSystem):
    """Pushes B from A by the spring of each released attachment.

    A `Spring` is driven by time (Eq. 5), a `DisplacementSpring` by the displacement of
    its pad along A's x axis. The force acts on B at the pad fixed in B, along A's x
    axis; the reaction acts on A at the same point in space. A spring driven by
    displacement whose stroke was reached has let go of its pad: it does not push again.

    Input ports:
        plant_state: state of the plant.
        released: (n,) time of each attachment's release, s; infinite while held.

    Output ports:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.
        forces: (k,) force of each spring, N.
        energy: (1,) energy that the springs driven by displacement store, J.

    Discrete state:
        (k,) 1 for each spring that has let go of its pad.

    Parameters:
        0: (10 k,) for each spring its maximum force, N, its frequency, rad/s (0 if
            driven by displacement), stroke, m, and damping, N s/m, and the place of
            its pad in A, while mated, and in B, m.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        self._count = len(separation.bodies)
        index = {body.name: i for i, body in enumerate(separation.bodies)}
        pushing = [a for a in separation.attachments if a.spring is not None]
        self._attachments = [separation.attachments.index(a) for a in pushing]
        self._ends = [(index[a.A], index[a.B]) for a in pushing]
        self._groups: dict[tuple[int, int], list[int]] = {}
        for k, ends in enumerate(self._ends):
            self._groups.setdefault(ends, []).append(k)
        self._profiles = [_profile(a.spring) for a in pushing]
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort(
            "released", len(separation.attachments)
        )
        self._springs = self.DeclareNumericParameter(
            BasicVector(_FIELDS * len(self._attachments))
        )
        self._spent = self.DeclareDiscreteState(len(pushing))
        self._by_stroke = [
            k for k, a in enumerate(pushing) if isinstance(a.spring, DisplacementSpring)
        ]
        if self._by_stroke:
            self.DeclarePerStepDiscreteUpdateEvent(self._let_go)
        self._witnesses = [
            self._make_witness(k)
            for k, a in enumerate(pushing)
            if isinstance(a.spring, DisplacementSpring) and a.spring.profile[-1][1] > 0
        ]
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)
        self.DeclareVectorOutputPort("forces", len(pushing), self._calc_forces)
        self.DeclareVectorOutputPort("energy", 1, self._calc_energy)

    def set_springs(self, context: Context, separation: Separation) -> None:
        """Write the springs of a separation into this system's Context."""
        rows: list[float] = []
        for attachment in separation.attachments:
            spring = attachment.spring
            if spring is None:
                continue
            if isinstance(spring, Spring):
                rows += [spring.force_max, spring.frequency, spring.stroke, 0.0]
            else:
                rows += [spring.force_max, 0.0, spring.stroke, spring.damping]
            rows += [*attachment.p_AoPad_A, *pad_on_B(separation, attachment)]
        context.get_mutable_numeric_parameter(self._springs).SetFromVector(rows)

    def _rows(self, context: Context) -> list[list[float]]:
        p = context.get_numeric_parameter(self._springs).value().tolist()
        return [p[i : i + _FIELDS] for i in range(0, len(p), _FIELDS)]

    def _read_bodies(self, context: Context) -> list[BodyState]:
        return self._layout.read(self._state.Eval(context).tolist())

    def _displacement(
        self, bodies: list[BodyState], k: int, row: list[float]
    ) -> tuple[float, float]:
        a, b = self._ends[k]
        return laws.spring_displacement(bodies[a], bodies[b], row[4:7], row[7:10])

    def _is_at_stroke(self, context: Context, k: int) -> bool:
        if not math.isfinite(self._released.Eval(context)[self._attachments[k]]):
            return False
        row = self._rows(context)[k]
        displacement, _ = self._displacement(self._read_bodies(context), k, row)
        return displacement >= row[2]

    def _let_go(self, context: Context, update: DiscreteValues) -> EventStatus:
        before = context.get_discrete_state(self._spent).value().tolist()
        after = list(before)
        for k in self._by_stroke:
            if not before[k] and self._is_at_stroke(context, k):
                after[k] = 1.0
        if after == before:
            return EventStatus.DidNothing()  # spares a new evaluation of the forces
        update.set_value(self._spent, after)
        return EventStatus.Succeeded()

    def _make_witness(self, k: int) -> WitnessFunction:
        return self.MakeWitnessFunction(
            f"stroke {k}",
            WitnessFunctionDirection.kNegativeThenNonNegative,
            lambda context: 1.0 if self._is_at_stroke(context, k) else -1.0,
        )

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return those of the springs that still push where their stroke ends."""
        return self._witnesses

    def _force_over_stroke(
        self, bodies: list[BodyState], k: int, row: list[float]
    ) -> float:
        force_max, _, stroke, damping = row[:4]
        displacement, speed = self._displacement(bodies, k, row)
        if displacement >= stroke:
            return 0.0
        return max(
            0.0,
            laws.displacement_spring_force(
                displacement, speed, force_max, stroke, damping, *self._profiles[k]
            ),
        )

    def _forces(
        self, context: Context, rows: list[list[float]]
    ) -> tuple[list[float], list[BodyState]]:
        """Return the forces, and the bodies if they had to be read for them."""
        released = self._released.Eval(context).tolist()
        t = context.get_time()
        spent = context.get_discrete_state(self._spent).value().tolist()
        bodies: list[BodyState] = []
        forces = [0.0] * len(rows)
        for k, row in enumerate(rows):
            elapsed = t - released[self._attachments[k]]
            force_max, frequency = row[:2]
            if elapsed < 0.0 or spent[k]:
                continue
            if frequency > 0.0:
                if elapsed < 0.5 * math.pi / frequency:
                    forces[k] = laws.spring_force(elapsed, force_max, frequency, math)
            else:
                bodies = bodies or self._read_bodies(context)
                forces[k] = self._force_over_stroke(bodies, k, row)
        return forces, bodies

    def _calc_forces(self, context: Context, output: BasicVector) -> None:
        forces, _ = self._forces(context, self._rows(context))
        output.SetFromVector(forces)

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        rows = self._rows(context)
        forces, bodies = self._forces(context, rows)
        if any(forces):
            bodies = bodies or self._read_bodies(context)
            for (a, b), springs in self._groups.items():
                on_A, on_B = laws.springs_wrenches(
                    bodies[a], bodies[b], [(forces[k], rows[k][7:]) for k in springs]
                )
                total.add(a, on_A)
                total.add(b, on_B)
        total.write(output)

    def _calc_energy(self, context: Context, output: BasicVector) -> None:
        energy = 0.0
        bodies, rows = self._read_bodies(context), self._rows(context)
        spent = context.get_discrete_state(self._spent).value().tolist()
        for k in self._by_stroke:
            displacement, _ = self._displacement(bodies, k, rows[k])
            force_max, _, stroke = rows[k][:3]
            if displacement < stroke and not spent[k]:
                energy += laws.displacement_spring_energy(
                    displacement, force_max, stroke, *self._profiles[k]
                )
        output.SetFromVector([energy])


def _profile(spring: Spring | DisplacementSpring | None) -> _Profile:
    if not isinstance(spring, DisplacementSpring):
        return 0.0, []
    return spring.profile[0][1], laws.ramps(spring.profile)
