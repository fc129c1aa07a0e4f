"""Attachments and loads in a case file."""

import math
from typing import Literal, Self

from pydantic import model_validator

from drakesep.case_file.section import (
    Column,
    Gains,
    Name,
    NotNegative,
    Positive,
    Rows,
    Section,
    Vector,
    named,
    to_si,
)
from drakesep.systems.model.joints import Joint, JointType
from drakesep.systems.model.loads import Axes, Load, thruster
from drakesep.systems.model.separation import Attachment
from drakesep.systems.model.springs import DisplacementSpring, Spring
from drakesep.units import unit_of


class AxesSection(Section):
    """Axes of a joint's frame, in A; z completes them."""

    x: Vector
    y: Vector


class JointSection(Section):
    """A joint by constraint forces; a gain is one number, or one for each axis."""

    type: JointType = "fixed"
    stiffness_N_m: Gains
    damping_N_s_m: Gains
    angular_stiffness_N_m_rad: Gains
    angular_damping_N_m_s_rad: Gains
    axes: AxesSection = AxesSection(x=(1.0, 0.0, 0.0), y=(0.0, 1.0, 0.0))

    def in_si(self) -> Joint:
        """Return the joint."""
        return Joint(
            type=self.type,
            K_F=self.stiffness_N_m,
            D_F=self.damping_N_s_m,
            K_T=self.angular_stiffness_N_m_rad,
            D_T=self.angular_damping_N_m_s_rad,
            x_axis_A=self.axes.x,
            y_axis_A=self.axes.y,
        )


class SpringSection(Section):
    """A separation spring: driven by time, as the paper's, or by displacement."""

    name: Name
    law: Literal["time", "displacement", "table"] = "time"
    force_max_N: Positive | None = None
    stroke_mm: Positive | None = None
    design_mass_kg: Positive | None = None
    damping_N_s_m: NotNegative | None = None
    displacements_mm: Column | None = None
    forces_N: Column | None = None
    tilt_y_deg: float = 0.0
    tilt_z_deg: float = 0.0
    """Of the push from A's x axis, about its y axis, then about its z axis."""

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        needs = {
            "time": ("force_max_N", "stroke_mm", "design_mass_kg"),
            "displacement": ("force_max_N", "stroke_mm"),
            "table": ("displacements_mm", "forces_N"),
        }[self.law]
        may = needs if self.law == "time" else (*needs, "damping_N_s_m")
        for key in type(self).model_fields:
            given = getattr(self, key) is not None
            if key in needs and not given:
                raise ValueError(f"{key}: missing; law: {self.law} needs it")
            if key not in ("name", "law", "tilt_y_deg", "tilt_z_deg", *may) and given:
                raise ValueError(f"{key}: law: {self.law} has none")
        return self

    def in_si(self) -> Spring | DisplacementSpring:
        """Return the spring."""
        damping = self.damping_N_s_m or 0.0
        millimetre, degree = unit_of("stroke"), unit_of("tilt")
        tilt_y, tilt_z = map(degree.to_si, (self.tilt_y_deg, self.tilt_z_deg))
        if self.displacements_mm is not None and self.forces_N is not None:
            return DisplacementSpring.from_table(
                name=self.name,
                displacements=tuple(map(millimetre.to_si, self.displacements_mm)),
                forces=self.forces_N,
                damping=damping,
                tilt_y=tilt_y,
                tilt_z=tilt_z,
            )
        assert self.force_max_N is not None and self.stroke_mm is not None  # _check_law
        force_max, stroke = self.force_max_N, millimetre.to_si(self.stroke_mm)
        if self.design_mass_kg is None:
            return DisplacementSpring(
                name=self.name,
                force_max=force_max,
                stroke=stroke,
                damping=damping,
                tilt_y=tilt_y,
                tilt_z=tilt_z,
            )
        return Spring(
            name=self.name,
            force_max=force_max,
            stroke=stroke,
            design_mass=self.design_mass_kg,
            tilt_y=tilt_y,
            tilt_z=tilt_z,
        )


class AttachmentSection(Section):
    """A place where two bodies are held together."""

    A: str
    B: str
    position_mm: Vector
    joint: JointSection
    spring: SpringSection | None = None
    release_time_s: float | None = None
    """By default 0, or never if it lets go at an angle."""
    release_angle_deg: float | None = None

    def in_si(self, name: str) -> Attachment:
        """Return the attachment."""
        time, angle = self.release_time_s, self.release_angle_deg
        if time is None:
            time = 0.0 if angle is None else math.inf
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
        )


class LoadSection(Section):
    """Forces and torques on a body over time, or the thrust of a thruster."""

    body: str
    position_mm: Vector = (0.0, 0.0, 0.0)
    start_s: NotNegative = 0.0
    after: str | None = None
    """Attachment whose release starts the table."""
    times_s: Column
    thrusts_N: Column | None = None
    direction: Vector | None = None
    """Along which a thruster pushes its body, in the body's axes."""
    axes: Axes | None = None
    """By default the body's; a thruster has no others."""
    forces_N: Rows | None = None
    torques_N_m: Rows | None = None

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
