"""Units at the edges: names that carry them, and values to and from SI.

Inside, a parameter is ``payload.cg_x`` in m; in files and tables it is
``payload.cg_x_mm``. The quantity alone decides the unit, of a metric its kind.
"""

import math
from typing import NamedTuple

from drakesep.analysis.metrics.registry import Kind, find_metric


class Unit(NamedTuple):
    """A unit of measurement."""

    suffix: str
    """In names of keys and columns."""
    symbol: str
    """In text and plots."""
    per_si: float = 1.0
    """Units in one SI unit."""

    def to_si(self, value: float) -> float:
        """Return a value of this unit in SI."""
        return value / self.per_si

    def from_si(self, value: float) -> float:
        """Return an SI value in this unit."""
        return value * self.per_si


SI = Unit("", "SI")
"""Of what has no unit of its own in tables."""

_DEG = math.degrees(1.0)
_UNITS = {
    unit.suffix: unit
    for unit in (
        Unit("kg", "kg"),
        Unit("mm", "mm", 1000.0),
        Unit("m", "m"),
        Unit("kg_m2", "kg m²"),
        Unit("N", "N"),
        Unit("N_s_m", "N s/m"),
        Unit("s", "s"),
        Unit("deg", "deg", _DEG),
        Unit("deg_s", "deg/s", _DEG),
        Unit("deg_per_sqrt_s", "deg/√s", _DEG),
        Unit("m_s", "m/s"),
        Unit("m_s2", "m/s²"),
        Unit("N_s", "N s"),
        Unit("N_m_s", "N m s"),
        Unit("", ""),
    )
}
_OF_QUANTITY = {
    # parameters
    "mass": "kg",
    "cg": "mm",
    "inertia": "kg_m2",
    "force_max": "N",
    "force": "N",
    "contact_end": "s",
    "impulse": "N_s",
    "nearest_time": "s",
    "stroke": "mm",
    "tilt": "deg",
    "damping": "N_s_m",
    "design_mass": "kg",
    "position": "mm",
    "release_time": "s",
    "release_angle": "deg",
    "start": "s",
    "factor": "",
    "attitude": "deg",
    # motion; the rate is a parameter too
    "time": "s",
    "rate": "deg_s",
    "relative_rate": "deg_s",
    "angle": "deg",
    "relative_position": "m",
    "relative_velocity": "m_s",
    "acceleration": "m_s2",
    "linear_momentum_change": "N_s",
    "angular_momentum_change": "N_m_s",
    # clearances
    "separation": "mm",
    "first_position": "mm",
    "second_position": "mm",
    "contact_time": "s",
    "closing_speed": "m_s",
}
_OF_KIND = {
    Kind.RATE: "deg_s",
    Kind.ANGLE: "deg",
    Kind.NORM_OF_RATE: "deg_per_sqrt_s",
    Kind.SPEED: "m_s",
    Kind.TIME: "s",
    Kind.CLEARANCE: "mm",
}
"""Of metrics."""
_AXES = ("x", "y", "z", "roll", "pitch", "yaw", "xx", "yy", "zz", "xy", "xz", "yz")


def split_axis(name: str) -> tuple[str, str]:
    """Return a name without its axis, and the axis; empty if it has none."""
    stem, _, last = name.rpartition("_")
    return (stem, last) if last in _AXES else (name, "")


def unit_of(name: str) -> Unit:
    """Return the unit of a parameter, a metric or a component of the motion.

    Args:
        name: such as ``payload.cg_x``, ``final_rate_y`` or ``relative_velocity_x``.
    """
    metric = find_metric(name)
    if metric is not None:
        return _UNITS[_OF_KIND[metric[0].kind]]
    quantity, _ = split_axis(name.rpartition(".")[2])
    return _UNITS[_OF_QUANTITY[quantity]]


def with_unit(name: str) -> str:
    """Return the name that carries its unit: ``payload.cg_x_mm``."""
    suffix = unit_of(name).suffix
    return f"{name}_{suffix}" if suffix else name
