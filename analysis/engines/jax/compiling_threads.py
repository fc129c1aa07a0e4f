"""Threads that compile, for which a script that is interrupted does not wait.

A compiler cannot be interrupted, and Python waits for threads as it ends; one that it
did not wait for would crash within the compiler. So a process that ends by an
interrupt, while one compiles, is ended as Python would end it, but by the system.
"""

import atexit
import contextlib
import functools
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType
from typing import TypeAlias


_NAME = "drakesep"
"""Of threads that may be within a compiler."""
_PATIENCE = 0.7
"""For threads that are not: calls of programs take half of a second, s."""


_Hook: TypeAlias = Callable[
    [type[BaseException], BaseException, TracebackType | None], object
]


def compiling_threads(count: int) -> ThreadPoolExecutor:
    """Return threads that may be within a compiler as their process is interrupted.

    Args:
        count: of the threads, at most.
    """
    _hear_of_interrupts()
    return ThreadPoolExecutor(count, thread_name_prefix=_NAME)


@functools.cache
def _hear_of_interrupts() -> None:
    """Let the hook of errors that nobody catches hear of interrupts."""
    sys.excepthook = functools.partial(_say_and_end, sys.excepthook)


def _say_and_end(
    say: _Hook,
    kind: type[BaseException],
    error: BaseException,
    trace: TracebackType | None,
) -> None:
    say(kind, error, trace)
    if issubclass(kind, KeyboardInterrupt) and not _goes_on() and _compiles():
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(Exception):  # it may be closed, or gone
                stream.flush()
        # As Python ends of an interrupt: who waits for the process sees that.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGINT)


def _goes_on() -> bool:
    """Return whether there is a prompt that goes on after errors."""
    inspects = sys.flags.interactive or "PYTHONINSPECT" in os.environ
    return bool(inspects) or hasattr(sys, "ps1")


def _compiles() -> bool:
    """Return whether nothing but compiling keeps this process from its end."""
    main = threading.main_thread()
    last = [t for t in threading.enumerate() if t is not main and not t.daemon]
    ours = [t for t in last if t.name.startswith(_NAME)]
    end = time.monotonic() + _PATIENCE
    for thread in ours:
        thread.join(max(end - time.monotonic(), 0.0))
    return len(ours) == len(last) and any(t.is_alive() for t in ours)
