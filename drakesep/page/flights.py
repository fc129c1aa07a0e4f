"""A process beside the page's, which flies what is asked for; the newest is flown.

It is another process, so that the page answers while it flies, and stays where it ends.
It ends when the page's does. What is asked while it flies waits; what the same asker
asks then takes the place of what waits, which nobody wants any more. Other askers keep
their turn: two views, or two browsers on one page, do not take it from each other.
"""

import asyncio
import threading
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import BrokenExecutor, Executor, Future
from typing import TYPE_CHECKING, Any, NamedTuple

from drakesep.analysis.analysis_case import AnalysisCase


if TYPE_CHECKING:  # imports Drake
    from drakesep.page.flown import Flown


class FlightsEnded(RuntimeError):
    """The process that flies has ended, killed perhaps; the next run starts another."""


class _Asked(NamedTuple):
    arguments: tuple[Any, ...]
    answer: "Future[Flown | None]"


class Flights:
    """Flies cases in a process of its own, which is started when it is first needed."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._pool: Executor | None = None
        self._flies: _Asked | None = None
        self._waits: dict[Hashable, _Asked] = {}

    def start(self) -> None:
        """Start the process, before it is needed."""
        with self._lock:
            self._started()

    def fly(
        self,
        case: AnalysisCase,
        values: Mapping[str, float],
        *,
        asker: Hashable = None,
        measure: bool = False,
    ) -> "Future[Flown | None]":
        """Fly a case with some of its parameters changed.

        Args:
            case: in SI.
            values: by parameter name with unit.
            asker: who wants the newest alone of what it asks for.
            measure: whether to measure how near parts come, where that is required.

        Returns:
            What comes of it; None if its asker asked for something newer before it was
            flown.
            Its errors: ValueError of values that cannot be flown, `FlightsEnded`.
        """
        asked = _Asked((case, dict(values), measure), Future())
        asked.answer.set_running_or_notify_cancel()  # none is cancelled by who waits
        with self._lock:
            if self._flies is None:
                self._begin(asked)
            else:
                before = self._waits.get(asker)
                self._waits[asker] = asked  # in the turn of what it asked before
                if before is not None:
                    before.answer.set_result(None)
        return asked.answer

    async def newest(
        self,
        case: AnalysisCase,
        values: Mapping[str, float],
        *,
        asker: Hashable,
        restarts: Callable[[str], object],
        measure: bool = False,
    ) -> "Flown | None":
        """Wait for a run; where the process ends, that is told, and it is flown anew.

        Args:
            case: in SI.
            values: by parameter name with unit.
            asker: who wants the newest alone of what it asks for.
            restarts: told that the process has ended, and is started again.
            measure: whether to measure how near parts come, where that is required.

        Returns:
            The run; None if its asker asked for something newer before it was flown.

        Raises:
            ValueError: the values cannot be flown.
            FlightsEnded: the process ended twice.
        """

        async def flown() -> "Flown | None":
            flying = self.fly(case, values, asker=asker, measure=measure)
            return await asyncio.wrap_future(flying)

        try:
            return await flown()
        except FlightsEnded as error:
            restarts(f"{error}; it is started again")
        return await flown()

    def end(self) -> None:
        """End the process, in the midst of a run if need be: nothing comes of it."""
        from drakesep.analysis.engines.processes import end_processes

        with self._lock:
            pool, self._pool = self._pool, None
            asked = [*filter(None, [self._flies]), *self._waits.values()]
            self._flies, self._waits = None, {}
        for each in asked:
            each.answer.set_result(None)
        if pool is not None:
            end_processes(pool)

    def _started(self) -> Executor:
        from drakesep.analysis.engines.processes import start_processes

        if self._pool is None:
            self._pool = start_processes(1, _prepare)
        return self._pool

    def _begin(self, asked: _Asked) -> None:
        self._flies = asked
        try:
            flying = self._started().submit(_fly, *asked.arguments)
        except (BrokenExecutor, RuntimeError) as error:  # it has ended meanwhile
            self._finish(asked, error)
        else:
            flying.add_done_callback(lambda done: self._finish(asked, None, done))

    def _finish(
        self,
        asked: _Asked,
        error: BaseException | None,
        done: "Future[Flown] | None" = None,
    ) -> None:
        """Hand on what came of a run, and fly what waits."""
        if done is not None:
            error = BrokenExecutor() if done.cancelled() else done.exception()
        with self._lock:
            if asked is not self._flies:  # it was ended
                return
            if done is None or isinstance(error, BrokenExecutor):
                self._pool = None
                error = FlightsEnded("the process that flies has ended")
            self._flies = None
            if self._waits:
                self._begin(self._waits.pop(next(iter(self._waits))))
        if error is not None:
            asked.answer.set_exception(error)
        elif done is not None:
            asked.answer.set_result(done.result())


def _prepare() -> None:
    """Import what takes long, before it is needed."""
    import drakesep.page.flown  # noqa: F401


def _fly(case: AnalysisCase, values: Mapping[str, float], measure: bool) -> "Flown":
    from drakesep.page.flown import fly

    return fly(case, values, measure=measure)
