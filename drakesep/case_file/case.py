"""What a case file holds: a separation, its tolerances and its requirements.

Keys carry their units; a `Case` hands everything on in SI and radians.
"""

import math
from collections.abc import Mapping
from typing import Self

from pydantic import Field, model_validator

from drakesep.analysis.metrics.objectives import Objective, lowest, towards
from drakesep.analysis.metrics.requirements import Requirement, deviation_limits
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.case_file.attachments import AttachmentSection, LoadSection
from drakesep.case_file.bodies import BodySection
from drakesep.case_file.geometry import ClearanceSection, RecontactSection
from drakesep.case_file.others import (
    BeforeSeparationSection,
    CorrelationSection,
    OrbitSection,
    PairSection,
    PublishedSection,
    RequirementSection,
    RunSection,
)
from drakesep.case_file.section import Name, Positive, Section, named
from drakesep.systems.checks import InputError, check_finite, unknown
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.part_pairs import pairs_apart, part_pairs
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.model.separation import Separation
from drakesep.units import unit_of, with_unit


class CaseError(InputError):
    """A case cannot be read; the message names the key, what was wanted and got."""


class Case(Section):
    """A separation with its tolerances and requirements, as a case file holds it."""

    name: Name
    description: str = ""
    pair: PairSection
    bodies: dict[Name, BodySection] = Field(min_length=2)
    attachments: dict[Name, AttachmentSection] = Field(min_length=1)
    loads: dict[Name, LoadSection] = Field(default_factory=dict)
    """Thrusters, retro-rockets, disturbances."""
    orbit: OrbitSection | None = None
    before_separation: BeforeSeparationSection = BeforeSeparationSection()
    dispersions: dict[str, Positive] = Field(default_factory=dict)
    """Tolerances to either side of the values above."""
    ellipsoids: list[CorrelationSection] = Field(default_factory=list)
    """Dispersed parameters that go together."""
    requirements: list[RequirementSection] = Field(default_factory=list)
    clearance: ClearanceSection = ClearanceSection()
    """Which of the bodies' geometry is measured."""
    recontact: RecontactSection | None = None
    """Whether it pushes where it touches; measured alone if absent."""
    run: RunSection
    published: list[PublishedSection] = Field(default_factory=list)

    @model_validator(mode="after")
    def _check_meaning(self) -> Self:
        _ = self.separation, self.integration
        self._check_clearance()
        self._check_dispersions()
        self._check_ellipsoids()
        self._check_requirements()
        self._check_published()
        return self

    def _check_clearance(self) -> None:
        with named("clearance"):
            part_pairs(self.separation, self.clearance.pairs)
            part_pairs(self.separation, self.clearance.touching)

    def _check_dispersions(self) -> None:
        for key, tolerance in self.dispersions.items():
            try:
                ToleranceBox.around(
                    self.separation, self.values_in_si({key: tolerance})
                )
            except InputError as error:
                bound = f"{key} ± {tolerance:g}: " if error.__cause__ else ""
                raise CaseError(
                    f"dispersions: {bound}{error.__cause__ or error}"
                ) from error

    def _check_ellipsoids(self) -> None:
        with named("ellipsoids"):
            _ = self.tolerance_set

    def _check_requirements(self) -> None:
        quantities = [section.quantity for section in self.requirements]
        for quantity in quantities:
            if quantities.count(quantity) > 1:
                raise CaseError(f"requirements: {quantity} must stand once")
        apart = any(not section.metric.of_every_run for section in self.requirements)
        if apart and not self.has_clearance:
            raise CaseError(
                "requirements: clearance_mm needs geometry on two bodies that does not "
                "touch while mated, got none"
            )
        for section in self.requirements:
            for limit in (
                section.requirements() if section.metric.never_negative else ()
            ):
                if limit.sense == "<=" and limit.limit < 0.0:
                    raise CaseError(
                        f"requirements: {with_unit(limit.metric)}: at_most must be >= "
                        f"0, got {unit_of(limit.metric).from_si(limit.limit):g}"
                    )

    def _check_published(self) -> None:
        labels = [published.label for published in self.published]
        for published in self.published:
            label = published.label
            if labels.count(label) > 1:
                raise CaseError(f"published: label {label!r} must stand once")
            if label == "nominal" or label.startswith(("worst_", "sqp_")):
                raise CaseError(f"published: label {label!r} is taken by our own runs")
            with named(f"published: {label}"):
                with_values(self.separation, self.published_values(published))

    @property
    def separation(self) -> Separation:
        """The separation, in SI."""
        return Separation(
            bodies=tuple(body.in_si(name) for name, body in self.bodies.items()),
            attachments=tuple(a.in_si(name) for name, a in self.attachments.items()),
            A=self.pair.A,
            B=self.pair.B,
            loads=tuple(load.in_si(name) for name, load in self.loads.items()),
            initial=self.before_separation.in_si(),
            orbit=None if self.orbit is None else self.orbit.in_si(),
            recontact=self._recontact,
            duration=self.run.duration_s,
        )

    @property
    def _recontact(self) -> Recontact | None:
        if self.recontact is None:
            return None
        return self.recontact.in_si(self.clearance.touching)

    @property
    def integration(self) -> Integration:
        """How runs are integrated."""
        return self.run.in_si()

    @property
    def box(self) -> ToleranceBox:
        """The tolerances, in SI."""
        return ToleranceBox.around(self.separation, self.values_in_si(self.dispersions))

    @property
    def tolerance_set(self) -> ToleranceSet:
        """What the tolerances admit, and can exist."""
        ellipsoids = [
            section.in_si(
                tuple(
                    name
                    for key in section.parameters
                    for name in self.values_in_si({key: 0.0})
                )
            )
            for section in self.ellipsoids
        ]
        return ToleranceSet(self.separation, self.box, ellipsoids)

    @property
    def requirement_objectives(self) -> tuple[Objective, ...]:
        """What leads out of each requirement, and the time to a deviation's limit."""
        objectives = [o for limit in self.limits for o in self.towards(limit)]
        if any(math.isfinite(limit) for limit in deviation_limits(self.limits)):
            objectives.append(lowest("deviation_within_limits_until"))
        return tuple(objectives)

    def towards(self, requirement: Requirement) -> tuple[Objective, ...]:
        """Return the objectives that lead out of a requirement."""
        if requirement.measured_apart:
            return (self.lowest_clearance(),)
        return towards(requirement)

    def lowest_clearance(self) -> Objective:
        """Return the objective that makes the smallest distance small.

        Over the time for which there is a requirement on it, else over the whole run.
        """
        # Here, since it takes long: a case is read without Drake.
        from drakesep.analysis.clearance.objective import LowestClearance

        window = [
            section.until_separation_mm
            for section in self.requirements
            if not section.metric.of_every_run
        ]
        until = window[0] if window else None
        return LowestClearance(
            self.separation,
            self.clearance.pairs,
            touching=self.clearance.touching,
            until_separation=(
                None if until is None else unit_of("separation").to_si(until)
            ),
        )

    @property
    def has_clearance(self) -> bool:
        """Whether parts of two bodies may come near each other."""
        of = self.clearance
        return bool(pairs_apart(self.separation, of.pairs, of.touching))

    @property
    def limits(self) -> tuple[Requirement, ...]:
        """The requirements, in SI, one for each axis."""
        return tuple(r for section in self.requirements for r in section.requirements())

    def values_in_si(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return parameter values in SI.

        Args:
            values: by the names with units, such as ``payload.cg_x_mm``.

        Raises:
            CaseError: a name is unknown.
        """
        names = {with_unit(name): name for name in parameters(self.separation)}
        in_si = {}
        for name, value in values.items():
            if name not in names:
                raise CaseError(unknown("parameter", name, names))
            check_finite(name, value)
            in_si[names[name]] = unit_of(names[name]).to_si(value)
        return in_si

    def published_values(self, published: PublishedSection) -> dict[str, float]:
        """Return the parameter values of a published worst case, in SI."""
        marks = {"M": 1.0, "m": -1.0}
        box = {d.name: d for d in self.box.dispersions}
        values = {}
        for key, mark in published.values.items():
            [(name, value)] = self.values_in_si({key: 0.0}).items()
            if isinstance(mark, str):
                if name not in box:
                    known = map(with_unit, box)
                    raise CaseError(unknown("dispersed parameter", key, known))
                value = box[name].nominal + marks[mark] * box[name].tolerance
            else:
                value = unit_of(name).to_si(mark)
            values[name] = value
        return values
