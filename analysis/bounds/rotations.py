"""Rotations and directions over boxes of parameters, by angles that may vary."""

from collections.abc import Sequence

from drakesep.analysis.bounds.intervals import Interval, cosine, sine
from drakesep.analysis.bounds.jets import Affine, combined, turned
from drakesep.systems.vectors import Rotation


Matrix = list[list[Affine]]
AffineVector = list[Affine]
_ROUNDED = 1e-15
"""Of an entry of a rotation that is computed: more than its error."""
ZERO, ONE = Affine(Interval(0.0)), Affine(Interval(1.0))


def entry(x: float) -> Affine:
    """Return an entry of a rotation or of a unit vector: 0, 1 and -1 are exact."""
    if x in (0.0, 1.0, -1.0):
        return Affine(Interval(x))
    return Affine(Interval(x - _ROUNDED, x + _ROUNDED))


def matrix(R: Rotation) -> Matrix:
    """Return a rotation, enclosed."""
    return [[entry(x) for x in R[3 * i : 3 * i + 3]] for i in range(3)]


def transposed(M: Sequence[Sequence[Affine]]) -> Matrix:
    """Return the transpose."""
    return [list(column) for column in zip(*M, strict=True)]


def product(M: Matrix, N: Matrix) -> Matrix:
    """Return M N."""
    return transposed([turned(M, column) for column in transposed(N)])


def rotation(roll: Affine, pitch: Affine, yaw: Affine) -> Matrix:
    """Return Rz(yaw) Ry(pitch) Rx(roll)."""
    (cx, sx), (cy, sy), (cz, sz) = (_cosine_and_sine(x) for x in (roll, pitch, yaw))
    Rx = [[ONE, ZERO, ZERO], [ZERO, cx, -sx], [ZERO, sx, cx]]
    Ry = [[cy, ZERO, sy], [ZERO, ONE, ZERO], [-sy, ZERO, cy]]
    Rz = [[cz, -sz, ZERO], [sz, cz, ZERO], [ZERO, ZERO, ONE]]
    return product(Rz, product(Ry, Rx))


def tilted(frame: Matrix, tilt_y: Affine, tilt_z: Affine) -> AffineVector:
    """Return the x axis of a frame, turned by Rz(tilt_z) Ry(tilt_y) in it."""
    (cy, sy), (cz, sz) = (_cosine_and_sine(x) for x in (tilt_y, tilt_z))
    return turned(frame, [combined([cy], [cz]), combined([cy], [sz]), -sy])


def _cosine_and_sine(angle: Affine) -> tuple[Affine, Affine]:
    """Return the cosine and the sine; of zero exactly 1 and 0."""
    if angle.is_zero:
        return ONE, ZERO
    c, s = cosine(angle.value), sine(angle.value)
    return (
        Affine(c, {i: -(s * x) for i, x in angle.slopes.items()}),
        Affine(s, {i: c * x for i, x in angle.slopes.items()}),
    )


def affine_cross(a: Sequence[Affine], b: Sequence[Affine]) -> AffineVector:
    """Return a x b; entries of b that are exactly 0, 1 or -1 cost nothing."""
    return [combined([b[j], -b[i]], [a[i], a[j]]) for i, j in ((1, 2), (2, 0), (0, 1))]


def plus(a: Sequence[Affine], b: Sequence[Affine]) -> AffineVector:
    """Return a + b; entries that are exactly 0 cost nothing."""
    pairs = zip(a, b, strict=True)
    return [y if x.is_zero else x if y.is_zero else x + y for x, y in pairs]


def minus(a: Sequence[Affine], b: Sequence[Affine]) -> AffineVector:
    """Return a - b; entries that are exactly 0 cost nothing."""
    return plus(a, [-y for y in b])


def constant(x: Sequence[float]) -> AffineVector:
    """Return a vector of numbers that are exact."""
    return [Affine(Interval(value)) for value in x]
