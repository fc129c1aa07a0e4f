"""The other sections of a case file: pair, orbit, requirements, run, publications."""

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Strict, model_validator

from drakesep.analysis.analysis_case import PrintedResult, PublishedCase
from drakesep.analysis.metrics.metric import Metric, Sense
from drakesep.analysis.metrics.objectives import ObjectiveName
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.case_file.errors import CaseError
from drakesep.case_file.section import Name, Positive, Section, Vector, to_si
from drakesep.case_file.values import parameter_of
from drakesep.systems.checks import unknown
from drakesep.systems.model.integration import Integration, Scheme
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import (
    EARTH_RADIUS,
    InitialMotion,
    Orbit,
    Separation,
)
from drakesep.units import unit_of, with_unit


def _as_limits(value: Any) -> Any:
    return value if value is None or isinstance(value, list | tuple) else (value,)


def _check_mark(value: Any) -> Any:
    if value not in ("M", "m") and not isinstance(value, int | float):
        raise ValueError(f"must be M, m or a number, got {value!r}")
    return value


def _limited() -> dict[str, Metric]:
    """Return the metrics that may be limited by their names with units.

    First those that requirements are usually on: a limit of theirs holds at all times,
    in both directions, or of what is measured apart.
    """

    def unusual(metric: Metric) -> bool:
        of_all_times = metric.at_most or metric.at_least or metric.directions
        return metric.of_every_run and not of_all_times

    return {with_unit(m.stem): m for m in sorted(registered_metrics(), key=unusual)}


def _check_quantity(value: str) -> str:
    *known, last = map(repr, _limited())
    if repr(value) not in (*known, last):
        raise ValueError(f"must be {', '.join(known)} or {last}, got {value!r}")
    return value


Quantity = Annotated[str, AfterValidator(_check_quantity)]
Mark = Annotated[str | float, BeforeValidator(_check_mark)]
Limits = Annotated[tuple[float, ...], Strict(False), BeforeValidator(_as_limits)]


class PairSection(Section):
    """The bodies whose separation is analysed."""

    A: str
    """Pushed from."""
    B: str
    """Pushed away."""


class OrbitSection(Section):
    """A circular orbit."""

    altitude_km: Positive
    """Above a sphere of the Earth's equatorial radius."""

    def in_si(self) -> Orbit:
        """Return the orbit."""
        return Orbit(radius=EARTH_RADIUS + 1000.0 * self.altitude_km)


class BeforeSeparationSection(Section):
    """Motion of the mated stack at t = 0."""

    attitude_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of A in W."""
    rate_deg_s: Vector = (0.0, 0.0, 0.0)
    """Angular velocity of A in W, in A's axes."""

    def in_si(self) -> InitialMotion:
        """Return the motion."""
        return InitialMotion(
            rpy_WA=to_si("attitude", self.attitude_deg),
            w_WA_A=to_si("rate", self.rate_deg_s),
        )


class CorrelationSection(Section):
    """Dispersed parameters that do not all reach their tolerances together."""

    parameters: list[str]
    """Keys of `dispersions`."""
    correlation: list[list[float]] | None = None
    """Matrix with 1 on its diagonal; uncorrelated if left out."""

    def in_si(self, names: tuple[str, ...]) -> Ellipsoid:
        """Return the ellipsoid of parameters whose names without units are given."""
        rows = self.correlation
        return Ellipsoid(
            names=names,
            correlation=None if rows is None else tuple(map(tuple, rows)),
        )


class RequirementSection(Section):
    """Limits on one metric, one for each axis that it has."""

    quantity: Quantity
    """Name of the metric, with its unit."""
    at_most: Limits | None = None
    """Limits from above, in the metric's unit; this or `at_least`."""
    at_least: Limits | None = None
    """Limits from below, in the metric's unit; this or `at_most`."""
    until_separation_mm: Positive | None = None
    """Of a clearance: how far B is to move along A's x axis until it holds no more."""

    @model_validator(mode="after")
    def _check_limits(self) -> Self:
        if (self.at_most is None) == (self.at_least is None):
            got = "none" if self.at_most is None else "both"
            raise ValueError(f"must have one of 'at_most' and 'at_least', got {got}")
        of_clearance = not self.metric.of_every_run
        if of_clearance and self.at_least is None:
            raise ValueError("a clearance must have 'at_least', got 'at_most'")
        if of_clearance and min(self._limits, default=0.0) <= 0.0:
            raise ValueError(  # at contact it is 0, however deep
                f"at_least of a clearance must be > 0, got {self._limits[0]:g}"
            )
        if not of_clearance and self.until_separation_mm is not None:
            raise ValueError("until_separation_mm must stand with clearance_mm")
        axes = len(self.metric.axes)
        if len(self._limits) != axes:
            raise ValueError(
                f"must have {axes} limits, got {', '.join(map(str, self._limits))}"
            )
        return self

    @property
    def _limits(self) -> tuple[float, ...]:
        limits = self.at_least if self.at_most is None else self.at_most
        assert limits is not None  # _check_limits
        return limits

    @property
    def metric(self) -> Metric:
        """That is limited."""
        return _limited()[self.quantity]

    def requirements(self) -> list[Requirement]:
        """Return the requirements in SI, one for each axis."""
        sense: Sense = "<=" if self.at_least is None else ">="
        condition = ""
        if self.until_separation_mm is not None:
            condition = f"until {self.until_separation_mm:g} mm of separation"
        return [
            Requirement(
                metric=name,
                sense=sense,
                limit=unit_of(name).to_si(value),
                condition=condition,
            )
            for name, value in zip(self.metric.names, self._limits, strict=True)
        ]


class RunSection(Section):
    """Length of the run, and how it is integrated."""

    duration_s: Positive
    """From t = 0."""
    integrator: Scheme = Integration().scheme
    """Drake's; the third is implicit, for stiff joints with much damping."""
    accuracy: Positive = Integration().accuracy
    """Of the error control, in m, rad, m/s and rad/s a step: 1e-12 to 1e-3."""
    max_step_s: Positive = Integration().max_step
    """Longest step."""

    def in_si(self) -> Integration:
        """Return how runs are integrated."""
        return Integration(
            scheme=self.integrator, accuracy=self.accuracy, max_step=self.max_step_s
        )


class PrintedSection(Section):
    """What a publication prints of a worst case, in the form of the paper's Table 4."""

    rate_deg_s: Vector
    """Angular rate modulus."""
    deviation_within_limits_until_s: float
    """Until when angular deviations are within their limits."""
    longitudinal_speed_m_s: float
    """With respect to A."""
    iterations: int
    """Of the publication's solver."""

    def in_si(self) -> PrintedResult:
        """Return it."""
        return PrintedResult(
            rate=to_si("rate", self.rate_deg_s),
            deviation_within_limits_until=self.deviation_within_limits_until_s,
            longitudinal_speed=self.longitudinal_speed_m_s,
            iterations=self.iterations,
        )


class PublishedSection(Section):
    """A published worst case: M and m for the bounds of a tolerance, or a value."""

    label: Name
    """Of its run, in tables and plots."""
    objectives: list[ObjectiveName]
    """Of which it is the published worst case."""
    values: dict[str, Mark]
    """By parameter: `M` or `m` for a bound of its tolerance, or a value; the others are
    nominal."""
    printed: PrintedSection
    """What it is compared with."""

    def in_si(
        self, separation: Separation, tolerances: Mapping[str, float]
    ) -> PublishedCase:
        """Return it.

        Args:
            separation: gives the nominal values.
            tolerances: by parameter name, in SI, which M and m stand for.

        Raises:
            CaseError: a parameter is unknown, or is marked and not dispersed.
        """
        return PublishedCase(
            label=self.label,
            values=self._values(separation, tolerances),
            objectives=tuple(self.objectives),
            printed=self.printed.in_si(),
        )

    def _values(
        self, separation: Separation, tolerances: Mapping[str, float]
    ) -> dict[str, float]:
        nominal, signs = parameters(separation), {"M": 1.0, "m": -1.0}
        values = {}
        for key, mark in self.values.items():
            name = parameter_of(separation, key)
            if not isinstance(mark, str):
                values[name] = unit_of(name).to_si(mark)
            elif name in tolerances:
                values[name] = nominal[name] + signs[mark] * tolerances[name]
            else:
                known = map(with_unit, tolerances)
                raise CaseError(unknown("dispersed parameter", key, known))
        return values
