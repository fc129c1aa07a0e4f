"""Interrupts and other signals: a command ends within two seconds, whatever it is at.

Before a command has begun, as it imports what it needs, there is nothing to put in
order: it ends at once. From then on a signal raises what leaves the folder in order and
says so. Where that is lost (a destructor, a library that catches everything, a minute
within a compiler) or takes too long, a thread ends the process. Nothing is imported
here but what Python has at once.
"""

import json
import os
import signal
import sys
import threading
import time
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
_PATIENCE = 1.7
"""That a command has to end in order, s."""


class _State:
    """How far the command is."""

    command: str | None = None
    as_json = "--json" in sys.argv
    begun = False
    said = False
    heard: int | None = None


def command_begins(name: str, *, as_json: bool) -> None:
    """Let signals raise from now on: the command ends in order, and says so itself."""
    _State.command, _State.as_json, _State.begun = name, as_json, True


def command_has_said() -> None:
    """Let nothing more be said: the command has done so."""
    _State.said = True


def heard() -> int | None:
    """Return the exit code of the signal that has come; None if none has.

    An exception that is raised in the midst of a library's import may come out of it as
    another.
    """
    return _State.heard


def listen() -> None:
    """Handle signals as this module says; in the main thread of a program of ours."""
    _State.as_json = "--json" in sys.argv
    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(read,), daemon=True).start()
    for number in _CODES:
        # What is ignored stays so: `nohup` ignores hang-ups, a shell's `&` interrupts.
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _handle)


def _handle(number: int, _: FrameType | None) -> None:
    code = _CODES[signal.Signals(number)]
    _State.heard = code
    if not _State.begun or _State.said:
        _end(code)
    if code == INTERRUPTED:
        raise KeyboardInterrupt
    raise SystemExit(code)


def _watch(read: int) -> None:
    """End the process a while after a signal, unless that has ended it before."""
    while True:
        for number in os.read(read, 1):
            if number in _CODES:
                time.sleep(_PATIENCE)
                _end(_CODES[signal.Signals(number)])


def _end(code: int) -> NoReturn:
    """Say what there is to say, and end the process at once."""
    if not _State.said:
        word = WORDS[code]
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
