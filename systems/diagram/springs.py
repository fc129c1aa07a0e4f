"""The separation springs."""

import math
from typing import TypeAlias

from pydrake.systems.framework import BasicVector, Context, WitnessFunction

from drakesep.systems.diagram.event_latch import LatchingSystem
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.diagram.wrenches import WrenchSum
from drakesep.systems.equations import springs as spring_laws
from drakesep.systems.equations.mated_stack import pad_on_B
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.model.separation import Separation
from drakesep.systems.model.springs import DisplacementSpring, Spring


_FIELDS = 13
"""Of a spring's parameters: see `Springs`."""
_Profile: TypeAlias = tuple[float, list[tuple[float, float]]]
"""Where the force over the stroke starts, and its ramps: see `spring_laws`."""


class Springs(LatchingSystem):
    """Pushes B from A by the spring of each released attachment.

    A `Spring` is driven by time (Eq. 5), a `DisplacementSpring` by the displacement of
    its pad along its axis: A's x axis, tilted if it is misaligned. The force acts on B
    at the pad fixed in B, along that axis; the reaction acts on A at the same point in
    space. A spring whose stroke was reached has let go of its pad: it does not push
    again, wherever the bodies go.

    Input ports:
        plant_state: state of the plant.
        released: (n,) time of each attachment's release, s; infinite while held.

    Output ports:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.
        forces: (k,) force of each spring, N.
        energy: (1,) energy that the springs driven by displacement store, J.

    Discrete state:
        (k,) 1 for each spring that has let go of its pad; and the step's start.

    Parameters:
        0: (13 k,) for each spring its maximum force, N, its frequency, rad/s (0 if
            driven by displacement), stroke, m, and damping, N s/m, the place of its pad
            in A, while mated, and in B, m, and its axis in A.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        pushing = [a for a in separation.attachments if a.spring is not None]
        super().__init__([0.0] * len(pushing))
        self._count = len(separation.bodies)
        self._attachments = [separation.attachments.index(a) for a in pushing]
        self._ends = [separation.ends(a) for a in pushing]
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
        self._by_stroke = [
            k for k, a in enumerate(pushing) if isinstance(a.spring, DisplacementSpring)
        ]
        # Force that is left at the end of a stroke is a jump, at which a step ends.
        self._abrupt = any(
            isinstance(a.spring, DisplacementSpring) and a.spring.profile[-1][1] > 0.0
            for a in pushing
        )
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)
        self.DeclareVectorOutputPort("forces", len(pushing), self._calc_forces)
        self.DeclareVectorOutputPort("energy", 1, self._calc_energy)

    def set_springs(self, context: Context, separation: Separation) -> None:
        """Write the springs of a separation, and that none has let go of its pad."""
        self._reset(context)
        rows: list[float] = []
        for attachment in separation.attachments:
            spring = attachment.spring
            if spring is None:
                continue
            if isinstance(spring, Spring):
                rows += [spring.force_max, spring.frequency, spring.stroke, 0.0]
            else:
                rows += [spring.force_max, 0.0, spring.stroke, spring.damping]
            pad_A = attachment.p_AoPad_A
            rows += [*pad_A, *pad_on_B(separation, attachment, pad_A)]
            rows += spring_laws.push_axis(spring.tilt_y, spring.tilt_z, math)
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
        return spring_laws.spring_displacement(
            bodies[a], bodies[b], row[4:7], row[7:10], _axis(row)
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
        rows = self._rows(context)
        released = self._released.Eval(context).tolist()
        bodies: list[BodyState] = []
        for k in pushing:
            frequency, stroke = rows[k][1:3]
            if frequency > 0.0:
                elapsed = t - released[self._attachments[k]]
                ended = elapsed >= 0.5 * math.pi / frequency
            else:
                bodies = bodies or self._read_bodies(context)
                ended = self._displacement(bodies, k, rows[k])[0] >= stroke
            spent[k] = float(ended)
        return spent

    def _force_over_stroke(
        self, bodies: list[BodyState], k: int, row: list[float]
    ) -> float:
        force_max, _, stroke, damping = row[:4]
        displacement, speed = self._displacement(bodies, k, row)
        if displacement >= stroke:
            return 0.0
        force = spring_laws.displacement_spring_force(
            displacement, speed, force_max, stroke, damping, *self._profiles[k]
        )
        return spring_laws.positive_part(force)

    def _forces(
        self, context: Context, pushing: list[int], rows: list[list[float]]
    ) -> tuple[dict[int, float], list[BodyState]]:
        """Return the forces, and the bodies if they had to be read for them."""
        bodies: list[BodyState] = []
        forces: dict[int, float] = {}
        released, t = self._released.Eval(context).tolist(), context.get_time()
        for k in pushing:
            force_max, frequency = rows[k][:2]
            if frequency > 0.0:
                elapsed = t - released[self._attachments[k]]
                if 0.0 <= elapsed < 0.5 * math.pi / frequency:
                    forces[k] = spring_laws.spring_force(
                        elapsed, force_max, frequency, math
                    )
            else:
                bodies = bodies or self._read_bodies(context)
                forces[k] = self._force_over_stroke(bodies, k, rows[k])
        return forces, bodies

    def _calc_forces(self, context: Context, output: BasicVector) -> None:
        pushing = self._pushing(context)
        forces, _ = self._forces(context, pushing, self._rows(context))
        output.SetFromVector([forces.get(k, 0.0) for k in range(len(self._ends))])

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        pushing = self._pushing(context)
        if not pushing:
            output.SetZero()
            return
        total = WrenchSum(self._count)
        rows = self._rows(context)
        forces, bodies = self._forces(context, pushing, rows)
        if forces:
            bodies = bodies or self._read_bodies(context)
            for (a, b), springs in self._groups.items():
                on_A, on_B = spring_laws.springs_wrenches(
                    bodies[a],
                    bodies[b],
                    [
                        (forces[k], rows[k][7:10], _axis(rows[k]))
                        for k in springs
                        if k in forces
                    ],
                )
                total.add(a, on_A)
                total.add(b, on_B)
        total.write(output)

    def _calc_energy(self, context: Context, output: BasicVector) -> None:
        energy = 0.0
        bodies, rows = self._read_bodies(context), self._rows(context)
        spent = self._get_latched(context)
        for k in self._by_stroke:
            displacement, _ = self._displacement(bodies, k, rows[k])
            force_max, _, stroke = rows[k][:3]
            if displacement < stroke and not spent[k]:
                energy += spring_laws.displacement_spring_energy(
                    displacement, force_max, stroke, *self._profiles[k]
                )
        output.SetFromVector([energy])


def _axis(row: list[float]) -> tuple[float, float, float] | None:
    """Return a spring's axis in A; None if it is A's x axis."""
    x, y, z = row[10:]
    return (x, y, z) if y or z else None


def _profile(spring: Spring | DisplacementSpring | None) -> _Profile:
    if not isinstance(spring, DisplacementSpring):
        return 0.0, []
    return spring.profile[0][1], spring_laws.ramps(spring.profile)
