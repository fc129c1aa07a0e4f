"""Bodies in a case file: their mass properties, or what these are computed from."""

from typing import TYPE_CHECKING, Any, Self

from pydantic import Field, model_validator

from drakesep.case_file.geometry import PartSection
from drakesep.case_file.section import (
    File,
    Name,
    Positive,
    Section,
    Vector,
    check_one,
    to_si,
)
from drakesep.case_file.shapes import (
    BoxSection,
    CapsuleSection,
    CylinderSection,
    EllipsoidSection,
    MeshSection,
    SphereSection,
)
from drakesep.systems.checks import Vector3, named
from drakesep.systems.model.inertia import Inertia
from drakesep.systems.model.separation import Body
from drakesep.units import unit_of


if TYPE_CHECKING:  # imports Drake
    from drakesep.systems.design.mass_properties import MassProperties, SolidKind


class InertiaSection(Section):
    """Inertia about the CG in body axes: entries of the matrix."""

    xx: float
    """Moment about x."""
    yy: float
    """Moment about y."""
    zz: float
    """Moment about z."""
    xy: float = 0.0
    """Product of inertia: minus the integral of x y dm."""
    xz: float = 0.0
    """Product of inertia: minus the integral of x z dm."""
    yz: float = 0.0
    """Product of inertia: minus the integral of y z dm."""


class MatedPlaceSection(Section):
    """Where a body stands in the frame of A while mated."""

    position_mm: Vector = (0.0, 0.0, 0.0)
    """Of the body's origin, in the frame of A."""
    attitude_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of the body, in the frame of A."""


_SHAPES: "tuple[SolidKind, ...]" = ("box", "cylinder", "sphere", "ellipsoid", "capsule")


class SolidSection(Section):
    """A uniform solid that makes up a body: one shape or mesh, its mass or density."""

    box: BoxSection | None = None
    """One of these shapes."""
    cylinder: CylinderSection | None = None
    """One of these shapes."""
    sphere: SphereSection | None = None
    """One of these shapes."""
    ellipsoid: EllipsoidSection | None = None
    """One of these shapes."""
    capsule: CapsuleSection | None = None
    """One of these shapes."""
    mesh: MeshSection | None = None
    """One of these shapes."""
    mass_kg: Positive | None = None
    """This, or a density."""
    density_kg_m3: Positive | None = None
    """This, or a mass."""
    position_mm: Vector = (0.0, 0.0, 0.0)
    """Of the shape's frame, in the body."""
    attitude_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of the shape's frame, in the body."""

    @model_validator(mode="after")
    def _check_one_of_each(self) -> Self:
        check_one(self, (*_SHAPES, "mesh"))
        check_one(self, ("mass_kg", "density_kg_m3"))
        return self

    def in_si(self) -> "MassProperties":
        """Return the mass properties."""
        # Drake and trimesh, which take a second to import, only where they are needed.
        from drakesep.systems.design import mass_properties

        options: dict[str, Any] = {
            "mass": self.mass_kg,
            "density": self.density_kg_m3,
            "p_BoSo_B": to_si("position", self.position_mm),
            "rpy_BS": to_si("attitude", self.attitude_deg),
        }
        if self.mesh is not None:
            return mass_properties.mass_properties_of_mesh(
                self.mesh.file, scale=self.mesh.scale, **options
            )
        [shape] = [shape for shape in _SHAPES if getattr(self, shape) is not None]
        lengths = (
            length
            for value in getattr(self, shape).model_dump().values()
            for length in (value if isinstance(value, tuple) else (value,))
        )
        return mass_properties.mass_properties_of_shape(
            shape, [unit_of("position").to_si(length) for length in lengths], **options
        )


class ModelSection(Section):
    """A model in an SDF, URDF or MJCF file, taken as one rigid body.

    Its joints stand as they are drawn. What it holds beside mass and places, such as
    looks, sensors or contact, is not looked at.
    """

    file: File
    """SDF, URDF or MJCF, from the folder of the case file."""
    frame: str | None = None
    """That becomes the body's; by default that of the first body."""

    def in_si(self) -> "MassProperties":
        """Return the mass properties."""
        from drakesep.systems.design.mass_properties import mass_properties_of_model

        return mass_properties_of_model(self.file, frame=self.frame)


class BodySection(Section):
    """A rigid body: its mass properties, or what they are computed from."""

    mass_kg: Positive | None = None
    """With `cg_mm` and `inertia_kg_m2`, unless it is computed."""
    cg_mm: Vector | None = None
    """The CG, from the body's origin."""
    inertia_kg_m2: InertiaSection | None = None
    """About the CG, in the body's axes."""
    solid: SolidSection | None = None
    """Computes mass, CG and inertia from a shape or a mesh."""
    model: ModelSection | None = None
    """Reads mass, CG and inertia from a model file."""
    mated: MatedPlaceSection = MatedPlaceSection()
    """Where the body stands before separation; A stands at its own origin."""
    spin_deg_s: float = 0.0
    """At which it turns before separation, about the x axis of the joint that holds it:
    of all its joints, that must turn about this axis."""
    geometry: dict[Name, PartSection] = Field(default_factory=dict)
    """Parts of it that may come near others."""

    @model_validator(mode="after")
    def _check_mass_properties(self) -> Self:
        given = ("mass_kg", "cg_mm", "inertia_kg_m2")
        if self.solid is None and self.model is None:
            for key in given:
                if getattr(self, key) is None:
                    raise ValueError(f"{key}: missing, as are solid and model")
        elif any(getattr(self, key) is not None for key in given):
            raise ValueError(f"must have {', '.join(given)}, or a solid or model")
        else:
            check_one(self, ("solid", "model"))
        return self

    def in_si(self, name: str) -> Body:
        """Return the body."""
        with named(name):
            mass, p_BoBcm_B, I_BBcm_B = self._mass_properties()
            parts = tuple(e.in_si(key) for key, e in self.geometry.items())
        return Body(
            name=name,
            mass=mass,
            p_BoBcm_B=p_BoBcm_B,
            I_BBcm_B=I_BBcm_B,
            p_ABo=to_si("position", self.mated.position_mm),
            rpy_AB=to_si("attitude", self.mated.attitude_deg),
            spin=unit_of("spin").to_si(self.spin_deg_s),
            parts=parts,
        )

    def _mass_properties(self) -> tuple[float, Vector3, Inertia]:
        computed = self.solid or self.model
        if computed is not None:
            return computed.in_si()
        # _check_mass_properties
        assert self.mass_kg is not None
        assert self.cg_mm is not None
        assert self.inertia_kg_m2 is not None
        xx, yy, zz, xy, xz, yz = self.inertia_kg_m2.model_dump().values()
        return self.mass_kg, to_si("cg", self.cg_mm), (xx, yy, zz, xy, xz, yz)
