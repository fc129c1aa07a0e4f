"""The other sections of a case file: pair, orbit, requirements, run, publications."""

import itertools
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    Strict,
    Tag,
    model_validator,
)

from drakesep.analysis.analysis_case import PrintedResult, PublishedCase
from drakesep.analysis.metrics.clearances import CLEARANCE, NO_CONTACT, clearance_name
from drakesep.analysis.metrics.metric import Metric, Owner, Sense
from drakesep.analysis.metrics.objectives import ObjectiveName
from drakesep.analysis.metrics.quantities import (
    QUANTITIES,
    Quantity,
    at_time,
    between_times,
)
from drakesep.analysis.metrics.registry import find_metric, registered_metrics
from drakesep.analysis.metrics.requirements import (
    Requirement,
    Sides,
    check_statistical,
)
from drakesep.analysis.tolerances.box import Dispersion
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.sides import Tolerance
from drakesep.case_file.errors import CaseError
from drakesep.case_file.geometry import PartNames
from drakesep.case_file.section import Name, Positive, Section, Vector, to_si
from drakesep.case_file.values import parameter_of
from drakesep.systems.checks import unknown
from drakesep.systems.model.integration import Integration, Scheme
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation
from drakesep.units import unit_of, with_unit


def _as_limits(value: Any) -> Any:
    return value if value is None or isinstance(value, list | tuple) else (value,)


def _check_mark(value: Any) -> Any:
    if value not in ("M", "m") and not isinstance(value, int | float):
        raise ValueError(f"must be M, m or a number, got {value!r}")
    return value


def limitable() -> dict[str, Metric | Quantity]:
    """Return what may be limited, by its name with unit.

    Quantities, and metrics: first those that requirements are usually on, whose limits
    hold at all times, in both directions, or of what is measured apart.
    """

    def unusual(metric: Metric) -> bool:
        of_all_times = metric.at_most or metric.at_least or metric.directions
        return metric.of_every_run and not of_all_times

    quantities = {with_unit(q.name): q for q in QUANTITIES.values()}
    metrics = {with_unit(m.stem): m for m in sorted(registered_metrics(), key=unusual)}
    return metrics | {NO_CONTACT: metrics[with_unit(CLEARANCE)]} | quantities


def _check_quantity(value: str) -> str:
    if value not in limitable():
        raise ValueError(unknown("quantity", value, limitable()))
    return value


Quantities = Annotated[str, AfterValidator(_check_quantity)]
Mark = Annotated[str | float, BeforeValidator(_check_mark)]
Limits = Annotated[tuple[float | None, ...], Strict(False), BeforeValidator(_as_limits)]
"""One for each axis; null: none."""
Seconds = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(gt=0, lt=1)]


class PairSection(Section):
    """The bodies whose separation is analysed."""

    A: str
    """Pushed from."""
    B: str
    """Pushed away."""
    direction: Vector = (1.0, 0.0, 0.0)
    """In which B leaves, a unit vector fixed in A."""


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


class WhenSection(Section):
    """A time in seconds, or the stretch from one to another."""

    at_s: Seconds | None = None
    """The time; or, in its place, the stretch."""
    from_s: Seconds | None = None
    """Where the stretch begins; the start of the run if absent."""
    to_s: Positive | None = None
    """Where it ends; the end of the run if absent."""

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        stretch = self.from_s is not None or self.to_s is not None
        if stretch == (self.at_s is not None):
            raise ValueError("must have at_s, or from_s, to_s or both")
        start, end = self.from_s, self.to_s
        if start is not None and end is not None and not start < end:
            raise ValueError(f"to_s must be > from_s, got {start:g} to {end:g}")
        return self

    @property
    def in_names(self) -> str:
        """What stands for it in names of metrics."""
        if self.at_s is not None:
            return at_time(self.at_s)
        return between_times(self.from_s, self.to_s)


MomentName: TypeAlias = Literal[
    "since_release",
    "after_separation",
    "until_separation",
    "at_release",
    "at_separation",
    "at_end",
]


WhenOf: TypeAlias = Annotated[
    Annotated[MomentName, Tag("moment")] | Annotated[WhenSection, Tag("seconds")],
    Discriminator(lambda value: "moment" if isinstance(value, str) else "seconds"),
]


_OF_CLEARANCES = ("parts", "to", "until_separation_mm")
"""Keys that only clearances have."""


class RequirementSection(Section):
    """Limits on a quantity at some time of the run, or on a metric."""

    quantity: Quantities
    """Name of the quantity or of the metric, with its unit; or `no_contact`."""
    when: WhenOf | None = None
    """Of a quantity; over the whole run if absent. A metric says it in its name."""
    at_most: Limits | None = None
    """Limits from above, in the unit of the quantity; this, `at_least` or both."""
    at_least: Limits | None = None
    """Limits from below, in the unit of the quantity; this, `at_most` or both."""
    pair: str | None = None
    """The body that leaves, B of its pair; if absent, of each pair. Of a clearance and
    of `no_contact`, if absent, all parts of different bodies are measured."""
    to: str | None = None
    """Of these: the body to which B is measured; if absent, A of the pair."""
    parts: list[PartNames] | None = None
    """Of these, in place of `pair` and `to`: pairs of parts, each held by itself."""
    of: str | None = None
    """The attachment or the spring, of a joint's or a spring's; if absent, of each."""
    id: str = ""
    """By which others know the requirement."""
    source: str = ""
    """Where it comes from."""
    share: Share | None = None
    """Of launches that must be within each limit, such as 0.99865; if absent, every run
    must, also the worst that the tolerances admit."""
    confidence: Share | None = None
    """At which a campaign is to show that share, such as 0.9; with `share`."""
    sides: Sides = "one"
    """Of a share: `one`, of those within one limit, each by itself; `two`, of those
    between the limits of an axis, or of a magnitude."""
    until_separation_mm: Positive | None = None
    """Of these: how far B is to move in its direction until it holds no more; every B,
    if all parts are measured; of two parts, each of their bodies that leaves. If
    absent, it holds to the end of the run."""

    @model_validator(mode="after")
    def _check_limits(self) -> Self:
        if self.when is not None and self._quantity is None:
            raise ValueError(f"{self.quantity} has no 'when': its name says it")
        given = [key for key in _OF_CLEARANCES if getattr(self, key) is not None]
        if given and not self.of_clearance:
            raise ValueError(f"{given[0]} must stand with clearance_mm or {NO_CONTACT}")
        if self.parts is not None and (self.pair or self.to):
            raise ValueError("must have 'parts', or 'pair' and 'to', got both")
        if self.parts == []:
            raise ValueError("parts: must be one pair or more, got none")
        limited = self.at_most is not None or self.at_least is not None
        if limited and self.quantity == NO_CONTACT:
            raise ValueError(f"{NO_CONTACT} has no limit")
        if not limited and self.quantity != NO_CONTACT:
            raise ValueError("must have 'at_most', 'at_least' or both, got none")
        axes = len(self.metric.axes)
        for limits in (self.at_most, self.at_least):
            if limits is not None and len(limits) != axes:
                raise ValueError(
                    f"must have {axes} limits, got {', '.join(map(str, limits))}"
                )
        if not self._sides:
            raise ValueError("must have a limit that is no null, got none")
        self._check_band()
        check_statistical(self.quantity, self.share, self.confidence, self.sides)
        return self

    @property
    def of_clearance(self) -> bool:
        """Whether it is on how near parts come."""
        return not self.metric.of_every_run

    def _check_band(self) -> None:
        for low, high in zip(self.at_least or (), self.at_most or (), strict=False):
            if low is not None and high is not None and low > high:
                raise ValueError(
                    f"at_least must not be above at_most, got {low:g} and {high:g}"
                )

    @property
    def _sides(self) -> list[tuple[str, Sense, float]]:
        """The limits, each with its metric and sense."""
        if self.quantity == NO_CONTACT:
            return [(CLEARANCE, ">", 0.0)]
        sides: list[tuple[str, Sense, float]] = []
        for name, low, high in zip(
            self.metric.names,
            self.at_least or itertools.repeat(None),
            self.at_most or itertools.repeat(None),
            strict=False,
        ):
            if low is not None:
                sides.append((name, ">=", low))
            if high is not None:
                sides.append((name, "<=", high))
        return sides

    @property
    def _quantity(self) -> Quantity | None:
        limited = limitable()[self.quantity]
        return limited if isinstance(limited, Quantity) else None

    @property
    def metric(self) -> Metric:
        """That is limited."""
        limited = limitable()[self.quantity]
        if isinstance(limited, Metric):
            return limited
        when = self.when.in_names if isinstance(self.when, WhenSection) else self.when
        found = find_metric("_".join(filter(None, (limited.name, when))))
        assert found is not None
        return found[0]

    def requirements(self, separation: Separation) -> list[Requirement]:
        """Return the requirements in SI, one for each limit.

        Args:
            separation: that has what they are about.

        Raises:
            CaseError: it has no such body, attachment or spring.
        """
        owner, bodies = self.metric.owner, [pair.B for pair in separation.pairs]
        if owner is Owner.PAIR:
            key, known, named, other = "pair", bodies, self.pair, self.of
        else:
            of_springs = owner is Owner.SPRING
            known = [*separation.owners_of_forces(springs=of_springs)]
            key, named, other = "of", self.of, self.pair
        if other is not None:
            raise CaseError(f"{self.quantity}: must be of one by {key!r}, got {other}")
        if named is not None and named not in known:
            raise CaseError(unknown(owner.value, named, known))
        if self.of_clearance:
            return [
                self._in_si(name, sense, limit)
                for name in self._clearances(separation)
                for _, sense, limit in self._sides
            ]
        return [
            self._in_si(f"{prefix}{name}", sense, limit)
            for prefix in (
                "" if name == bodies[0] else f"{name}."
                for name in (known if named is None else [named])
            )
            for name, sense, limit in self._sides
        ]

    def _clearances(self, separation: Separation) -> list[str]:
        """Return the names of the clearances that it is on."""
        until = self._window
        if self.parts is not None:
            return [clearance_name("", until, parts=two) for two in self.parts]
        if self.pair is None and self.to is None:
            return [clearance_name("", until)]
        if self.pair is None and separation.others:
            raise CaseError(
                f"{self.quantity}: to {self.to}: must have 'pair', got none"
            )
        pair = separation.pair_of(self.pair or separation.B)
        prefix = "" if pair.B == separation.B else f"{pair.B}."
        return [prefix + clearance_name(self.to or pair.A, until)]

    @property
    def _window(self) -> float | None:
        """How far B is to move, m."""
        until = self.until_separation_mm
        return None if until is None else unit_of("separation").to_si(until)

    def _in_si(self, metric: str, sense: Sense, limit: float) -> Requirement:
        return Requirement(
            metric=metric,
            sense=sense,
            limit=unit_of(metric).to_si(limit),
            id=self.id,
            source=self.source,
            share=self.share,
            confidence=self.confidence,
            sides=self.sides,
        )


class RunSection(Section):
    """Length of the run, and how it is integrated."""

    duration_s: Positive
    """From t = 0."""
    integrator: Scheme = Integration().scheme
    """Drake's; the last is implicit, for stiff joints with much damping."""
    accuracy: Positive = Integration().accuracy
    """Of the error control, in m, rad, m/s and rad/s a step: 1e-12 to 1e-3.
    runge_kutta5 is held to a tenth of it."""
    max_step_s: Positive = Integration().max_step
    """Longest step."""
    time_limit_s: Positive = Integration().time_limit
    """Of a processor's time, after which a run in Drake fails: the last resort."""

    def in_si(self) -> Integration:
        """Return how runs are integrated."""
        return Integration(
            scheme=self.integrator,
            accuracy=self.accuracy,
            max_step=self.max_step_s,
            time_limit=self.time_limit_s,
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
        self, separation: Separation, tolerances: Mapping[str, Tolerance]
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
        self, separation: Separation, tolerances: Mapping[str, Tolerance]
    ) -> dict[str, float]:
        nominal = parameters(separation)
        values = {}
        for key, mark in self.values.items():
            name = parameter_of(separation, key)
            if not isinstance(mark, str):
                values[name] = unit_of(name).to_si(mark)
            elif name in tolerances:
                dispersion = Dispersion(
                    name=name, nominal=nominal[name], tolerance=tolerances[name]
                )
                values[name] = dispersion.bounds[mark == "M"]
            else:
                known = map(with_unit, tolerances)
                raise CaseError(unknown("dispersed parameter", key, known))
        return values
