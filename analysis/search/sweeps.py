"""Searches that fly points known beforehand: random samples, vertices.

A point is flown once for all objectives.
"""

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np

from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import (
    Candidate,
    Known,
    OnProgress,
    Problem,
    Searched,
    SearchProgress,
)
from drakesep.analysis.search.sqp import Start, slopes_at
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


_T = TypeVar("_T")

_KEPT = 4
"""Candidates of a sweep, for each objective: an ascent starts there."""
_SWEEP = 16_384
"""Points between two tellings of progress."""


class Best:
    """The best points of a sweep, for each objective."""

    def __init__(self, search: str, problem: Problem):
        self.search = search
        self._problem = problem
        self._found: dict[int, list[tuple[float, tuple[float, ...]]]] = {
            k: [] for k in problem.asked
        }
        self.points = 0
        self.failures: dict[str, int] = {}

    def add(self, u: Array, values: Array, failures: Mapping[int, str]) -> None:
        """Take in points (p, n) and their values (p, m); NaN where a run failed."""
        self.points += len(u)
        self.fail(failures)
        for k in self._found:
            self._keep(k, u, values[:, k])

    def fail(self, failures: Mapping[int, str]) -> None:
        """Count runs that failed."""
        for why in failures.values():
            self.failures[why] = self.failures.get(why, 0) + 1

    def add_of(self, k: int, u: Array, values: Array) -> None:
        """Take in points (p, n) and the values (p,) of one objective."""
        self.points += len(u)
        self._keep(k, u, values)

    def _keep(self, k: int, u: Array, values: Array) -> None:
        found = self._found[k]
        least = found[-1][0] if len(found) == _KEPT else -np.inf
        # False where a run failed.
        enough = np.flatnonzero(values >= least)
        for i in enough[np.argsort(-values[enough], kind="stable")][:_KEPT].tolist():
            found.append((float(values[i]), tuple(u[i].tolist())))
        self._found[k] = sorted(set(self._found[k]), reverse=True)[:_KEPT]

    @property
    def values(self) -> dict[int, float]:
        """Best values, by objective."""
        return {k: found[0][0] for k, found in self._found.items() if found}

    def searched(self, note: str) -> Searched:
        """Return what was found."""
        return Searched(
            search=self.search,
            candidates=tuple(
                Candidate(objective=k, u=u, value=value, search=self.search)
                for k, found in self._found.items()
                for value, u in found
            ),
            points=self.points,
            failures=self.failures,
            what={note: len(self._problem.asked)},
            objectives=self._problem.asked,
            of=len(self._problem.evaluator.objectives),
        )


def sample(
    problem: Problem, settings: SearchSettings, known: Known, on_progress: OnProgress
) -> Searched:
    """Fly points drawn uniformly from the set."""
    rng = np.random.default_rng(settings.seed)
    total = settings.samples
    best = Best("samples", problem)
    draws = (
        problem.tolerances.draw(min(_SWEEP, total - first), rng)
        for first in range(0, total, _SWEEP)
    )
    for u in _ahead(draws):
        _fly_all(problem, u, best, total, on_progress)
    return best.searched(f"{total} random samples")


def _fly_all(
    problem: Problem, u: Array, best: Best, total: int, on_progress: OnProgress
) -> Array:
    before = best.points

    def tell(done: int, _: int) -> None:
        on_progress(
            SearchProgress(
                search=best.search, done=before + done, total=total, best=best.values
            )
        )

    told = problem.evaluator.all(problem.tolerances.rows(u), tell, problem.asked)
    best.add(u, told.values, told.failures)
    return told.values


def sweep_vertices(
    problem: Problem, settings: SearchSettings, known: Known, on_progress: OnProgress
) -> Searched:
    """Fly every vertex of the box.

    A vertex that is not in the set is flown where the line from the nominal to it
    leaves the set. Where all vertices are too many, a parameter is held at one of its
    bounds for an objective whose slope has one sign wherever it was looked at.

    Raises:
        ValueError: the vertices are too many, even so.
    """
    n = len(problem.tolerances)
    best = Best("vertices", problem)
    if 2**n <= settings.vertices:
        drawn_back = 0
        for u, drawn in _ahead(_vertices(problem.tolerances, np.zeros(n))):
            drawn_back += drawn
            _fly_all(problem, u, best, 2**n, on_progress)
        note = f"all {2**n} vertices"
        if drawn_back:
            note += f", {drawn_back} of them drawn back into the set"
        return best.searched(note)
    held = _one_signed(problem, settings, known)
    free = (held[list(problem.asked)] == 0.0).sum(axis=1)
    total = int(sum(2.0**count for count in free))
    if total > settings.vertices:
        raise InputError(
            f"vertices: a box of {n} parameters has 2^{n}, and {total:.3g} where "
            f"slopes do not tell the worse bound; {settings.vertices} are affordable. "
            "Search by 'corners' or 'multistart', disperse fewer parameters, or "
            "afford more"
        )
    for k in problem.asked:
        for u, _ in _vertices(problem.tolerances, held[k]):
            told = problem.evaluator.one(problem.tolerances.rows(u), [k] * len(u))
            best.add_of(k, u, told.values)
            best.fail(told.failures)
            on_progress(
                SearchProgress(
                    search="vertices", done=best.points, total=total, best=best.values
                )
            )
    return best.searched(
        f"{total} vertices in the {int(free.min())} to {int(free.max())} parameters "
        f"whose slopes changed sign at {_PLACES} points, the others at the worse bound"
    )


_PLACES = 64
"""Points at which slopes are looked at."""


def _one_signed(problem: Problem, settings: SearchSettings, known: Known) -> Array:
    """Return (m, n) signs of slopes that keep theirs; 0 where they do not."""
    rng = np.random.default_rng(settings.seed)
    points = problem.tolerances.draw(_PLACES, rng)
    points[0] = 0.0
    signs = np.zeros((len(problem.evaluator.objectives), len(problem.tolerances)))
    for k in problem.asked:
        mine = [np.array(c.u) for c in known if c.objective == k]
        starts = [
            Start(objective=k, tolerances=problem.tolerances, u=u)
            for u in [*points, *mine]
        ]
        slopes = slopes_at(starts, problem.evaluator, settings.ascent)
        sign = np.sign(slopes)
        sign[:, (sign == 0.0).all(axis=0)] = 1.0  # of no matter: either bound does
        signs[k] = np.where((sign == sign[0]).all(axis=0), sign[0], 0.0)
    return signs


def _ahead(items: Iterator[_T]) -> Iterator[_T]:
    """Yield items, each made while the one before it is at work.

    Who stops early waits for the one that is being made.
    """
    with ThreadPoolExecutor(1) as thread:
        following = thread.submit(next, items, None)
        while (item := following.result()) is not None:
            following = thread.submit(next, items, None)
            yield item


def _vertices(tolerances: ToleranceSet, held: Array) -> Iterator[tuple[Array, int]]:
    """Yield points (p, n), and how many of them were drawn back into the set."""
    free = np.flatnonzero(held == 0.0)
    for first in range(0, 2 ** len(free), _SWEEP):
        numbers = np.arange(first, min(first + _SWEEP, 2 ** len(free)))
        signs = np.tile(held, (len(numbers), 1))
        signs[:, free] = 2.0 * ((numbers[:, None] >> np.arange(len(free))) & 1) - 1.0
        corners = tolerances.box.corners(signs)
        u = tolerances.draw_back(corners)
        yield u, int((u != corners).any(axis=1).sum())
