"""Standard streams that are closed, full, gone, or cannot show a character.

Who reads may have seen enough: that is no error, and the rest goes nowhere. Where
standard output cannot be written for another reason, as on a full disk, the error names
it. What is said aside may be lost: a study goes on when its terminal is gone. Nothing
is imported here but what Python has at once.
"""

import errno
import io
import os
import sys
from collections.abc import Callable
from typing import Any


STANDARD_OUTPUT = "standard output"
"""What an error of the system names as its file."""


def prepare() -> None:
    """Make the streams of a program of ours so."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            # Closed: the next file that is opened would be it.
            _lead_nowhere(number)
            setattr(sys, name, open(number, "w" if number else "r"))
    sys.stdout = _Stream(sys.stdout, _output_failed)
    sys.stderr = _Stream(sys.stderr, lambda _: None)


class _Stream(io.TextIOWrapper):
    """A standard stream; a character that it cannot show is another."""

    def __init__(self, stream: Any, failed: Callable[[OSError], None]):
        super().__init__(
            stream.buffer,
            encoding=stream.encoding,
            errors="replace",
            line_buffering=stream.line_buffering,
            write_through=stream.write_through,
        )
        self._stream = stream  # which would close what both write on, as it goes
        self._failed = failed

    def write(self, text: str) -> int:
        try:
            return super().write(text)
        except OSError as error:
            self._lead_nowhere(error)
            return len(text)

    def flush(self) -> None:
        try:
            super().flush()
        except OSError as error:
            self._lead_nowhere(error)

    def _lead_nowhere(self, error: OSError) -> None:
        _lead_nowhere(self.fileno())  # what waits to be written, too
        self._failed(error)


def _output_failed(error: OSError) -> None:
    if error.errno != errno.EPIPE:
        raise OSError(error.errno, error.strerror, STANDARD_OUTPUT) from None


def _lead_nowhere(number: int) -> None:
    nowhere = os.open(os.devnull, os.O_RDWR)
    if nowhere != number:
        os.dup2(nowhere, number)
        os.close(nowhere)
