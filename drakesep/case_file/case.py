"""What a case file holds: a separation, its tolerances and its requirements.

Keys carry their units; a `Case` hands everything on in SI and radians.
"""

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import (
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from ruamel.yaml import YAML

from drakesep.analysis.analysis_case import AnalysisCase, ClearancePairs
from drakesep.analysis.metrics.clearances import CLEARANCE, NO_CONTACT
from drakesep.analysis.metrics.requirements import Requirement, UnusableLimit
from drakesep.analysis.tolerances.box import ToleranceBox, UnphysicalTolerance
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.case_file.attachments import AttachmentSection, LoadSection
from drakesep.case_file.before_separation import BeforeSeparationSection
from drakesep.case_file.bodies import BodySection
from drakesep.case_file.dispersions import (
    RankCorrelationSection,
    Tolerance,
    tolerances_in_si,
)
from drakesep.case_file.errors import CaseError, explained
from drakesep.case_file.failure_cases import FailureCases, failure_cases_in_si
from drakesep.case_file.geometry import ClearanceSection, RecontactSection
from drakesep.case_file.orbit import OrbitSection
from drakesep.case_file.others import (
    CorrelationSection,
    PairSection,
    PublishedSection,
    RequirementSection,
    RunSection,
)
from drakesep.case_file.section import Name, Section, files_of
from drakesep.case_file.values import parameter_of, values_in_si
from drakesep.systems.checks import named
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.separation import Pair, Separation
from drakesep.tables.columns import tolerance_text
from drakesep.tables.roles import check_labels
from drakesep.units import unit_of, with_unit


if TYPE_CHECKING:  # imports Drake
    from drakesep.analysis.clearance.objective import LowestClearance


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a case was read from; cases that say the same are equal wherever."""

    source: str | None = field(default=None, compare=False)
    """The file, or the name if it is built in; None: made or changed in Python."""
    text: str | None = field(default=None, compare=False)
    """What stands there."""


class Case(Section):
    """A separation with its tolerances and requirements, as a case file holds it.

    It is turned into SI once, when it is read or made; `in_si` returns that.
    """

    name: Name
    """Of the case: results go to a folder of this name."""
    description: str = ""
    """A line for `drakesep cases`."""
    pair: PairSection | None = None
    """The body that leaves, and from which; or several, in `pairs`."""
    pairs: list[PairSection] = Field(default_factory=list)
    """The bodies that leave, each from another; in place of `pair`."""
    bodies: dict[Name, BodySection] = Field(min_length=2)
    """All bodies, by name."""
    attachments: dict[Name, AttachmentSection] = Field(min_length=1)
    """Where bodies are held together until they are released, by name."""
    loads: dict[Name, LoadSection] = Field(default_factory=dict)
    """Thrusters, retro-rockets, disturbances."""
    orbit: OrbitSection | None = None
    """Gravity of the Earth on W's orbit; free of gravity if left out."""
    before_separation: BeforeSeparationSection = BeforeSeparationSection()
    """Motion of the mated stack at t = 0."""
    dispersions: dict[str, Tolerance] = Field(default_factory=dict)
    """Tolerances of the values above, and how they are distributed in a campaign."""
    ellipsoids: list[CorrelationSection] = Field(default_factory=list)
    """Dispersed parameters that go together."""
    correlations: list[RankCorrelationSection] = Field(default_factory=list)
    """Dispersed parameters that are correlated in a campaign."""
    requirements: list[RequirementSection] = Field(default_factory=list)
    """What runs are held against."""
    objectives: Literal["paper"] | None = None
    """What is looked at beside the requirements: the paper's objectives, or nothing.
    `published` needs them."""
    clearance: ClearanceSection = ClearanceSection()
    """Which of the bodies' geometry is measured."""
    recontact: RecontactSection | None = None
    """How it pushes where it touches again; without, it is only measured."""
    run: RunSection
    """How long, and how it is integrated."""
    published: list[PublishedSection] = Field(default_factory=list)
    """Worst cases of a publication, to be compared with ours."""
    failure_cases: FailureCases = Field(default_factory=dict)
    """What may go wrong, by name, or `standard`: what `verify --failures` looks at."""
    failures: dict[str, float] = Field(default_factory=dict)
    """Failure cases that happen in a campaign, with their probability in a launch."""

    _record: AnalysisCase = PrivateAttr()
    _origin: Origin = PrivateAttr()

    @model_validator(mode="after")
    def _check_pairs(self) -> Self:
        if (self.pair is None) == (not self.pairs):
            got = "none" if self.pair is None else "both"
            raise ValueError(f"must have one of 'pair' and 'pairs', got {got}")
        return self

    @model_validator(mode="after")
    def _turn_into_si(self, info: ValidationInfo) -> Self:
        self._record = self._in_si()
        self._origin = (info.context or {}).get("origin", Origin())
        return self

    def _in_si(self) -> AnalysisCase:
        separation = self._separation()
        with named("dispersions"):
            tolerances = tolerances_in_si(separation, self.dispersions)
        with named("ellipsoids"):
            ellipsoids = [
                section.in_si(
                    tuple(parameter_of(separation, key) for key in section.parameters)
                )
                for section in self.ellipsoids
            ]
        with named("correlations"):
            correlations = [section.in_si(separation) for section in self.correlations]
        with named("failure_cases"):
            failures = failure_cases_in_si(separation, tolerances, self.failure_cases)
        published = []
        for section in self.published:
            with named(f"published: {section.label}"):
                published.append(section.in_si(separation, tolerances))
        try:
            record = AnalysisCase(
                name=self.name,
                separation=separation,
                integration=self.run.in_si(),
                tolerances=tolerances,
                ellipsoids=tuple(ellipsoids),
                correlations=tuple(correlations),
                requirements=self._limits(separation),
                objectives=self.objectives,
                clearance=self._clearance_pairs(),
                published=tuple(published),
                failure_cases=failures,
                failure_probabilities=self.failures,
            )
        except UnphysicalTolerance as error:
            got = tolerance_text(error.dispersion)
            raise CaseError(
                f"dispersions: {with_unit(error.dispersion.name)} {got}: {error.reason}"
            ) from error
        except UnusableLimit as error:
            raise CaseError(_in_words_of_files(error)) from error
        check_labels(record, record.objective_names)
        return record

    def _separation(self) -> Separation:
        touching, recontact = self.clearance.touching, self.recontact
        first, *others = self._pairs
        mated = Separation(
            bodies=tuple(body.in_si(name) for name, body in self.bodies.items()),
            attachments=tuple(a.in_si(name) for name, a in self.attachments.items()),
            A=first.A,
            B=first.B,
            direction=first.direction,
            others=tuple(Pair(A=x.A, B=x.B, direction=x.direction) for x in others),
            loads=tuple(load.in_si(name) for name, load in self.loads.items()),
            initial=self.before_separation.in_si(),
            orbit=None if self.orbit is None else self.orbit.in_si(),
            recontact=None if recontact is None else recontact.in_si(touching),
            duration=self.run.duration_s,
        )
        with named("before_separation"):
            return self.before_separation.taken(mated)

    def _clearance_pairs(self) -> ClearancePairs:
        pairs = self.clearance.pairs
        return ClearancePairs(
            pairs=None if pairs is None else tuple(pairs),
            touching=tuple(self.clearance.touching),
        )

    @property
    def _pairs(self) -> list[PairSection]:
        return self.pairs if self.pair is None else [self.pair]

    def _limits(self, separation: Separation) -> tuple[Requirement, ...]:
        """Return the requirements in SI."""
        with named("requirements"):
            return tuple(
                requirement
                for section in self.requirements
                for requirement in section.requirements(separation)
            )

    def in_si(self) -> AnalysisCase:
        """Return the case in SI and radians, as studies take it."""
        return self._record

    @property
    def source(self) -> str | None:
        """The file or built-in case that it was read from; None if it was not."""
        return self._origin.source

    @property
    def text(self) -> str:
        """The case as a case file has it: that which was read, or one of its own."""
        if self._origin.text is not None:
            return self._origin.text
        stream = io.StringIO()
        yaml = YAML(typ="safe", pure=True)
        yaml.representer.sort_base_mapping_type_on_output = False  # tables follow it
        yaml.dump(self.model_dump(mode="json", exclude_none=True), stream)
        return stream.getvalue()

    @property
    def files(self) -> tuple[Path, ...]:
        """The meshes and models that it names."""
        return tuple(dict.fromkeys(map(Path, files_of(self))))

    def replaced(self, **sections: Any) -> Self:
        """Return the case with some of its sections changed, checked as a file is.

        Args:
            sections: new ones by their keys, as a case file or a `Case` has them.

        Raises:
            CaseError: the changed case is wrong.
        """
        kept = {key: getattr(self, key) for key in self.model_fields_set}
        try:
            return type(self).model_validate(kept | sections)
        except ValidationError as error:
            raise explained(error) from error

    def model_copy(
        self, *, update: Mapping[str, Any] | None = None, deep: bool = False
    ) -> Self:
        """Return what `replaced` does: no copy is left unchecked."""
        return self.replaced(**(update or {}))

    @property
    def separation(self) -> Separation:
        """The separation, in SI."""
        return self._record.separation

    @property
    def integration(self) -> Integration:
        """How runs are integrated."""
        return self._record.integration

    @property
    def box(self) -> ToleranceBox:
        """The tolerances, in SI."""
        return self._record.box

    @property
    def tolerance_set(self) -> ToleranceSet:
        """What the tolerances admit, and can exist."""
        return self._record.tolerance_set

    @property
    def limits(self) -> tuple[Requirement, ...]:
        """The requirements, in SI, one for each axis."""
        return self._record.requirements

    @property
    def has_clearance(self) -> bool:
        """Whether parts of two bodies may come near each other."""
        return self._record.has_clearance

    def lowest_clearance(self, metric: str = CLEARANCE) -> "LowestClearance":
        """Return a new objective that makes the smallest distance small.

        Args:
            metric: name of the clearance, as ``clearance_to_ring_until_0.5_m``; without
                a window it is that of the whole run.

        Raises:
            ValueError: there is no such clearance.
        """
        return self._record.lowest_clearance(metric)

    def values_in_si(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return parameter values in SI.

        Args:
            values: by the names with units, such as ``payload.cg_x_mm``.

        Raises:
            CaseError: a name is unknown.
        """
        return values_in_si(self._record.separation, values)


def _in_words_of_files(error: UnusableLimit) -> str:
    """Return what is wrong with a limit by the keys and in the units of case files."""
    wrong = error.requirement
    key = "at_most" if wrong.from_above else "at_least"
    if wrong.forbids_contact:
        key = NO_CONTACT
    limit = unit_of(wrong.metric).from_si(wrong.limit)
    said = error.said(with_unit(wrong.metric), key, limit)
    if wrong.measured_apart and wrong.limit <= 0.0 and key == "at_least":
        said += f"; that nothing touches is 'quantity: {NO_CONTACT}'"
    return said
