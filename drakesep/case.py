"""What a case file holds: a separation, its tolerances and its requirements.

Keys carry their units; a `Case` hands everything on in SI and radians.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    model_validator,
)

from drakesep.analysis.dispersions import Box
from drakesep.analysis.metrics import ANGLES, AXES
from drakesep.analysis.objectives import ObjectiveName
from drakesep.analysis.requirements import Requirement
from drakesep.systems.checks import InputError, Vector3, check_finite, unknown
from drakesep.systems.joints import Joint
from drakesep.systems.model import (
    EARTH_RADIUS,
    Attachment,
    Body,
    InitialMotion,
    Orbit,
    Separation,
)
from drakesep.systems.parameters import parameters, with_values
from drakesep.systems.pushers import DisplacementSpring, Spring
from drakesep.systems.settings import Integration, Scheme
from drakesep.units import unit_of, with_unit


Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$")]


def _check_vector(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise ValueError(f"must be 3 numbers, got {value!r}")
    return value


def _as_limits(value: Any) -> Any:
    return value if value is None or isinstance(value, list | tuple) else (value,)


def _check_mark(value: Any) -> Any:
    if value not in ("M", "m") and not isinstance(value, int | float):
        raise ValueError(f"must be M, m or a number, got {value!r}")
    return value


Mark = Annotated[str | float, BeforeValidator(_check_mark)]
Vector = Annotated[
    tuple[float, float, float], Strict(False), BeforeValidator(_check_vector)
]
Limits = Annotated[tuple[float, ...], Strict(False), BeforeValidator(_as_limits)]


class CaseError(InputError):
    """A case cannot be read; the message names the key, what was wanted and got."""


class _Section(BaseModel):
    model_config = ConfigDict(
        strict=True, frozen=True, extra="forbid", allow_inf_nan=False
    )

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in data:
                if key not in cls.model_fields:
                    raise ValueError(unknown("key", key, cls.model_fields))
        return data


class PairSection(_Section):
    """The bodies whose separation is analysed."""

    A: str
    """Pushed from."""
    B: str
    """Pushed away."""


class InertiaSection(_Section):
    """Inertia about the CG in body axes: entries of the matrix."""

    xx: float
    yy: float
    zz: float
    xy: float = 0.0
    xz: float = 0.0
    yz: float = 0.0


class MatedPlaceSection(_Section):
    """Where a body stands in the frame of A while mated."""

    position_mm: Vector = (0.0, 0.0, 0.0)
    attitude_deg: Vector = (0.0, 0.0, 0.0)


class BodySection(_Section):
    """A rigid body."""

    mass_kg: Positive
    cg_mm: Vector
    inertia_kg_m2: InertiaSection
    mated: MatedPlaceSection = MatedPlaceSection()


class JointSection(_Section):
    """Gains of the joint by constraint forces."""

    stiffness_N_m: NotNegative
    damping_N_s_m: NotNegative
    angular_stiffness_N_m_rad: NotNegative
    angular_damping_N_m_s_rad: NotNegative


class SpringSection(_Section):
    """A separation spring: driven by time, as the paper's, or by displacement."""

    name: Name
    law: Literal["time", "displacement"] = "time"
    force_max_N: Positive
    stroke_mm: Positive
    design_mass_kg: Positive | None = None
    damping_N_s_m: NotNegative = 0.0

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        timed = self.law == "time"
        if timed and self.design_mass_kg is None:
            raise ValueError("design_mass_kg: missing; law: time needs it")
        if not timed and self.design_mass_kg is not None:
            raise ValueError("design_mass_kg: only law: time has one, got displacement")
        if timed and self.damping_N_s_m:
            raise ValueError("damping_N_s_m: only law: displacement has it, got time")
        return self


class AttachmentSection(_Section):
    """A place where two bodies are held together."""

    A: str
    B: str
    position_mm: Vector
    joint: JointSection
    spring: SpringSection | None = None
    release_time_s: float = 0.0


class OrbitSection(_Section):
    """A circular orbit."""

    altitude_km: Positive


class BeforeSeparationSection(_Section):
    """Motion of the mated stack at t = 0."""

    attitude_deg: Vector = (0.0, 0.0, 0.0)
    rate_deg_s: Vector = (0.0, 0.0, 0.0)


class RequirementSection(_Section):
    """Limits on one quantity, one for each axis that it has."""

    quantity: Literal[
        "rate_after_separation_deg_s",
        "deviation_at_separation_deg",
        "longitudinal_speed_after_separation_m_s",
    ]
    at_most: Limits | None = None
    at_least: Limits | None = None

    @model_validator(mode="after")
    def _check_limits(self) -> Self:
        if (self.at_most is None) == (self.at_least is None):
            got = "none" if self.at_most is None else "both"
            raise ValueError(f"must have one of 'at_most' and 'at_least', got {got}")
        axes = len(_requirement_axes(self.quantity))
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

    def requirements(self) -> list[Requirement]:
        """Return the requirements in SI, one for each axis."""
        sense: Literal["<=", ">="] = "<=" if self.at_least is None else ">="
        stem = _requirement_stem(self.quantity)
        requirements = []
        for axis, value in zip(
            _requirement_axes(self.quantity), self._limits, strict=True
        ):
            metric = f"{stem}_{axis}" if axis else stem
            requirements.append(
                Requirement(
                    metric=metric, sense=sense, limit=unit_of(metric).to_si(value)
                )
            )
        return requirements


class RunSection(_Section):
    """Length of the run, and how it is integrated."""

    duration_s: Positive
    integrator: Scheme = Integration().scheme
    accuracy: Positive = Integration().accuracy
    max_step_s: Positive = Integration().max_step


class PrintedSection(_Section):
    """What a publication prints of a worst case, in the form of the paper's Table 4."""

    rate_deg_s: Vector
    deviation_within_limits_until_s: float
    longitudinal_speed_m_s: float
    iterations: int


class PublishedSection(_Section):
    """A published worst case: M and m for the bounds of a tolerance, or a value."""

    label: Name
    objectives: list[ObjectiveName]
    values: dict[str, Mark]
    printed: PrintedSection


class Case(_Section):
    """A separation with its tolerances and requirements, as a case file holds it."""

    name: Name
    description: str = ""
    pair: PairSection
    bodies: dict[Name, BodySection] = Field(min_length=2)
    attachments: dict[Name, AttachmentSection] = Field(min_length=1)
    orbit: OrbitSection | None = None
    before_separation: BeforeSeparationSection = BeforeSeparationSection()
    dispersions: dict[str, Positive] = {}
    """Tolerances to either side of the values above."""
    requirements: list[RequirementSection] = []
    run: RunSection
    published: list[PublishedSection] = []

    @model_validator(mode="after")
    def _check_meaning(self) -> Self:
        _ = self.separation, self.integration
        self._check_dispersions()
        self._check_requirements()
        self._check_published()
        return self

    def _check_dispersions(self) -> None:
        for key, tolerance in self.dispersions.items():
            try:
                Box.around(self.separation, self.values_in_si({key: tolerance}))
            except InputError as error:
                bound = f"{key} ± {tolerance:g}: " if error.__cause__ else ""
                raise CaseError(
                    f"dispersions: {bound}{error.__cause__ or error}"
                ) from error

    def _check_requirements(self) -> None:
        quantities = [section.quantity for section in self.requirements]
        for quantity in quantities:
            if quantities.count(quantity) > 1:
                raise CaseError(f"requirements: {quantity} must stand once")
        for limit in self.limits:
            if limit.sense == "<=" and limit.limit < 0.0:
                raise CaseError(
                    f"requirements: {with_unit(limit.metric)}: at_most must be >= 0, "
                    f"got {unit_of(limit.metric).from_si(limit.limit):g}"
                )

    def _check_published(self) -> None:
        labels = [published.label for published in self.published]
        for published in self.published:
            label = published.label
            if labels.count(label) > 1:
                raise CaseError(f"published: label {label!r} must stand once")
            if label == "nominal" or label.startswith("worst_"):
                raise CaseError(f"published: label {label!r} is taken by our own runs")
            try:
                with_values(self.separation, self.published_values(published))
            except InputError as error:
                raise CaseError(f"published: {label}: {error}") from error

    @property
    def separation(self) -> Separation:
        """The separation, in SI."""
        before = self.before_separation
        return Separation(
            bodies=tuple(_body(name, body) for name, body in self.bodies.items()),
            attachments=tuple(
                _attachment(name, attachment)
                for name, attachment in self.attachments.items()
            ),
            A=self.pair.A,
            B=self.pair.B,
            initial=InitialMotion(
                rpy_WA=_to_si("attitude", before.attitude_deg),
                w_WA_A=_to_si("rate", before.rate_deg_s),
            ),
            orbit=None if self.orbit is None else _orbit(self.orbit),
            duration=self.run.duration_s,
        )

    @property
    def integration(self) -> Integration:
        """How runs are integrated."""
        return Integration(
            scheme=self.run.integrator,
            accuracy=self.run.accuracy,
            max_step=self.run.max_step_s,
        )

    @property
    def box(self) -> Box:
        """The tolerances, in SI."""
        return Box.around(self.separation, self.values_in_si(self.dispersions))

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


def _requirement_stem(quantity: str) -> str:
    return quantity.removesuffix("_deg_s").removesuffix("_deg").removesuffix("_m_s")


def _requirement_axes(quantity: str) -> tuple[str, ...]:
    return {"rate_after_separation": AXES, "deviation_at_separation": ANGLES}.get(
        _requirement_stem(quantity), ("",)
    )


def _to_si(quantity: str, vector: Vector3) -> Vector3:
    unit = unit_of(quantity)
    x, y, z = vector
    return unit.to_si(x), unit.to_si(y), unit.to_si(z)


def _body(name: str, body: BodySection) -> Body:
    inertia = body.inertia_kg_m2
    return Body(
        name=name,
        mass=body.mass_kg,
        p_BoBcm_B=_to_si("cg", body.cg_mm),
        I_BBcm_B=(
            inertia.xx,
            inertia.yy,
            inertia.zz,
            inertia.xy,
            inertia.xz,
            inertia.yz,
        ),
        p_ABo=_to_si("position", body.mated.position_mm),
        rpy_AB=_to_si("attitude", body.mated.attitude_deg),
    )


def _orbit(orbit: OrbitSection) -> Orbit:
    return Orbit(radius=EARTH_RADIUS + 1000.0 * orbit.altitude_km)


def _spring(spring: SpringSection) -> Spring | DisplacementSpring:
    stroke = unit_of("stroke").to_si(spring.stroke_mm)
    if spring.design_mass_kg is None:
        return DisplacementSpring(
            name=spring.name,
            force_max=spring.force_max_N,
            stroke=stroke,
            damping=spring.damping_N_s_m,
        )
    return Spring(
        name=spring.name,
        force_max=spring.force_max_N,
        stroke=stroke,
        design_mass=spring.design_mass_kg,
    )


def _attachment(name: str, attachment: AttachmentSection) -> Attachment:
    joint = attachment.joint
    return Attachment(
        name=name,
        A=attachment.A,
        B=attachment.B,
        p_AoPad_A=_to_si("position", attachment.position_mm),
        joint=Joint(
            K_F=joint.stiffness_N_m,
            D_F=joint.damping_N_s_m,
            K_T=joint.angular_stiffness_N_m_rad,
            D_T=joint.angular_damping_N_m_s_rad,
        ),
        spring=None if attachment.spring is None else _spring(attachment.spring),
        release_time=attachment.release_time_s,
    )
