"""How the command of a study begins and ends, and where it writes its results."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drakesep.cli.answer import Answer, CommandError
from drakesep.cli.caches import fonts_kept
from drakesep.cli.signals import INTERRUPTED, WORDS, ends_in_order_by


if TYPE_CHECKING:
    from rich.console import Console

    from drakesep.case_file.case import Case
    from drakesep.results.folder import ResultsFolder


@contextlib.contextmanager
def results_folder(
    output: Path | None, case: str, command: str
) -> "Iterator[ResultsFolder]":
    """Give the folder of a command; if a signal ends the command, it does in one line.

    Args:
        output: that is asked for; None: results/CASE/COMMAND.
        case: its name.
        command: its name.
    """
    from drakesep.results.folder import ResultsFolder

    directory = output or Path("results") / case / command
    # Done again from its beginning, it is the same.
    words = [word for word in sys.argv[1:] if word != "--resume"]
    folder = ResultsFolder(directory, command, command=words)

    def done() -> str:
        return f"; what was done is in {folder.directory}" if folder.begun else ""

    def put_in_order() -> str:
        folder.leave(wait=0.3)
        return done()

    ends_in_order_by(put_in_order)
    try:
        with fonts_kept(), folder:
            yield folder
    except (KeyboardInterrupt, SystemExit) as end:
        code = INTERRUPTED if isinstance(end, KeyboardInterrupt) else end.code
        if not isinstance(code, int) or code not in WORDS:
            raise
        raise CommandError(code, f"{WORDS[code]}{done()}") from None


def load(answer: Answer, case: str) -> "Case":
    """Return the case that a command is about."""
    from drakesep.case_file.reader import load_case

    loaded = load_case(case)
    answer.add(case=loaded.name)
    return loaded


def say(
    answer: Answer,
    folder: "ResultsFolder",
    summary: object,
    show: Callable[["Console"], None],
) -> None:
    """Say what a study has done, and where its results are.

    Args:
        answer: of the command.
        folder: with the results.
        summary: one of `drakesep.cli.summaries`.
        show: prints the tables.
    """
    answer.add(**vars(summary))
    show(answer.console)
    answer.console.print(f"Tables and plots are in {folder.directory}", markup=False)
