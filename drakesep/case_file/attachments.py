"""Attachments and loads in a case file."""

import functools
import math
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    PlainValidator,
    SerializeAsAny,
    ValidationInfo,
    create_model,
    model_validator,
)

from drakesep.case_file.errors import shown
from drakesep.case_file.section import (
    Column,
    Gains,
    Name,
    NotNegative,
    Positive,
    Rows,
    Section,
    Vector,
    to_si,
)
from drakesep.systems.checks import named, unknown
from drakesep.systems.equations.springs import PUSHERS, PusherKind
from drakesep.systems.model.joints import Joint, JointType
from drakesep.systems.model.loads import Axes, Load, thruster
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.separation import Attachment
from drakesep.units import Unit, unit_of_kind


class AxesSection(Section):
    """Axes of a joint's frame, in A; z completes them."""

    x: Vector
    """Unit vector."""
    y: Vector
    """Unit vector, at a right angle to x."""


class JointSection(Section):
    """A joint by constraint forces; a gain is one number, or one for each axis.

    A rigid one has no gains.
    """

    type: JointType = "fixed"
    """Which directions it holds."""
    rigid: bool = False
    """Whether it holds exactly, without stiffness and damping."""
    stiffness_N_m: Gains | None = None
    """Of translation (K_F of Eq. 3); needed unless the joint is rigid."""
    damping_N_s_m: Gains | None = None
    """Of translation (D_F of Eq. 3); needed unless the joint is rigid."""
    angular_stiffness_N_m_rad: Gains | None = None
    """Of rotation (K_T of Eq. 4); needed unless the joint is rigid."""
    angular_damping_N_m_s_rad: Gains | None = None
    """Of rotation (D_T of Eq. 4); needed unless the joint is rigid."""
    axes: AxesSection = AxesSection(x=(1.0, 0.0, 0.0), y=(0.0, 1.0, 0.0))
    """Of its frame; by default those of A."""

    @model_validator(mode="after")
    def _check_gains(self) -> Self:
        for key in (
            "stiffness_N_m",
            "damping_N_s_m",
            "angular_stiffness_N_m_rad",
            "angular_damping_N_m_s_rad",
        ):
            given = getattr(self, key) is not None
            if given and self.rigid:
                raise ValueError(f"{key}: a rigid joint has none")
            if not given and not self.rigid:
                raise ValueError(f"{key}: missing; a joint that is not rigid needs it")
        return self

    def in_si(self) -> Joint:
        """Return the joint."""
        return Joint(
            type=self.type,
            rigid=self.rigid,
            K_F=self.stiffness_N_m,
            D_F=self.damping_N_s_m,
            K_T=self.angular_stiffness_N_m_rad,
            D_T=self.angular_damping_N_m_s_rad,
            x_axis_A=self.axes.x,
            y_axis_A=self.axes.y,
        )


class SpringSection(Section):
    """A separation spring, or whatever else pushes; its other keys go by its law."""

    name: Name
    """Differs from all other names."""
    law: str = "time"
    """What its force follows."""
    axis: Vector = (1.0, 0.0, 0.0)
    """Unit vector along which it pushes B, fixed in A."""

    def in_si(self) -> Pusher:
        """Return the record."""
        kind = PUSHERS[self.law]
        values: dict[str, Any] = {"axis_A": self.axis}
        for argument in kind.arguments:
            key, unit = key_of(kind, argument)
            value = getattr(self, key)
            if isinstance(value, tuple):
                values[argument] = tuple(map(unit.to_si, value))
            elif value is not None:
                values[argument] = unit.to_si(value)
        pusher: Pusher = kind.maker(name=self.name, **values)
        return pusher


def key_of(kind: PusherKind, argument: str) -> tuple[str, Unit]:
    """Return the key of an argument of a kind of pusher, and its unit."""
    if argument in kind.columns:
        unit = unit_of_kind(kind.columns[argument])
    else:
        unit = unit_of_kind(kind.parameter(argument).kind)
    return "_".join(filter(None, [argument, unit.suffix])), unit


def _value_type(kind: PusherKind, argument: str) -> Any:
    if argument in kind.columns:
        return Column
    range_ = kind.parameter(argument).range
    if range_.low != 0.0:
        return float
    return NotNegative if range_.closed else Positive


@functools.cache
def _section_of(law: str, kind: PusherKind) -> type[SpringSection]:
    """Return the section of a kind of pusher: its arguments with their units."""
    fields: dict[str, Any] = {"law": (Literal[law], law)}
    for argument in kind.arguments:
        optional = _value_type(kind, argument) | None
        fields[key_of(kind, argument)[0]] = (optional, None)
    return create_model("SpringSection", __base__=SpringSection, **fields)


def _read_spring(data: Any, info: ValidationInfo) -> SpringSection:
    """Return the section of a spring, of the kind that its law says."""
    if isinstance(data, SpringSection) or not isinstance(data, dict):
        return SpringSection.model_validate(data)
    given = {key: value for key, value in data.items() if value is not None}
    sections = {law: _section_of(law, kind) for law, kind in PUSHERS.items()}
    known = dict.fromkeys(key for s in sections.values() for key in s.model_fields)
    for key in given:
        if key not in known:
            raise ValueError(unknown("key", key, known))
    law = given.get("law", "time")
    if not isinstance(law, str) or law not in sections:
        laws: Any = Literal[tuple(sections)]
        create_model("Law", law=(laws, ...)).model_validate({"law": law})
    kind, section = PUSHERS[law], sections[law]
    for argument, needed in kind.arguments.items():
        key, _ = key_of(kind, argument)
        if needed and key not in given:
            raise ValueError(f"{key}: missing; law: {law} needs it")
    for key in given:
        if key not in section.model_fields:
            raise ValueError(f"{key}: law: {law} has none")
    return section.model_validate(given, context=info.context)


NEVER = "never"
"""Of a time of release."""


def _check_release_time(value: Any) -> Any:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if value != NEVER and not (number and math.isfinite(value)):
        raise ValueError(f"must be a finite number, or never, got {shown(value)}")
    return value


ReleaseTime = Annotated[float | Literal["never"], BeforeValidator(_check_release_time)]
"""When something lets go, s."""


class AttachmentSection(Section):
    """A place where two bodies are held together."""

    A: str
    """Name of the body pushed from."""
    B: str
    """Name of the body pushed away."""
    position_mm: Vector
    """Of the pad, in the frame of its A."""
    joint: JointSection
    """What holds until the release."""
    spring: (
        Annotated[SerializeAsAny[SpringSection], PlainValidator(_read_spring)] | None
    ) = None
    """What pushes from the release on; none if left out."""
    release_time_s: ReleaseTime | None = None
    """At which it lets go, 0 or later; by default 0, or never if there is an angle or a
    travel."""
    release_angle_deg: float | None = None
    """Of its joint about x, either way, at which it lets go: above 0, below 180."""
    release_travel_mm: Positive | None = None
    """Of its joint along x, either way, after which it lets go."""

    def in_si(self, name: str) -> Attachment:
        """Return the attachment."""
        time, angle = self.release_time_s, self.release_angle_deg
        travel = self.release_travel_mm
        if time is None:
            time = 0.0 if angle is None and travel is None else math.inf
        elif isinstance(time, str):
            time = math.inf
        with named(name):
            joint = self.joint.in_si()
        return Attachment(
            name=name,
            A=self.A,
            B=self.B,
            p_AoPad_A=to_si("position", self.position_mm),
            joint=joint,
            spring=None if self.spring is None else self.spring.in_si(),
            release_time=time,
            release_angle=math.inf if angle is None else math.radians(angle),
            release_travel=math.inf
            if travel is None
            else unit_of_kind("length").to_si(travel),
        )


class LoadSection(Section):
    """Forces and torques on a body over time, or the thrust of a thruster."""

    body: str
    """Name of the body that feels it."""
    position_mm: Vector = (0.0, 0.0, 0.0)
    """Where the force acts, in the body."""
    start_s: NotNegative = 0.0
    """When the table begins: in the run, or after the release of `after`."""
    after: str | None = None
    """Attachment whose release starts the table."""
    times_s: Column
    """Of the rows, increasing; straight lines join them."""
    thrusts_N: Column | None = None
    """Of a thruster, for each time; it needs a `direction`."""
    direction: Vector | None = None
    """Along which a thruster pushes its body, in the body's axes."""
    axes: Axes | None = None
    """By default the body's; a thruster has no others."""
    forces_N: Rows | None = None
    """For each time; this or torques, or both, without thrusts."""
    torques_N_m: Rows | None = None
    """For each time."""

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        tables = self.forces_N is not None or self.torques_N_m is not None
        if (self.thrusts_N is None) != (self.direction is None):
            raise ValueError("thrusts_N and direction: one needs the other")
        if self.direction is not None and self.axes is not None:
            raise ValueError("axes: a thruster has none, its direction is the body's")
        if tables == (self.thrusts_N is not None):
            got = "both" if tables else "none"
            raise ValueError(
                f"must have thrusts_N, or forces_N and torques_N_m; got {got}"
            )
        return self

    def in_si(self, name: str) -> Load:
        """Return the load."""
        position = to_si("position", self.position_mm)
        if self.thrusts_N is not None and self.direction is not None:
            return thruster(
                name=name,
                body=self.body,
                p_BoQ_B=position,
                direction_B=self.direction,
                times=self.times_s,
                thrusts=self.thrusts_N,
                start=self.start_s,
                after=self.after,
            )
        return Load(
            name=name,
            body=self.body,
            p_BoQ_B=position,
            axes=self.axes or "body",
            times=self.times_s,
            forces=self.forces_N or (),
            torques=self.torques_N_m or (),
            start=self.start_s,
            after=self.after,
        )
