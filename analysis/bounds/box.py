"""Boxes of parameters, and the numbers of a problem over them."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drakesep.analysis.bounds.impulses import Law
from drakesep.analysis.bounds.intervals import Interval
from drakesep.analysis.bounds.jets import Affine, combined, turned
from drakesep.analysis.bounds.problem import (
    BoundBody,
    BoundPair,
    BoundProblem,
    BoundSpring,
    Number,
)
from drakesep.analysis.bounds.rotations import (
    ZERO,
    AffineVector,
    Matrix,
    affine_cross,
    entry,
    matrix,
    minus,
    plus,
    product,
    rotation,
    tilted,
    transposed,
)
from drakesep.systems.arrays import Array


class Mating(NamedTuple):
    """How a pair's bodies are mated."""

    R0: Matrix
    """Orientation of B in A."""
    place: AffineVector
    """Of B's origin in A, m."""


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
        return Law(*(self.affine(number).value for number in spring.law))

    def orientation(self, body: BoundBody) -> Matrix:
        """Return the orientation of a body in the stack."""
        turn = rotation(*self.vector(body.turn))
        return product(matrix(body.orientation), turn)

    def attitude(self) -> Matrix:
        """Return the orientation of the stack in W."""
        return rotation(*self.vector(self.problem.attitude))

    def place(self, body: BoundBody) -> AffineVector:
        """Return where a body's origin is in the stack."""
        return [
            self._shifted(p, x) for p, x in zip(body.place, body.offset, strict=True)
        ]

    def _shifted(self, place: float, offset: Number) -> Affine:
        if offset.parameter is None and offset.value == 0.0:
            return Affine(Interval(place))
        return Affine(Interval(place)) + self.affine(offset)

    def mating(self, pair: BoundPair) -> Mating:
        """Return how a pair is mated."""
        A, B = (self.problem.bodies[b] for b in (pair.A, pair.B))
        R_AS = transposed(self.orientation(A))
        apart = [
            b if a.is_zero else b - a
            for a, b in zip(self.place(A), self.place(B), strict=True)
        ]
        return Mating(product(R_AS, self.orientation(B)), turned(R_AS, apart))

    def axis(self, spring: BoundSpring) -> AffineVector:
        """Return along which axis of A a spring pushes."""
        return tilted(matrix(spring.frame), *self.vector(spring.tilt))

    def rates(self) -> list[AffineVector]:
        """Return the rate of each body before separation, in its axes."""
        rate = self.vector(self.problem.rate)
        of_bodies = [
            turned(transposed(self.orientation(b)), rate) for b in self.problem.bodies
        ]
        for pair in self.problem.pairs:
            if pair.spin is None:
                continue
            spin = turned(transposed(self.mating(pair).R0), self.spin(pair))
            of_bodies[pair.B] = plus(of_bodies[pair.B], spin)
        return of_bodies

    def spin(self, pair: BoundPair) -> AffineVector:
        """Return the rate of a pair's B relative to A before separation, in A."""
        if pair.spin is None:
            return [ZERO] * 3
        rate = self.affine(pair.spin.rate)
        return [combined([entry(x)], [rate]) for x in pair.spin.axis]

    def spinning(self, pair: BoundPair, point_B: AffineVector) -> AffineVector:
        """Return how fast a point of a pair's B moves in A before separation.

        Args:
            pair: of the problem.
            point_B: from B's origin, in B.
        """
        if pair.spin is None:
            return [ZERO] * 3
        mated, about = self.mating(pair), self.vector(pair.spin.place)
        place = plus(mated.place, turned(mated.R0, point_B))
        return affine_cross(self.spin(pair), minus(place, about))

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
    return Law(*(Interval(np.full((1, 1), number.value)) for number in spring.law))
