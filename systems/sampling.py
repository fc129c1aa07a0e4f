"""When a run is sampled, and where its motion has kinks. No Drake here."""

import itertools
import math
from collections.abc import Mapping

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.equations.joint_modes import joint_modes
from drakesep.systems.model.separation import Separation


NANOSECOND = 1e-9
_ROWS = 300
"""Sample intervals over a run, common to all runs of a case."""
_ROWS_PER_PUSH = 64
"""Sample intervals over a push, where the motion changes fastest."""
_ROWS_PER_STRETCH = 6
"""Sample intervals from one kink to the next: splines have something to go by."""

_ROWS_PER_PERIOD = 20
"""Sample intervals over a period in which bodies ring on their joints: straight lines
miss at most a hundredth of an amplitude."""
_FEWEST_PER_PERIOD = 10
"""With fewer, loads of joints are not told."""
_ROWS_OF_RINGING = 10_000
"""The most over a run."""
_RUNG_OUT = 7.0
"""By how much the logarithm of an amplitude falls until it rings no more."""


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
    end = separation.duration
    breaks = [0.0]
    for t in find_kinks(separation, releases, stroke_ends):
        # Kinks a nanosecond apart are one: nothing moves between them.
        if t - breaks[-1] > NANOSECOND and end - t > NANOSECOND:
            breaks.append(t)
    return (*breaks, end)


def find_kinks(
    separation: Separation,
    releases: Mapping[str, float],
    stroke_ends: Mapping[str, float],
) -> list[float]:
    """Return when forces have kinks, however close, increasing, s; infinite: never.

    Args:
        separation: as it was flown.
        releases: when each attachment let go, s, by its name.
        stroke_ends: when each spring reached its stroke, s, by its name.
    """
    kinks = [*releases.values(), *stroke_ends.values()]
    for load in separation.loads:
        begin = 0.0 if load.after is None else releases.get(load.after, math.inf)
        kinks += [begin + load.start + kink for kink in load.kinks]
    return sorted(kinks)


def sample_times(
    separation: Separation,
    releases: Mapping[str, float],
    stroke_ends: Mapping[str, float],
) -> Array:
    """Return when a run is sampled, s.

    At the multiples of a 300th of its length, which all runs of a case share, at every
    kink, and closer while a spring pushes, where kinks are close together, and where
    bodies ring on joints that hold, as far as `tells_loads`.

    Args:
        separation: as it was flown.
        releases: when each attachment let go, s, by its name.
        stroke_ends: when each spring reached its stroke, s, by its name.
    """
    breaks = np.array(find_breaks(separation, releases, stroke_ends))
    knots = _knots(separation, breaks)
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
    shortest = _shortest_periods(separation, releases, breaks, knots)
    rows = max(1.0, _rows_of_ringing(knots, shortest) / _ROWS_OF_RINGING)
    longest = np.minimum(longest, rows * shortest / _ROWS_PER_PERIOD)
    # A hair less: round-off must not add a row.
    intervals = np.ceil(np.diff(knots) / longest - 1e-9).astype(int)
    first = np.repeat(np.cumsum(intervals) - intervals, intervals)
    number = np.arange(len(first)) - first
    steps = np.repeat(np.diff(knots) / intervals, intervals)
    return np.append(np.repeat(knots[:-1], intervals) + number * steps, knots[-1])


def tells_loads(separation: Separation) -> bool:
    """Return whether samples follow what rings on joints, so that they tell its loads.

    A joint without a time of release counts as if it held to the end.
    """
    end = separation.duration
    releases = {a.name: min(a.release_time, end) for a in separation.attachments}
    ends = separation.timed_stroke_ends(separation.scheduled_releases)
    breaks = np.array(find_breaks(separation, releases, ends))
    knots = _knots(separation, breaks)
    shortest = _shortest_periods(separation, releases, breaks, knots)
    most = _ROWS_OF_RINGING * _ROWS_PER_PERIOD / _FEWEST_PER_PERIOD
    return _rows_of_ringing(knots, shortest) <= most


def _knots(separation: Separation, breaks: Array) -> Array:
    """Return the kinks, and the times that all runs share."""
    grid = np.linspace(0.0, separation.duration, _ROWS + 1)
    apart = np.abs(grid[:, None] - breaks).min(axis=1) > NANOSECOND
    return np.union1d(grid[apart], breaks)


def _shortest_periods(
    separation: Separation, releases: Mapping[str, float], breaks: Array, knots: Array
) -> Array:
    """Return (k - 1,) the shortest period that rings between knots, s, or infinity.

    Each kink makes the bodies ring on the joints that hold, until they have rung out.
    """
    shortest = np.full(len(knots) - 1, math.inf)
    for start, end in itertools.pairwise([0.0, *sorted({*releases.values()})]):
        if end <= start:
            continue
        held = {name for name, release in releases.items() if release >= end}
        modes = joint_modes(separation, held)
        inside = (start <= knots[:-1]) & (knots[:-1] < end)
        since = knots[:-1] - breaks[np.searchsorted(breaks, knots[:-1], "right") - 1]
        rings = modes.decays * since[:, None] < _RUNG_OUT
        periods = np.where(rings, modes.periods, math.inf)
        least = periods.min(axis=1, initial=math.inf)
        shortest = np.where(inside, least, shortest)
    return shortest


def _rows_of_ringing(knots: Array, shortest: Array) -> float:
    return float((np.diff(knots) / shortest).sum()) * _ROWS_PER_PERIOD
