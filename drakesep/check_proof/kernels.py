"""Integrals over time, of a product with a kernel too, for many functions at once.

A function is a column of intervals, one on each piece of time. A kernel is a lower
triangle: its row n is for t in piece n, its column m for s in piece m.
"""

from flint import arb, arb_mat

from .intervals import ZERO, Interval, Jet


Column = list[Interval]
Ends = tuple[arb_mat, arb_mat]


def integrated(x: list[Jet], lengths: list[arb]) -> list[Jet]:
    """Enclose the integral from 0 to any time of each piece."""
    total = [(ZERO, ZERO) for _ in x[0]]
    out = []
    for jet, length in zip(x, lengths, strict=True):
        steps = [(low * length, high * length) for low, high in jet]
        out.append(
            [
                (a + low.min(ZERO), b + high.max(ZERO))
                for (a, b), (low, high) in zip(total, steps, strict=True)
            ]
        )
        total = [
            (a + low, b + high)
            for (a, b), (low, high) in zip(total, steps, strict=True)
        ]
    return out


class Columns:
    """Functions times the lengths of the first pieces, laid out for kernels."""

    def __init__(self, columns: list[Column], lengths: list[arb]):
        rows = [
            [(low * length, high * length) for low, high in row]
            for row, length in zip(zip(*columns, strict=True), lengths, strict=True)
        ]
        low = [a for row in rows for a, _ in row]
        high = [b for row in rows for _, b in row]
        shape = len(rows), len(columns)
        self.low_up = arb_mat(*shape, [a.max(ZERO) for a in low])
        self.low_down = arb_mat(*shape, [a.min(ZERO) for a in low])
        self.high_up = arb_mat(*shape, [b.max(ZERO) for b in high])
        self.high_down = arb_mat(*shape, [b.min(ZERO) for b in high])
        centre = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        radius = [(b - a) / 2 for a, b in zip(low, high, strict=True)]
        most = [abs(c) + r for c, r in zip(centre, radius, strict=True)]
        self.centre = arb_mat(*shape, centre)
        self.radius = arb_mat(*shape, radius)
        self.most = arb_mat(*shape, most)


class PositiveKernel:
    """A kernel that is nowhere negative: ends are exact (Eq. 14)."""

    def __init__(self, rows: list[list[Interval]]):
        self.low = _triangle([[low for low, _ in row] for row in rows])
        self.high = _triangle([[high for _, high in row] for row in rows])

    def __call__(self, x: Columns) -> list[Column]:
        """Return the sums of products, a column for each."""
        low = self.low * x.low_up + self.high * x.low_down
        high = self.high * x.high_up + self.low * x.high_down
        return _columns(low, high)


class DifferenceKernel:
    """x(t) - x(s), by products of balls (Eq. 15)."""

    def __init__(self, x: Column, push: int):
        centres, radii = [], []
        for n in range(push + 1):
            low, high = x[min(n, len(x) - 1)]
            row = [(low - x[m][1], high - x[m][0]) for m in range(min(n + 1, push))]
            centres.append([(a + b) / 2 for a, b in row])
            radii.append([(b - a) / 2 for a, b in row])
        self.centre = _triangle(centres)
        self.radius = _triangle(radii)
        self.size = _triangle([[abs(c) for c in row] for row in centres])

    def __call__(self, x: Columns) -> list[Column]:
        """Return the sums of products, a column for each."""
        centre = self.centre * x.centre
        radius = self.size * x.radius + self.radius * x.most
        return _columns(centre - radius, centre + radius)


def _triangle(rows: list[list[arb]]) -> arb_mat:
    """Return a kernel; its last row is for all times after those of the others."""
    count = len(rows) - 1
    return arb_mat([(row + [ZERO] * count)[:count] for row in rows])


def _columns(low: arb_mat, high: arb_mat) -> list[Column]:
    lows, highs = low.transpose().tolist(), high.transpose().tolist()
    return [list(zip(a, b, strict=True)) for a, b in zip(lows, highs, strict=True)]
