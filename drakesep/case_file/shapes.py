"""Shapes in a case file: of solids with mass, and of parts to be measured."""

from drakesep.case_file.section import File, Positive, Section, Vector


class BoxSection(Section):
    """A box."""

    size_mm: Vector


class CylinderSection(Section):
    """A cylinder along x."""

    radius_mm: Positive
    length_mm: Positive


class SphereSection(Section):
    """A sphere."""

    radius_mm: Positive


class EllipsoidSection(Section):
    """An ellipsoid."""

    semi_axes_mm: Vector


class CapsuleSection(Section):
    """A capsule along x; its length is that between the centres of its round ends."""

    radius_mm: Positive
    length_mm: Positive


class MeshSection(Section):
    """A closed mesh."""

    file: File
    scale: Positive = 1.0
    """Metres in a unit of the file."""
