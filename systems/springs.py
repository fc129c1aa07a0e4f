"""The separation springs."""

import math

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from drakesep.systems import laws
from drakesep.systems.geometry import pad_on_B
from drakesep.systems.model import Separation
from drakesep.systems.state_layout import StateLayout
from drakesep.systems.wrenches import WrenchSum


_FIELDS = 5
"""Of a spring's parameters: maximum force, frequency, and the pad on B."""


class Springs(LeafSystem):
    """Pushes B from A by the spring of each released attachment, Eq. 5.

    The force acts on B at the pad fixed in B, along A's x axis; the reaction acts
    on A at the same point in space.

    Input ports:
        plant_state: state of the plant.
        released: (n,) time of each attachment's release, s; infinite while held.

    Output ports:
        wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on each
            of the m bodies.
        forces: (k,) force of each spring, N.

    Parameters:
        0: (5 k,) for each spring its maximum force, N, its frequency, rad/s, and
            the place of its pad in B, m.
    """

    def __init__(self, separation: Separation, layout: StateLayout):
        super().__init__()
        self._count = len(separation.bodies)
        index = {body.name: i for i, body in enumerate(separation.bodies)}
        pushing = [a for a in separation.attachments if a.spring is not None]
        self._attachments = [separation.attachments.index(a) for a in pushing]
        self._groups: dict[tuple[int, int], list[int]] = {}
        for k, attachment in enumerate(pushing):
            ends = index[attachment.A], index[attachment.B]
            self._groups.setdefault(ends, []).append(k)
        self._layout = layout
        self._state = self.DeclareVectorInputPort("plant_state", layout.size)
        self._released = self.DeclareVectorInputPort(
            "released", len(separation.attachments)
        )
        self._springs = self.DeclareNumericParameter(
            BasicVector(_FIELDS * len(self._attachments))
        )
        self.DeclareVectorOutputPort("wrenches", 6 * self._count, self._calc_wrenches)
        self.DeclareVectorOutputPort(
            "forces", len(self._attachments), self._calc_forces
        )

    def set_springs(self, context: Context, separation: Separation) -> None:
        """Write the springs of a separation into this system's Context."""
        rows: list[float] = []
        for attachment in separation.attachments:
            spring = attachment.spring
            if spring is not None:
                pad = pad_on_B(separation, attachment)
                rows += [spring.force_max, spring.frequency, *pad]
        context.get_mutable_numeric_parameter(self._springs).SetFromVector(rows)

    def _forces(self, context: Context) -> list[tuple[float, list[float]]]:
        """Return each spring's force and its pad on B."""
        p = context.get_numeric_parameter(self._springs).value().tolist()
        released = self._released.Eval(context).tolist()
        t = context.get_time()
        forces = []
        for k, i in enumerate(self._attachments):
            force_max, frequency, *pad = p[_FIELDS * k : _FIELDS * (k + 1)]
            elapsed = t - released[i]
            force = 0.0
            if 0.0 <= elapsed < 0.5 * math.pi / frequency:
                force = laws.spring_force(elapsed, force_max, frequency, math)
            forces.append((force, pad))
        return forces

    def _calc_forces(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([force for force, _ in self._forces(context)])

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        total = WrenchSum(self._count)
        forces = self._forces(context)
        if any(force for force, _ in forces):
            bodies = self._layout.read(self._state.Eval(context).tolist())
            for (a, b), springs in self._groups.items():
                on_A, on_B = laws.springs_wrenches(
                    bodies[a], bodies[b], [forces[k] for k in springs]
                )
                total.add(a, on_A)
                total.add(b, on_B)
        total.write(output)
