"""Work beside a study's own: measuring and drawing its runs.

Python runs one thread of a process at a time, and tracing and searches keep it busy:
what is drawn in a thread beside them takes twice its time, and theirs too. Where there
is more than one core, a process beside takes it over. It takes a while to import what
it needs, so that it is started early, and kept for a minute for the next study.
"""

import contextlib
import os
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor

from loky import ProcessPoolExecutor

from drakesep.analysis.interrupts import interrupts_ignored


_KEPT = 60.0
"""Without work, s."""
_lock = threading.Lock()
_process: ProcessPoolExecutor | None = None


@contextlib.contextmanager
def beside(workers: int | None, *, keep: bool = True) -> Iterator[Executor]:
    """Return what takes over work: a process, or a thread if there is to be only one.

    If the caller fails or is interrupted, the process is stopped.

    Args:
        workers: number of processes; one per core if None.
        keep: whether the process is kept for a minute.
    """
    if (workers or os.cpu_count() or 1) == 1:
        with ThreadPoolExecutor(1) as thread:
            yield thread
        return
    process = _running()
    try:
        yield process
    except BaseException:
        _stop(process)
        raise
    if not keep:
        _stop(process)


def _running() -> ProcessPoolExecutor:
    global _process
    with _lock:
        if _process is None:
            with interrupts_ignored():  # by the process, which inherits it
                _process = ProcessPoolExecutor(
                    max_workers=1, timeout=_KEPT, initializer=_import
                )
                _process.submit(_nothing)  # so that it starts
        return _process


def _stop(process: ProcessPoolExecutor) -> None:
    global _process
    with _lock:
        if _process is process:
            _process = None
    process.shutdown(wait=True, kill_workers=True)


def _import() -> None:
    """Import what takes long, before it is needed."""
    from drakesep import clearance_figures, figures, pictures  # noqa: F401


def _nothing() -> None:
    pass
