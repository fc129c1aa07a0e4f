"""The tolerances: a box of parameter values around the nominal."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_finite, check_positive, unknown
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.separation import Separation


@dataclass(frozen=True, slots=True, kw_only=True)
class Dispersion:
    """One dispersed parameter: nominal, and tolerance to either side, in SI.

    Raises:
        ValueError: the nominal is not finite or the tolerance is not positive.
    """

    name: str
    nominal: float
    tolerance: float

    def __post_init__(self) -> None:
        """Check the values."""
        check_finite(f"{self.name}: nominal", self.nominal)
        check_positive(f"{self.name}: tolerance", self.tolerance)


class UnphysicalTolerance(InputError):
    """A tolerance that reaches a value that is not physical.

    Attributes:
        name: of the parameter.
        reason: what is wrong with it at its bound.
    """

    def __init__(self, name: str, bound: float, reason: str):
        super().__init__(
            f"{name}: tolerance must keep to physical values, got {bound:g} "
            f"at its bound ({reason})"
        )
        self.name, self.reason = name, reason


class ToleranceBox:
    """The set of all values within their tolerances.

    A point of the box is scaled: u in [-1, 1]^n, value = nominal + tolerance u.

    Attributes:
        dispersions: the dispersed parameters, in order.
        nominal: (n,) nominal values, in SI.
        tolerance: (n,) tolerances, in SI.
    """

    def __init__(self, dispersions: Sequence[Dispersion]):
        self.dispersions = tuple(dispersions)
        self.nominal = np.array([d.nominal for d in self.dispersions])
        self.tolerance = np.array([d.tolerance for d in self.dispersions])

    @classmethod
    def around(
        cls, separation: Separation, tolerances: Mapping[str, float]
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
            for bound in (nominal[name] - tolerance, nominal[name] + tolerance):
                _check_reach(separation, name, bound)
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


def _check_reach(separation: Separation, name: str, bound: float) -> None:
    try:
        with_values(separation, {name: bound})
    except ValueError as error:
        raise UnphysicalTolerance(name, bound, str(error)) from error
