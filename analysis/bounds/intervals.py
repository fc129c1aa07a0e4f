"""Arrays of intervals, rounded outward.

After each operation, which IEEE rounds to the nearest, both ends take a step outward
that is at least a unit in the last place. That is several times as fast as
`numpy.nextafter`, and a little wider. XLA, which reorders and contracts, has no place
here.
"""

from collections.abc import Callable, Iterable
from typing import Any, Self, TypeAlias, TypeVar, cast

import numpy as np

from drakesep.systems.arrays import Array


EPS = 2.0**-52
TINY = 1e-300
"""More than what underflow takes."""
_LIBM = 1e-15
"""Of sines, cosines and arctangents, relative: more than four units in the last place,
which libraries keep."""
Number: TypeAlias = float | Array
Term = TypeVar("Term")


def down(x: Array, scale: Array | None = None, units: float = 1.0) -> Array:
    """Return what is surely below numbers that are rounded.

    Args:
        x: the numbers.
        scale: magnitude of what they are sums of; None: their own.
        units: how many roundings there may be, of half a unit in the last place, less
            one.
    """
    return np.asarray(x - _step(x, scale, units))


def up(x: Array, scale: Array | None = None, units: float = 1.0) -> Array:
    """Return what is surely above numbers that are rounded; see `down`."""
    return np.asarray(x + _step(x, scale, units))


def _step(x: Array, scale: Array | None, units: float) -> Array:
    step: Array = np.abs(x) if scale is None else np.array(scale)
    step *= units * EPS
    step += TINY
    return step


def products(al: Array, ah: Array, bl: Array, bh: Array) -> tuple[Array, Array]:
    """Return the ends of products of intervals, rounded to the nearest."""
    p, q, r, s = al * bl, al * bh, ah * bl, ah * bh
    low = np.minimum(np.minimum(p, q), np.minimum(r, s))
    return low, np.maximum(np.maximum(p, q), np.maximum(r, s))


class Interval:
    """Intervals, entry by entry."""

    __array_ufunc__ = None  # numpy leaves operators to this class
    __slots__ = ("hi", "lo")

    def __init__(self, lo: Number, hi: Number | None = None):
        """Take ends, which are exact; a point if there is one alone."""
        self.lo = np.asarray(lo, dtype=float)
        self.hi = self.lo if hi is None else np.asarray(hi, dtype=float)

    def __repr__(self) -> str:
        return f"[{self.lo}, {self.hi}]"

    def __getitem__(self, key: Any) -> Self:
        return type(self)(self.lo[key], self.hi[key])

    def __add__(self, other: "Interval | float") -> Self:
        b = _interval(other)
        return type(self)(down(self.lo + b.lo), up(self.hi + b.hi))

    __radd__ = __add__

    def __neg__(self) -> Self:
        return type(self)(-self.hi, -self.lo)

    def __sub__(self, other: "Interval | float") -> Self:
        b = _interval(other)
        return type(self)(down(self.lo - b.hi), up(self.hi - b.lo))

    def __rsub__(self, other: float) -> Self:
        return -self + other

    def __mul__(self, other: "Interval | float") -> Self:
        b = _interval(other)
        low, high = products(self.lo, self.hi, b.lo, b.hi)
        return type(self)(down(low), up(high))

    __rmul__ = __mul__

    def __truediv__(self, other: "Interval | float") -> Self:
        return self * _interval(other).inverse()

    def inverse(self) -> "Interval":
        """Return 1 / x; NaN where zero may be in x."""
        apart = (self.lo > 0.0) | (self.hi < 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            low = np.where(apart, down(1.0 / self.hi), np.nan)
            high = np.where(apart, up(1.0 / self.lo), np.nan)
        return Interval(low, high)

    def square(self) -> "Interval":
        """Return x^2."""
        least, most = self.least_magnitude(), self.magnitude()
        return Interval(np.maximum(down(least * least), 0.0), up(most * most))

    def sqrt(self) -> "Interval":
        """Return the root; of what may be below zero by rounding, from zero on."""
        low = np.sqrt(np.maximum(self.lo, 0.0))
        high = np.sqrt(np.maximum(self.hi, 0.0))
        return Interval(np.maximum(down(low), 0.0), up(high))

    def magnitude(self) -> Array:
        """Return the largest |x|."""
        return np.asarray(np.maximum(np.abs(self.lo), np.abs(self.hi)))

    def least_magnitude(self) -> Array:
        """Return the least |x|."""
        return np.asarray(np.maximum(np.maximum(self.lo, -self.hi), 0.0))

    def abs(self) -> "Interval":
        """Return |x|."""
        return Interval(self.least_magnitude(), self.magnitude())

    def meet(self, other: "Interval") -> Self:
        """Return the intersection with another enclosure of the same."""
        return type(self)(np.maximum(self.lo, other.lo), np.minimum(self.hi, other.hi))

    def hull(self, other: "Interval | float") -> Self:
        """Return the least intervals that hold both."""
        b = _interval(other)
        return type(self)(np.minimum(self.lo, b.lo), np.maximum(self.hi, b.hi))

    def within(self, other: "Interval") -> Array:
        """Return whether each lies in another; never of NaN."""
        return np.asarray((self.lo >= other.lo) & (self.hi <= other.hi))


def _interval(x: "Interval | float | Array") -> Interval:
    return x if isinstance(x, Interval) else Interval(x)


def total(terms: Iterable[Term]) -> Term:
    """Return the sum of one or more."""
    first, *rest = terms
    result: Any = first
    for term in rest:
        result = result + term
    return cast(Term, result)


HALF_PI = Interval(np.pi / 2, np.nextafter(np.pi / 2, 2.0))
"""numpy's pi is below the number."""


def sin(x: Interval) -> Interval:
    """Return sines of x within [0, pi/2], which is cut to it from above."""
    high = np.where(x.hi < HALF_PI.lo, np.sin(np.minimum(x.hi, HALF_PI.lo)), 1.0)
    low = np.sin(np.minimum(x.lo, HALF_PI.lo))
    return Interval(
        np.maximum(low * (1.0 - _LIBM), 0.0), np.minimum(high * (1.0 + _LIBM), 1.0)
    )


def cos(x: Interval) -> Interval:
    """Return cosines of x within [0, pi/2], which is cut to it from above."""
    # Beyond it the double, the cosine is 6e-17 of the double itself, and zero.
    low = np.where(x.hi < HALF_PI.lo, np.cos(np.minimum(x.hi, HALF_PI.lo)), 0.0)
    high = np.cos(np.minimum(x.lo, HALF_PI.lo))
    return Interval(
        np.maximum(low * (1.0 - _LIBM), 0.0), np.minimum(high * (1.0 + _LIBM), 1.0)
    )


def cosine(x: Interval) -> Interval:
    """Return cosines of any angles."""
    low, high = _at_ends(x, np.cos)
    return _with_turns(low, high, x, 0.0)


def sine(x: Interval) -> Interval:
    """Return sines of any angles."""
    low, high = _at_ends(x, np.sin)
    return _with_turns(low, high, x, 0.5)


def _at_ends(x: Interval, of: Callable[[Array], Array]) -> tuple[Array, Array]:
    a, b = of(x.lo), of(x.hi)
    low, high = np.minimum(a, b), np.maximum(a, b)
    return low - np.abs(low) * _LIBM, high + np.abs(high) * _LIBM


_NEARLY = 1e-12
"""Of half turns: within it an angle may be where a sine or cosine turns."""


def _with_turns(low: Array, high: Array, x: Interval, first: float) -> Interval:
    """Return ends; 1 and -1 where it turns, at every half turn from the first on."""
    wide = _NEARLY * (1.0 + x.magnitude())
    begin = np.ceil(x.lo / np.pi - first - wide)
    end = np.floor(x.hi / np.pi - first + wide)
    ups = 2.0 * np.ceil(0.5 * begin) <= end
    downs = 2.0 * np.ceil(0.5 * (begin - 1.0)) + 1.0 <= end
    return Interval(
        np.where(downs, -1.0, np.maximum(low, -1.0)),
        np.where(ups, 1.0, np.minimum(high, 1.0)),
    )


def arctan2(y: Interval, x: Interval) -> Interval:
    """Return the angle of (x, y) where x > 0; NaN elsewhere."""
    right = x.lo > 0.0
    with np.errstate(invalid="ignore"):
        low = np.arctan2(y.lo, np.where(y.lo > 0.0, x.hi, x.lo))
        high = np.arctan2(y.hi, np.where(y.hi > 0.0, x.lo, x.hi))
    wide = (np.abs(low) * _LIBM + TINY, np.abs(high) * _LIBM + TINY)
    return Interval(
        np.where(right, low - wide[0], np.nan), np.where(right, high + wide[1], np.nan)
    )


def arcsin(x: Interval) -> Interval:
    """Return the arcsine; NaN beyond -1 and 1."""
    with np.errstate(invalid="ignore"):
        low, high = np.arcsin(x.lo), np.arcsin(x.hi)
    return Interval(
        low - (np.abs(low) * _LIBM + TINY), high + (np.abs(high) * _LIBM + TINY)
    )
