"""What is constant in time on a box: values of the problem as jets."""

from functools import cached_property

from flint import arb

from .certificate import Box, Problem, Value
from .intervals import NONE, Interval, Jet, Vector, point


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
            return NONE if value.value == 0 else point(value.value)
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

    @cached_property
    def with_nominal(self) -> "Constants":
        """The same on the hull of the box and the nominal values, s = 0."""
        lower = tuple(min(s, 0.0) for s in self.box.lower)
        upper = tuple(max(s, 0.0) for s in self.box.upper)
        return Constants(self.problem, Box(lower, upper), self.live)
