"""The distance between two convex sets that are told by their support points.

Gilbert, Johnson and Keerthi's algorithm, with Lawson and Hanson's least distance
programming for the nearest point of a few corners (scipy's nnls). Slow, and exact: it
ends when a plane between the sets proves the distance.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import nnls

from drakesep.systems.arrays import Array


SupportPoints: TypeAlias = Callable[[Array], tuple[Array, Array]]
"""Returns the farthest point of the first set along a direction, and the farthest of
the second against it."""

_CLOSE = 1e-9
"""By which the distance may differ from that of the plane, m."""
_ITERATIONS = 200


class GjkResult(NamedTuple):
    """The nearest points of two sets."""

    distance: float
    """m; 0 where the sets meet."""
    low: float
    """What a plane between the sets proves, m."""
    n: Array
    """Unit vector from the first to the second, across that plane."""
    first: Array
    second: Array


def gjk(support_points: SupportPoints, n: Array) -> GjkResult:
    """Return the distance of two convex sets.

    Args:
        support_points: tells those of the two sets.
        n: (3,) a first guess of the direction from the first to the second.
    """
    pairs = [support_points(n)]
    best = -np.inf
    best_n = n
    for _ in range(_ITERATIONS):
        first, second = (np.array(side) for side in zip(*pairs, strict=True))
        corners = second - first
        weights, _ = nnls(
            np.vstack([corners.T, np.ones(len(corners))]),
            np.array([0.0, 0.0, 0.0, 1.0]),
        )
        weights /= weights.sum()
        v = weights @ corners
        distance = float(np.linalg.norm(v))
        if distance <= _CLOSE:
            return GjkResult(0.0, 0.0, best_n, weights @ first, weights @ second)
        a, b = support_points(v / distance)
        low = float(v @ (b - a)) / distance
        if low > best:
            best, best_n = low, v / distance
        if distance - best <= _CLOSE:
            break
        pairs = [p for p, weight in zip(pairs, weights, strict=True) if weight > 0.0]
        pairs.append((a, b))
    return GjkResult(distance, best, best_n, weights @ first, weights @ second)
