"""What bounds are proven of: signals of the enclosed motion, and what is made of them.

Each comes with its derivatives, over boxes and pieces of time: section 6 of
docs/proof.md. What is made of them is the largest of some options: section 7.
"""

import dataclasses
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from drakesep.analysis.bounds.grid import Grid
from drakesep.analysis.bounds.integrals import (
    by_mean,
    by_sign,
    mean,
    of_magnitude,
    of_square,
    sign_of,
)
from drakesep.analysis.bounds.intervals import Interval, arcsin, arctan2, total
from drakesep.analysis.bounds.jets import Affine, Jet, combined, turned
from drakesep.analysis.bounds.motion import Enclosure
from drakesep.analysis.bounds.options import Options, beside, option, summed
from drakesep.analysis.bounds.rotations import (
    Matrix,
    entry,
    matrix,
    product,
    transposed,
)
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
    until: Literal["last", "separation"] = "last"
    """What it ends with."""
    blocks: tuple[int, ...] = ()
    """Of a sum of peaks: pieces, counted from the first, at which blocks of time begin,
    and the end of the last block."""
    moment: bool = False
    """Whether it looks at one moment alone, that with which it begins."""
    coast: int | None = None
    """Of an integral: the piece from which on its signal is looked at as a whole, by
    its sign or by its mean; None: nowhere."""
    levels: tuple[float, ...] = ()
    """Of an integral of a square: between them its signal's mean lies, from there."""
    window: tuple[int, int] | None = None
    """First and last piece of what is the least over a window, which is at most what it
    is in the one that is looked at; None: it is what is looked at."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """What is bounded from above: a sum of terms of one kind."""

    kind: Kind
    terms: tuple[Term, ...]

    @property
    def attitudes(self) -> bool:
        """Whether it takes orientations in W."""
        return any(term.signal.field == "angle" for term in self.terms)

    @property
    def may_coast(self) -> bool:
        """Whether all of it can be looked at as a whole after the push."""
        return self.kind != "peak" and all(
            term.signal.law == "component"
            and term.signal.field in ("rate", "relative_rate")
            for term in self.terms
        )


def options(enclosure: Enclosure, grid: Grid, quantity: Quantity) -> Options:
    """Return the options of a quantity.

    Of one peak each piece of time with each sign; of a sum of peaks each choice of
    signs and blocks of time, with the largest in these; of integrals each choice of
    signs, or of cells in which means lie.
    """
    terms = quantity.terms
    signals = [_signal(enclosure, term) for term in terms]
    if quantity.kind != "peak":
        return summed(
            [
                _integral(enclosure, grid, quantity.kind, term, x)
                for term, x in zip(terms, signals, strict=True)
            ]
        )
    if len(terms) == 1:
        return beside([_with_sign(signals[0], sign) for sign in terms[0].signs])
    return summed(
        [
            beside(
                [
                    _largest(_with_sign(x[..., start:stop], sign))
                    for sign in term.signs
                    for start, stop in itertools.pairwise(term.blocks)
                ]
            )
            for x, term in zip(signals, terms, strict=True)
        ]
    )


def least(
    enclosure: Enclosure, grid: Grid, quantity: Quantity, found: Options
) -> Array:
    """Return what a quantity surely is (boxes,) over all of boxes, from its options.

    Of one peak it is so if the whole of its window is looked at.
    """
    window = quantity.terms[0].window
    if window is not None:
        [term] = quantity.terms
        every = dataclasses.replace(term, first=window[0], last=window[1])
        value = options(enclosure, grid, Quantity(kind="peak", terms=(every,))).value
        by_sign = value.lo.reshape(len(value.lo), len(term.signs), -1)
        return np.asarray(by_sign.max(1).min(-1))
    if quantity.kind == "peak":
        return np.asarray(found.value.lo.max(-1))
    plain = [dataclasses.replace(term, coast=None) for term in quantity.terms]
    whole = dataclasses.replace(quantity, terms=tuple(plain))
    return np.asarray(options(enclosure, grid, whole).value.lo[..., 0])


def means(enclosure: Enclosure, grid: Grid, term: Term, coast: int) -> Interval:
    """Return the mean (boxes, 1) of a term's signal from a piece on."""
    return mean(_signal(enclosure, term), grid, coast)


def _integral(
    enclosure: Enclosure, grid: Grid, kind: Kind, term: Term, x: Jet
) -> Options:
    """Return the options of an integral over all pieces."""
    if kind == "integral_of_magnitude":
        if term.coast is None:
            return of_magnitude(x, grid.lengths)
        return by_sign(x, grid, term.coast)
    if term.coast is None:
        return of_square(x, grid.lengths)
    change = _change(enclosure, term)
    return by_mean(x, change, grid, term.coast, term.levels)


def _signal(enclosure: Enclosure, term: Term) -> Jet:
    """Return a signal over the pieces that a term looks at."""
    signal = term.signal
    field = _field(enclosure, signal)
    if signal.field == "angle" and not term.moment:
        field = [_followed(x) for x in field]
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
            across = turned(_across(constants), vector)
            return total([x.squared() for x in across])


def _change(enclosure: Enclosure, term: Term) -> Jet:
    """Return the derivative by time of a component of a rate, without springs."""
    signal = term.signal
    assert signal.law == "component"
    if signal.field == "rate":
        pair = enclosure.problem.pairs[signal.pair]
        return enclosure.accelerations()[pair.B][signal.component]
    assert signal.field == "relative_rate"
    return enclosure.relative_acceleration(signal.pair)[signal.component]


def _across(vector: Sequence[Affine]) -> Matrix:
    """Return the matrix that takes the part of a vector across a unit vector."""
    v = [x.value for x in vector]
    exact = all(float(x.lo) == float(x.hi) for x in v)

    def of(i: int, j: int) -> Affine:
        if exact:
            return Affine(Interval(float(i == j) - float(v[i].lo) * float(v[j].lo)))
        return Affine(Interval(float(i == j)) - v[i] * v[j])

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
    body = problem.bodies[problem.pairs[j].B]
    start = product(transposed(matrix(body.orientation)), enclosure.attitude(body))
    P = enclosure.state.P[j]
    columns = [[P[k][c] for k in range(3)] for c in range(3)]

    def M(i: int, c: int) -> Jet:
        return combined(start[i], columns[c]) + start[i][c]

    return [
        _angle_of(M(2, 1), M(2, 2)),
        _less_arcsine(M(2, 0)),
        _angle_of(M(1, 0), M(0, 0)),
    ]


def _followed(angle: Jet) -> Jet:
    """Return an angle that goes on beyond half a turn: NaN once it may have left.

    It is known as long as it has been within a right angle since the start.
    """
    lost = np.isnan(np.cumsum(angle.lo[0], -1))
    return Jet(np.where(lost, np.nan, angle.lo), np.where(lost, np.nan, angle.hi))


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


def _with_sign(x: Jet, sign: int) -> Options:
    if sign == 1:
        return option(x.value, x.slopes)
    if sign == -1:
        return option(-x.value, -x.slopes)
    return option(-x.value.abs(), -(x.slopes * sign_of(x.value)))


def _largest(peak: Options) -> Options:
    """Return the largest option, whichever that may be, as one."""
    value, slopes = peak.value, peak.slopes
    low = value.lo.max(-1, keepdims=True)
    active = value.hi >= low
    return option(
        Interval(low, value.hi.max(-1, keepdims=True)),
        Interval(
            np.where(active, slopes.lo, np.inf).min(-1, keepdims=True),
            np.where(active, slopes.hi, -np.inf).max(-1, keepdims=True),
        ),
    )


def root(bound: float) -> float:
    """Return a root, rounded upward."""
    return math.nextafter(math.sqrt(max(bound, 0.0)), math.inf)
