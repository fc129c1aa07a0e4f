"""How near parts are in a run while bodies leave each other, to be drawn."""

from typing import NamedTuple

from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.systems.arrays import Array


class Approach(NamedTuple):
    """How near the nearest pair of a run is while distances matter."""

    clearance: str
    """Name of the metric that it is of."""
    label: str
    pair: str
    separation: Array
    """(n,) how far the body that leaves has moved in its direction, m."""
    distance: Array
    """(n,) m."""


class Curve(NamedTuple):
    """How near two parts are in a run."""

    separation: Array
    """(n,) how far the body that leaves has moved in its direction, m."""
    distance: Array
    """(n,) m."""
    smallest: Clearance
    """Over continuous time."""
