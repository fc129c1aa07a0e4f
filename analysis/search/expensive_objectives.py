"""Searches for expensive objectives, beside those for the others.

What takes longer to tell than its run to fly, as a clearance does, is not swept: it is
searched by SQP only, from fewer starts, in a thread beside the searches for the others.
Neither knows of the other, so that nothing depends on which is sooner.
"""

import dataclasses
import queue
import threading
from collections.abc import Sequence
from concurrent import futures
from types import TracebackType
from typing import Self

from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.effort import SearchSettings, fewer_starts
from drakesep.analysis.search.problem import (
    OnProgress,
    Problem,
    Searched,
    SearchProgress,
    candidates_of,
)
from drakesep.analysis.search.registry import SQP_SEARCHES, run_search
from drakesep.systems.checks import InputError


_A_MOMENT = 0.1
"""Between two tellings of progress, s."""


def check_expensive(objectives: Sequence[Objective], searches: Sequence[str]) -> None:
    """Raise ValueError if expensive objectives beside others have no search by SQP.

    Args:
        objectives: of a study.
        searches: names out of `SEARCHES`.
    """
    expensive = [o.name for o in objectives if o.expensive]
    if 0 < len(expensive) < len(objectives) and not set(searches) & set(SQP_SEARCHES):
        raise InputError(
            f"searches: {', '.join(expensive)} takes too long to be swept beside "
            f"others: must have {' or '.join(SQP_SEARCHES)} too, got "
            f"{', '.join(searches)}"
        )


def by_cost(problem: Problem) -> tuple[Problem, Problem | None]:
    """Return the problem of the cheap objectives, and that of the expensive ones.

    The problem itself and None, unless it has both.
    """
    objectives = problem.evaluator.objectives
    expensive = tuple(k for k in problem.asked if objectives[k].expensive)
    cheap = tuple(k for k in problem.asked if not objectives[k].expensive)
    if not (cheap and expensive):
        return problem, None
    cheaply = dataclasses.replace(problem, only=cheap)
    return cheaply, dataclasses.replace(problem, only=expensive)


class ExpensiveSearches:
    """The searches by SQP, for expensive objectives; a context manager.

    They begin at once if the evaluator may be asked by several threads, else each when
    it is waited for.
    """

    def __init__(
        self,
        problem: Problem,
        searches: Sequence[str],
        settings: SearchSettings,
        on_progress: OnProgress,
        finished: Sequence[Searched] = (),
    ):
        """Begin.

        Args:
            problem: the expensive objectives, and the set.
            searches: names out of `SEARCHES`, in their order.
            settings: how hard to search for others.
            on_progress: called with what they tell, when one of them is waited for.
            finished: what came of the first of them, if that is known.

        Raises:
            ValueError: no search is by SQP.
        """
        check_expensive(problem.evaluator.objectives, searches)
        names = [n for n in searches[len(finished) :] if n in SQP_SEARCHES]
        self._problem = problem
        self._settings = dataclasses.replace(
            settings, starts=fewer_starts(settings.starts)
        )
        self._on_progress = on_progress
        self._known = candidates_of(problem, finished)
        self._told: dict[str, queue.SimpleQueue[SearchProgress]] = {
            name: queue.SimpleQueue() for name in names
        }
        self._abandoned = threading.Event()
        self._thread = futures.ThreadPoolExecutor(1)
        self._begun: dict[str, futures.Future[Searched]] = {}
        self._names = names
        if problem.evaluator.concurrent:
            self._begun = {n: self._thread.submit(self._search, n) for n in names}

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Abandon what is still under way."""
        self._abandoned.set()
        self._thread.shutdown(cancel_futures=True)

    def join(self, found: Searched) -> Searched:
        """Return a search for others, with the same for the expensive objectives."""
        if found.search not in self._names:
            return found
        begun = self._begun.get(found.search)
        if begun is None:
            return found.joined(self._search(found.search))
        while not begun.done():
            self._pass_on(found.search)
            futures.wait([begun], timeout=_A_MOMENT)
        self._pass_on(found.search)
        return found.joined(begun.result())

    def _pass_on(self, search: str) -> None:
        """Tell what has been told, in the caller's thread."""
        while not self._told[search].empty():
            self._on_progress(self._told[search].get())

    def _search(self, name: str) -> Searched:
        found = run_search(name, self._problem, self._settings, self._known, self._tell)
        self._known.extend(found.candidates)
        return found

    def _tell(self, progress: SearchProgress) -> None:
        if self._abandoned.is_set():
            raise _Abandoned
        if self._problem.evaluator.concurrent:
            self._told[progress.search].put(progress)
        else:
            self._on_progress(progress)


class _Abandoned(Exception):
    """Raised in a search that nobody waits for any more."""
