"""How far a parameter may go to either side of its nominal value."""

import abc
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
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
    def of(cls, extent: "Extent") -> "Sides":
        """Return the sides of an extent; a number is as far to both.

        Raises:
            ValueError: it is a number that is not positive.
        """
        if isinstance(extent, Sides):
            return extent
        check_positive("tolerance", extent)
        return cls(minus=extent, plus=extent)

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


Extent: TypeAlias = float | Sides
"""A number: as far to either side."""


class Distribution(abc.ABC):
    """How a parameter is distributed about its nominal value, or apart from it.

    Those that there are stand in `drakesep.analysis.tolerances.distributions`. Values
    are in SI.
    """

    __slots__ = ()

    kind: ClassVar[str]
    """Its name in case files."""
    within: Extent | None
    """What searches look at, from the nominal; None: what is usual of its kind."""

    @abc.abstractmethod
    def usual_sides(self, nominal: float) -> Sides:
        """Return how far from its nominal searches look unless `within` says it.

        Raises:
            ValueError: there is no such distribution about this nominal.
        """

    @abc.abstractmethod
    def ppf(self, q: Array, nominal: float) -> Array:
        """Return the values (N,) below which shares of all values lie.

        Args:
            q: (N,) the shares, 0 < q < 1.
            nominal: value of the parameter.
        """

    @abc.abstractmethod
    def of_normal(self, z: Array, nominal: float) -> Array:
        """Return the values (N,) at the same shares as standard normal ones.

        Args:
            z: (N,) the standard normal values.
            nominal: value of the parameter.
        """

    def sides(self, nominal: float) -> Sides:
        """Return how far from its nominal searches look.

        Raises:
            ValueError: there is no such distribution about this nominal.
        """
        usual = self.usual_sides(nominal)
        return usual if self.within is None else Sides.of(self.within)


Tolerance: TypeAlias = Extent | Distribution
"""How far it may go, uniformly distributed; or a distribution."""


def sides_of(tolerance: Tolerance, nominal: float) -> Sides:
    """Return how far from a nominal value searches look.

    Raises:
        ValueError: it is a number that is not positive, or no distribution about this
            nominal.
    """
    if isinstance(tolerance, Distribution):
        return tolerance.sides(nominal)
    return Sides.of(tolerance)


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
        larger = sides_of(tolerance, nominal).larger
    if larger < _LEAST or nominal - larger == nominal == nominal + larger:
        raise InputError(
            f"{name}: tolerance must be large enough to matter, got {larger:g} in SI "
            f"beside a nominal of {nominal:g}"
        )


def ends_of(nominal: float, tolerance: Tolerance) -> tuple[float, float]:
    """Return the least and the greatest value that searches look at.

    Args:
        nominal: value of the parameter.
        tolerance: about it.
    """
    sides = sides_of(tolerance, nominal)
    return nominal - sides.minus, nominal + sides.plus
