"""The tolerances: a box of parameter values around the nominal."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drakesep.analysis.tolerances.sides import (
    Sides,
    Tolerance,
    check_matters,
    ends_of,
    sides_of,
)
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_finite, unknown
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.separation import Separation


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Dispersion:
    """One dispersed parameter: its nominal value and its tolerance, in SI.

    Raises:
        ValueError: the nominal is not finite or the tolerance is not positive.
    """

    name: str
    nominal: float
    tolerance: Tolerance

    def __post_init__(self) -> None:
        """Check the values."""
        check_finite(f"{self.name}: nominal", self.nominal)
        check_matters(self.name, self.nominal, self.tolerance)

    @property
    def sides(self) -> Sides:
        """How far searches go to either side."""
        return sides_of(self.tolerance, self.nominal)

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the greatest value that searches look at."""
        return ends_of(self.nominal, self.tolerance)

    def grown(self, factor: float) -> "Dispersion":
        """Return it with each side multiplied; the nominal stays."""
        return replace(self, tolerance=self.sides.grown(factor))


class UnphysicalTolerance(InputError):
    """A tolerance that reaches a value that is not physical.

    Attributes:
        dispersion: with it.
        reason: what is wrong with it at its bound.
    """

    def __init__(self, dispersion: Dispersion, bound: float, reason: str):
        super().__init__(
            f"{dispersion.name}: tolerance must keep to physical values, got {bound:g} "
            f"at its bound ({reason})"
        )
        self.dispersion, self.reason = dispersion, reason


@typed
class ToleranceBox:
    """The set of all values within their tolerances.

    A point of the box is scaled: value = nominal + tolerance u, lower <= u <= upper.
    The nominal is at u = 0. Where it is the middle, u goes from -1 to 1; else the
    larger side is the tolerance, and the other ends sooner.

    Attributes:
        dispersions: the dispersed parameters, in order.
        nominal: (n,) nominal values, in SI.
        tolerance: (n,) tolerances, in SI; the larger of two sides.
        lower: (n,) least u, -1 to 0.
        upper: (n,) greatest u, 0 to 1.
    """

    def __init__(self, dispersions: Sequence[Dispersion]):
        self.dispersions = tuple(dispersions)
        self.nominal = np.array([d.nominal for d in self.dispersions])
        sides = [d.sides for d in self.dispersions]
        self.tolerance = np.array([s.larger for s in sides])
        self.lower = np.array([-_share(s.minus, s.larger) for s in sides])
        self.upper = np.array([_share(s.plus, s.larger) for s in sides])

    @classmethod
    def around(
        cls, separation: Separation, tolerances: Mapping[str, Tolerance]
    ) -> "ToleranceBox":
        """Return the box around a separation's own values.

        Args:
            separation: gives the nominal values.
            tolerances: by parameter name, in SI.

        Raises:
            ValueError: a parameter is unknown, or its tolerance alone reaches a
                value that is not physical.
        """
        nominal = parameters(separation)
        dispersions = []
        for name, tolerance in tolerances.items():
            if name not in nominal:
                raise InputError(unknown("parameter", name, nominal))
            dispersion = Dispersion(
                name=name, nominal=nominal[name], tolerance=tolerance
            )
            for bound in dispersion.bounds:
                _check_reach(separation, dispersion, bound)
            dispersions.append(dispersion)
        return cls(dispersions)

    def __len__(self) -> int:
        return len(self.dispersions)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the dispersed parameters."""
        return tuple(d.name for d in self.dispersions)

    def values(self, u: ArrayLike) -> dict[str, float]:
        """Return the parameter values of a scaled point.

        Args:
            u: (n,) scaled point.
        """
        point = self.nominal + self.tolerance * np.asarray(u, dtype=float)
        return dict(zip(self.names, point.tolist(), strict=True))

    def scaled(self, values: Mapping[str, float]) -> Array:
        """Return the scaled point (n,) of parameter values; nominal if not given.

        Raises:
            ValueError: a name is not dispersed.
        """
        for name in values:
            if name not in self.names:
                raise InputError(unknown("dispersed parameter", name, self.names))
        point = [values.get(d.name, d.nominal) for d in self.dispersions]
        u: Array = (np.array(point) - self.nominal) / self.tolerance
        return u

    def corners(self, signs: ArrayLike) -> Array:
        """Return points (..., n) at bounds: the upper where a sign is positive.

        Args:
            signs: (..., n) numbers; where one is zero, so is u.
        """
        given = np.asarray(signs, dtype=float)
        at_bounds = np.where(given > 0.0, self.upper, self.lower)
        return np.asarray(np.where(given == 0.0, 0.0, at_bounds))

    def opposite(self, u: ArrayLike) -> Array:
        """Return points (..., n) as far from the other bound as these are from one."""
        return np.asarray(self.lower + self.upper - np.asarray(u, dtype=float))

    def sides_of(self, u: ArrayLike, within: float) -> NDArray[np.int_]:
        """Return (..., n) at which bound points (..., n) are.

        Args:
            u: scaled points.
            within: how near to a bound is at it, scaled.

        Returns:
            1 at the upper, -1 at the lower, 0 between.
        """
        points = np.asarray(u, dtype=float)
        at_upper = np.abs(points - self.upper) <= within
        at_lower = np.abs(points - self.lower) <= within
        return np.asarray(np.where(at_upper, 1, np.where(at_lower, -1, 0)))

    def contains(self, u: ArrayLike) -> NDArray[np.bool_]:
        """Return (...,) whether points (..., n) are in the box."""
        points = np.asarray(u, dtype=float)
        inside = (points >= self.lower) & (points <= self.upper)
        return np.asarray(inside.all(axis=-1))

    def clipped(self, u: ArrayLike) -> Array:
        """Return points (..., n) drawn into the box, entry by entry."""
        return np.asarray(np.clip(np.asarray(u, dtype=float), self.lower, self.upper))

    def grown(self, factors: float | Array) -> "ToleranceBox":
        """Return the box with its tolerances multiplied about the nominal.

        Args:
            factors: one for all, or (n,).
        """
        each = np.broadcast_to(factors, len(self)).tolist()
        return ToleranceBox(
            [d.grown(f) for d, f in zip(self.dispersions, each, strict=True)]
        )


def _share(side: float, larger: float) -> float:
    share = side / larger
    # Round-off must not lead beyond a bound, which may be where what exists ends.
    return share if share * larger <= side else math.nextafter(share, 0.0)


def _check_reach(separation: Separation, dispersion: Dispersion, bound: float) -> None:
    try:
        with_values(separation, {dispersion.name: bound})
    except ValueError as error:
        raise UnphysicalTolerance(dispersion, bound, str(error)) from error
