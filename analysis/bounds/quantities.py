"""What bounds are proven of: signals of the enclosed motion, and what is made of them.

Each comes with its derivatives, over boxes and pieces of time: section 6 of
docs/proof.md.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from drakesep.analysis.bounds.box import Matrix, entry, matrix, product, transposed
from drakesep.analysis.bounds.intervals import TINY, Interval, arcsin, arctan2, total
from drakesep.analysis.bounds.jets import Jet, combined, rotated
from drakesep.analysis.bounds.motion import Enclosure, Grid
from drakesep.systems.arrays import Array
from drakesep.systems.checks import Vector3


Field: TypeAlias = Literal[
    "rate", "relative_rate", "relative_velocity", "relative_position", "angle"
]
Law: TypeAlias = Literal["component", "along", "length_squared", "across_squared"]
Kind: TypeAlias = Literal["peak", "integral_of_magnitude", "integral_of_square"]
LESS_MAGNITUDE = 0
"""Among signs: less the magnitude."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """A number at each time of the motion of a pair."""

    field: Field
    pair: int
    law: Law
    component: int = 0
    """Of the field, where the law takes one."""
    vector: Vector3 = (1.0, 0.0, 0.0)
    """Of the law, where it takes one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """What is made of a signal."""

    signal: Signal
    signs: tuple[int, ...]
    """Of a peak: 1 the largest value, -1 less the smallest, both the largest
    magnitude; 0 less the smallest magnitude."""
    first: int
    """First piece of time that is looked at."""
    last: int
    """Last one."""
    since: Literal["first", "separation"] = "first"
    """What it begins with: its first piece, or separation, somewhere in its pieces."""
    blocks: tuple[int, ...] = ()
    """Of a sum of peaks: pieces, counted from the first, at which blocks of time begin,
    and the end of the last block."""
    moment: bool = False
    """Whether it looks at one moment alone, that with which it begins."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """What is bounded from above: a sum of terms of one kind."""

    kind: Kind
    terms: tuple[Term, ...]

    @property
    def attitudes(self) -> bool:
        """Whether it takes orientations in W."""
        return any(term.signal.field == "angle" for term in self.terms)


class Options(NamedTuple):
    """Numbers of which a quantity is the largest, and their derivatives."""

    value: Interval
    """(boxes, options)."""
    slopes: Interval
    """(parameters, boxes, options)."""
    choice: Array
    """(options,) to which choice of signs each belongs, from 0."""


def options(enclosure: Enclosure, grid: Grid, quantity: Quantity) -> Options:
    """Return the options of a quantity.

    Of one peak each piece of time with each sign; of a sum of peaks each choice of
    signs and blocks of time, with the largest in these; of integrals the quantity
    itself.
    """
    signals = [_signal(enclosure, term) for term in quantity.terms]
    if quantity.kind != "peak":
        return _summed([_integral(x, grid, quantity.kind) for x in signals])
    if len(signals) == 1:
        return _beside(
            [_with_sign(signals[0], sign) for sign in quantity.terms[0].signs]
        )
    each = [
        [
            _largest(_with_sign(x[..., start:stop], sign))
            for sign in term.signs
            for start, stop in itertools.pairwise(term.blocks)
        ]
        for x, term in zip(signals, quantity.terms, strict=True)
    ]
    return _beside([_summed(chosen) for chosen in itertools.product(*each)])


def _signal(enclosure: Enclosure, term: Term) -> Jet:
    """Return a signal over the pieces that a term looks at."""
    signal = term.signal
    field = _field(enclosure, signal)
    vector = [x[..., term.first : term.last + 1] for x in field]
    constants = [entry(x) for x in signal.vector]
    match signal.law:
        case "component":
            return vector[signal.component]
        case "along":
            return combined(constants, vector)
        case "length_squared":
            return total([x.squared() for x in vector])
        case "across_squared":
            across = rotated(_across(constants), vector)
            return total([x.squared() for x in across])


def _across(v: Sequence[Interval]) -> Matrix:
    """Return the matrix that takes the part of a vector across a unit vector."""
    exact = all(float(x.lo) == float(x.hi) for x in v)

    def of(i: int, j: int) -> Interval:
        if exact:
            return Interval(float(i == j) - float(v[i].lo) * float(v[j].lo))
        return Interval(float(i == j)) - v[i] * v[j]

    return [[of(i, j) for j in range(3)] for i in range(3)]


def _field(enclosure: Enclosure, signal: Signal) -> list[Jet]:
    state, j = enclosure.state, signal.pair
    pair = enclosure.problem.pairs[j]
    match signal.field:
        case "rate":
            return enclosure.rates(state)[pair.B]
        case "relative_rate":
            return enclosure.relative_rate(state, enclosure.changes(state), j)
        case "relative_velocity":
            return enclosure.velocity(state, j)
        case "relative_position":
            return enclosure.displacement(state, j)
        case "angle":
            return _angles(enclosure, j)


def _angles(enclosure: Enclosure, j: int) -> list[Jet]:
    """Return roll, pitch and yaw from the mated attitude in the nominal stack."""
    problem = enclosure.problem
    R_SB = matrix(problem.bodies[problem.pairs[j].B].orientation)
    start = product(transposed(R_SB), product(matrix(problem.attitude), R_SB))
    P = enclosure.state.P[j]
    columns = [[P[k][c] for k in range(3)] for c in range(3)]

    def M(i: int, c: int) -> Jet:
        moved = combined(start[i], columns[c])
        return moved + start[i][c]

    return [
        _angle_of(M(2, 1), M(2, 2)),
        _less_arcsine(M(2, 0)),
        _angle_of(M(1, 0), M(0, 0)),
    ]


def _angle_of(y: Jet, x: Jet) -> Jet:
    """Return atan2(y, x)."""
    value = arctan2(y.value, x.value)
    over = (x.value.square() + y.value.square()).inverse()
    slopes = (y.slopes * x.value - x.slopes * y.value) * over
    return _jet(value, slopes)


def _less_arcsine(x: Jet) -> Jet:
    """Return -arcsin x."""
    cosine = (1.0 - x.value.square()).sqrt()
    return _jet(-arcsin(x.value), -(x.slopes * cosine.inverse()))


def _jet(value: Interval, slopes: Interval) -> Jet:
    return Jet(
        np.concatenate([value.lo[None], slopes.lo]),
        np.concatenate([value.hi[None], slopes.hi]),
    )


def _beside(parts: Sequence[Options]) -> Options:
    """Return options that there are together."""
    counts = [part.value.lo.shape[-1] for part in parts]
    return Options(
        Interval(*(_side_by_side([part.value for part in parts]))),
        Interval(*(_side_by_side([part.slopes for part in parts]))),
        np.repeat(np.arange(len(parts)), counts),
    )


def _side_by_side(parts: Sequence[Interval]) -> tuple[Array, Array]:
    lo, hi = ([getattr(x, end) for x in parts] for end in ("lo", "hi"))
    return np.concatenate(lo, -1), np.concatenate(hi, -1)


def _with_sign(x: Jet, sign: int) -> Options:
    if sign == 1:
        return _options(x.value, x.slopes)
    if sign == -1:
        return _options(-x.value, -x.slopes)
    return _options(-x.value.abs(), -(x.slopes * _sign(x.value)))


def _options(value: Interval, slopes: Interval) -> Options:
    """Return options of one choice of signs."""
    return Options(value, slopes, np.zeros(value.lo.shape[-1], dtype=int))


def _sign(x: Interval) -> Interval:
    return Interval(np.where(x.lo > 0.0, 1.0, -1.0), np.where(x.hi < 0.0, -1.0, 1.0))


def _largest(peak: Options) -> Options:
    """Return the largest option, whichever that may be, as one."""
    value, slopes, _ = peak
    least = value.lo.max(-1, keepdims=True)
    active = value.hi >= least
    return _options(
        Interval(least, value.hi.max(-1, keepdims=True)),
        Interval(
            np.where(active, slopes.lo, np.inf).min(-1, keepdims=True),
            np.where(active, slopes.hi, -np.inf).max(-1, keepdims=True),
        ),
    )


def _summed(parts: Sequence[Options]) -> Options:
    return _options(
        total([part.value for part in parts]), total([part.slopes for part in parts])
    )


def _integral(x: Jet, grid: Grid, kind: Kind) -> Options:
    """Return an integral over all pieces."""
    if kind == "integral_of_square":
        value, slopes = x.value.square(), x.slopes * x.value * 2.0
    else:
        value, slopes = x.value.abs(), x.slopes * _sign(x.value)
    return _options(_over_time(value, grid), _over_time(slopes, grid))


def _over_time(x: Interval, grid: Grid) -> Interval:
    """Return the sum over pieces of time."""
    lo, hi = x.lo * grid.lengths, x.hi * grid.lengths
    size = np.maximum(np.abs(lo), np.abs(hi)).sum(-1, keepdims=True)
    wide = size * ((len(grid.lengths) + 6) * 2.0**-52) + TINY * len(grid.lengths)
    return Interval(lo.sum(-1, keepdims=True) - wide, hi.sum(-1, keepdims=True) + wide)


def root(bound: float) -> float:
    """Return a root, rounded upward."""
    return math.nextafter(math.sqrt(max(bound, 0.0)), math.inf)
