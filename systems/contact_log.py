"""The forces between elements that touch again, as a run goes on."""

import numpy as np
from pydrake.systems.framework import Context

from drakesep.systems.run import ContactForces
from drakesep.systems.separation_system import SeparationSystem
from drakesep.systems.vectors import Vector


class ContactLog:
    """Notes forces at every step; call `note` from a Simulator's monitor.

    Steps, not samples: a stiff contact is over before the next sample.
    """

    def __init__(self, system: SeparationSystem, context: Context):
        self._system, self._context = system, context
        self._noted: dict[tuple[str, str], dict[float, Vector]] = {}

    def note(self) -> None:
        """Note the forces of a step."""
        now = self._context.get_time()
        forces = self._system.contact_forces(self._context)
        for pair, noted in self._noted.items():
            if pair not in forces and any(noted[max(noted)]):
                noted[now] = (0.0, 0.0, 0.0)
        for pair, force in forces.items():
            self._noted.setdefault(pair, {})[now] = force

    @property
    def forces(self) -> tuple[ContactForces, ...]:
        """What was noted, in the order of first contact."""
        return tuple(
            ContactForces(
                first=first,
                second=second,
                time=np.array(list(noted)),
                force=np.array(list(noted.values())),
            )
            for (first, second), noted in self._noted.items()
        )
