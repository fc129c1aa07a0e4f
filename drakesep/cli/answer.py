"""What a command answers: tables for a person, one JSON object, or nothing but errors.

Standard output has what was asked; errors, warnings and progress go to standard error.
Imports that take time wait until something is said.
"""

import errno
import json
import math
import os
import sys
import warnings
from collections.abc import Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any, NoReturn, Self, TextIO

from drakesep.cli.signals import (
    INTERRUPTED,
    WORDS,
    command_begins,
    command_has_said,
    heard,
)
from drakesep.systems.checks import InputError


if TYPE_CHECKING:
    from rich.console import Console


NOT_MET, BAD_INPUT, MACHINE, FAILED = 1, 2, 3, 4
"""Exit codes; 0: done, and all is well. 1: done, and something is not; 2: the input is
wrong; 3: the machine failed; 4: a run did. Of signals see `drakesep.cli.signals`."""
FORMAT = 1
"""Of the JSON object: another number means other keys."""


class CommandError(Exception):
    """A command ends here: its message is the last that is said."""

    def __init__(self, code: int, message: str):
        """Prepare.

        Args:
            code: with which it exits.
            message: in lines; of an empty one nothing is printed.
        """
        super().__init__(message)
        self.code = code


class Answer:
    """What one command answers; a context manager, whose errors end the command.

    Attributes:
        console: for a person; silent with `--quiet` or `--json`.
        itself: for what was asked itself, such as a list; silent with `--json` alone.
        aside: for progress, that never mixes with a JSON object; silent with `--quiet`.
    """

    console: "Console"
    itself: "Console"
    aside: "Console"

    def __init__(self, command: str, *, quiet: bool, as_json: bool):
        """Prepare.

        Args:
            command: its name.
            quiet: whether to say nothing but errors and what was asked.
            as_json: whether to say a JSON object.
        """
        self._command, self._quiet, self._as_json = command, quiet, as_json
        self._summary: dict[str, Any] = {}
        self._warnings: list[str] = []
        self._code = 0

    def __enter__(self) -> Self:
        """Begin: from here on, warnings are lines on standard error."""
        self.console = _console(quiet=self._quiet or self._as_json)
        self.itself = _console(quiet=self._as_json)
        self.aside = _console(quiet=self._quiet, stderr=self._as_json)
        self._shown_before = warnings.showwarning
        warnings.showwarning = self._show_warning
        command_begins(self._command, as_json=self._as_json)
        return self

    def add(self, **summary: Any) -> None:
        """Add to the summary, which `--json` prints; a key that is there is replaced.

        Args:
            summary: what `drakesep.cli.summaries` declares.
        """
        self._summary |= summary

    def not_well(self) -> None:
        """Say by the exit code that all is not well, though all is done."""
        self._code = NOT_MET

    def fail(self, message: str) -> NoReturn:
        """End the command: a run has failed."""
        raise CommandError(FAILED, message)

    def not_met(self, message: str) -> NoReturn:
        """End the command: all is done, and something is not well."""
        raise CommandError(NOT_MET, message)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Say what has gone wrong, and the summary; exit unless all is well."""
        warnings.showwarning = self._shown_before
        if error is None:
            code, message = self._code, ""
        else:
            found = _ending(error)
            if found is None:  # an error of ours: its traceback is wanted
                return
            code, message = found
        say_error(message)
        if self._as_json:
            try:
                print_json(self._command, code, message, self._warnings, self._summary)
            except OSError as unwritten:
                code, message = MACHINE, words_of(unwritten)
                say_error(message)
        command_has_said()
        if code:
            sys.exit(code)

    def _show_warning(
        self,
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        self._warnings.append(str(message))
        if not self._quiet:
            print(f"drakesep: warning: {message}", file=sys.stderr)


_OF_MACHINE = frozenset(
    {
        *(errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.ENOMEM),
        *(errno.EACCES, errno.EPERM, errno.EROFS, errno.EMFILE, errno.ENFILE),
    }
)
"""Errors of the system that no other input mends: disk, memory, permission."""


def _ending(error: BaseException) -> tuple[int, str] | None:
    """Return the exit code of an error and what is said of it; None if it is ours."""
    signal = heard()
    match error:
        case CommandError() if signal in (None, error.code):
            return error.code, str(error)
        case _ if signal is not None:
            return signal, WORDS[signal]
        case InputError():
            return _blamed(error.__cause__), str(error)
        case OSError():
            return _blamed(error), words_of(error)
        case MemoryError():
            return MACHINE, "the memory is full"
        case RecursionError():
            return None
        case RuntimeError() if _is_killed(error):
            return MACHINE, "a process of ours was killed, for want of memory perhaps"
        case RuntimeError():
            return (MACHINE if _is_full(error) else FAILED), str(error)
        case KeyboardInterrupt():
            return INTERRUPTED, WORDS[INTERRUPTED]
        case SystemExit(code=int() as code) if code in WORDS:
            return code, WORDS[code]
    return None


def words_of(error: OSError) -> str:
    """Return what is said of an error of the system, with its file if it has one.

    Args:
        error: that no other input mends, or that names the file that is wrong.
    """
    return ": ".join(map(str, filter(None, (error.filename, error.strerror))))


def _blamed(error: BaseException | None) -> int:
    """Return the exit code of an error of the system, or of another."""
    machine = isinstance(error, OSError) and error.errno in _OF_MACHINE
    return MACHINE if machine else BAD_INPUT


def _is_killed(error: RuntimeError) -> bool:
    """Return whether a process of ours has died."""
    from concurrent.futures import BrokenExecutor

    return isinstance(error, BrokenExecutor)


def _is_full(error: RuntimeError) -> bool:
    """Return whether JAX has found no room."""
    return type(error).__module__.startswith("jax") and "RESOURCE_EXH" in str(error)


def say_error(message: str) -> None:
    """Print a message on standard error, line by line."""
    for line in message.splitlines():
        print(f"drakesep: {line}", file=sys.stderr, flush=True)


def print_json(
    command: str | None,
    code: int,
    error: str,
    told: list[str],
    summary: Mapping[str, Any],
) -> None:
    """Print the JSON object of a command.

    Args:
        command: its name; None if it could not be told.
        code: with which it exits.
        error: what went wrong; empty if nothing did.
        told: warnings.
        summary: what else there is to be said.
    """
    data = {
        "format": FORMAT,
        "command": command,
        "exit_code": code,
        "error": error or None,
        "warnings": told,
        **summary,
    }
    text = json.dumps(_plain(data), indent=1, ensure_ascii=False, allow_nan=False)
    print(text, flush=True)


def _plain(value: Any) -> Any:
    """Return what JSON has for a value: a number that it does not know is null."""
    match value:
        case Mapping():
            return {str(key): _plain(entry) for key, entry in value.items()}
        case list() | tuple():
            return [_plain(entry) for entry in value]
        case float():
            return float(value) if math.isfinite(value) else None
        case None | bool() | int() | str():
            return value
    return _plain(value.item()) if hasattr(value, "item") else str(value)


def _console(*, quiet: bool, stderr: bool = False) -> "Console":
    from rich.console import Console

    console = Console(quiet=quiet, stderr=stderr)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console = Console(quiet=quiet, stderr=stderr, width=200)  # a file: no edge
    return console
