"""The figures that a run is judged by, in SI and radians."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

from drakesep.analysis import signals
from drakesep.analysis.objectives import OBJECTIVES
from drakesep.systems.run import Run


AXES = ("x", "y", "z")
ANGLES = ("roll", "pitch", "yaw")
METRICS: tuple[str, ...] = (
    *(f"G_{name}" for name in OBJECTIVES),
    *(f"final_rate_{axis}" for axis in AXES),
    *(f"rate_after_separation_{axis}" for axis in AXES),
    *(f"deviation_at_separation_{angle}" for angle in ANGLES),
    "deviation_within_limits_until",
    "longitudinal_speed_max",
    "longitudinal_speed_after_separation",
    "separation_end",
)
"""Names of the figures, in order."""


def metrics(run: Run, deviation_limits: Sequence[float]) -> dict[str, float]:
    """Return every figure of a completed run, by name.

    Separation ends when every attachment is released and the last spring has reached
    its stroke. Rates are those of B in W, in B; deviations are its roll, pitch and yaw
    in W; the longitudinal speed is that of B's CG as seen from A.

    Args:
        run: a completed run.
        deviation_limits: (3,) limits of roll, pitch and yaw, rad, for the time
            until which all stay within theirs; infinite where there is none.

    Raises:
        RuntimeError: the run failed.
    """
    motion = run.completed_motion
    end, duration = run.separation_end, run.separation.duration

    def signal(samples: NDArray[np.float64]) -> list[PPoly]:
        return signals.interpolate(motion.time, samples, run.breaks)

    values = {f"G_{name}": objective(run) for name, objective in OBJECTIVES.items()}
    for i, axis in enumerate(AXES):
        values[f"final_rate_{axis}"] = float(motion.rate[-1, i])
    for axis, rate in zip(AXES, signal(motion.rate), strict=True):
        after = signals.between(rate, end, duration)
        values[f"rate_after_separation_{axis}"] = signals.peak(after)
    angles = signal(motion.angle)
    for name, angle in zip(ANGLES, angles, strict=True):
        values[f"deviation_at_separation_{name}"] = abs(float(angle(end)))
    values["deviation_within_limits_until"] = min(
        signals.time_within(angle, limit)
        for angle, limit in zip(angles, deviation_limits, strict=True)
    )
    [speed] = signal(motion.relative_velocity[:, :1])
    values["longitudinal_speed_max"] = signals.extremes(speed)[1]
    after = signals.between(speed, end, duration)
    values["longitudinal_speed_after_separation"] = signals.extremes(after)[0]
    values["separation_end"] = end
    return values
