"""What is claimed of a motion: its signals, and the options that a quantity is of."""

import itertools
import math
from collections.abc import Sequence

from flint import arb

from .certificate import Claim, Term
from .intervals import (
    ONE,
    ZERO,
    Jet,
    NotVerified,
    Vector,
    dot,
    hull,
    inverse,
    jet_minus,
    jet_negative,
    jet_product,
    jet_square,
    jet_sum,
    magnitude,
    plus,
    product,
    scaled,
    square,
    times,
    transposed,
)
from .motion import Motion


def choices(claim: Claim) -> int:
    """Return how many choices of options there are (section 7)."""
    if claim.kind != "peak":
        return 1
    if len(claim.terms) == 1:
        return len(claim.terms[0].signs)
    return math.prod(len(t.signs) * len(t.blocks) for t in claim.terms)


def options(claim: Claim, motion: Motion, chosen: Sequence[int]) -> list[Jet]:
    """Return the options of some choices: the quantity is the largest of all."""
    if claim.kind != "peak":
        return [jet_sum(*(_integral(claim, term, motion) for term in claim.terms))]
    peaks = [_peaks(term, motion) for term in claim.terms]
    if len(peaks) == 1:
        return [jet for c in chosen for jet in peaks[0][c]]
    of_terms = [
        [_largest(jets[b.start : b.stop]) for jets in peak for b in term.blocks]
        for term, peak in zip(claim.terms, peaks, strict=True)
    ]
    every = itertools.product(*(range(len(of_term)) for of_term in of_terms))
    wanted = set(chosen)
    return [
        jet_sum(*(of_term[i] for of_term, i in zip(of_terms, choice, strict=True)))
        for c, choice in enumerate(every)
        if c in wanted
    ]


def _peaks(term: Term, motion: Motion) -> list[list[Jet]]:
    """Return, for each sign, the signal with it on each piece."""
    vectors = _signal(term, motion)
    jets = [_of_law(term, vectors[n], motion) for n in term.pieces]
    return [[_with_sign(sign, jet) for jet in jets] for sign in term.signs]


def _with_sign(sign: int, jet: Jet) -> Jet:
    """Return a jet, less it, or for the sign 0 less its magnitude."""
    if sign == 0:
        return jet_negative(_magnitude(jet))
    return jet if sign > 0 else jet_negative(jet)


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


def _integral(claim: Claim, term: Term, motion: Motion) -> Jet:
    vectors = _signal(term, motion)
    of_piece = _magnitude if claim.kind == "integral_of_magnitude" else jet_square
    whole = motion.constants.zero
    for n in term.pieces:
        h = motion.lengths[n]
        jet = of_piece(_of_law(term, vectors[n], motion))
        whole = jet_sum(whole, [(low * h, high * h) for low, high in jet])
    return whole


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
    return _angles(motion.problem.pairs[term.pair].leaver, motion)


def _of_law(term: Term, x: Vector, motion: Motion) -> Jet:
    if term.law == "component":
        assert term.component is not None
        return x[term.component]
    if term.law == "length_squared":
        return jet_sum(*(jet_square(jet) for jet in x))
    assert term.vector is not None
    vector = motion.constants.constant(term.vector)
    along = dot(vector, x)
    if term.law == "along":
        return along
    across = [
        jet_minus(a, jet_product(along, v)) for a, v in zip(x, vector, strict=True)
    ]
    return jet_sum(*(jet_square(jet) for jet in across))


def _angles(b: int, motion: Motion) -> list[Vector]:
    """Return roll, pitch and yaw on each piece."""
    body = motion.problem.bodies[b]
    in_W = [scaled(motion.problem.R_W, [[x] for x in c]) for c in transposed(body.R_S)]
    in_S = [scaled(transposed(body.R_S), column) for column in in_W]
    fixed = transposed([[jet[0] for jet in column] for column in in_S])
    out = []
    for P in motion.orientation(b):
        columns = []
        for c, column in enumerate(transposed(P)):
            column[c] = [plus(ONE, column[c][0]), *column[c][1:]]
            columns.append(scaled(fixed, column))
        M = transposed(columns)
        out.append(
            [
                _direction(M[2][1], M[2][2]),
                jet_negative(_arcsine(M[2][0])),
                _direction(M[1][0], M[0][0]),
            ]
        )
    return out


def _direction(y: Jet, x: Jet) -> Jet:
    """Return atan2(y, x) for x > 0."""
    if not x[0][0] > ZERO:
        raise NotVerified("an angle may be beyond 90 deg")
    low_x, high_x = x[0]
    low, high = y[0]
    value = (
        (low / (high_x if low >= ZERO else low_x)).atan(),
        (high / (low_x if high >= ZERO else high_x)).atan(),
    )
    over = inverse(plus(square(x[0]), square(y[0])))
    by_y = times(product(x[0], over), y[1:])
    by_x = times(product(y[0], over), x[1:])
    return [value, *jet_minus(by_y, by_x)]


def _arcsine(x: Jet) -> Jet:
    low, high = x[0]
    if not (low > -1 and high < 1):
        raise NotVerified("an angle of pitch may be 90 deg")
    cosine = square(x[0])
    slope = inverse(((1 - cosine[1]).sqrt(), (1 - cosine[0]).sqrt()))
    return [(low.asin(), high.asin()), *times(slope, x[1:])]
