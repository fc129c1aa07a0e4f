"""Values with their first derivatives, as intervals: jets.

A jet's arrays have a row for its value and one for each parameter's derivative, then
boxes, then pieces of time. What depends on few parameters, and not on time, is affine.
"""

from collections.abc import Mapping, Sequence
from typing import Self, TypeVar

import numpy as np

from drakesep.analysis.bounds.intervals import (
    EPS,
    TINY,
    Interval,
    down,
    products,
    total,
    up,
)
from drakesep.systems.arrays import Array


class Affine:
    """A number that changes with a few parameters alone: value and slopes."""

    __array_ufunc__ = None
    __slots__ = ("slopes", "value")

    def __init__(self, value: Interval, slopes: Mapping[int, Interval] | None = None):
        """Take a value (boxes, 1), or one for all, and slopes by parameter."""
        self.value, self.slopes = value, dict(slopes or {})

    @property
    def is_zero(self) -> bool:
        """Whether it is zero, for all parameters."""
        none = not self.value.lo.any() and not self.value.hi.any()
        return none and not self.slopes

    @property
    def unit(self) -> float:
        """1 or -1 where it is exactly that, for all parameters; 0 elsewhere."""
        lo, hi = self.value.lo, self.value.hi
        if self.slopes or lo.size > 1 or lo.item() != hi.item():
            return 0.0
        return lo.item() if lo.item() in (1.0, -1.0) else 0.0

    def nothing(self) -> "Affine":
        """Return zero."""
        return Affine(Interval(0.0))

    def __add__(self, other: "Affine") -> "Affine":
        slopes = dict(self.slopes)
        for i, slope in other.slopes.items():
            slopes[i] = slopes[i] + slope if i in slopes else slope
        return Affine(self.value + other.value, slopes)

    def __neg__(self) -> "Affine":
        return Affine(-self.value, {i: -x for i, x in self.slopes.items()})

    def __sub__(self, other: "Affine") -> "Affine":
        return self + -other

    def __mul__(self, factor: "float | Interval | Affine") -> "Affine":
        if isinstance(factor, Affine):
            if self.unit:
                return factor if self.unit > 0.0 else -factor
            # Not affine any more: what its slopes are over the boxes.
            return self * factor.value + Affine(
                Interval(0.0), (factor * self.value).slopes
            )
        slopes = {i: x * factor for i, x in self.slopes.items()}
        return Affine(self.value * factor, slopes)

    __rmul__ = __mul__


class Jet(Interval):
    """A value and its derivatives; see the head of this file."""

    __slots__ = ()

    @classmethod
    def zeros(cls, parameters: int, boxes: int, pieces: int) -> "Jet":
        """Return zeros."""
        none = np.zeros((1 + parameters, boxes, pieces))
        return cls(none, none.copy())

    @classmethod
    def of(cls, x: Affine, parameters: int, boxes: int) -> "Jet":
        """Return an affine number as a jet."""
        jet = cls.zeros(parameters, boxes, 1)
        jet.lo[0], jet.hi[0] = x.value.lo, x.value.hi
        for i, slope in x.slopes.items():
            jet.lo[1 + i], jet.hi[1 + i] = slope.lo, slope.hi
        return jet

    def nothing(self) -> "Jet":
        """Return zeros of its form."""
        return Jet(np.zeros_like(self.lo), np.zeros_like(self.hi))

    @property
    def value(self) -> Interval:
        """(boxes, pieces) values."""
        return Interval(self.lo[0], self.hi[0])

    @property
    def slopes(self) -> Interval:
        """(parameters, boxes, pieces) derivatives."""
        return Interval(self.lo[1:], self.hi[1:])

    def __add__(self, other: "Interval | Affine | float") -> Self:
        if isinstance(other, Affine):
            return self._plus(other)
        if isinstance(other, Jet):
            return super().__add__(other)
        return self._plus(
            Affine(other if isinstance(other, Interval) else Interval(other))
        )

    __radd__ = __add__

    def __sub__(self, other: "Interval | Affine | float") -> Self:
        return super().__sub__(other) if isinstance(other, Jet) else self + -other

    def _plus(self, other: Affine) -> Self:
        lo, hi = self.lo.copy(), self.hi.copy()
        first = self.value + other.value
        if first.lo.shape != lo.shape[1:]:
            shape = (len(lo), *first.lo.shape)
            lo, hi = (
                np.broadcast_to(lo, shape).copy(),
                np.broadcast_to(hi, shape).copy(),
            )
        lo[0], hi[0] = first.lo, first.hi
        for i, slope in other.slopes.items():
            row = Interval(lo[1 + i], hi[1 + i]) + slope
            lo[1 + i], hi[1 + i] = row.lo, row.hi
        return type(self)(lo, hi)

    def __mul__(self, other: "Interval | Affine | float") -> Self:
        if isinstance(other, Jet):
            return self._times(other)
        if isinstance(other, Affine):
            return self._scaled(other)
        return super().__mul__(other)

    __rmul__ = __mul__

    def _times(self, b: "Jet") -> Self:
        """Return the product, by Leibniz's rule."""
        al, ah, bl, bh = self.lo, self.hi, b.lo, b.hi
        low, high = products(al, ah, bl[:1], bh[:1])
        low, high = _wide(low, high, b)
        size_l, size_h = np.abs(low), np.abs(high)
        if len(low) > 1:
            xl, xh = products(al[:1], ah[:1], bl[1:], bh[1:])
            size_l[1:] += np.abs(xl)
            size_h[1:] += np.abs(xh)
            low[1:] += xl
            high[1:] += xh
        size_l *= 2.0 * EPS
        size_l += TINY
        low -= size_l
        size_h *= 2.0 * EPS
        size_h += TINY
        high += size_h
        return type(self)(low, high)

    def _scaled(self, other: Affine) -> Self:
        lo, hi = products(self.lo, self.hi, other.value.lo, other.value.hi)
        lo, hi = down(lo), up(hi)
        for i, slope in other.slopes.items():
            row = Interval(lo[1 + i], hi[1 + i]) + self.value * slope
            lo[1 + i], hi[1 + i] = row.lo, row.hi
        return type(self)(lo, hi)

    def squared(self) -> "Jet":
        """Return the square, whose value is not negative."""
        value = self.value.square()
        jet = self._times(self)
        jet.lo[0], jet.hi[0] = value.lo, value.hi
        return jet


def _wide(low: Array, high: Array, b: Jet) -> tuple[Array, Array]:
    """Return arrays with the pieces of both factors, to be written to."""
    shape = np.broadcast_shapes(low.shape, b.lo.shape)
    if low.shape != shape:
        return np.broadcast_to(low, shape).copy(), np.broadcast_to(high, shape).copy()
    return low, high


_X = TypeVar("_X", Jet, Affine)


def cross(a: Sequence[_X], b: Sequence["_X | Affine"]) -> list[_X]:
    """Return a x b, of jets or affine numbers with such or affine ones."""
    return [a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))]


def added(*vectors: Sequence[Jet]) -> list[Jet]:
    """Return the sum of vectors."""
    return [total(each) for each in zip(*vectors, strict=True)]


def turned(M: Sequence[Sequence[Affine]], vector: Sequence[_X]) -> list[_X]:
    """Return M v."""
    return [combined(row, vector) for row in M]


def combined(weights: Sequence[Affine], terms: Sequence[_X]) -> _X:
    """Return a sum with weights; those that are exactly 0, 1 or -1 cost nothing."""
    found = [
        _weighted(term, weight)
        for weight, term in zip(weights, terms, strict=True)
        if not weight.is_zero and not _is_zero(term)
    ]
    return total(found) if found else terms[0].nothing()


def _is_zero(term: "Jet | Affine") -> bool:
    return isinstance(term, Affine) and term.is_zero


def _weighted(term: _X, weight: Affine) -> _X:
    if weight.unit:
        return term if weight.unit > 0.0 else -term
    return term * weight


def stacked(jets: Sequence[Jet]) -> Jet:
    """Return jets side by side, along a new first axis."""
    return Jet(np.stack([j.lo for j in jets]), np.stack([j.hi for j in jets]))


def integrals(jets: Jet, lengths: Array) -> Jet:
    """Return the ranges, in each piece of time, of integrals from the start.

    Args:
        jets: (..., pieces) ranges of what is integrated.
        lengths: (pieces,) of the pieces, rounded, s.
    """
    al, ah = jets.lo * lengths, jets.hi * lengths
    sums_l, sums_h = np.cumsum(al, -1), np.cumsum(ah, -1)
    size = np.cumsum(np.maximum(np.abs(al), np.abs(ah)), -1)
    before_l, before_h = (np.roll(x, 1, -1) for x in (sums_l, sums_h))
    before_l[..., 0] = before_h[..., 0] = 0.0
    units = len(lengths) + 4.0
    return Jet(
        down(before_l + np.minimum(al, 0.0), size, units),
        up(before_h + np.maximum(ah, 0.0), size, units),
    )
