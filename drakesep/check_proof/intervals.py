"""Intervals with Arb balls for ends, jets of them, and vectors of jets.

An interval is a pair of Arb balls, its ends. The ends are those of interval arithmetic
in real numbers, and each ball encloses the rounding of its end: nothing is rounded
outward by hand. A jet is a list of intervals: a value, then its derivatives by those
parameters that vary in a box.
"""

from collections.abc import Sequence
from typing import Any

from flint import arb, ctx


ctx.prec = 64  # bits: rounding is 1e-19, certificates leave 1e-6

Interval = tuple[arb, arb]
Jet = list[Interval]
Vector = list[Jet]
Matrix = list[list[Interval]]
Rows = list[Vector]  # of a matrix of jets

ZERO = arb(0)
NONE: Interval = (ZERO, ZERO)  # zero exactly: told by identity, to skip it
ONE: Interval = (arb(1), arb(1))
MINUS: Interval = (arb(-1), arb(-1))


class NotVerified(Exception):
    """What the certificate says could not be verified."""


def point(x: float | arb) -> Interval:
    """Return an interval of one number."""
    ball = arb(x)
    return ball, ball


def plus(a: Interval, b: Interval) -> Interval:
    """Return a + b."""
    if a is NONE:
        return b
    return a if b is NONE else (a[0] + b[0], a[1] + b[1])


def negative(a: Interval) -> Interval:
    """Return -a."""
    return a if a is NONE else (-a[1], -a[0])


def minus(a: Interval, b: Interval) -> Interval:
    """Return a - b."""
    if b is NONE:
        return a
    return (-b[1], -b[0]) if a is NONE else (a[0] - b[1], a[1] - b[0])


def times(a: Interval, row: Sequence[Interval]) -> list[Interval]:
    """Return the products of an interval with each of a row.

    Where a sign is not certain because a ball about zero holds it, the product with the
    end of larger magnitude is chosen: its ball reaches as far as either may.
    """
    low, high = a
    out = []
    if a is NONE:
        return [NONE] * len(row)
    if a is ONE:
        return list(row)
    if low >= ZERO:
        for b in row:
            if b is NONE:
                out.append(NONE)
            else:
                p, q = b
                out.append(
                    ((low if p >= ZERO else high) * p, (low if q <= ZERO else high) * q)
                )
    elif high <= ZERO:
        for b in row:
            if b is NONE:
                out.append(NONE)
            else:
                p, q = b
                out.append(
                    ((high if q <= ZERO else low) * q, (high if p >= ZERO else low) * p)
                )
    else:
        for b in row:
            if b is NONE:
                out.append(NONE)
                continue
            p, q = b
            if p >= ZERO:
                out.append((low * q, high * q))
            elif q <= ZERO:
                out.append((high * p, low * p))
            else:
                out.append(((low * q).min(high * p), (low * p).max(high * q)))
    return out


def product(a: Interval, b: Interval) -> Interval:
    """Return a b."""
    return times(a, (b,))[0]


def square(a: Interval) -> Interval:
    """Return the squares."""
    low, high = a
    if low >= ZERO:
        return low * low, high * high
    if high <= ZERO:
        return high * high, low * low
    return ZERO, (low * low).max(high * high)


def inverse(a: Interval) -> Interval:
    """Return 1 / a; raise NotVerified where a may be zero."""
    if not (a[0] > ZERO or a[1] < ZERO):
        raise NotVerified("a divisor may be zero")
    return 1 / a[1], 1 / a[0]


def intersection(a: Interval, b: Interval) -> Interval:
    """Return what is in both."""
    return a[0].max(b[0]), a[1].min(b[1])


def hull(a: Interval, b: Interval) -> Interval:
    """Return the least interval that holds both."""
    return a[0].min(b[0]), a[1].max(b[1])


def symmetric(bound: arb) -> Interval:
    """Return the interval from less a bound to it."""
    return -bound, bound


def magnitude(a: Interval) -> arb:
    """Return the largest magnitude."""
    return (-a[0]).max(a[1])


def jet_sum(*jets: Jet) -> Jet:
    """Return the sum of jets."""
    first, *others = jets
    for other in others:
        first = [plus(a, b) for a, b in zip(first, other, strict=True)]
    return first


def jet_minus(x: Jet, y: Jet) -> Jet:
    """Return x - y."""
    return [minus(a, b) for a, b in zip(x, y, strict=True)]


def jet_negative(x: Jet) -> Jet:
    """Return -x."""
    return [negative(a) for a in x]


def jet_product(x: Jet, y: Jet) -> Jet:
    """Return x y, by the rule of products."""
    by_x = times(x[0], y)
    if all(slope is NONE for slope in x[1:]):
        return by_x
    by_y = times(y[0], x[1:])
    return [by_x[0], *(plus(a, b) for a, b in zip(by_x[1:], by_y, strict=True))]


def jet_square(x: Jet) -> Jet:
    """Return the square of a jet."""
    twice = (2 * x[0][0], 2 * x[0][1])
    return [square(x[0]), *times(twice, x[1:])]


def jets_intersected(x: Jet, y: Jet) -> Jet:
    """Return the intersections of two jets' intervals."""
    return [intersection(a, b) for a, b in zip(x, y, strict=True)]


def vector_sum(*vectors: Vector) -> Vector:
    """Return the sum of vectors."""
    return [jet_sum(*jets) for jets in zip(*vectors, strict=True)]


def vector_minus(x: Vector, y: Vector) -> Vector:
    """Return x - y."""
    return [jet_minus(a, b) for a, b in zip(x, y, strict=True)]


def dot(x: Vector, y: Vector) -> Jet:
    """Return the scalar product."""
    return jet_sum(*(jet_product(a, b) for a, b in zip(x, y, strict=True)))


def cross(x: Vector, y: Vector) -> Vector:
    """Return x times y, the vector product."""
    return [
        jet_minus(jet_product(x[b], y[c]), jet_product(x[c], y[b]))
        for b, c in ((1, 2), (2, 0), (0, 1))
    ]


def scaled(matrix: Sequence[Sequence[Interval]], x: Vector) -> Vector:
    """Return a matrix of constants times a vector."""
    return [
        jet_sum(*(times(m, jet) for m, jet in zip(row, x, strict=True)))
        for row in matrix
    ]


def applied(rows: Rows, x: Vector) -> Vector:
    """Return a matrix of jets times a vector of jets."""
    return [dot(row, x) for row in rows]


def transposed(matrix: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Return the rows' columns as rows."""
    return [list(row) for row in zip(*matrix, strict=True)]
