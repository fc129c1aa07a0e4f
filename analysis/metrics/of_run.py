"""The metrics that a run is judged by, in SI and radians."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

from drakesep.analysis.metrics import sampled_signals as signals
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run


AXES = ("x", "y", "z")
ANGLES = ("roll", "pitch", "yaw")
_OBJECTIVES = ("G_L1", "G_L2", "G_Linf", "G_PM")
_AFTER_SEPARATION = (
    *(f"rate_after_separation_{axis}" for axis in AXES),
    *(f"rate_min_after_separation_{axis}" for axis in AXES),
    *(f"rate_max_after_separation_{axis}" for axis in AXES),
    *(f"rate_magnitude_min_after_separation_{axis}" for axis in AXES),
)
_SPEEDS = (
    "longitudinal_speed_max",
    "longitudinal_speed_after_separation",
    "longitudinal_speed_max_after_separation",
)
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
"""Names of the metrics, in order."""
WINDOWED = (*_OBJECTIVES, *_AFTER_SEPARATION, *_SPEEDS)
"""Metrics that can look at a part of a run alone."""


def metrics_of_run(run: Run, deviation_limits: Sequence[float]) -> dict[str, float]:
    """Return every metric of a completed run, by name.

    Separation ends when every attachment is released and the last spring has reached
    its stroke. Rates are those of B in W, in B; deviations are its roll, pitch and yaw
    in W; the longitudinal speed is that of B's CG as seen from A. A metric of a rate's
    or an angle's magnitude stands beside those of its two directions.

    Args:
        run: a completed run.
        deviation_limits: (3,) limits of roll, pitch and yaw, rad, for the time
            until which all stay within theirs; infinite where there is none.

    Raises:
        RuntimeError: the run failed.
    """
    motion = run.completed_motion
    end, duration = run.separation_end, run.separation.duration
    released = run.separation_start, duration
    values = _objectives(
        _signals(run, motion.relative_rate, *released),
        _signals(run, motion.relative_velocity[:, :1], *released)[0],
    )
    for i, axis in enumerate(AXES):
        values[f"final_rate_{axis}"] = float(motion.rate[-1, i])
    values |= _peaks(_signals(run, motion.rate, end, duration))
    angles = _signals(run, motion.angle, 0.0, duration)
    for name, angle in zip(ANGLES, angles, strict=True):
        values[f"angle_at_separation_{name}"] = float(angle(end))
        values[f"deviation_at_separation_{name}"] = abs(float(angle(end)))
    values["deviation_within_limits_until"] = min(
        signals.time_within(angle, limit)
        for angle, limit in zip(angles, deviation_limits, strict=True)
    )
    speed = motion.relative_velocity[:, :1]
    whole, after = (_signals(run, speed, t, duration)[0] for t in (0.0, end))
    values["longitudinal_speed_max"] = signals.extremes(whole)[1]
    (
        values["longitudinal_speed_after_separation"],
        values["longitudinal_speed_max_after_separation"],
    ) = signals.extremes(after)
    values["separation_end"] = end
    return {name: values[name] for name in METRICS}


def metric_within(run: Run, metric: str, window: tuple[float, float]) -> float:
    """Return a metric over a part of a run alone.

    The window takes the place of the time that the metric looks at: a rate "after
    separation" is looked at from the window's start, be separation over or not. The
    paper's objectives still begin at the release at the earliest.

    Args:
        run: a completed run.
        metric: one of `WINDOWED`.
        window: from when to when, s.

    Raises:
        RuntimeError: the run failed.
        ValueError: the window leaves nothing of the run to look at.
    """
    motion = run.completed_motion
    since = run.separation_start if metric in _OBJECTIVES else 0.0
    start, stop = max(window[0], since), min(window[1], run.separation.duration)
    if start >= stop:
        raise InputError(
            f"window: must end after {since:g} s and begin before the run's end at "
            f"{run.separation.duration:g} s, got {window[0]:g} to {window[1]:g} s"
        )
    [speed] = _signals(run, motion.relative_velocity[:, :1], start, stop)
    if metric in _OBJECTIVES:
        rates = _signals(run, motion.relative_rate, start, stop)
        return _objectives(rates, speed)[metric]
    if metric in _SPEEDS:
        slowest, fastest = signals.extremes(speed)
        return slowest if metric == "longitudinal_speed_after_separation" else fastest
    return _peaks(_signals(run, motion.rate, start, stop))[metric]


def _signals(
    run: Run, samples: NDArray[np.float64], start: float, stop: float
) -> list[PPoly]:
    """Return the signals through samples, from one time to another."""
    whole = signals.interpolate(run.completed_motion.time, samples, run.breaks)
    return [signals.between(signal, start, stop) for signal in whole]


def _peaks(rates: Sequence[PPoly]) -> dict[str, float]:
    """Return the largest rates about each axis, and their magnitudes."""
    values = {}
    for axis, rate in zip(AXES, rates, strict=True):
        lowest, highest = signals.extremes(rate)
        values[f"rate_after_separation_{axis}"] = max(-lowest, highest)
        values[f"rate_min_after_separation_{axis}"] = lowest
        values[f"rate_max_after_separation_{axis}"] = highest
        values[f"rate_magnitude_min_after_separation_{axis}"] = max(
            0.0, lowest, -highest
        )
    return values


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
