"""Units at the edges: names that carry them, and values to and from SI.

Inside, a parameter is ``payload.cg_x`` in m; in files and tables it is
``payload.cg_x_mm``. The unit follows from what the parameter measures; of a metric,
from its kind.
"""

import functools
import math
from typing import Any, NamedTuple

from drakesep.analysis.metrics.metric import Kind as MetricKind
from drakesep.analysis.metrics.registry import find_metric
from drakesep.systems.checks import InputError
from drakesep.systems.equations.springs import PUSHERS
from drakesep.systems.model.loads import Load
from drakesep.systems.model.magnitudes import Kind
from drakesep.systems.model.parameter_table import split_axis as split_axis
from drakesep.systems.model.parts import Part
from drakesep.systems.model.separation import Attachment, Body, InitialMotion


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


def share_words(share: float | None) -> str:
    """Return of how many launches a limit is, such as `` in 99.865 % of launches``.

    Args:
        share: of launches; None: of all, of which nothing is said.
    """
    return "" if share is None else f" in {100.0 * share:.10g} % of launches"


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
        Unit("N_m", "N m"),
        Unit("N_m_s", "N m s"),
        Unit("", ""),
    )
}
_OF_KIND: dict[Kind, str] = {
    "mass": "kg",
    "length": "mm",
    "angle": "deg",
    "angular_rate": "deg_s",
    "inertia": "kg_m2",
    "force": "N",
    "damping": "N_s_m",
    "time": "s",
    "factor": "",
}
_OF_QUANTITY = {
    "force": "N",
    "force_max": "N",
    "contact_end": "s",
    "impulse": "N_s",
    "nearest_time": "s",
    # motion
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
_OF_METRIC = {
    MetricKind.RATE: "deg_s",
    MetricKind.ANGLE: "deg",
    MetricKind.NORM_OF_RATE: "deg_per_sqrt_s",
    MetricKind.SPEED: "m_s",
    MetricKind.TIME: "s",
    MetricKind.CLEARANCE: "mm",
    MetricKind.DISPLACEMENT: "m",
    MetricKind.ACCELERATION: "m_s2",
    MetricKind.FORCE: "N",
    MetricKind.TORQUE: "N_m",
    MetricKind.MOMENTUM: "N_s",
    MetricKind.ANGULAR_MOMENTUM: "N_m_s",
}
"""Of metrics."""


def unit_of(name: str) -> Unit:
    """Return the unit of a parameter, a metric or a component of the motion.

    Args:
        name: such as ``payload.cg_x``, ``final_rate_y`` or ``relative_velocity_x``.
    """
    metric = find_metric(name)
    if metric is not None:
        return _UNITS[_OF_METRIC[metric[0].kind]]
    stem, _ = split_axis(name.rpartition(".")[2])
    kind = _kinds(records()).get(stem)
    return unit_of_kind(kind) if kind else _UNITS[_OF_QUANTITY[stem]]


def records() -> tuple[type[Any], ...]:
    """Return the kinds of records that have parameters."""
    pushers = dict.fromkeys(kind.record for kind in PUSHERS.values())
    return Body, Attachment, *pushers, Load, Part, InitialMotion


@functools.cache
def _kinds(records: tuple[type[Any], ...]) -> dict[str, Kind]:
    """Return what the parameters of records measure, by the stems of their names."""
    kinds: dict[str, Kind] = {}
    for parameter in (p for record in records for p in record.PARAMETERS):
        if kinds.setdefault(parameter.stem, parameter.kind) != parameter.kind:
            raise InputError(
                f"parameters named {parameter.stem!r} must be of one kind, which gives "
                f"their unit, got {kinds[parameter.stem]} and {parameter.kind}"
            )
    return kinds


def unit_of_kind(kind: Kind) -> Unit:
    """Return the unit of parameters that measure something, such as a length."""
    return _UNITS[_OF_KIND[kind]]


def with_unit(name: str) -> str:
    """Return the name that carries its unit: ``payload.cg_x_mm``."""
    suffix = unit_of(name).suffix
    return f"{name}_{suffix}" if suffix else name


def split_unit(name: str) -> tuple[str, Unit]:
    """Return a name without the unit that it carries, and that unit.

    Of units whose suffix it ends with, the longest: ``rate_x_deg_s`` is in deg/s.
    """
    fitting = [s for s in _UNITS if s and name.endswith(f"_{s}")]
    suffix = max(fitting, key=len, default="")
    return name.removesuffix(f"_{suffix}") if suffix else name, _UNITS[suffix]
