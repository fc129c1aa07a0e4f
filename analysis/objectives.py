"""What makes a separation bad: scalar objectives of a run, to be maximised.

An objective is any function of a `Run` that returns a float. The four of the paper
look at the motion of B relative to A from release to the end of the run.
"""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

from drakesep.analysis import signals
from drakesep.systems.run import Run


Objective: TypeAlias = Callable[[Run], float]
ObjectiveName: TypeAlias = Literal["L1", "L2", "Linf", "PM"]


def _since_release(run: Run, samples: NDArray[np.float64]) -> list[PPoly]:
    interpolants = signals.interpolate(run.completed_motion.time, samples, run.breaks)
    start, end = run.separation_start, run.separation.duration
    return [signals.between(signal, start, end) for signal in interpolants]


def _relative_rates(run: Run) -> list[PPoly]:
    return _since_release(run, run.completed_motion.relative_rate)


def l1(run: Run) -> float:
    """Return G_L1, the integral of the relative rates' magnitudes, rad."""
    return sum(map(signals.integral_of_magnitude, _relative_rates(run)))  # Eq. 11


def l2(run: Run) -> float:
    """Return G_L2, the energy norm of the relative rates, rad/sqrt(s)."""
    squares = map(signals.integral_of_square, _relative_rates(run))
    return math.sqrt(sum(squares))  # Eq. 12


def linf(run: Run) -> float:
    """Return G_Linf, the sum of the relative rates' peaks, rad/s."""
    return sum(map(signals.peak, _relative_rates(run)))  # Eq. 13


def pm(run: Run) -> float:
    """Return G_PM, less the largest longitudinal speed relative to A, m/s."""
    [speed] = _since_release(run, run.completed_motion.relative_velocity[:, :1])
    return -signals.extremes(speed)[1]  # Eq. 14


OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {"L1": l1, "L2": l2, "Linf": linf, "PM": pm}
)
"""The paper's objectives by name."""
