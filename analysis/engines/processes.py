"""Processes beside ours: an interrupt leaves them alone, our end does not."""

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import resource_tracker, util
from types import FrameType
from typing import Any

from loky import ProcessPoolExecutor
from loky.backend import resource_tracker as loky_tracker


_NOT_THEIRS = {signal.SIGINT, signal.SIGHUP}
"""What a terminal sends to all processes of a command: the command ends the others."""
_FILTERS = "PYTHONWARNINGS"
_SILENT = "ignore:resource_tracker:UserWarning"
"""What trackers say of semaphores that they clear away is no matter of the user's."""
_LOOK = 0.2
"""How often the parent is looked for, s."""


def start_processes(
    count: int, prepare: Callable[..., None], *arguments: Any
) -> ProcessPoolExecutor:
    """Start processes, which work for whoever has their pool.

    They end when this one does, however that ends.

    Args:
        count: of the processes.
        prepare: called in each before its work, while the caller goes on.
        arguments: of it.
    """
    with contextlib.ExitStack() as failed:
        with _trackers_silent(), _signals_held():
            _start_trackers()
            pool = ProcessPoolExecutor(
                max_workers=count,
                initializer=_begin,
                initargs=(os.getpid(), prepare, arguments),
            )
            failed.callback(end_processes, pool)
            for _ in range(count):
                pool.submit(_nothing)  # so that they start
        failed.pop_all()
    return pool


def end_processes(pool: ProcessPoolExecutor) -> None:
    """End processes, in the midst of their work if need be."""
    pool.shutdown(wait=True, kill_workers=True)


@contextlib.contextmanager
def _signals_held() -> Iterator[None]:
    """Let an interrupt wait; what is started meanwhile never hears of one.

    Processes inherit what is blocked. Here that holds nothing up: another thread takes
    the signal, and Python's handler runs in the main one.
    """
    came: list[FrameType | None] = []
    handler = signal.getsignal(signal.SIGINT)
    in_main = threading.current_thread() is threading.main_thread()
    if mine := in_main and callable(handler):  # else nothing of Python's is to wait
        signal.signal(signal.SIGINT, lambda _, frame: came.append(frame))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _NOT_THEIRS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if mine:
            signal.signal(signal.SIGINT, handler)
        if came:
            signal.raise_signal(signal.SIGINT)


@contextlib.contextmanager
def _trackers_silent() -> Iterator[None]:
    """Let what is started meanwhile not warn of what a killed command has left."""
    before = os.environ.get(_FILTERS)
    os.environ[_FILTERS] = ",".join(filter(None, (before, _SILENT)))
    try:
        yield
    finally:
        if before is None:
            del os.environ[_FILTERS]
        else:
            os.environ[_FILTERS] = before


def _start_trackers() -> None:
    """Start what clears semaphores away when this process and its workers have ended.

    Python and loky have one each, in this process's group, where a kill of the group
    ends them too. Ours are in sessions of their own; those that run already stay.
    """
    spawn = util.spawnv_passfds
    util.spawnv_passfds = _spawn_apart
    try:
        resource_tracker.ensure_running()
        loky_tracker.ensure_running()
    finally:
        util.spawnv_passfds = spawn
    # As it starts, Python's lets interrupts through again.
    signal.pthread_sigmask(signal.SIG_BLOCK, _NOT_THEIRS)


def _spawn_apart(path: bytes, args: Sequence[Any], passfds: Sequence[int]) -> int:
    """Do as `util.spawnv_passfds` does, in a session of its own."""
    process = subprocess.Popen(
        args,
        executable=path,
        pass_fds=passfds,
        restore_signals=False,
        start_new_session=True,
    )
    process.returncode = 0  # it is waited for by its number, by who has asked for it
    return process.pid


def _begin(
    parent: int, prepare: Callable[..., None], arguments: tuple[Any, ...]
) -> None:
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    prepare(*arguments)


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOK)
    os._exit(1)


def _nothing() -> None:
    pass
