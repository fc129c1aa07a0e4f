"""Integrals of what springs push on: int (J(t) - J(s)) x(s) ds over boxes and pieces.

Here a spring's impulse J does not fall. Nominal impulses depend on no parameter: their
kernels are matrices, the same for all boxes. What a spring differs by from the nominal
has a kernel for each box.
"""

from collections.abc import Sequence

import numpy as np

from drakesep.analysis.bounds.impulses import Law, impulse, summed_impulse
from drakesep.analysis.bounds.intervals import EPS, TINY, Interval, down, up
from drakesep.analysis.bounds.jets import Jet
from drakesep.systems.arrays import Array


class NominalKernel:
    """The kernel of an impulse that depends on no parameter."""

    def __init__(self, law: Law, times: Array, push: int):
        """Take the times (N + 1,) of a grid, and how many pieces are the push's."""
        t = times[: push + 1]
        at = impulse(law, Interval(t)).value[0]
        self.range = impulse(law, Interval(times[:-1], times[1:])).value
        sums = summed_impulse(law, t)[0]
        over = sums[1:] - sums[:-1]  # of J over each piece
        lengths = Interval(t[1:]) - Interval(t[:-1])
        # Rows: t in a piece of the push, or after it; columns: s in a piece.
        first = Interval(
            np.append(at.lo[:-1], at.lo[-1]), np.append(at.hi[1:], at.hi[-1])
        )
        rows = Interval(first.lo[:, None], first.hi[:, None]) * lengths - over
        low, high = (
            np.tril(np.maximum(rows.lo, 0.0), -1),
            np.tril(np.maximum(rows.hi, 0.0)),
        )
        self._low, self._high = low.T.copy(), high.T.copy()

    def __call__(self, x: Jet) -> Jet:
        """Return the integrals (..., push + 1), the last after the push.

        Args:
            x: (..., push) jets side by side.
        """
        n = self._low.shape[0]
        lo = _ends(x.lo, self._low, self._high)
        hi = _ends(x.hi, self._high, self._low)
        units = float(n + 4)
        return Jet(down(lo[0], lo[1], units), up(hi[0], hi[1], units))


def _ends(x: Array, of_positive: Array, of_negative: Array) -> tuple[Array, Array]:
    """Return an end of the integral, and the sum of the magnitudes in it."""
    a = np.maximum(x, 0.0) @ of_positive
    b = np.minimum(x, 0.0) @ of_negative
    return a + b, a - b


class DeviationKernel:
    """The kernel of what a spring's impulse differs by from the nominal."""

    def __init__(self, deviation: Jet, rows: Sequence[int], times: Array, push: int):
        """Take the deviation (1 + n, boxes, push + 1), and which derivatives it has."""
        self._rows = rows
        self._lengths = np.diff(times[: push + 1])
        self._value = self._ball(deviation.value, push)
        self._by = [self._ball(deviation.slopes[i], push) for i in rows]

    def _ball(self, D: Interval, push: int) -> tuple[Array, Array]:
        """Return centres and radii (boxes, push, push + 1) of the kernel."""
        late, early = D[:, None, :], D[:, :push, None]
        K = (Interval(late.lo, late.hi) - early) * Interval(self._lengths[:, None])
        # s comes before t; a piece with t in it may be empty or whole.
        s, t = np.arange(push)[:, None], np.arange(push + 1)
        low = np.where(s < t, K.lo, np.where(s == t, np.minimum(K.lo, 0.0), 0.0))
        high = np.where(s < t, K.hi, np.where(s == t, np.maximum(K.hi, 0.0), 0.0))
        return _ball(low, high)

    def __call__(self, x: Jet) -> Jet:
        """Return the integrals (c, 1 + n, boxes, push + 1), the last after the push.

        Args:
            x: (c, 1 + n, boxes, push) jets side by side.
        """
        result = _applied(self._value, x.lo, x.hi)
        for i, ball in zip(self._rows, self._by, strict=True):
            row = _applied(ball, x.lo[:, :1], x.hi[:, :1])
            here = Interval(result.lo[:, 1 + i], result.hi[:, 1 + i])
            here = here + Interval(row.lo[:, 0], row.hi[:, 0])
            result.lo[:, 1 + i], result.hi[:, 1 + i] = here.lo, here.hi
        return result


def _ball(low: Array, high: Array) -> tuple[Array, Array]:
    """Return centres and radii that hold intervals."""
    centre = 0.5 * (low + high)
    radius = up(np.maximum(high - centre, centre - low))
    return centre, radius


def _applied(kernel: tuple[Array, Array], lo: Array, hi: Array) -> Jet:
    """Return the product of kernels with ranges, summed over pieces."""
    K, R = kernel
    shape = lo.shape  # (c, rows, boxes, push)
    x, r = (np.moveaxis(a, 2, 0).reshape(shape[2], -1, shape[3]) for a in _ball(lo, hi))
    size = np.abs(x) + r
    middle = x @ K
    magnitude = np.abs(K)
    all_of_it = size @ magnitude + size @ R
    radius = r @ magnitude + size @ R
    radius = radius + all_of_it * ((shape[3] + 6) * EPS) + TINY * shape[3]
    radius = up(radius)

    def back(a: Array) -> Array:
        parts = a.reshape(shape[2], shape[0], shape[1], -1)
        return np.moveaxis(parts, 0, 2).copy()

    return Jet(back(down(middle - radius)), back(up(middle + radius)))
