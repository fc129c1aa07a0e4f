"""Where bodies of many runs are as seen from others, at times that all have."""

from typing import NamedTuple

from drakesep.systems.arrays import Array


class RelativePlaces(NamedTuple):
    """Where bodies B are in bodies A: n rows, T times, k pairs of bodies."""

    q_AB: Array
    """(n, T, k, 4)."""
    p_AoBo_A: Array
    """(n, T, k, 3), m."""
    curved: Array
    """(n, T - 1, k, 2) integrals over the time between, at most: of the size of the
    origin's acceleration in A, m/s; and of that of a point of B about it, over its
    distance, 1/s."""
