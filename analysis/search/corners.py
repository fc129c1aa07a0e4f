"""The search among corners, where they are too many to be flown: by flips of bounds.

What is worst is often worst in a corner of the box, and each corner has n neighbours,
in which one parameter is at its other bound. From many corners the search goes on to
worse ones: all flips of one bound are flown, then the best of them alone and together.
Where none gains anything, flips of two bounds are looked at, which free the search from
most corners that are worst among their neighbours alone. It ends when several
starts have come to the worst corner known.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from drakesep.analysis.search.ask_tell import side_by_side
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import (
    Candidate,
    Known,
    OnProgress,
    Problem,
    Searched,
    SearchProgress,
)
from drakesep.analysis.search.sweeps import Best
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.arrays import Array


_ROUND = 16
"""Corners from which the search goes up at once."""
_THERE = 8
"""Starts that must have come to the worst corner known."""
_PAIRED = 4
"""Ends of a round, the worst, about which flips of two bounds are looked at."""
_GAIN = 1e-12
"""That counts, as a part of the value: less is round-off."""
_Fly: TypeAlias = Callable[[Array], Array]
"""Values (c,) of one objective at corners (c, n): -1 at lower bounds, 1 at upper."""
_Asked: TypeAlias = tuple[int, Any]
"""An objective, and corners (c, n) at which it is wanted."""


def flip_bounds(
    problem: Problem, settings: SearchSettings, known: Known, on_progress: OnProgress
) -> Searched:
    """Search the corners of the box by flips of one and two bounds.

    A corner that is not in the set is flown where the line from the nominal to it
    leaves the set. It begins at corners near likely points and the best known ones.
    """
    best = Best("corners", problem)
    set_ = problem.tolerances
    starts: dict[int, int] = {}
    if settings.flips < _ROUND:  # of so few starts each should be a good one
        known = [*known, *_scattered(problem, settings, best)]

    def task(k: int) -> Callable[[Callable[[_Asked], Array]], None]:
        worst_first = sorted(
            (c for c in known if c.objective == k), key=lambda c: -c.value
        )
        points = [problem.likely[k]] if k in problem.likely else []
        points += [c.u for c in worst_first]

        def run(ask: Callable[[_Asked], Array]) -> None:
            search = _Flips(lambda corners: ask((k, corners)), problem, settings)
            starts[k] = search.run(_corners_near(points, set_.box))

        return run

    def answer(asked: list[_Asked]) -> list[Array | None]:
        u = set_.draw_back(set_.box.corners(np.concatenate([c for _, c in asked])))
        which = [k for k, corners in asked for _ in corners]
        told = problem.evaluator.one(set_.rows(u), which)
        answers: list[Array | None] = []
        first = 0
        for k, corners in asked:
            part = slice(first, first + len(corners))
            first = part.stop
            best.add_of(k, u[part], told.values[part])
            answers.append(told.values[part])
        best.fail(told.failures)
        on_progress(
            SearchProgress(
                search=best.search, done=best.points, total=None, best=best.values
            )
        )
        return answers

    side_by_side([task(k) for k in problem.asked], answer)
    least, most = min(starts.values()), max(starts.values())
    return best.searched(
        f"flips of one and two bounds, from {least} to {most} corners"
        if least < most
        else f"flips of one and two bounds, from {least} corners"
    )


def _scattered(
    problem: Problem, settings: SearchSettings, best: Best
) -> Sequence[Candidate]:
    """Return the worst of corners drawn at random, which all objectives share.

    Of all corners, if they are fewer.
    """
    set_ = problem.tolerances
    n, most = len(set_), settings.samples
    if 2**n <= most:
        signs = 2.0 * ((np.arange(2**n)[:, None] >> np.arange(n)) & 1) - 1.0
    else:
        rng = np.random.default_rng(settings.seed)
        signs = rng.choice([-1.0, 1.0], size=(most, n))
    u = set_.draw_back(set_.box.corners(signs))
    told = problem.evaluator.all(set_.rows(u), None, problem.asked)
    best.add(u, told.values, told.failures)
    return best.searched("").candidates


def _corners_near(points: list[tuple[float, ...]], box: ToleranceBox) -> Array:
    """Return the different corners (c, n) that points are nearest to."""
    middle = 0.5 * (box.lower + box.upper)
    corners = np.where(np.array(points).reshape(-1, len(box)) >= middle, 1.0, -1.0)
    different = dict.fromkeys(map(tuple, corners.tolist()))
    return np.array([*different]).reshape(-1, len(box))


class _Flips:
    """The search for one objective."""

    def __init__(self, fly: _Fly, problem: Problem, settings: SearchSettings):
        self._fly = fly
        self._settings = settings
        # The same for each objective: what others there are changes nothing.
        self._rng = np.random.default_rng(settings.seed)
        n = len(problem.tolerances)
        self._one = 1.0 - 2.0 * np.eye(n)
        i, j = np.triu_indices(n, 1)
        self._two = self._one[i] * self._one[j]
        self._values: dict[bytes, float] = {}
        # Who affords fewer flips than corners of a round begins at fewer.
        self._round = min(_ROUND, settings.flips)
        self._paired = _PAIRED * self._round // _ROUND

    def run(self, first: Array) -> int:
        """Search, and return from how many corners.

        Args:
            first: (c, n) corners of the first round; the others are drawn at random.
        """
        ends: list[bytes] = []
        flown, there = -1, 0
        # A round that flies nothing new has seen all corners there are.
        while there < _THERE and flown < len(self._values) < self._settings.flips:
            flown = len(self._values)
            corners = self._drawn(self._round)
            if not ends:
                corners[: len(first)] = first[: self._round]
            ends += map(_key, self._freed(self._climbed(corners)))
            values = np.array([self._values[end] for end in ends])
            there = int((values >= values.max() - _least(values.max())).sum())
        return len(ends)

    def _drawn(self, count: int) -> Array:
        return self._rng.choice([-1.0, 1.0], size=(count, len(self._one)))

    def _valued(self, corners: Array) -> Array:
        """Return the values (...,) of corners (..., n); each is flown once.

        Less than all others where a run failed.
        """
        flat = corners.reshape(-1, corners.shape[-1])
        keys = [_key(corner) for corner in flat]
        new = {key: i for i, key in enumerate(keys) if key not in self._values}
        if new:
            told = self._fly(flat[[*new.values()]])
            flown = np.where(np.isnan(told), -np.inf, told)
            self._values.update(zip(new, flown.tolist(), strict=True))
        return np.array([self._values[key] for key in keys]).reshape(corners.shape[:-1])

    def _climbed(self, corners: Array) -> Array:
        """Return where flips of one bound lead from corners (c, n)."""
        corners = corners.copy()
        moving = np.arange(len(corners))
        while len(moving):
            here = corners[moving]
            values = self._valued(here)
            flips = here[:, None] * self._one
            gains = (
                self._valued(flips)
                - np.where(np.isfinite(values), values, np.finfo(float).min)[:, None]
            )
            rising = gains > _least(values)[:, None]
            up = np.flatnonzero(rising.any(axis=1))
            moving = moving[up]
            if len(up):
                steps = np.stack(
                    [_together(here[i], gains[i], rising[i]) for i in up.tolist()]
                )
                best = self._valued(steps).argmax(axis=1)
                corners[moving] = steps[np.arange(len(up)), best]
        return corners

    def _freed(self, corners: Array) -> Array:
        """Return corners (c, n), the worst of them led on by flips of two bounds."""
        corners, looked = corners.copy(), set[bytes]()
        while True:
            keys = [_key(corner) for corner in corners]
            values = np.array([self._values[key] for key in keys])
            order = np.argsort(-values, kind="stable")
            worst = [*dict.fromkeys(keys[i] for i in order)][: self._paired]
            left = [key for key in worst if key not in looked]
            if not left:
                return corners
            looked.add(left[0])
            alike = [i for i, key in enumerate(keys) if key == left[0]]
            pairs = corners[alike[0]] * self._two
            told = self._valued(pairs)
            if told.max(initial=-np.inf) > values[alike[0]] + _least(values[alike[0]]):
                corners[alike] = self._climbed(pairs[[told.argmax()]])


def _together(corner: Array, gains: Array, rising: Array) -> Array:
    """Return corners (t, n) with the flips that gain most: one, two, four, ... or all.

    Always as many, whatever gains: all of them again and again if they are few.
    """
    order = np.argsort(-gains, kind="stable")[: int(rising.sum())]
    sizes = [2**i for i in range(len(corner).bit_length() + 1)]
    steps = np.tile(corner, (len(sizes), 1))
    for step, size in zip(steps, sizes, strict=True):
        step[order[:size]] *= -1.0
    return steps


def _least(value: Array | float) -> Any:
    """Return what a gain must exceed to count."""
    finite = np.where(np.isfinite(value), value, 0.0)
    return _GAIN * np.abs(finite)


def _key(corner: Array) -> bytes:
    return (corner > 0.0).tobytes()
