"""What is constant in time on a box: values of the problem as jets."""

from functools import cached_property

from flint import arb

from .certificate import Body, Box, Pair, Problem, Spring, Value
from .intervals import (
    NONE,
    Interval,
    Jet,
    Rows,
    Vector,
    applied,
    cross,
    jet_product,
    point,
    transposed,
    vector_minus,
    vector_sum,
)
from .rotations import composed, constant, rotation, tilted


class Constants:
    """The values of a problem on a box, with their derivatives by `live` parameters."""

    def __init__(self, problem: Problem, box: Box, live: list[int]):
        self.problem = problem
        self.box = box
        self.live = live
        self.zero: Jet = [NONE] * (1 + len(live))

    def parameter(self, i: int) -> Interval:
        """Return nominal + scale * s, as a real number."""
        p = self.problem.parameters[i]
        low, high = self.box.interval(i)
        return arb(p.nominal) + arb(p.scale) * low, arb(p.nominal) + arb(p.scale) * high

    def interval(self, value: Value) -> Interval:
        """Enclose a value."""
        if value.parameter is None:
            return _exact(value.value)
        return self.parameter(value.parameter)

    def jet(self, value: Value) -> Jet:
        """Enclose a value and its derivatives."""
        return self.jet_of(self.interval(value), {value.parameter: self.scale(value)})

    def jet_of(self, value: Interval, slopes: dict[int | None, Interval]) -> Jet:
        """Return a jet of a value and of slopes by parameter."""
        return [value, *(slopes.get(i, NONE) for i in self.live)]

    def scale(self, value: Value) -> Interval:
        """Return the derivative of a value by the s of its parameter."""
        if value.parameter is None:
            return NONE
        return point(self.problem.parameters[value.parameter].scale)

    def vector(self, values: list[Value]) -> Vector:
        """Enclose values and their derivatives."""
        return [self.jet(value) for value in values]

    def constant(self, values: list[Interval]) -> Vector:
        """Return a vector that no parameter varies."""
        return [self.jet_of(value, {}) for value in values]

    def orientation(self, body: Body) -> Rows:
        """Return the orientation of a body in the stack."""
        meant = constant(body.R_S, self.zero)
        return composed(meant, rotation(self.vector(body.turn)))

    def origin(self, body: Body) -> Vector:
        """Return where a body's origin is in the stack."""
        meant = self.constant([_exact(x) for x in body.origin_S])
        return vector_sum(meant, self.vector(body.offset))

    def cg(self, body: Body) -> Vector:
        """Return where a body's CG is in the stack."""
        arm = applied(self.orientation(body), self.vector(body.cg))
        return vector_sum(self.origin(body), arm)

    def mating(self, pair: Pair) -> tuple[Rows, Vector]:
        """Return the orientation and the origin of a pair's B in its A."""
        A, B = (self.problem.bodies[b] for b in (pair.carrier, pair.leaver))
        to_A = transposed(self.orientation(A))
        apart = vector_minus(self.origin(B), self.origin(A))
        return composed(to_A, self.orientation(B)), applied(to_A, apart)

    def axis(self, spring: Spring) -> Vector:
        """Return along which axis of the carrier a spring pushes."""
        return tilted(constant(spring.frame, self.zero), self.vector(spring.tilt))

    def spin(self, pair: Pair) -> Vector:
        """Return the rate of a pair's B relative to its A at first, in A."""
        if pair.spin is None:
            return [self.zero] * 3
        rate = self.jet(pair.spin.rate)
        return [jet_product(x, rate) for x in self.constant(pair.spin.axis)]

    def swing(self, pair: Pair, point_B: Vector) -> Vector:
        """Return how fast a point fixed in a pair's B moves in its A at first."""
        if pair.spin is None:
            return [self.zero] * 3
        R0, origin = self.mating(pair)
        place = vector_sum(origin, applied(R0, point_B))
        arm = vector_minus(place, self.vector(pair.spin.place))
        return cross(self.spin(pair), arm)

    @cached_property
    def with_nominal(self) -> "Constants":
        """The same on the hull of the box and the nominal values, s = 0."""
        lower = tuple(min(s, 0.0) for s in self.box.lower)
        upper = tuple(max(s, 0.0) for s in self.box.upper)
        return Constants(self.problem, Box(lower, upper), self.live)


def _exact(x: float) -> Interval:
    return NONE if x == 0 else point(x)
