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
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor

from loky import ProcessPoolExecutor

from drakesep.analysis.interrupts import interrupts_ignored


_KEPT = 60.0
"""Without work, s."""
_lock = threading.Lock()
_process: ProcessPoolExecutor | None = None
_users = 0


@contextlib.contextmanager
def beside(workers: int | None, *, keep: bool = True) -> Iterator[Executor]:
    """Return what takes over work: a process, or a thread if there is to be only one.

    If the caller fails or is interrupted, the process is stopped, unless others use it.

    Args:
        workers: number of processes; one per core if None.
        keep: whether the process is kept for a minute.
    """
    if (workers or os.cpu_count() or 1) == 1:
        with ThreadPoolExecutor(1) as thread:
            yield thread
        return
    process = _join()
    try:
        yield process
    except BaseException:
        keep = False
        raise
    finally:
        _leave(process, keep=keep)


def _join() -> ProcessPoolExecutor:
    """Return the process, started anew if there is none."""
    global _process, _users
    with _lock, interrupts_ignored():  # by the process, which inherits it
        _users += 1
        if _process is not None:
            with contextlib.suppress(BrokenExecutor):
                _process.submit(_nothing)
                return _process
        _process = ProcessPoolExecutor(
            max_workers=1, timeout=_KEPT, initializer=_import
        )
        _process.submit(_nothing)  # so that it starts
        return _process


def _leave(process: ProcessPoolExecutor, *, keep: bool) -> None:
    global _process, _users
    with _lock:
        _users -= 1
        if keep or _users:
            return
        if _process is process:
            _process = None
    process.shutdown(wait=True, kill_workers=True)


def _import() -> None:
    """Import what takes long, before it is needed."""
    from drakesep import clearance_figures, figures, pictures  # noqa: F401


def _nothing() -> None:
    pass
