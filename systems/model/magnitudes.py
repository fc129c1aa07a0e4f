"""How small and how large a number may be, by what it measures.

Far wider than what any separation has, and narrow enough that products and quotients
of what is within stay numbers: what lies outside is a slip, and is refused by name when
it is read. What lies within flies, or fails with its reason.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias

from drakesep.systems.checks import InputError, check_finite, check_positive


Kind: TypeAlias = Literal[
    "mass",
    "length",
    "orbit_radius",
    "angle",
    "angular_rate",
    "inertia",
    "force",
    "torque",
    "stiffness",
    "angular_stiffness",
    "face_stiffness",
    "damping",
    "angular_damping",
    "density",
    "time",
    "factor",
]
"""What a number measures. The unit of a parameter in files and tables follows from
it."""


class Magnitude(NamedTuple):
    """How small and how large a number may be, in SI."""

    least: float
    """Of what must be above zero."""
    most: float
    """Without its sign."""
    unit: str


MAGNITUDES: Mapping[Kind, Magnitude] = MappingProxyType(
    {
        "mass": Magnitude(1e-6, 1e9, "kg"),
        "length": Magnitude(1e-9, 1e5, "m"),
        "orbit_radius": Magnitude(1e-9, 1e9, "m"),
        "angle": Magnitude(1e-9, 1e4, "rad"),
        "angular_rate": Magnitude(1e-9, 1e4, "rad/s"),
        "inertia": Magnitude(1e-15, 1e15, "kg m²"),
        "force": Magnitude(1e-9, 1e12, "N"),
        "torque": Magnitude(1e-9, 1e12, "N m"),
        "stiffness": Magnitude(1e-9, 1e15, "N/m"),
        "angular_stiffness": Magnitude(1e-9, 1e15, "N m/rad"),
        "face_stiffness": Magnitude(1e-9, 1e18, "N/m³"),
        "damping": Magnitude(1e-9, 1e15, "N s/m"),
        "angular_damping": Magnitude(1e-9, 1e15, "N m s/rad"),
        "density": Magnitude(1e-9, 1e9, "kg/m³"),
        "time": Magnitude(1e-9, 1e6, "s"),
        "factor": Magnitude(1e-9, 1e9, ""),
    }
)
"""By kind."""


def check_size(kind: Kind, name: str, value: float) -> None:
    """Raise InputError unless a value is above zero and of a size that its kind has."""
    check_positive(name, value)
    least, most, unit = MAGNITUDES[kind]
    if not least <= value <= most:
        wanted = f"from {least:g} to {most:g} {unit}".rstrip()
        raise InputError(f"{name} must be {wanted}, got {value:g}")


def check_within(kind: Kind, name: str, *values: float) -> None:
    """Raise InputError unless values are no larger than their kind may be."""
    check_finite(name, *values)
    _, most, unit = MAGNITUDES[kind]
    for value in values:
        if abs(value) > most:
            wanted = f"at most {most:g} {unit}".rstrip()
            raise InputError(f"{name} must be {wanted} in magnitude, got {value:g}")
