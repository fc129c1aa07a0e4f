"""How far a parameter may go to either side of its nominal value."""

from dataclasses import dataclass
from typing import TypeAlias

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    check_not_negative,
    check_positive,
    named,
)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Sides:
    """A tolerance whose nominal is not its middle, or at one of its ends.

    Raises:
        ValueError: a side is negative or not finite, or both are zero.
    """

    minus: float
    """Below the nominal, in SI."""
    plus: float
    """Above it, in SI."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_not_negative("minus", self.minus)
        check_not_negative("plus", self.plus)
        if self.larger == 0.0:
            raise InputError("minus or plus must be > 0, got 0 for both")

    @classmethod
    def of(cls, tolerance: "Tolerance") -> "Sides":
        """Return the sides of a tolerance; a number is as far to both.

        Raises:
            ValueError: it is a number that is not positive.
        """
        if isinstance(tolerance, Sides):
            return tolerance
        check_positive("tolerance", tolerance)
        return cls(minus=tolerance, plus=tolerance)

    @property
    def larger(self) -> float:
        """The larger side, by which the parameter is scaled."""
        return max(self.minus, self.plus)

    @property
    def symmetric(self) -> bool:
        """Whether the nominal is the middle."""
        return self.minus == self.plus

    def grown(self, factor: float) -> "Sides":
        """Return the sides, each multiplied."""
        return Sides(minus=self.minus * factor, plus=self.plus * factor)


Tolerance: TypeAlias = float | Sides
"""A number: as far to either side."""


_LEAST = 1e-15
"""Of a tolerance, in SI."""


def check_matters(name: str, nominal: float, tolerance: Tolerance) -> None:
    """Raise InputError if a tolerance is so small that numbers do not show it.

    Args:
        name: of the parameter.
        nominal: in SI.
        tolerance: in SI.
    """
    with named(name):
        larger = Sides.of(tolerance).larger
    if larger < _LEAST or nominal - larger == nominal == nominal + larger:
        raise InputError(
            f"{name}: tolerance must be large enough to matter, got {larger:g} in SI "
            f"beside a nominal of {nominal:g}"
        )


def ends_of(nominal: float, tolerance: Tolerance) -> tuple[float, float]:
    """Return the least and the greatest value that a tolerance admits.

    Args:
        nominal: value of the parameter.
        tolerance: about it.
    """
    sides = Sides.of(tolerance)
    return nominal - sides.minus, nominal + sides.plus
