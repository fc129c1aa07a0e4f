"""A process beside the caller's, that measures and draws a study's runs.

Python runs one thread of a process at a time, and tracing and searches keep it busy:
what is drawn in a thread beside them takes twice its time, and theirs too. Where there
is more than one core, another process takes it over.

Who has something to be done makes a `BackgroundProcess` and hands it down. The process
takes seconds to import what it draws with: the sooner it is begun, the less is waited.
"""

import multiprocessing
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from types import TracebackType
from typing import Any, Self, TypeVar

from loky import ProcessPoolExecutor

from drakesep.analysis.engines.processes import end_processes, start_processes
from drakesep.analysis.metrics.metric import Metric
from drakesep.analysis.metrics.registry import (
    find_metric,
    register_metric,
    registered_metrics,
)
from drakesep.systems.equations.springs import PUSHERS, PusherKind


_R = TypeVar("_R")


class BackgroundProcess:
    """A process that takes over work, or the caller's own; a context manager.

    It begins as the caller enters, and begins by importing what it draws with. It ends
    as the caller leaves, in the midst of its work if need be.
    """

    def __init__(self, workers: int | None = None):
        """Prepare.

        Args:
            workers: number of processes; one per core if None. With 1, or in a process
                that may not start others, none is started, and the caller's does all.
        """
        several = (os.cpu_count() or 1) > 1 if workers is None else workers > 1
        self._wanted = several and not multiprocessing.current_process().daemon
        self._process: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        """Start it."""
        if self._wanted:
            self._process = start_processes(
                1, _prepare, registered_metrics(), dict(PUSHERS)
            )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it."""
        self.end()

    def end(self) -> None:
        """End it, in the midst of its work if need be."""
        process, self._process = self._process, None
        if process is not None:
            end_processes(process)

    @property
    def is_another(self) -> bool:
        """Whether there is a process beside the caller's."""
        return self._process is not None

    def submit(self, function: Callable[..., _R], *arguments: Any) -> Future[_R]:
        """Return what will come of a function; without a process it is called here.

        Its errors, and that of a process that has died, come when its result is asked
        for.

        Args:
            function: to be called there.
            arguments: of it.
        """
        called: Future[_R] = Future()
        try:
            if self._process is not None:
                begun: Future[_R] = self._process.submit(function, *arguments)
                return begun
            called.set_result(function(*arguments))
        except Exception as error:
            called.set_exception(error)
        return called


def _prepare(metrics: Sequence[Metric], pushers: Mapping[str, PusherKind]) -> None:
    """Import what takes long, before it is needed; know what the caller registered."""
    PUSHERS.update(pushers)
    for metric in metrics:
        if find_metric(metric.stem) is None:
            register_metric(metric)
    from drakesep.plots import clearance_plots, motion, tornado  # noqa: F401
    from drakesep.systems.geometry.meshes import DoubtfulScale
    from drakesep.tables import run_tables  # noqa: F401

    # The caller prepares the same geometry, and warns of it.
    warnings.simplefilter("ignore", DoubtfulScale)
