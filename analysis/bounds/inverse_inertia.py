"""The inverse of an inertia over boxes, nearly sharp entry by entry."""

import itertools
from collections.abc import Sequence

import numpy as np

from drakesep.analysis.bounds.intervals import Interval


def inverse(entries: Sequence[Interval]) -> list[list[Interval]]:
    """Return the inverse by Schur complements; NaN where a pivot may not be positive.

    Args:
        entries: xx, yy, zz, xy, xz, yz.
    """
    xx, yy, zz, xy, xz, yz = entries
    M = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    G: dict[tuple[int, int], Interval] = {}
    for a in range(3):
        b, c = (x for x in range(3) if x != a)
        shares = {b: _share(M, a, b, c), c: _share(M, a, c, b)}
        rest = M[a][b] - M[b][c] * M[a][c] / M[c][c]
        pivot = M[b][b] - M[b][c].square() / M[c][c]
        last = M[a][a] - M[a][c].square() / M[c][c] - rest.square() / pivot
        G[a, a] = _positive(last).inverse()
        for k, share in shares.items():
            found = -(G[a, a] * share)
            key = (min(a, k), max(a, k))
            G[key] = G[key].meet(found) if key in G else found
    for a, b in itertools.combinations(range(3), 2):
        G[b, a] = G[a, b]
    return [[G[a, b] for b in range(3)] for a in range(3)]


def _share(M: list[list[Interval]], a: int, b: int, c: int) -> Interval:
    over = M[a][b] - M[b][c] * M[a][c] / M[c][c]
    return over / _positive(M[b][b] - M[b][c].square() / M[c][c])


def _positive(x: Interval) -> Interval:
    """Return x, and NaN where it may not be positive."""
    good = x.lo > 0.0
    return Interval(np.where(good, x.lo, np.nan), np.where(good, x.hi, np.nan))
