"""When a run is sampled, and where its motion has kinks. No Drake here."""

import math
from collections.abc import Mapping

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.model.separation import Separation


NANOSECOND = 1e-9
_ROWS = 300
"""Sample intervals over a run, common to all runs of a case."""
_ROWS_PER_PUSH = 64
"""Sample intervals over a push, where the motion changes fastest."""
_ROWS_PER_STRETCH = 6
"""Sample intervals from one kink to the next: splines have something to go by."""


def find_breaks(
    separation: Separation,
    releases: Mapping[str, float],
    stroke_ends: Mapping[str, float],
) -> tuple[float, ...]:
    """Return the times at which the motion has a kink, with start and end, s.

    Args:
        separation: as it was flown.
        releases: when each attachment let go, s, by its name.
        stroke_ends: when each spring reached its stroke, s, by its name.
    """
    kinks = [*releases.values(), *stroke_ends.values()]
    for load in separation.loads:
        begin = 0.0 if load.after is None else releases.get(load.after, math.inf)
        kinks += [begin + load.start + kink for kink in load.kinks]
    end = separation.duration
    breaks = [0.0]
    for t in sorted(kinks):
        # Kinks a nanosecond apart are one: nothing moves between them.
        if t - breaks[-1] > NANOSECOND and end - t > NANOSECOND:
            breaks.append(t)
    return (*breaks, end)


def sample_times(
    separation: Separation,
    releases: Mapping[str, float],
    stroke_ends: Mapping[str, float],
) -> Array:
    """Return when a run is sampled, s.

    At the multiples of a 300th of its length, which all runs of a case share, at every
    kink, and closer while a spring pushes or where kinks are close together.

    Args:
        separation: as it was flown.
        releases: when each attachment let go, s, by its name.
        stroke_ends: when each spring reached its stroke, s, by its name.
    """
    breaks = np.array(find_breaks(separation, releases, stroke_ends))
    grid = np.linspace(0.0, separation.duration, _ROWS + 1)
    apart = np.abs(grid[:, None] - breaks).min(axis=1) > NANOSECOND
    knots = np.union1d(grid[apart], breaks)
    pushes = [
        (releases[a.name], stroke_ends[a.spring.name])
        for a in separation.attachments
        if a.spring
    ]
    middle = 0.5 * (knots[:-1] + knots[1:])
    longest = np.diff(breaks)[np.searchsorted(breaks, middle) - 1] / _ROWS_PER_STRETCH
    for start, end in pushes:
        pushing = (start < middle) & (middle < end)
        closer = np.minimum(longest, (end - start) / _ROWS_PER_PUSH)
        longest = np.where(pushing, closer, longest)
    # A hair less: round-off must not add a row.
    intervals = np.ceil(np.diff(knots) / longest - 1e-9).astype(int)
    first = np.repeat(np.cumsum(intervals) - intervals, intervals)
    number = np.arange(len(first)) - first
    steps = np.repeat(np.diff(knots) / intervals, intervals)
    return np.append(np.repeat(knots[:-1], intervals) + number * steps, knots[-1])
