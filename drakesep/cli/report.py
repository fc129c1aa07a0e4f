"""What a command says: tables for a person, one JSON object, or nothing but errors.

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

from drakesep.systems.checks import InputError


if TYPE_CHECKING:
    from rich.console import Console


FAILED, BAD_INPUT, INTERRUPTED, TERMINATED = 1, 2, 130, 143
"""Exit codes; 0: done, and all is well."""
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


class Report:
    """What one command says; a context manager, whose errors end the command.

    Attributes:
        console: for a person; silent with `--quiet` or `--json`.
        answer: for what was asked itself, such as a list; silent with `--json` alone.
        aside: for progress, that never mixes with a JSON object; silent with `--quiet`.
    """

    console: "Console"
    answer: "Console"
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
        self.answer = _console(quiet=self._as_json)
        self.aside = _console(quiet=self._quiet, stderr=self._as_json)
        self._shown_before = warnings.showwarning
        warnings.showwarning = self._show_warning
        return self

    def add(self, **summary: Any) -> None:
        """Add to the summary, which `--json` prints; a key that is there is replaced.

        Args:
            summary: what `drakesep.cli.summaries` declares.
        """
        self._summary |= summary

    def not_well(self) -> None:
        """Say by the exit code that all is not well, though all is done."""
        self._code = FAILED

    def fail(self, message: str) -> NoReturn:
        """End the command: something has failed."""
        raise CommandError(FAILED, message)

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
            message = message or _ENDED.get(code, "")
            print_json(self._command, code, message, self._warnings, self._summary)
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


_ENDED = {INTERRUPTED: "interrupted", TERMINATED: "terminated"}
"""What a JSON object says of an end that a person knows of."""


def _ending(error: BaseException) -> tuple[int, str] | None:
    """Return the exit code of an error and what is said of it; None if it is ours."""
    match error:
        case CommandError():
            return error.code, str(error)
        case InputError():
            return BAD_INPUT, str(error)
        case BrokenPipeError():  # who reads has left: typer knows what to do
            return None
        case OSError():
            disk = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
            code = FAILED if disk else BAD_INPUT
            return code, f"{error.filename}: {error.strerror}"
        case RuntimeError():
            return FAILED, str(error)
        case KeyboardInterrupt():
            return INTERRUPTED, ""
        case SystemExit() if error.code == TERMINATED:
            return TERMINATED, ""
    return None


def say_error(message: str) -> None:
    """Print a message on standard error, line by line."""
    for line in message.splitlines():
        print(f"drakesep: {line}", file=sys.stderr)


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
    print(json.dumps(_plain(data), indent=1, ensure_ascii=False, allow_nan=False))


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
        console = Console(quiet=quiet, stderr=stderr, width=200)  # a file has no edge
    return console
