"""How far a study has come, as the command line shows it."""

import contextlib
import sys
from collections.abc import Callable, Iterator

from rich import progress as rich_progress
from rich.console import Console

from drakesep.studies.worst_case.plan import Progress
from drakesep.tables.columns import shown, unit_of_objective


@contextlib.contextmanager
def progress_bar(console: Console) -> Iterator[Callable[[Progress], None]]:
    """Show a bar while a study goes on; give what is to be told of its progress.

    Where there is no terminal, a line says which search begins.
    """
    bar = rich_progress.Progress(
        rich_progress.TextColumn("{task.description}"),
        rich_progress.BarColumn(),
        rich_progress.TimeElapsedColumn(),
        console=console,
        transient=True,
    )
    task = bar.add_task("compiling", total=None)
    said = ""

    def show(progress: Progress) -> None:
        nonlocal said
        search = progress.search
        bar.update(
            task,
            total=search.total,
            completed=search.done,
            description=_described(progress),
        )
        if not console.is_terminal and said != search.search:
            said = search.search
            print(f"{search.search} begins", file=sys.stderr)

    with bar:
        yield show


def _described(progress: Progress) -> str:
    """Return what is searched, how far, and the first objective's best so far."""
    search = progress.search
    total = "" if search.total is None else f" of {search.total}"
    text = f"{search.search}: {search.done}{total}"
    if not search.best:
        return text
    k = min(search.best)
    objective, value = progress.objectives[k], search.best[k]
    symbol = unit_of_objective(objective).symbol
    return f"{text}, {objective.name} {shown(objective, value):.5g} {symbol}"
