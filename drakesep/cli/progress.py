"""How far a study has come, as the command line shows it."""

import contextlib
import sys
import time
from collections.abc import Callable, Iterator

from rich import progress as rich_progress
from rich.console import Console

from drakesep.studies.worst_case.effort import in_time
from drakesep.studies.worst_case.plan import PLAN, OnProgress, Progress
from drakesep.tables.columns import shown, unit_of_objective


_PACE = 10.0
"""Seconds after which a log gets another line, if no tenth of the study was done."""


@contextlib.contextmanager
def progress_bar(console: Console) -> Iterator[OnProgress]:
    """Show a bar while a study goes on; give what is to be told of its progress.

    Where there is no terminal, lines on standard error say how far it has come. What
    the study will do is said in any case, before it does; nothing on a quiet console.
    """
    if console.quiet:
        yield lambda _: None
    elif console.is_terminal:
        with _bar(console) as tell:
            yield tell
    else:
        yield _Log(lambda line: print(line, file=sys.stderr, flush=True))


@contextlib.contextmanager
def _bar(console: Console) -> Iterator[OnProgress]:
    bar = rich_progress.Progress(
        rich_progress.TextColumn("{task.description}"),
        rich_progress.BarColumn(),
        rich_progress.TaskProgressColumn(),
        rich_progress.TextColumn("{task.fields[left]}"),
        console=console,
        transient=True,
    )
    task = bar.add_task("compiling", total=None, left="")

    def tell(progress: Progress) -> None:
        if progress.search.search == PLAN:
            console.print(_planned(progress), markup=False, highlight=False)
        bar.update(
            task,
            total=1.0,
            completed=progress.remaining.share,
            description=_described(progress),
            left=f"{in_time(progress.remaining.seconds)} left",
        )

    with bar:
        yield tell


class _Log:
    """Lines at a pace that a log can bear."""

    def __init__(
        self,
        say: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ):
        """Prepare.

        Args:
            say: takes a line.
            clock: tells the time, s.
        """
        self._say, self._clock = say, clock
        self._step = ""
        self._share, self._when = 0.0, clock()

    def __call__(self, progress: Progress) -> None:
        """Say how far a study has come, if it has come far enough since last time."""
        step, share = progress.search.search, progress.remaining.share
        now = self._clock()
        if step == PLAN:
            self._say(_planned(progress))
        elif (
            step != self._step
            or _tenths(share) > _tenths(self._share)
            or now >= self._when + _PACE
        ):
            left = in_time(progress.remaining.seconds)
            self._say(f"{share:4.0%}, {left} left: {_described(progress)}")
        else:
            return
        self._step, self._share, self._when = step, share, now


def _tenths(share: float) -> int:
    return int(10.0 * share + 1e-9)


def _planned(progress: Progress) -> str:
    text = str(progress.effort)
    return text[0].upper() + text[1:]


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
