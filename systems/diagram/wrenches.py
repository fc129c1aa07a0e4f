"""Wrenches on floating bodies, as vectors between systems.

Each force system puts out one vector of 6 n entries: torque about the origin and
force, in W, for each of n bodies. For a body that floats in the world these are its
generalized forces in Drake, so that a sum of such vectors goes into the plant as it
stands; a list of ExternallyAppliedSpatialForce would double the cost of a run.
"""

from pydrake.systems.framework import BasicVector

from drakesep.systems.equations.relative_motion import Wrench


class WrenchSum:
    """Adds wrenches up, body by body."""

    def __init__(self, bodies: int):
        self._entries = [0.0] * (6 * bodies)
        self._is_zero = True

    def add(self, body: int, wrench: Wrench) -> None:
        """Add a wrench on a body, given by its index."""
        entries = self._entries
        (tx, ty, tz), (fx, fy, fz) = wrench
        i = 6 * body
        entries[i] += tx
        entries[i + 1] += ty
        entries[i + 2] += tz
        entries[i + 3] += fx
        entries[i + 4] += fy
        entries[i + 5] += fz
        self._is_zero = False

    def write(self, output: BasicVector) -> None:
        """Write the sums into an output port's vector."""
        if self._is_zero:
            output.SetZero()  # much cheaper, and most of a run
        else:
            output.SetFromVector(self._entries)
