"""What is claimed of a motion: its signals, and the options that a quantity is of."""

import itertools
import math
from collections.abc import Callable, Sequence

from flint import arb

from .certificate import Claim, Term
from .intervals import (
    NONE,
    ONE,
    ZERO,
    Interval,
    Jet,
    Matrix,
    NotVerified,
    Vector,
    applied,
    dot,
    hull,
    inverse,
    jet_minus,
    jet_negative,
    jet_square,
    jet_sum,
    magnitude,
    minus,
    plus,
    product,
    scaled,
    square,
    times,
    transposed,
)
from .motion import Motion
from .rotations import composed, constant, rotation


Alternatives = list[list[Jet]]  # of a term: options by choice


def choices(claim: Claim) -> int:
    """Return how many choices of options there are (section 7)."""
    return math.prod(_count(claim, term) for term in claim.terms)


def _count(claim: Claim, term: Term) -> int:
    if claim.kind == "peak":
        blocks = term.blocks if len(claim.terms) > 1 else [term.pieces]
        return len(term.signs) * len(blocks)
    if term.coast is None:
        return 1
    return 3 if claim.kind == "integral_of_magnitude" else len(term.levels) + 1


def alternatives(claim: Claim, motion: Motion) -> list[Alternatives]:
    """Return the options of each term, by its choices."""
    if claim.kind != "peak":
        return [
            [[jet] for jet in _integrals(claim, term, motion)] for term in claim.terms
        ]
    peaks = [_peaks(term, motion) for term in claim.terms]
    if len(peaks) == 1:
        return peaks
    return [
        [[_largest(jets[b.start : b.stop])] for jets in peak for b in term.blocks]
        for term, peak in zip(claim.terms, peaks, strict=True)
    ]


def options(of_terms: list[Alternatives], chosen: Sequence[int]) -> list[Jet]:
    """Return options of some choices; the quantity is at most the largest of all."""
    if len(of_terms) == 1:
        return [jet for c in chosen for jet in of_terms[0][c]]
    every = itertools.product(*(range(len(of_term)) for of_term in of_terms))
    wanted = set(chosen)
    return [
        jet_sum(*(of_term[i][0] for of_term, i in zip(of_terms, choice, strict=True)))
        for c, choice in enumerate(every)
        if c in wanted
    ]


def enclosed(claim: Claim, motion: Motion) -> Interval:
    """Enclose the quantity itself, between the largest of ends."""
    if claim.kind != "peak":
        return jet_sum(*(_integral(claim, t, motion, t.pieces) for t in claim.terms))[0]
    of_terms = alternatives(claim, motion)
    ends = [jet[0] for jet in options(of_terms, range(choices(claim)))]
    low, high = ends[0]
    for end in ends[1:]:
        low, high = low.max(end[0]), high.max(end[1])
    return low, high


def _peaks(term: Term, motion: Motion) -> list[list[Jet]]:
    """Return, for each sign, the signal with it on each piece."""
    vectors = _signal(term, motion)
    jets = [_of_law(term, vectors[n], motion) for n in term.pieces]
    with_sign: dict[int, Callable[[Jet], Jet]] = {
        1: lambda jet: jet,
        -1: jet_negative,
        0: lambda jet: jet_negative(_magnitude(jet)),
    }
    return [[with_sign[sign](jet) for jet in jets] for sign in term.signs]


def _largest(jets: list[Jet]) -> Jet:
    """Return the largest; its derivatives are of those that can be it (Danskin)."""
    low, high = jets[0][0]
    for jet in jets[1:]:
        low, high = low.max(jet[0][0]), high.max(jet[0][1])
    first, *others = (jet for jet in jets if not jet[0][1] < low)
    slopes = first[1:]
    for jet in others:
        slopes = [hull(a, b) for a, b in zip(slopes, jet[1:], strict=True)]
    return [(low, high), *slopes]


def _integral(claim: Claim, term: Term, motion: Motion, pieces: range) -> Jet:
    """Return the integral over some pieces, of what the claim is of."""
    vectors = _signal(term, motion)
    of_piece = _magnitude if claim.kind == "integral_of_magnitude" else jet_square
    jets = [of_piece(_of_law(term, vectors[n], motion)) for n in pieces]
    return _over(jets, pieces, motion)


def _over(jets: list[Jet], pieces: range, motion: Motion) -> Jet:
    whole = motion.constants.zero
    for n, jet in zip(pieces, jets, strict=True):
        h = motion.lengths[n]
        whole = jet_sum(whole, [(low * h, high * h) for low, high in jet])
    return whole


def _integrals(claim: Claim, term: Term, motion: Motion) -> list[Jet]:
    """Return the options of an integral, by choices."""
    if term.coast is None:
        return [_integral(claim, term, motion, term.pieces)]
    if term.coast < motion.setting.push:
        raise NotVerified(f"from piece {term.coast} on springs may push")
    before = _integral(claim, term, motion, range(term.coast))
    late = range(term.coast, motion.problem.pieces)
    vectors = _signal(term, motion)
    jets = [_of_law(term, vectors[n], motion) for n in late]
    start, end = motion.problem.grid[term.coast], motion.problem.grid[-1]
    length = arb(end) - arb(start)
    whole = _over(jets, late, motion)
    if claim.kind == "integral_of_magnitude":
        parts = [whole, jet_negative(whole), _by(length, _spread(jets))]  # (20)
    else:
        mean = _by(1 / length, whole)
        changes = _change(term, motion)
        squares = [jet_square(changes[n]) for n in late]
        moved = _by((length / arb.pi()) ** 2, _over(squares, late, motion))
        ends = [None, *term.levels, None]
        parts = [
            jet_sum(_by(length, _tangent(mean, *cell)), moved)  # (21)
            for cell in itertools.pairwise(ends)
        ]
    return [jet_sum(before, part) for part in parts]


def _by(factor: arb, jet: Jet) -> Jet:
    """Return a jet times a positive number."""
    return [(low * factor, high * factor) for low, high in jet]


def _spread(jets: list[Jet]) -> Jet:
    """Return by how much a signal changes at most; its derivatives are of any two."""
    low, high = jets[0][0]
    for jet in jets[1:]:
        low, high = low.min(jet[0][0]), high.max(jet[0][1])
    slopes = jets[0][1:]
    for jet in jets[1:]:
        slopes = [hull(a, b) for a, b in zip(slopes, jet[1:], strict=True)]
    return [(ZERO, high - low), *((a - b, b - a) for a, b in slopes)]


def _tangent(x: Jet, low: float | None, high: float | None) -> Jet:
    """Return the largest 2 l x - l^2 over l from low to high (None: no end)."""

    def nearest(y: arb) -> arb:
        y = y if low is None else y.max(arb(low))
        return y if high is None else y.min(arb(high))

    l_low, l_high = (nearest(end) for end in x[0])
    ends = [
        2 * near * end - near * near
        for near, end in zip((l_low, l_high), x[0], strict=True)
    ]
    least = ends[0].min(ends[1])
    if not (x[0][0] >= ZERO or x[0][1] <= ZERO):
        least = least.min(ZERO)
    return [(least, ends[0].max(ends[1])), *times((2 * l_low, 2 * l_high), x[1:])]


def _change(term: Term, motion: Motion) -> list[Jet]:
    """Return the derivative of a component of a rate by time, on each piece."""
    assert term.component is not None
    pair = motion.problem.pairs[term.pair]
    if term.field == "rate":
        vectors = motion.change_of_rate(pair.leaver)
    else:
        vectors = motion.change_of_relative_rate(term.pair)
    return [vector[term.component] for vector in vectors]


def _magnitude(x: Jet) -> Jet:
    low, high = x[0]
    if low >= ZERO:
        return x
    if high <= ZERO:
        return jet_negative(x)
    sign = (arb(-1), arb(1))
    return [(ZERO, magnitude(x[0])), *times(sign, x[1:])]


def _signal(term: Term, motion: Motion) -> list[Vector]:
    if term.field == "rate":
        return motion.kinematics.w[motion.problem.pairs[term.pair].leaver]
    if term.field == "relative_rate":
        return motion.kinematics.relative[term.pair]
    if term.field == "relative_velocity":
        return motion.velocity_of_cg(term.pair)
    if term.field == "relative_position":
        return motion.way_of_cg(term.pair)
    wanted = range(3) if term.component is None else [term.component]
    return _angles(motion.problem.pairs[term.pair].leaver, motion, wanted)


def _of_law(term: Term, x: Vector, motion: Motion) -> Jet:
    if term.law == "component":
        assert term.component is not None
        return x[term.component]
    if term.law == "length_squared":
        return jet_sum(*(jet_square(jet) for jet in x))
    assert term.vector is not None
    if term.law == "along":
        return dot(motion.constants.constant(term.vector), x)
    across = scaled(_across(term.vector), x)
    return jet_sum(*(jet_square(jet) for jet in across))


def _across(v: list[Interval]) -> Matrix:
    """Return 1 - v v^T: where an axis is exact, the part along it is left out."""
    return [
        [minus(ONE if a == b else NONE, product(v[a], v[b])) for b in range(3)]
        for a in range(3)
    ]


def _angles(b: int, motion: Motion, wanted: Sequence[int]) -> list[Vector]:
    """Return roll, pitch and yaw on each piece; zero for those that nobody wants.

    Of these one may be beyond 90 deg.
    """
    body, constants = motion.problem.bodies[b], motion.constants
    attitude = rotation(constants.vector(motion.problem.attitude))
    meant = constant(transposed(body.R_S), constants.zero)
    fixed = composed(meant, composed(attitude, constants.orientation(body)))
    out = []
    for P in motion.orientation(b):
        columns = []
        for c, column in enumerate(transposed(P)):
            column[c] = [plus(ONE, column[c][0]), *column[c][1:]]
            columns.append(applied(fixed, column))
        M = transposed(columns)
        angles = [constants.zero] * 3
        for c in wanted:
            angles[c] = _ANGLES[c](M)
        out.append(angles)
    return out


def _direction(y: Jet, x: Jet) -> Jet:
    """Return atan2(y, x) for x > 0."""
    if not x[0][0] > ZERO:
        raise NotVerified("an angle may be beyond 90 deg")
    low_x, high_x = x[0]
    low, high = y[0]
    value = (
        (low / (high_x if low >= ZERO else low_x)).atan(),
        (high / (high_x if high <= ZERO else low_x)).atan(),
    )
    over = inverse(plus(square(x[0]), square(y[0])))
    turned = jet_minus(times(x[0], y[1:]), times(y[0], x[1:]))
    return [value, *times(over, turned)]


def _arcsine(x: Jet) -> Jet:
    low, high = x[0]
    if not (low > -1 and high < 1):
        raise NotVerified("an angle of pitch may be 90 deg")
    cosine = square(x[0])
    slope = inverse(((1 - cosine[1]).sqrt(), (1 - cosine[0]).sqrt()))
    return [(low.asin(), high.asin()), *times(slope, x[1:])]


_ANGLES: Sequence[Callable[[list[Vector]], Jet]] = (
    lambda M: _direction(M[2][1], M[2][2]),
    lambda M: jet_negative(_arcsine(M[2][0])),
    lambda M: _direction(M[1][0], M[0][0]),
)
