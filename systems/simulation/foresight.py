"""What the motion of a run brings about, foreseen from its pace."""

import math

from pydrake.systems.framework import Context

from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.separation import Separation


_LEFT = 1e-7
"""Time until a release by motion from which on it is searched, s."""


class Foresight:
    """How long a run goes on until the next event, and where steps are to be short.

    Kinks of forces are stepped to. A release by motion, or a stroke that ends in a jump
    is found by bisection in the step that straddles it, twenty tries of some steps
    each: so it is to be a short one.
    """

    def __init__(
        self,
        system: SeparationSystem,
        context: Context,
        separation: Separation,
        accuracy: float,
    ):
        """Prepare.

        Args:
            system: that is flown.
            context: of it.
            separation: as it is flown.
            accuracy: of its events.
        """
        self._system, self._context = system, context
        self._by_motion = any(a.released_by_motion for a in separation.attachments)
        self._by_stroke = any(not law_of(x).by_time for x in separation.springs)
        # Drake's search ends within a hundredth of the accuracy, in seconds.
        self._least = max(_LEFT, 0.01 * accuracy)
        self._last = 0.0

    def is_near(self) -> bool:
        """Return whether an event has come, or may lie within the next step."""
        now = self._context.get_time()
        step, self._last = now - self._last, now
        kink, jump = self._left()
        return jump <= 0.0 or self._least < jump < 2.0 * step or kink < 2.0 * step

    def step(self) -> float:
        """Return how long to go on, s.

        Until the next kink. Of what is searched, until just before it, and then well
        beyond it: Drake ends the process when it lies at the end of `AdvanceTo`.
        """
        kink, jump = self._left()
        beyond = 3.0 * self._least
        if kink < jump - beyond:
            return kink
        return 0.99 * jump if jump > self._least else beyond

    def _left(self) -> tuple[float, float]:
        """Return the time until the next kink, s, and until what is searched."""
        kink = jump = math.inf
        if self._by_motion:
            jump = self._system.time_to_release(self._context)
        if self._by_stroke:
            kink, end = self._system.times_to_kinks(self._context)
            jump = min(jump, end)
        return kink, jump
