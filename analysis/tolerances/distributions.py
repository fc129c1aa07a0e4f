"""How dispersed parameters are distributed, and the sets that searches look at.

Each is a frozen record, in SI. What it says is drawn by its quantiles; searches look at
what `within` states, or at what is usual of its kind:

- uniform, triangular, truncated normal: all values that there are;
- normal: three standard deviations to either side;
- lognormal: between the same quantiles as of a normal, 0.135 % and 99.865 %;
- table, discrete: from the least to the greatest value, and the nominal.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias, get_args

import numpy as np
from scipy.special import expm1, ndtr, ndtri

from drakesep.analysis.tolerances.sides import (
    Distribution,
    Extent,
    Sides,
    Tolerance,
)
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_finite, check_positive, named


SIGMAS = 3.0
"""Standard deviations that a tolerance is, unless it is said otherwise."""

KindOverTolerance: TypeAlias = Literal[
    "uniform", "normal", "truncated_normal", "triangular", "lognormal"
]
"""Distributions that a tolerance is enough for."""


class _ByQuantiles(Distribution):
    """One that is drawn by its own quantiles."""

    __slots__ = ()

    def of_normal(self, z: Array, nominal: float) -> Array:
        """See `Distribution`."""
        return self.ppf(np.asarray(ndtr(z)), nominal)


class _OfNormal(Distribution):
    """One that is a function of a normal distribution."""

    __slots__ = ()

    def ppf(self, q: Array, nominal: float) -> Array:
        """See `Distribution`."""
        return self.of_normal(np.asarray(ndtri(q)), nominal)


@dataclass(frozen=True, slots=True, kw_only=True)
class _OverExtent(_ByQuantiles):
    """One that is all within an extent, which searches look at."""

    extent: Extent
    """From the nominal."""
    within: Extent | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        _check_extents(self)

    def usual_sides(self, nominal: float) -> Sides:
        """See `Distribution`."""
        return Sides.of(self.extent)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Uniform(_OverExtent):
    """All values of an extent are alike.

    Raises:
        ValueError: the extent or what searches look at is not positive.
    """

    kind: ClassVar[str] = "uniform"

    def ppf(self, q: Array, nominal: float) -> Array:
        """See `Distribution`."""
        sides = Sides.of(self.extent)
        return nominal - sides.minus + q * (sides.minus + sides.plus)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Triangular(_OverExtent):
    """Most likely at the nominal, and ever less towards the ends of an extent.

    Raises:
        ValueError: the extent or what searches look at is not positive.
    """

    kind: ClassVar[str] = "triangular"

    def ppf(self, q: Array, nominal: float) -> Array:
        """See `Distribution`."""
        sides = Sides.of(self.extent)
        width = sides.minus + sides.plus
        below = sides.minus / width
        rise = width * np.sqrt(q * below) - sides.minus
        fall = sides.plus - width * np.sqrt((1.0 - q) * (1.0 - below))
        return nominal + np.where(q < below, rise, fall)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Normal(_OfNormal):
    """The normal distribution about the nominal.

    Raises:
        ValueError: a number is not positive.
    """

    kind: ClassVar[str] = "normal"
    sigma: float
    """Its standard deviation."""
    within: Extent | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive("sigma", self.sigma)
        _check_extents(self)

    def usual_sides(self, nominal: float) -> Sides:
        """See `Distribution`."""
        return Sides.of(SIGMAS * self.sigma)

    def of_normal(self, z: Array, nominal: float) -> Array:
        """See `Distribution`."""
        return nominal + self.sigma * z


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class TruncatedNormal(_ByQuantiles):
    """A normal distribution about the nominal without what lies beyond an extent.

    Raises:
        ValueError: a number is not positive, or the extent is so small a part of the
            standard deviation that shares do not resolve it.
    """

    kind: ClassVar[str] = "truncated_normal"
    sigma: float
    """The standard deviation before it is truncated."""
    extent: Extent
    """Where it is truncated, from the nominal."""
    within: Extent | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive("sigma", self.sigma)
        _check_extents(self)
        larger = Sides.of(self.extent).larger
        if self.sigma > _WIDEST * larger:
            raise InputError(
                f"{self.kind}: sigma must be at most {_WIDEST:g} times the extent, got "
                f"{self.sigma / larger:g} times; that is uniform"
            )

    def usual_sides(self, nominal: float) -> Sides:
        """See `Distribution`."""
        return Sides.of(self.extent)

    def ppf(self, q: Array, nominal: float) -> Array:
        """See `Distribution`."""
        sides = Sides.of(self.extent)
        below, above = ndtr(-sides.minus / self.sigma), ndtr(sides.plus / self.sigma)
        deviation = self.sigma * ndtri(below + q * (above - below))
        return np.asarray(nominal + np.clip(deviation, -sides.minus, sides.plus))


_WIDEST = 1e6
"""Of a truncated normal distribution: shares of 1e-16 still resolve 1e-9 of it."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Lognormal(_OfNormal):
    """Values whose logarithms are normal; the nominal, above zero, is their median.

    So half of the values lie below the nominal, and as many below a part of it as above
    the same multiple.

    Raises:
        ValueError: a number is not positive.
    """

    kind: ClassVar[str] = "lognormal"
    sigma: float
    """The standard deviation of the values, not of their logarithms."""
    within: Extent | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive("sigma", self.sigma)
        _check_extents(self)

    def spread(self, nominal: float) -> float:
        """Return the standard deviation s of the logarithms.

        Of a median m and e = exp(s^2) the variance is m^2 e (e - 1).

        Raises:
            ValueError: the nominal is not above zero.
        """
        if not nominal > 0.0:
            raise InputError(
                f"lognormal: needs a nominal > 0, its median, got {nominal:g}"
            )
        share = self.sigma / nominal
        # e - 1 = (sqrt(1 + 4 share^2) - 1) / 2, without cancellation
        return math.sqrt(
            math.log1p(share / (1.0 + math.hypot(1.0, 2.0 * share)) * 2.0 * share)
        )

    def usual_sides(self, nominal: float) -> Sides:
        """See `Distribution`."""
        reach = SIGMAS * self.spread(nominal)
        return Sides(
            minus=float(-nominal * expm1(-reach)), plus=float(nominal * expm1(reach))
        )

    def of_normal(self, z: Array, nominal: float) -> Array:
        """See `Distribution`."""
        return nominal + nominal * np.asarray(expm1(self.spread(nominal) * z))


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Table(_ByQuantiles):
    """Values as they were measured, with straight lines between their shares.

    From the least to the greatest value. Between two neighbours lies the mean of their
    weights, over the sum of these means: of k values of the same weight, 1 / (k - 1).

    Raises:
        ValueError: there are no two different values, or a weight is not positive.
    """

    kind: ClassVar[str] = "table"
    values: tuple[float, ...]
    """Of the parameter, in any order."""
    weights: tuple[float, ...] | None = None
    """Of each; None: all the same."""
    within: Extent | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        _check_values(self.kind, self.values, repeated=True)
        _check_shares(self.kind, "weights", self.weights, len(self.values))
        _check_extents(self)

    def usual_sides(self, nominal: float) -> Sides:
        """See `Distribution`."""
        return _sides_around(self.values, nominal)

    def ppf(self, q: Array, nominal: float) -> Array:
        """See `Distribution`."""
        weights = self.weights or (1.0,) * len(self.values)
        x, w = np.array(sorted(zip(self.values, weights, strict=True))).T
        below = np.concatenate([[0.0], np.cumsum(0.5 * (w[1:] + w[:-1]))])
        return np.asarray(np.interp(q, below / below[-1], x))


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Discrete(_ByQuantiles):
    """One of some values, each with its probability.

    Searches look at all that lies between them too.

    Raises:
        ValueError: there are no two values, one stands twice, or the probabilities are
            not positive or do not add up to 1.
    """

    kind: ClassVar[str] = "discrete"
    values: tuple[float, ...]
    """Of the parameter, in any order."""
    probabilities: tuple[float, ...]
    """Of each."""
    within: Extent | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        _check_values(self.kind, self.values, repeated=False)
        _check_shares(self.kind, "probabilities", self.probabilities, len(self.values))
        if abs(sum(self.probabilities) - 1.0) > _ROUNDED:
            raise InputError(
                f"{self.kind}: probabilities must add up to 1, got "
                f"{sum(self.probabilities):.9g}"
            )
        _check_extents(self)

    def usual_sides(self, nominal: float) -> Sides:
        """See `Distribution`."""
        return _sides_around(self.values, nominal)

    def ppf(self, q: Array, nominal: float) -> Array:
        """See `Distribution`."""
        values, shares = zip(
            *sorted(zip(self.values, self.probabilities, strict=True)), strict=True
        )
        below = np.cumsum(shares)[:-1] / sum(shares)
        return np.array(values)[np.searchsorted(below, q, side="left")]


_ROUNDED = 1e-6
"""By which probabilities that are written in decimals may miss their sum."""


def distribution_of(tolerance: Tolerance) -> Distribution:
    """Return how a tolerance is distributed: uniformly, if it does not say it."""
    if isinstance(tolerance, Distribution):
        return tolerance
    return Uniform(extent=tolerance)


def over_tolerance(
    kind: KindOverTolerance, extent: Extent, sigmas: float = SIGMAS
) -> Distribution:
    """Return a distribution over a tolerance, which is what searches look at.

    Args:
        kind: of the distribution.
        extent: the tolerance.
        sigmas: standard deviations that it is; where it is truncated, of a truncated
            normal distribution.

    Raises:
        ValueError: the kind is unknown, the tolerance is not positive, or it is
            not the same to either side and is to be some standard deviations.
    """
    check_positive("sigmas", sigmas)
    sides = Sides.of(extent)
    if kind == "uniform":
        return Uniform(extent=extent)
    if kind == "triangular":
        return Triangular(extent=extent)
    if kind not in get_args(KindOverTolerance):
        raise InputError(
            f"distribution must be one of {', '.join(get_args(KindOverTolerance))}, "
            f"got {kind!r}"
        )
    if not sides.symmetric:
        raise InputError(
            f"{kind}: a tolerance of some standard deviations must be the same to "
            f"either side, got {sides.minus:g} below the nominal and {sides.plus:g} "
            "above, in SI"
        )
    sigma = sides.plus / sigmas
    if kind == "truncated_normal":
        return TruncatedNormal(sigma=sigma, extent=extent)
    record = Normal if kind == "normal" else Lognormal
    return record(sigma=sigma, within=extent)


def _check_extents(distribution: Distribution) -> None:
    """Raise InputError unless extents of a distribution are positive."""
    for field in ("extent", "within"):
        extent = getattr(distribution, field, None)
        if extent is not None:
            with named(f"{distribution.kind}: {field}"):
                Sides.of(extent)


def _check_values(kind: str, values: Sequence[float], *, repeated: bool) -> None:
    check_finite(f"{kind}: values", *values)
    if len(set(values)) < 2:
        raise InputError(
            f"{kind}: values must be two different ones or more, got {values}"
        )
    if not repeated and len(set(values)) < len(values):
        raise InputError(f"{kind}: each of the values must stand once, got {values}")


def _check_shares(
    kind: str, field: str, shares: Sequence[float] | None, count: int
) -> None:
    if shares is None:
        return
    if len(shares) != count:
        raise InputError(
            f"{kind}: {field} must be {count}, one for each value, got {len(shares)}"
        )
    for share in shares:
        check_positive(f"{kind}: {field}", share)
    check_finite(f"{kind}: sum of the {field}", sum(shares))


def _sides_around(values: Sequence[float], nominal: float) -> Sides:
    """Return how far the least and the greatest of values, and the nominal, go."""
    return Sides(
        minus=max(0.0, nominal - min(values)), plus=max(0.0, max(values) - nominal)
    )
