"""Boxes of parameters, and the numbers of a problem over them."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drakesep.analysis.bounds.impulses import Law
from drakesep.analysis.bounds.intervals import Interval, total
from drakesep.analysis.bounds.jets import Affine
from drakesep.analysis.bounds.problem import (
    BoundPair,
    BoundProblem,
    BoundSpring,
    Number,
)
from drakesep.systems.arrays import Array
from drakesep.systems.vectors import Rotation


Matrix = list[list[Interval]]
AffineVector = list[Affine]
_ROUNDED = 1e-15
"""Of an entry of a rotation that is computed: more than its error."""


def entry(x: float) -> Interval:
    """Return an entry of a rotation or of a unit vector: 0, 1 and -1 are exact."""
    if x in (0.0, 1.0, -1.0):
        return Interval(x)
    return Interval(x - _ROUNDED, x + _ROUNDED)


def matrix(R: Rotation) -> Matrix:
    """Return a rotation, enclosed."""
    return [[entry(x) for x in R[3 * i : 3 * i + 3]] for i in range(3)]


def transposed(M: Matrix) -> Matrix:
    """Return the transpose."""
    return [list(column) for column in zip(*M, strict=True)]


def is_zero(x: Interval) -> bool:
    """Return whether a constant is exactly zero."""
    return not x.lo.any() and not x.hi.any()


def weighted(weights: Sequence[Interval], terms: Sequence[Affine]) -> Affine:
    """Return a sum with constant weights; those that are exactly zero are left out."""
    found = [
        _times(x, w) for w, x in zip(weights, terms, strict=True) if not is_zero(w)
    ]
    return total(found) if found else Affine(Interval(0.0))


def _times(x: Affine, weight: Interval) -> Affine:
    if bool((weight.lo == weight.hi).all()) and float(weight.lo) in (1.0, -1.0):
        return x if float(weight.lo) == 1.0 else -x
    return x * weight


def turned(M: Matrix, vector: Sequence[Affine]) -> AffineVector:
    """Return M v of an affine v."""
    return [weighted(row, vector) for row in M]


def product(M: Matrix, N: Matrix) -> Matrix:
    """Return M N of constants; of a single nonzero factor exactly it."""
    columns = transposed(N)
    return [[_dot(row, column) for column in columns] for row in M]


def _dot(a: Sequence[Interval], b: Sequence[Interval]) -> Interval:
    terms = [
        y if float(x.lo) == float(x.hi) == 1.0 else x * y
        for x, y in zip(a, b, strict=True)
        if not is_zero(x) and not is_zero(y)
    ]
    return total(terms) if terms else Interval(0.0)


def affine_cross(a: Sequence[Affine], d: Sequence[Interval]) -> AffineVector:
    """Return a x d of an affine vector and a constant one."""
    return [weighted([d[j], -d[i]], [a[i], a[j]]) for i, j in ((1, 2), (2, 0), (0, 1))]


class Mating(NamedTuple):
    """How a pair's bodies are mated."""

    R0: Matrix
    """Orientation of B in A."""
    place: list[Interval]
    """Of B's origin in A, m."""


def mating(problem: BoundProblem, pair: BoundPair) -> Mating:
    """Return how a pair is mated."""
    A, B = problem.bodies[pair.A], problem.bodies[pair.B]
    R_AS = transposed(matrix(A.orientation))
    apart = [
        Interval(b) - Interval(a) if a else Interval(b)
        for a, b in zip(A.place, B.place, strict=True)
    ]
    return Mating(
        product(R_AS, matrix(B.orientation)), [_dot(row, apart) for row in R_AS]
    )


class Boxes:
    """Boxes of the parameters of a problem."""

    def __init__(
        self,
        problem: BoundProblem,
        lower: Array,
        upper: Array,
        slopes: Sequence[int] = (),
    ):
        """Take ends (boxes, n) of s, and by which parameters derivatives are taken."""
        self.problem, self.lower, self.upper = problem, lower, upper
        self.count = len(lower)
        self.rows = {i: row for row, i in enumerate(slopes)}
        """The derivatives' places among them."""

    def affine(self, number: Number) -> Affine:
        """Return a number of the problem over the boxes."""
        i = number.parameter
        if i is None:
            return Affine(Interval(np.full((1, 1), number.value)))
        scale = Interval(self.problem.parameters[i].scale)
        s = Interval(self.lower[:, i, None], self.upper[:, i, None])
        slopes = {self.rows[i]: scale} if i in self.rows else {}
        return Affine(Interval(number.value) + scale * s, slopes)

    def vector(self, numbers: Sequence[Number]) -> AffineVector:
        """Return a vector of numbers of the problem."""
        return [self.affine(number) for number in numbers]

    def law(self, spring: BoundSpring) -> Law:
        """Return the law of a spring."""
        numbers = spring.force_max, spring.stroke, spring.design_mass
        return Law(*(self.affine(number).value for number in numbers))

    def pad_in_B(self, spring: BoundSpring) -> AffineVector:
        """Return where the pad of a spring is in the body that it pushes."""
        mated = mating(self.problem, self.problem.pairs[spring.pair])
        pad = self.vector(spring.place)
        apart = [
            p if is_zero(o) else p - Affine(o)
            for p, o in zip(pad, mated.place, strict=True)
        ]
        return turned(transposed(mated.R0), apart)

    @functools.cached_property
    def with_nominal(self) -> "Boxes":
        """The least boxes that hold these, and the nominal values."""
        return Boxes(
            self.problem, np.minimum(self.lower, 0.0), np.maximum(self.upper, 0.0)
        )


def whole_box(problem: BoundProblem) -> Boxes:
    """Return the box of a problem."""
    return Boxes(
        problem,
        np.array([[p.lower for p in problem.parameters]]),
        np.array([[p.upper for p in problem.parameters]]),
    )


def nominal_law(spring: BoundSpring) -> Law:
    """Return the law of a spring at the nominal values."""
    numbers = spring.force_max, spring.stroke, spring.design_mass
    return Law(*(Interval(np.full((1, 1), number.value)) for number in numbers))
