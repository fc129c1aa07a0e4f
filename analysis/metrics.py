"""The figures that a run is judged by, in SI and radians."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

from drakesep.analysis import signals
from drakesep.systems.checks import InputError
from drakesep.systems.run import Run


AXES = ("x", "y", "z")
ANGLES = ("roll", "pitch", "yaw")
_OBJECTIVES = ("G_L1", "G_L2", "G_Linf", "G_PM")
_AFTER_SEPARATION = (
    *(f"rate_after_separation_{axis}" for axis in AXES),
    *(f"rate_min_after_separation_{axis}" for axis in AXES),
    *(f"rate_max_after_separation_{axis}" for axis in AXES),
)
_SPEEDS = ("longitudinal_speed_max", "longitudinal_speed_after_separation")
METRICS: tuple[str, ...] = (
    *_OBJECTIVES,
    *(f"final_rate_{axis}" for axis in AXES),
    *_AFTER_SEPARATION,
    *(f"deviation_at_separation_{angle}" for angle in ANGLES),
    *(f"angle_at_separation_{angle}" for angle in ANGLES),
    "deviation_within_limits_until",
    *_SPEEDS,
    "separation_end",
)
"""Names of the figures, in order."""
WINDOWED = (*_OBJECTIVES, *_AFTER_SEPARATION, *_SPEEDS)
"""Figures that can look at a part of a run alone."""


def metrics(
    run: Run,
    deviation_limits: Sequence[float],
    window: tuple[float, float] | None = None,
) -> dict[str, float]:
    """Return every figure of a completed run, by name.

    Separation ends when every attachment is released and the last spring has reached
    its stroke. Rates are those of B in W, in B; deviations are its roll, pitch and yaw
    in W; the longitudinal speed is that of B's CG as seen from A. A figure of a rate's
    or an angle's magnitude stands beside those of its two directions.

    Args:
        run: a completed run.
        deviation_limits: (3,) limits of roll, pitch and yaw, rad, for the time
            until which all stay within theirs; infinite where there is none.
        window: from when to when to look, s, for the figures of `WINDOWED`; the whole
            run if None.

    Raises:
        RuntimeError: the run failed.
        ValueError: the window leaves nothing to look at.
    """
    motion = run.completed_motion
    released, end = run.separation_start, run.separation_end
    duration = run.separation.duration
    first, last = (-math.inf, math.inf) if window is None else window

    def seen(samples: NDArray[np.float64], since: float) -> list[PPoly]:
        start, stop = max(since, first), min(duration, last)
        if start >= stop:
            raise InputError(
                f"window: must end after {since:g} s, from when its figure looks, and "
                f"begin before the run's end at {duration:g} s, got {window} s"
            )
        whole = signals.interpolate(motion.time, samples, run.breaks)
        return [signals.between(signal, start, stop) for signal in whole]

    values = _objectives(
        seen(motion.relative_rate, released),
        seen(motion.relative_velocity[:, :1], released)[0],
    )
    for i, axis in enumerate(AXES):
        values[f"final_rate_{axis}"] = float(motion.rate[-1, i])
    for axis, rate in zip(AXES, seen(motion.rate, end), strict=True):
        lowest, highest = signals.extremes(rate)
        values[f"rate_after_separation_{axis}"] = max(-lowest, highest)
        values[f"rate_min_after_separation_{axis}"] = lowest
        values[f"rate_max_after_separation_{axis}"] = highest
    angles = signals.interpolate(motion.time, motion.angle, run.breaks)
    for name, angle in zip(ANGLES, angles, strict=True):
        values[f"angle_at_separation_{name}"] = float(angle(end))
        values[f"deviation_at_separation_{name}"] = abs(float(angle(end)))
    values["deviation_within_limits_until"] = min(
        signals.time_within(angle, limit)
        for angle, limit in zip(angles, deviation_limits, strict=True)
    )
    speed_of = motion.relative_velocity[:, :1]
    values["longitudinal_speed_max"] = signals.extremes(seen(speed_of, 0.0)[0])[1]
    after = seen(speed_of, end)[0]
    values["longitudinal_speed_after_separation"] = signals.extremes(after)[0]
    values["separation_end"] = end
    return {name: values[name] for name in METRICS}


def _objectives(rates: Sequence[PPoly], speed: PPoly) -> dict[str, float]:
    """Return the paper's objectives, of the motion relative to A since release."""

    def total(functional: Callable[[PPoly], float]) -> float:
        return sum(map(functional, rates))

    return {
        "G_L1": total(signals.integral_of_magnitude),  # Eq. 11
        "G_L2": math.sqrt(total(signals.integral_of_square)),  # Eq. 12
        "G_Linf": total(signals.peak),  # Eq. 13
        "G_PM": -signals.extremes(speed)[1],  # Eq. 14
    }
