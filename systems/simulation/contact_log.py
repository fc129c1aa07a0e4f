"""The forces between parts that touch again, as a run goes on."""

import numpy as np
from pydrake.systems.framework import Context

from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.run import ContactForces
from drakesep.systems.vectors import Vector


_NONE = (0.0, 0.0, 0.0)


class ContactLog:
    """Notes forces at every step; call `note` from a Simulator's monitor.

    Steps, not samples: a stiff contact is over before the next sample.
    """

    def __init__(self, system: SeparationSystem, context: Context):
        self._system, self._context = system, context
        self._noted: dict[tuple[str, str], dict[float, Vector]] = {}
        self._before: float | None = None

    def note(self) -> None:
        """Note the forces of a step.

        Raises:
            RuntimeError: parts are pressed so deep that their law has ended.
        """
        now = self._context.get_time()
        forces = self._system.contact_forces(self._context)
        if forces:
            self._system.check_depths(self._context)
        for pair, noted in self._noted.items():
            if pair not in forces and _last(noted) != _NONE:
                noted[now] = _NONE
        for pair, force in forces.items():
            noted = self._noted.setdefault(pair, {})
            # From nothing at the step before: an impulse has all of the rise.
            if self._before is not None and _last(noted) == _NONE:
                noted[self._before] = _NONE
            noted[now] = force
        self._before = now

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


def _last(noted: dict[float, Vector]) -> Vector:
    return next(reversed(noted.values()), _NONE)
