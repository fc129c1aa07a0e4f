"""Quantities that a run has, and the metrics that tell them at some time of it.

The name of such a metric says what it is: the quantity, which extreme over a stretch of
time, when, and the axis, as in ``rate_max_after_separation_x``. Without an extreme it
is the one that a requirement is most often about.
"""

import functools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from drakesep.analysis.metrics.metric import (
    AFTER_SEPARATION,
    ANGLE,
    JOINT_LOAD,
    LONGITUDINAL_SPEED,
    RATE,
    RELATIVE_RATE,
    SINCE_RELEASE,
    SPRING_FORCE,
    UNTIL_SEPARATION,
    WHOLE_RUN,
    Functional,
    Kind,
    Law,
    Metric,
    Moment,
    Outer,
    Signal,
    When,
    Window,
)
from drakesep.systems.equations import pair_signals as laws
from drakesep.systems.model.parameter_table import ROLL_PITCH_YAW, XYZ


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """What a run has at every time of it."""

    name: str
    kind: Kind
    signal: Signal
    two_sided: bool = False
    """Whether limits are those of its magnitude."""
    signed: str = ""
    """Name of the quantity that is the same with its sign; itself if empty."""
    over_time: Functional = Functional.LARGEST
    """What stands for it over a stretch of time, if it is not two-sided."""


def _alone(
    words: str, quantity: str, law: Law, outer: Outer = Outer.ITSELF, **more: bool
) -> Signal:
    """Return a signal of one component, which a law makes of a field of the motion."""
    return Signal(words, quantity, ("",), (0,), law=law, outer=outer, **more)


_OF_B, _SEEN = "of B in W (w_WB_B)", "of B's CG as seen from A"
_RELATIVE = "of B relative to A (w_AB_B)"
_ACROSS, _ABOUT = "across the direction, as mated", "about the direction, as mated"
_ROOT = Outer.ROOT


def _rates(prefix: str, field: str, of: str) -> tuple[Quantity, ...]:
    """Return what is said of an angular velocity."""
    return (
        Quantity(
            name=f"{prefix}rate_modulus",
            kind=Kind.RATE,
            signal=_alone(
                f"modulus of the rate {of}", field, laws.length_squared, _ROOT
            ),
        ),
        Quantity(
            name=f"{prefix}transverse_rate",
            kind=Kind.RATE,
            signal=_alone(
                f"modulus of the rate {of} {_ACROSS}",
                field,
                laws.transverse_squared,
                _ROOT,
            ),
        ),
        Quantity(
            name=f"{prefix}spin_rate",
            kind=Kind.RATE,
            signal=_alone(f"rate {of} {_ABOUT}", field, laws.about),
            two_sided=True,
        ),
    )


def _lengths(kind: Kind, field: str, names: Sequence[str]) -> tuple[Quantity, ...]:
    """Return what is said of a velocity, or of a displacement: across, and in all."""
    lateral, total = names
    words = f"modulus of the {total}"
    return (
        Quantity(
            name=lateral,
            kind=kind,
            signal=_alone(
                f"{words} {_SEEN} across the direction",
                field,
                laws.across_squared,
                _ROOT,
            ),
        ),
        Quantity(
            name=total,
            kind=kind,
            signal=_alone(f"{words} {_SEEN}", field, laws.length_squared, _ROOT),
        ),
    )


def _leaping(name: str, kind: Kind, field: str, words: str) -> Quantity:
    """Return the modulus of what leaps at releases and ends of strokes."""
    law = laws.length_squared
    signal = _alone(f"modulus of the {words}", field, law, _ROOT, jumps=True)
    return Quantity(name=name, kind=kind, signal=signal)


def _rotations(prefix: str, field: str, of: str) -> tuple[Quantity, ...]:
    """Return what is said of how far a body has turned, all turns counted."""
    since = "since the start of the run"
    return (
        Quantity(
            name=f"{prefix}rotation",
            kind=Kind.ANGLE,
            signal=Signal(
                f"angle about each axis of B {since} (integral of the rate {of})",
                field,
                summed=True,
            ),
            two_sided=True,
        ),
        Quantity(
            name=f"{prefix}total_rotation",
            kind=Kind.ANGLE,
            signal=_alone(
                f"angle turned {since} (integral of the modulus of the rate {of})",
                field,
                laws.length,
                summed=True,
            ),
        ),
    )


QUANTITIES: Mapping[str, Quantity] = {
    quantity.name: quantity
    for quantity in (
        Quantity(name="rate", kind=Kind.RATE, signal=RATE, two_sided=True),
        *_rates("", "rate", _OF_B),
        Quantity(
            name="relative_rate", kind=Kind.RATE, signal=RELATIVE_RATE, two_sided=True
        ),
        *_rates("relative_", "relative_rate", _RELATIVE),
        Quantity(
            name="deviation",
            kind=Kind.ANGLE,
            signal=ANGLE,
            two_sided=True,
            signed="angle",
        ),
        Quantity(name="angle", kind=Kind.ANGLE, signal=ANGLE),
        *_rotations("", "rate", _OF_B),
        *_rotations("relative_", "relative_rate", _RELATIVE),
        Quantity(
            name="tip_off_angle",
            kind=Kind.ANGLE,
            signal=_alone(
                "angle between B's axis and its mated direction in W",
                "angle",
                laws.tip_off,
                Outer.CONE,
            ),
        ),
        Quantity(
            name="nutation",
            kind=Kind.ANGLE,
            signal=_alone(
                "angle between B's angular momentum and its axis",
                "rate",
                laws.nutation,
                Outer.CONE,
            ),
        ),
        Quantity(
            name="longitudinal_speed",
            kind=Kind.SPEED,
            signal=LONGITUDINAL_SPEED,
            over_time=Functional.SMALLEST,
        ),
        *_lengths(Kind.SPEED, "relative_velocity", ("lateral_speed", "speed")),
        Quantity(
            name="longitudinal_displacement",
            kind=Kind.DISPLACEMENT,
            signal=_alone(
                "longitudinal displacement of B's CG as seen from A",
                "relative_position",
                laws.along,
            ),
            over_time=Functional.SMALLEST,
        ),
        *_lengths(
            Kind.DISPLACEMENT,
            "relative_position",
            ("lateral_displacement", "displacement"),
        ),
        _leaping(
            "acceleration",
            Kind.ACCELERATION,
            "acceleration",
            "acceleration of B's CG in W",
        ),
        _leaping(
            "momentum_given",
            Kind.MOMENTUM,
            "linear_momentum_change",
            "momentum that springs give to B (Eq. 6)",
        ),
        _leaping(
            "angular_momentum_given",
            Kind.ANGULAR_MOMENTUM,
            "angular_momentum_change",
            "angular momentum that springs give to B about its CG (Eq. 7)",
        ),
        Quantity(
            name="joint_force",
            kind=Kind.FORCE,
            signal=_alone(
                "modulus of the force of the joint",
                JOINT_LOAD,
                laws.force_squared,
                _ROOT,
                jumps=True,
            ),
        ),
        Quantity(
            name="joint_torque",
            kind=Kind.TORQUE,
            signal=_alone(
                "modulus of the torque of the joint about B's pad",
                JOINT_LOAD,
                laws.torque_squared,
                _ROOT,
                jumps=True,
            ),
        ),
        Quantity(
            name="spring_force",
            kind=Kind.FORCE,
            signal=Signal("force of the spring", SPRING_FORCE, ("",), (0,), jumps=True),
        ),
    )
}
"""By name."""

_TIMES: Mapping[str, When] = {
    "": WHOLE_RUN,
    "since_release": SINCE_RELEASE,
    "after_separation": AFTER_SEPARATION,
    "until_separation": UNTIL_SEPARATION,
    "at_release": Moment.RELEASE,
    "at_separation": Moment.SEPARATION,
    "at_end": Moment.END,
}
"""By what stands for them in names."""
NUMBER = r"(\d+(?:\.\d+)?(?:e-?\d+)?)"
"""In names, as a pattern; see `written`."""
_SECONDS: tuple[tuple[str, Callable[..., When]], ...] = (
    (rf"at_{NUMBER}_s", lambda t: t),
    (rf"until_{NUMBER}_s", lambda t: Window(Moment.START, t, f"until {t:g} s")),
    (rf"from_{NUMBER}_s", lambda t: Window(t, Moment.END, f"from {t:g} s")),
    (
        rf"from_{NUMBER}_to_{NUMBER}_s",
        lambda t, u: Window(t, u, f"from {t:g} to {u:g} s"),
    ),
)
"""The same, of times in seconds."""


def at_time(seconds: float) -> str:
    """Return what stands in names for a time, s."""
    return f"at_{written(seconds)}_s"


def between_times(start: float | None, end: float | None) -> str:
    """Return what stands in names for the stretch from one time to another, s.

    Args:
        start: None: the start of the run.
        end: None: the end of the run.
    """
    if start is None:
        return "" if end is None else f"until_{written(end)}_s"
    if end is None:
        return f"from_{written(start)}_s"
    return f"from_{written(start)}_to_{written(end)}_s"


def written(number: float) -> str:
    """Return what stands in names for a number."""
    return f"{number:.10g}".replace("e+", "e")


def time_named(text: str) -> When | None:
    """Return the time for which a text stands in names; None if there is none."""
    if text in _TIMES:
        return _TIMES[text]
    for pattern, make in _SECONDS:
        found = re.fullmatch(pattern, text)
        if found is not None:
            return make(*map(float, found.groups()))
    return None


_NAME = re.compile(
    rf"({'|'.join(sorted(QUANTITIES, key=len, reverse=True))})"
    r"(?:_(max|min|magnitude_min|value))?(?:_(.+?))??"
    rf"(?:_({'|'.join((*XYZ, *ROLL_PITCH_YAW))}))?"
)


@functools.lru_cache(maxsize=4096)
def metric_of_quantity(name: str) -> tuple[Metric, str] | None:
    """Return the metric of a name or a stem, and the axis that is in the name.

    Args:
        name: such as ``rate_max_from_0.5_to_2_s_x``; the axis of a stem is empty.

    Returns:
        None if no quantity has such a metric.
    """
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    quantity, extreme, when, axis = (part or "" for part in found.groups())
    metric = _metric(QUANTITIES[quantity], extreme, when)
    if metric is None or (axis and axis not in metric.axes):
        return None
    return metric, axis


def _metric(quantity: Quantity, extreme: str, when: str) -> Metric | None:
    """Return the metric of a quantity; None if it has no such extreme."""
    time = time_named(when)
    if time is None:
        return None

    def stem(extreme: str, name: str = quantity.name) -> str:
        return "_".join(filter(None, (name, extreme, when)))

    roles = (_over_time if isinstance(time, Window) else _at_once)(quantity, stem)
    if extreme not in roles:
        return None
    functional, partners = roles[extreme]
    return Metric(
        stem=stem(extreme),
        kind=quantity.kind,
        functional=functional,
        signal=quantity.signal,
        when=time,
        **partners,
    )


_Role: TypeAlias = tuple[Functional, dict[str, Any]]
"""A functional, and the partners of the metric that it makes."""


def _over_time(quantity: Quantity, stem: Callable[..., str]) -> dict[str, _Role]:
    """Return what a quantity has over a stretch of time, by the extreme's name."""
    signed = quantity.signed or quantity.name
    extremes: dict[str, _Role] = {
        "max": (Functional.LARGEST, {}),
        "min": (Functional.SMALLEST, {}),
    }
    if quantity.two_sided:
        magnitude = {
            "at_least": stem("magnitude_min"),
            "directions": (stem("max", signed), stem("min", signed)),
        }
        return {
            "": (Functional.LARGEST_MAGNITUDE, magnitude),
            "magnitude_min": (Functional.SMALLEST_MAGNITUDE, {}),
            **({} if quantity.signed else extremes),
        }
    if quantity.over_time is Functional.SMALLEST:
        return {"": (Functional.SMALLEST, {"at_most": stem("max")}), **extremes}
    return {"": (Functional.LARGEST, {"at_least": stem("min")}), **extremes}


def _at_once(quantity: Quantity, stem: Callable[..., str]) -> dict[str, _Role]:
    """Return what a quantity has at a time."""
    if not quantity.two_sided:
        return {"": (Functional.VALUE, {})}
    value = stem("", quantity.signed) if quantity.signed else stem("value")
    roles: dict[str, _Role] = {"": (Functional.MAGNITUDE, {"directions": (value,) * 2})}
    return roles if quantity.signed else roles | {"value": (Functional.VALUE, {})}
