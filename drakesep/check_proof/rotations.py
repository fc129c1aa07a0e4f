"""Rotations and directions on a box, by angles that may vary."""

import math

from flint import arb

from .intervals import (
    NONE,
    ONE,
    Interval,
    Jet,
    Matrix,
    Rows,
    Vector,
    applied,
    jet_negative,
    jet_product,
    negative,
    times,
    transposed,
)


def constant(M: Matrix, zero: Jet) -> Rows:
    """Return a matrix that no parameter varies."""
    return [[[x, *zero[1:]] for x in row] for row in M]


def composed(M: Rows, N: Rows) -> Rows:
    """Return M N."""
    return transposed([applied(M, column) for column in transposed(N)])


def rotation(angles: Vector) -> Rows:
    """Return Rz(yaw) Ry(pitch) Rx(roll)."""
    (cx, sx), (cy, sy), (cz, sz) = (cosine_and_sine(x) for x in angles)
    zero, one = ([x, *[NONE] * (len(cx) - 1)] for x in (NONE, ONE))
    Rx = [[one, zero, zero], [zero, cx, jet_negative(sx)], [zero, sx, cx]]
    Ry = [[cy, zero, sy], [zero, one, zero], [jet_negative(sy), zero, cy]]
    Rz = [[cz, jet_negative(sz), zero], [sz, cz, zero], [zero, zero, one]]
    return composed(Rz, composed(Ry, Rx))


def tilted(frame: Rows, tilts: Vector) -> Vector:
    """Return the x axis of a frame, turned by Rz Ry of two tilts in it."""
    (cy, sy), (cz, sz) = (cosine_and_sine(x) for x in tilts)
    x, y = jet_product(cy, cz), jet_product(cy, sz)
    return applied(frame, [x, y, jet_negative(sy)])


def cosine_and_sine(angle: Jet) -> tuple[Jet, Jet]:
    """Enclose the cosine and the sine; of zero they are 1 and 0."""
    value, slopes = angle[0], angle[1:]
    if value is NONE:
        return [ONE, *slopes], [NONE, *slopes]
    c, s = cosine(value), cosine((value[0] - _QUARTER, value[1] - _QUARTER))
    return [c, *times(negative(s), slopes)], [s, *times(c, slopes)]


_QUARTER = arb.pi() / 2
NEARLY = 1e-9  # of angles in half turns: what is so near to a whole one may be it


def cosine(x: Interval) -> Interval:
    """Enclose cosines: of both ends, and 1 or -1 where x may hold a whole half turn."""
    ends = x[0].cos(), x[1].cos()
    low, high = ends[0].min(ends[1]), ends[0].max(ends[1])
    turns = float((x[0] / arb.pi()).lower()), float((x[1] / arb.pi()).upper())
    nearly = NEARLY * (1 + max(map(abs, turns)))
    first, last = math.ceil(turns[0] - nearly), math.floor(turns[1] + nearly)
    for k in range(first, min(last, first + 1) + 1):  # two in turn are both
        low, high = (low, arb(1)) if k % 2 == 0 else (arb(-1), high)
    return low, high
