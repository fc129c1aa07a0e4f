"""Shapes in a case file: of solids with mass, and of parts to be measured."""

from drakesep.case_file.section import File, Positive, Section, Vector


class BoxSection(Section):
    """A box."""

    size_mm: Vector
    """Edges along x, y and z."""


class CylinderSection(Section):
    """A cylinder along x."""

    radius_mm: Positive
    """Of the cylinder."""
    length_mm: Positive
    """Along x."""


class SphereSection(Section):
    """A sphere."""

    radius_mm: Positive
    """Of the sphere."""


class EllipsoidSection(Section):
    """An ellipsoid."""

    semi_axes_mm: Vector
    """Along x, y and z."""


class CapsuleSection(Section):
    """A capsule along x; its length is that between the centres of its round ends."""

    radius_mm: Positive
    """Of the cylinder and of its round ends."""
    length_mm: Positive
    """Between the centres of the round ends."""


class MeshSection(Section):
    """A mesh: closed, if it is to have a mass."""

    file: File
    """OBJ, STL, PLY or glTF, from the folder of the case file."""
    scale: Positive = 1.0
    """Metres in a unit of the file."""
