"""How near the nearest pair of a run is while B moves away, to be drawn."""

from typing import NamedTuple

from drakesep.systems.arrays import Array


class Approach(NamedTuple):
    """How near the nearest pair of a run is while B moves away."""

    clearance: str
    """Name of the metric that it is of."""
    label: str
    pair: str
    separation: Array
    """(n,) how far B has moved in its direction, m."""
    distance: Array
    """(n,) m."""
