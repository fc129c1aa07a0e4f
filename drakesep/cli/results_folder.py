"""Where a command writes its results, and how it ends at a signal."""

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drakesep.cli.report import CommandError
from drakesep.cli.signals import INTERRUPTED, WORDS


if TYPE_CHECKING:
    from rich.console import Console

    from drakesep.results.folder import ResultsFolder


def results_folder(output: Path | None, case: str, command: str) -> "ResultsFolder":
    """Return the folder of a command.

    Args:
        output: that is asked for; None: results/CASE/COMMAND.
        case: its name.
        command: its name.
    """
    from drakesep.results.folder import ResultsFolder

    directory = output or Path("results") / case / command
    return ResultsFolder(directory, command, command=sys.argv[1:])


@contextlib.contextmanager
def interruptible(folder: "ResultsFolder") -> Iterator[None]:
    """End in one line if a signal ends the command."""
    try:
        yield
    except (KeyboardInterrupt, SystemExit) as end:
        code = INTERRUPTED if isinstance(end, KeyboardInterrupt) else end.code
        if not isinstance(code, int) or code not in WORDS:
            raise
        done = f"; what was done is in {folder.directory}" if folder.begun else ""
        raise CommandError(code, f"{WORDS[code]}{done}") from None


def say_where(console: "Console", folder: "ResultsFolder") -> None:
    """Say where the results are."""
    console.print(f"Tables and plots are in {folder.directory}", markup=False)
