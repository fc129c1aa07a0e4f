"""Geometry in a case file: parts of bodies that may come near each other."""

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, Strict, model_validator

from drakesep.case_file.section import (
    NotNegative,
    Positive,
    Section,
    Vector,
    check_one,
    to_si,
)
from drakesep.case_file.shapes import (
    BoxSection,
    CapsuleSection,
    MeshSection,
    SphereSection,
)
from drakesep.systems.checks import named
from drakesep.systems.model.parts import (
    Box,
    Capsule,
    Cone,
    Mesh,
    Part,
    Shape,
    Sphere,
)
from drakesep.systems.model.recontact import Recontact
from drakesep.units import unit_of


class TubeSection(Section):
    """A cylinder along x; hollow if its wall has a thickness."""

    radius_mm: Positive
    """Outside."""
    length_mm: Positive
    """Along x."""
    thickness_mm: Positive | None = None
    """Of its wall, inward from the radius; solid if left out."""


class ConeSection(Section):
    """A cone or truncated cone along x; hollow if its wall has a thickness."""

    radius_aft_mm: NotNegative
    """Outside, at the end toward -x."""
    radius_fore_mm: NotNegative
    """Outside, at the end toward +x."""
    length_mm: Positive
    """Along x."""
    thickness_mm: Positive | None = None
    """Of its wall, inward from the radii; solid if left out."""


_SHAPES = ("box", "sphere", "capsule", "cylinder", "cone", "mesh")


class PartSection(Section):
    """A part of a body: one shape or mesh, its place, and what it is."""

    box: BoxSection | None = None
    """One of these shapes."""
    sphere: SphereSection | None = None
    """One of these shapes."""
    capsule: CapsuleSection | None = None
    """One of these shapes."""
    cylinder: TubeSection | None = None
    """One of these shapes, solid or hollow."""
    cone: ConeSection | None = None
    """One of these shapes, solid or hollow."""
    mesh: MeshSection | None = None
    """One of these shapes."""
    position_mm: Vector = (0.0, 0.0, 0.0)
    """Of the shape's frame, in the body."""
    attitude_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of the shape's frame, in the body."""
    role: str = ""
    """What it is, for tables: an antenna, a nozzle."""

    @model_validator(mode="after")
    def _check_one_shape(self) -> Self:
        check_one(self, _SHAPES)
        return self

    def in_si(self, name: str) -> Part:
        """Return the part."""
        with named(name):
            shape = self._shape()
        return Part(
            name=name,
            shape=shape,
            p_BoGo_B=to_si("position", self.position_mm),
            rpy_BG=to_si("attitude", self.attitude_deg),
            role=self.role,
        )

    def _shape(self) -> Shape:
        m = unit_of("position").to_si
        if self.box is not None:
            return Box(size=to_si("position", self.box.size_mm))
        if self.sphere is not None:
            return Sphere(radius=m(self.sphere.radius_mm))
        if self.capsule is not None:
            return Capsule(
                radius=m(self.capsule.radius_mm), length=m(self.capsule.length_mm)
            )
        if self.mesh is not None:
            return Mesh(file=Path(self.mesh.file), scale=self.mesh.scale)
        cone = self.cone
        if cone is None:
            assert self.cylinder is not None  # _check_one_shape
            cone = ConeSection(
                radius_aft_mm=self.cylinder.radius_mm,
                radius_fore_mm=self.cylinder.radius_mm,
                length_mm=self.cylinder.length_mm,
                thickness_mm=self.cylinder.thickness_mm,
            )
        return Cone(
            radius_aft=m(cone.radius_aft_mm),
            radius_fore=m(cone.radius_fore_mm),
            length=m(cone.length_mm),
            thickness=None if cone.thickness_mm is None else m(cone.thickness_mm),
        )


def _check_pair(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError(f"must be two names of parts, such as [a, b], got {value!r}")
    return value


PartNames = Annotated[tuple[str, str], Strict(False), BeforeValidator(_check_pair)]


class RecontactSection(Section):
    """Forces between bodies that touch again after they have parted."""

    stiffness_N_m: Positive
    """Of two pieces that touch at a point: force over overlap."""
    face_stiffness_N_m3: Positive | None = None
    """Of two faces: pressure over overlap. If left out: the stiffness over the area of
    the smallest piece, a quarter of its surface."""
    dissipation_s_m: NotNegative = 0.0
    """Of Hunt and Crossley; 0: no energy is lost."""
    friction: NotNegative = 0.0
    """Coulomb's coefficient, sticking and sliding."""

    def in_si(self, touching: list[PartNames]) -> Recontact:
        """Return it, without the parts that touch while mated."""
        return Recontact(
            stiffness=self.stiffness_N_m,
            face_stiffness=self.face_stiffness_N_m3,
            dissipation=self.dissipation_s_m,
            friction=self.friction,
            without=tuple(touching),
        )


class ClearanceSection(Section):
    """Which parts are measured to each other."""

    pairs: list[PartNames] | None = None
    """All of different bodies if left out."""
    touching: list[PartNames] = Field(default_factory=list)
    """That touch or overlap while mated: measured once they have parted."""
