"""Integrals over time of magnitudes and of squares, as the largest of some options.

After all strokes a signal changes little: it is looked at as a whole there, by its sign
or by its mean, so that no modulus hides to which side it goes. The inequalities are
those of docs/proof.md, section 7.
"""

import itertools
from collections.abc import Sequence

import numpy as np

from drakesep.analysis.bounds.grid import Grid
from drakesep.analysis.bounds.intervals import (
    HALF_PI,
    TINY,
    Interval,
    down,
    up,
)
from drakesep.analysis.bounds.jets import Jet
from drakesep.analysis.bounds.options import Options, beside, option
from drakesep.systems.arrays import Array


def of_magnitude(x: Jet, lengths: Array) -> Options:
    """Return the integral of a magnitude over pieces of some lengths."""
    return option(
        over_time(x.value.abs(), lengths),
        over_time(x.slopes * sign_of(x.value), lengths),
    )


def of_square(x: Jet, lengths: Array) -> Options:
    """Return the integral of a square over pieces of some lengths."""
    return option(
        over_time(x.value.square(), lengths),
        over_time(x.slopes * x.value * 2.0, lengths),
    )


def by_sign(x: Jet, grid: Grid, coast: int) -> Options:
    """Return options of the integral of a magnitude: (20).

    Args:
        x: the signal, in all pieces.
        grid: of time.
        coast: the piece from which on the signal is looked at as a whole.
    """
    late = x[..., coast:]
    lengths, whole = grid.lengths[coast:], _length(grid, coast)
    value, slopes = over_time(late.value, lengths), over_time(late.slopes, lengths)
    spread, by = _spread(late)
    return _after(
        of_magnitude(x[..., :coast], grid.lengths[:coast]),
        [
            option(value, slopes),
            option(-value, -slopes),
            option(spread * whole, by * whole),
        ],
    )


def by_mean(
    x: Jet, change: Jet, grid: Grid, coast: int, levels: Sequence[float]
) -> Options:
    """Return options of the integral of a square: (21).

    Args:
        x: the signal, in all pieces.
        change: its derivative by time, in the same from the coast on.
        grid: of time.
        coast: the piece from which on the signal is looked at as a whole.
        levels: between which its mean lies.
    """
    mean, by = _mean(x[..., coast:], grid, coast)
    whole = _length(grid, coast)
    wave = (whole * (HALF_PI * 2.0).inverse()).square()
    moved = of_square(change[..., coast:], grid.lengths[coast:])
    ends = [-np.inf, *levels, np.inf]
    choices = []
    for low, high in itertools.pairwise(ends):
        value, slope = _tangent(mean, low, high)
        choices.append(
            option(
                value * whole + moved.value * wave,
                by * slope * whole + moved.slopes * wave,
            )
        )
    return _after(of_square(x[..., :coast], grid.lengths[:coast]), choices)


def mean(x: Jet, grid: Grid, coast: int) -> Interval:
    """Return the mean (boxes, 1) of a signal from a piece on."""
    return _mean(x[..., coast:], grid, coast)[0]


def _mean(late: Jet, grid: Grid, coast: int) -> tuple[Interval, Interval]:
    lengths, over = grid.lengths[coast:], _length(grid, coast).inverse()
    return (
        over_time(late.value, lengths) * over,
        over_time(late.slopes, lengths) * over,
    )


def _tangent(x: Interval, low: float, high: float) -> tuple[Interval, Interval]:
    """Return the largest 2 l x - l^2 over l from low to high, and its derivative.

    It is x^2 where x is among these l, and the nearest tangent of it elsewhere.
    """
    l_lo, l_hi = np.clip(x.lo, low, high), np.clip(x.hi, low, high)
    ends = l_lo * (2.0 * x.lo - l_lo), l_hi * (2.0 * x.hi - l_hi)
    least = np.minimum(*ends)
    if low <= 0.0 <= high:  # convex, and least at zero
        least = np.where((x.lo < 0.0) & (x.hi > 0.0), np.minimum(least, 0.0), least)
    value = Interval(down(least, None, 2.0), up(np.maximum(*ends), None, 2.0))
    return value, Interval(2.0 * l_lo, 2.0 * l_hi)


def _after(before: Options, choices: Sequence[Options]) -> Options:
    """Return choices, each with what is integrated before."""
    return beside(
        [
            option(before.value + part.value, before.slopes + part.slopes)
            for part in choices
        ]
    )


def _spread(x: Jet) -> tuple[Interval, Interval]:
    """Return by how much a signal changes at most, and the derivatives of that."""
    least = down(x.value.lo.max(-1, keepdims=True) - x.value.hi.min(-1, keepdims=True))
    most = _width(x.value)
    apart = _width(x.slopes)
    return Interval(np.maximum(least, 0.0), most), Interval(-apart, apart)


def _width(x: Interval) -> Array:
    return up(x.hi.max(-1, keepdims=True) - x.lo.min(-1, keepdims=True))


def _length(grid: Grid, coast: int) -> Interval:
    return Interval(grid.times[-1]) - Interval(grid.times[coast])


def sign_of(x: Interval) -> Interval:
    """Return signs; where they are not known, -1 to 1."""
    return Interval(np.where(x.lo > 0.0, 1.0, -1.0), np.where(x.hi < 0.0, -1.0, 1.0))


def over_time(x: Interval, lengths: Array) -> Interval:
    """Return the sums over pieces of time, times their lengths, which are rounded."""
    lo, hi = x.lo * lengths, x.hi * lengths
    size = np.maximum(np.abs(lo), np.abs(hi)).sum(-1, keepdims=True)
    wide = size * ((len(lengths) + 6) * 2.0**-52) + TINY * len(lengths)
    return Interval(lo.sum(-1, keepdims=True) - wide, hi.sum(-1, keepdims=True) + wide)
