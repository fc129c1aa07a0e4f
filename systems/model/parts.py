"""Parts of bodies that may come near each other: their shapes and places.

They have no mass, and feel no force unless `Separation.recontact` asks for it: they are
there to be measured and to be seen.
Frozen records in SI, free of Drake, as those of `drakesep.systems.model.separation`.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, TypeAlias

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    Vector3,
    check_entries,
    check_not_negative,
)
from drakesep.systems.model.magnitudes import check_size
from drakesep.systems.model.parameter_table import (
    ROLL_PITCH_YAW,
    XYZ,
    ParameterTable,
    vector,
)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A box around its frame's origin.

    Raises:
        ValueError: an edge is not positive.
    """

    size: Vector3
    """Edges along x, y and z, m."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_entries("box: size", self.size, 3)
        for edge in self.size:
            check_size("length", "box: edge", edge)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere:
    """A sphere around its frame's origin.

    Raises:
        ValueError: the radius is not positive.
    """

    radius: float
    """m."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_size("length", "sphere: radius", self.radius)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Capsule:
    """A cylinder along x with round ends, around its frame's origin.

    Raises:
        ValueError: a dimension is not positive.
    """

    radius: float
    """m."""
    length: float
    """Between the centres of the round ends, m."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_size("length", "capsule: radius", self.radius)
        check_size("length", "capsule: length", self.length)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Cone:
    """A cylinder, cone or truncated cone along x, solid or hollow.

    Its frame's origin is on its axis, half-way between its ends.

    Raises:
        ValueError: the length is not positive, a radius is negative or both are zero,
            or the wall is as thick as the smaller radius, or thicker.
    """

    radius_aft: float
    """At the end toward -x, m."""
    radius_fore: float
    """At the end toward +x, m."""
    length: float
    """m."""
    thickness: float | None = None
    """Of its wall, inward from the radii, m; solid if None."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_not_negative("cone or cylinder: radius aft", self.radius_aft)
        check_not_negative("cone or cylinder: radius fore", self.radius_fore)
        check_size(
            "length",
            "cone or cylinder: larger radius",
            max(self.radius_aft, self.radius_fore),
        )
        check_size("length", "cone or cylinder: length", self.length)
        if self.thickness is None:
            return
        check_size("length", "cone or cylinder: thickness", self.thickness)
        if self.thickness >= min(self.radius_aft, self.radius_fore):
            raise InputError(
                "cone or cylinder: thickness must be below the smaller radius, "
                f"{min(self.radius_aft, self.radius_fore):g} m, "
                f"got {self.thickness:g} m"
            )


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Mesh:
    """The solid that a closed mesh bounds, convex or not; of an open one its surface.

    Raises:
        ValueError: the scale is not positive.
    """

    file: Path
    """OBJ, STL, PLY or glTF."""
    scale: float = 1.0
    """Metres in a unit of the file."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_size("factor", "mesh: scale", self.scale)
        if "\0" in str(self.file):
            raise InputError(f"mesh: file must be a path, got {str(self.file)!r}")


Shape: TypeAlias = Box | Sphere | Capsule | Cone | Mesh


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A part of a body that may come near others.

    Raises:
        ValueError: a value is not finite.
    """

    name: str
    shape: Shape
    p_BoGo_B: Vector3 = (0.0, 0.0, 0.0)
    """Place of the shape's frame G in the body, m."""
    rpy_BG: Vector3 = (0.0, 0.0, 0.0)
    """Its roll, pitch and yaw in the body, rad."""
    role: str = ""
    """What it is, for tables: an antenna, a nozzle."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        *vector("position", "p_BoGo_B", XYZ, "length"),
        *vector("attitude", "rpy_BG", ROLL_PITCH_YAW, "angle"),
    )

    def __post_init__(self) -> None:
        """Check the values."""
        self.PARAMETERS.check(f"{self.name}: ", self)
