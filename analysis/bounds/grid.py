"""The pieces of time on which motion is enclosed."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from drakesep.analysis.bounds.box import Boxes, whole_box
from drakesep.analysis.bounds.intervals import Interval, up
from drakesep.analysis.bounds.problem import BoundProblem
from drakesep.systems.arrays import Array


class Grid(NamedTuple):
    """Pieces of time."""

    times: Array
    """(N + 1,) their ends, s."""
    push: int
    """Of them, those before all strokes have surely ended."""

    @property
    def lengths(self) -> Array:
        """(N,) s."""
        return np.diff(self.times)


_SHORT = 1e-6
"""Part of the run that a piece takes that stands for a moment."""


_ENDING = 4
"""Pieces from when the last stroke may end to when it surely has."""


class Stroke(NamedTuple):
    """Between which times the last stroke ends, over the whole box, s."""

    earliest: float
    latest: float


def last_stroke(problem: BoundProblem, pairs: Iterable[int]) -> Stroke:
    """Return when the last stroke of some pairs ends; 0 if there is none."""
    ends = stroke_ends(whole_box(problem), pairs)
    return Stroke(float(ends.lo.max()), float(ends.hi.max()))


def stroke_ends(boxes: Boxes, pairs: Iterable[int]) -> Interval:
    """Return when the last stroke of some pairs ends (boxes,); 0 if there is none."""
    chosen = set(pairs)
    none = np.zeros(boxes.count)
    low, high = [none], [none]
    for spring in boxes.problem.springs:
        if spring.pair in chosen:
            end = boxes.law(spring).duration
            low.append(np.broadcast_to(end.lo[:, 0], none.shape))
            high.append(np.broadcast_to(end.hi[:, 0], none.shape))
    return Interval(np.max(low, axis=0), np.max(high, axis=0))


def make_grid(
    problem: BoundProblem, push: int, coast: int, moments: Iterable[float] = ()
) -> Grid:
    """Return pieces of time.

    Args:
        problem: with the springs.
        push: pieces while springs may push, or a few more.
        coast: pieces after that, or a few more.
        moments: times, each of which is to be the end of a short piece, s; of 0 it is
            the beginning.
    """
    T = problem.duration
    first, latest = last_stroke(problem, range(len(problem.pairs)))
    ended = float(up(np.array(latest))) if latest > 0.0 else 0.0
    times = [*np.linspace(0.0, first, push + 1), *np.linspace(ended, T, coast + 1)]
    times += [*np.linspace(first, ended, _ENDING + 1)]
    for moment in (*moments, T):
        times += [moment, moment - _SHORT * T if moment > 0.0 else _SHORT * T]
    grid = np.unique(np.clip(times, 0.0, T))
    return Grid(grid, int(np.searchsorted(grid, ended)))


def pieces_between(grid: Grid, start: float, end: float) -> tuple[int, int]:
    """Return the first and the last piece that may hold a time from one to another.

    Of one moment at which a piece ends it is that piece.
    """
    last = int(np.searchsorted(grid.times, end, side="left")) - 1
    first = min(int(np.searchsorted(grid.times, start, side="right")) - 1, last)
    most = len(grid.times) - 2
    return min(max(first, 0), most), min(max(last, 0), most)
