"""Work beside a study's own: measuring and drawing its runs.

Python runs one thread of a process at a time, and tracing and searches keep it busy:
what is drawn in a thread beside them takes twice its time, and theirs too. Where there
is more than one core, a process beside takes it over. It takes seconds to import what
it needs, so that it is started early.
"""

import contextlib
import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextvars import ContextVar
from typing import Any, TypeVar

from loky import ProcessPoolExecutor

from drakesep.analysis.engines.interrupts import interrupts_ignored
from drakesep.analysis.metrics.registry import (
    Metric,
    find_metric,
    register_metric,
    registered_metrics,
)


_R = TypeVar("_R")
_process: ContextVar[Executor | None] = ContextVar("process", default=None)


@contextlib.contextmanager
def beside(workers: int | None) -> Iterator[Executor | None]:
    """Start a process that takes over work, or return that which there is already.

    It ends with the caller's `with`, in the midst of its work if need be.

    Args:
        workers: number of processes; one per core if None. With 1, or in a process that
            may not start others, there is none: None.
    """
    one = (os.cpu_count() or 1) == 1 if workers is None else workers <= 1
    running = _process.get()
    if running or one or multiprocessing.current_process().daemon:
        yield None if one else running
        return
    process = ProcessPoolExecutor(
        max_workers=1, initializer=_prepare, initargs=(registered_metrics(),)
    )
    try:
        with interrupts_ignored():  # by the process, which inherits it
            process.submit(_nothing)  # so that it starts
        token = _process.set(process)
        try:
            yield process
        finally:
            _process.reset(token)
    finally:
        process.shutdown(wait=True, kill_workers=True)


def submitted(
    aside: Executor | None, function: Callable[..., _R], *arguments: Any
) -> Future[_R]:
    """Return what will come of a function, or has: without a process it is called here.

    Its errors, and that of a process that has died, come when its result is asked for.
    """
    called: Future[_R] = Future()
    try:
        if aside is not None:
            return aside.submit(function, *arguments)
        called.set_result(function(*arguments))
    except Exception as error:
        called.set_exception(error)
    return called


def _prepare(metrics: Sequence[Metric]) -> None:
    """Import what takes long, before it is needed; know the caller's metrics."""
    for metric in metrics:
        if find_metric(metric.stem) is None:
            register_metric(metric)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # The caller warns of its case itself.
    warnings.filterwarnings("ignore", message=".*check scale")
    from drakesep.plots import clearance_plots, motion, tornado  # noqa: F401
    from drakesep.tables import run_tables as tables  # noqa: F401


def _nothing() -> None:
    pass
