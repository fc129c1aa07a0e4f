"""Interrupts and other signals: a command ends within two seconds, whatever it is at.

Before a command has begun there is nothing to put in order: it ends at once. From then
on a signal raises what leaves the folder in order and says so. Where that is lost (in a
destructor, or a callback of a library's) it is raised again; where it takes too long (a
minute within a compiler, a library that catches everything) a thread leaves the folder
in order, and ends the process. In the midst of an import nothing is raised, since
libraries in C++ abort: the folder is left in order there. Nothing is imported here but
what Python has at once.
"""

import contextlib
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import NoReturn


INTERRUPTED, TERMINATED, HUNG_UP = 130, 143, 129
"""Exit codes."""
WORDS = {INTERRUPTED: "interrupted", TERMINATED: "terminated", HUNG_UP: "hung up"}
"""What is said of them."""
_CODES = {
    signal.SIGINT: INTERRUPTED,
    signal.SIGTERM: TERMINATED,
    signal.SIGHUP: HUNG_UP,
}
_PATIENCE = 0.6
"""That a command has to end in order, s."""
_LOOK = 0.05
"""How often it is looked whether what was raised is lost, s."""


class _State:
    """How far the command is."""

    listens = False
    command: str | None = None
    as_json = "--json" in sys.argv
    begun = False
    said = False
    heard: int | None = None
    lost = False
    put_in_order: Callable[[], str] | None = None
    done = ""


def command_begins(name: str, *, as_json: bool) -> None:
    """Let signals raise from now on: the command ends in order, and says so itself."""
    _State.command, _State.as_json, _State.begun = name, as_json, True


def ends_in_order_by(put_in_order: Callable[[], str]) -> None:
    """Let a command that does not end by itself leave its results in order.

    Args:
        put_in_order: called in any thread, whatever the command is at; returns what
            more is to be said.
    """
    _State.put_in_order = put_in_order


def end_now(code: int) -> NoReturn:
    """Leave results in order and end the process at once, from any thread.

    Args:
        code: of the signal that this is instead of.
    """
    _State.heard = code
    _leave(code)


def command_has_said() -> None:
    """Let nothing more be said: the command has done so, and exits as it said."""
    _State.said = True
    if _State.listens:
        # As Python ends, it would let signals end the process in their own way.
        for number in _CODES:
            signal.signal(number, signal.SIG_IGN)


def heard() -> int | None:
    """Return the exit code of the signal that has come; None if none has.

    What it raises in the midst of a library may come out of that as another exception.
    """
    return _State.heard


def listen() -> None:
    """Handle signals as this module says; in the main thread of a program of ours."""
    _State.listens, _State.as_json = True, "--json" in sys.argv
    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(read,), daemon=True).start()
    sys.unraisablehook = _unraisable
    for number in _CODES:
        # What is ignored stays so: `nohup` ignores hang-ups, a shell's `&` interrupts.
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _handle)


def _handle(number: int, frame: FrameType | None) -> None:
    code = _CODES[signal.Signals(number)]
    _State.heard = code
    if not _State.begun or _imports(frame):
        _leave(code)
    if code == INTERRUPTED:
        raise KeyboardInterrupt
    raise SystemExit(code)


def _imports(frame: FrameType | None) -> bool:
    """Return whether an import is under way."""
    while frame is not None:
        if frame.f_globals.get("__name__") == "importlib._bootstrap":
            return True
        frame = frame.f_back
    return False


def _unraisable(lost: "sys.UnraisableHookArgs") -> None:
    """Hear of what could not be raised where it was."""
    if _State.heard is not None and lost.exc_type in (KeyboardInterrupt, SystemExit):
        _State.lost = True
    else:
        sys.__unraisablehook__(lost)


def _watch(read: int) -> None:
    """End the process a while after a signal, unless that has ended it before."""
    while True:
        for number in os.read(read, 1):
            if number in _CODES:
                _wait(number)
                _leave(_CODES[signal.Signals(number)])


def _wait(number: int) -> None:
    """Wait as long as a command has to end in order."""
    end = time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        time.sleep(_LOOK)
        if _State.lost:
            _State.lost = False
            signal.pthread_kill(threading.main_thread().ident or 0, number)


def _leave(code: int) -> NoReturn:
    """Put in order and say what there is to be, and end the process at once."""
    if _State.put_in_order is not None:
        with contextlib.suppress(Exception):  # it ends in any case
            _State.done = _State.put_in_order()
    if not _State.said:
        word = f"{WORDS[code]}{_State.done}"
        _write(2, f"drakesep: {word}\n")
        if _State.as_json:
            told = {"format": 1, "command": _State.command, "exit_code": code}
            _write(1, json.dumps({**told, "error": word, "warnings": []}) + "\n")
    os._exit(code)


def _write(where: int, text: str) -> None:
    try:
        os.write(where, text.encode())
    except OSError:  # nobody reads it any more
        pass
