"""Distributions as a case file states them: over a tolerance, or by their numbers."""

from typing import Self

from pydantic import model_validator

from drakesep.analysis.tolerances import sides
from drakesep.analysis.tolerances.distributions import (
    SIGMAS,
    Discrete,
    KindOverTolerance,
    Lognormal,
    Normal,
    Table,
    Triangular,
    TruncatedNormal,
    Uniform,
    over_tolerance,
)
from drakesep.analysis.tolerances.sides import Distribution
from drakesep.case_file.extents import (
    BoundsSection,
    Extent,
    Width,
    extent_in_si,
    side_in_si,
)
from drakesep.case_file.section import Column, Positive, Section
from drakesep.systems.checks import named
from drakesep.units import unit_of


class NormalSection(Section):
    """A normal distribution about the nominal; or a lognormal one, whose median it is.

    Searches look at three standard deviations to either side, or of a lognormal one
    between the quantiles that these are of a normal one.
    """

    sigma: Width
    """Standard deviation of the values."""


class TruncatedNormalSection(Section):
    """A normal distribution about the nominal, without what lies beyond a tolerance."""

    sigma: Width
    """Standard deviation of the whole."""
    tolerance: Extent
    """Beyond which there is nothing."""


class TableSection(Section):
    """Values as they were measured, with straight lines between their shares."""

    values: Column
    """Of the parameter."""
    weights: Column | None = None
    """Of each value; all the same if left out."""


class DiscreteSection(Section):
    """One of some values; searches look at what lies between them too."""

    values: Column
    """Of the parameter."""
    probabilities: Column
    """Of each value."""


class ToleranceSection(BoundsSection):
    """A tolerance by its bounds, by its sides or to both; or a distribution.

    One of these is stated. Numbers are in the unit of the parameter.
    """

    tolerance: Extent | None = None
    """To either side, as a number alone is."""
    distribution: KindOverTolerance | None = None
    """Over a tolerance, bounds or sides; uniform if left out."""
    sigmas: Positive | None = None
    """Standard deviations that the tolerance is, 3 if left out: of `normal`,
    `lognormal` and `truncated_normal`."""
    uniform: Extent | None = None
    """All values of it alike."""
    triangular: Extent | None = None
    """Most likely at the nominal, ever less towards the ends."""
    normal: NormalSection | None = None
    """About the nominal."""
    truncated_normal: TruncatedNormalSection | None = None
    """The same, without its ends."""
    lognormal: NormalSection | None = None
    """With the nominal as its median."""
    table: TableSection | None = None
    """Of measured values."""
    discrete: DiscreteSection | None = None
    """Of some values."""
    within: Extent | None = None
    """Of a distribution that is stated so: what searches look at, in place of what is
    usual of its kind."""

    @model_validator(mode="after")
    def check(self) -> Self:
        """Raise ValueError unless keys go together."""
        stated = [key for key in _STATED if getattr(self, key) is not None]
        bounds = self.bounds_given
        if not stated and bounds:
            self.check_bounds()
        elif len(stated) != 1 or bounds:
            got = " and ".join([*bounds, *stated]) or "none"
            raise ValueError(
                f"must have one of {', '.join(_STATED)}, lower and upper, or minus and "
                f"plus, got {got}"
            )
        of_tolerance = bounds or stated == ["tolerance"]
        if self.distribution is not None and not of_tolerance:
            raise ValueError(
                f"distribution must be of a tolerance, bounds or sides, got {stated[0]}"
            )
        if self.sigmas is not None and self.distribution not in _OF_SIGMA:
            raise ValueError(
                f"sigmas must be of a distribution that is {', '.join(_OF_SIGMA)}, got "
                f"{self.distribution or 'none'}"
            )
        if self.within is not None and of_tolerance:
            raise ValueError(
                "within must be of a distribution without a tolerance, which is what "
                "searches look at"
            )
        return self

    def in_si(self, key: str, name: str, nominal: float) -> sides.Tolerance:
        """Return it.

        Args:
            key: of the parameter, for errors.
            name: of the parameter, without unit.
            nominal: value of the parameter, in SI.

        Raises:
            CaseError: the nominal is beyond a bound, or a share is one of zero.
            ValueError: there is no such distribution.
        """
        if self.bounds_given:
            extent: sides.Extent = self.sides_in_si(key, name, nominal)
        elif self.tolerance is not None:
            extent = extent_in_si(key, name, self.tolerance, nominal)
        else:
            return self._distribution(key, name, nominal)
        if self.distribution is None:
            return extent
        with named(key):
            return over_tolerance(self.distribution, extent, self.sigmas or SIGMAS)

    def _distribution(self, key: str, name: str, nominal: float) -> Distribution:
        """Return a distribution that states its own numbers."""

        def extent(of: Extent) -> sides.Extent:
            return extent_in_si(key, name, of, nominal)

        def sigma(of: NormalSection | TruncatedNormalSection) -> float:
            return side_in_si(f"{key}: sigma", name, of.sigma, nominal)

        def values(of: TableSection | DiscreteSection) -> tuple[float, ...]:
            return tuple(map(unit_of(name).to_si, of.values))

        within = None if self.within is None else extent(self.within)
        with named(key):
            if self.uniform is not None:
                return Uniform(extent=extent(self.uniform), within=within)
            if self.triangular is not None:
                return Triangular(extent=extent(self.triangular), within=within)
            if self.normal is not None:
                return Normal(sigma=sigma(self.normal), within=within)
            if self.truncated_normal is not None:
                of = self.truncated_normal
                return TruncatedNormal(
                    sigma=sigma(of), extent=extent(of.tolerance), within=within
                )
            if self.lognormal is not None:
                return Lognormal(sigma=sigma(self.lognormal), within=within)
            if self.table is not None:
                return Table(
                    values=values(self.table),
                    weights=self.table.weights,
                    within=within,
                )
            assert self.discrete is not None
            return Discrete(
                values=values(self.discrete),
                probabilities=self.discrete.probabilities,
                within=within,
            )


_STATED = (
    *("tolerance", "uniform", "triangular", "normal", "truncated_normal"),
    *("lognormal", "table", "discrete"),
)
"""Keys, of which a tolerance without bounds has one."""
_OF_SIGMA = ("normal", "truncated_normal", "lognormal")
