"""How far a study has come, as the command line shows it."""

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

from rich import progress as rich_progress
from rich.console import Console

from drakesep.studies.campaign.progress import CONFIRM, MEASURE, CampaignProgress
from drakesep.studies.proof_check import CheckProgress
from drakesep.studies.proof_progress import ProofProgress
from drakesep.studies.runs_progress import RunsProgress
from drakesep.studies.sweep import SweepProgress
from drakesep.studies.worst_case.effort import in_time
from drakesep.studies.worst_case.pace import Remaining
from drakesep.studies.worst_case.plan import PLAN, Progress
from drakesep.tables.columns import shown, unit_of_objective


_PACE = 10.0
"""Seconds after which a log gets another line, if no tenth of the study was done."""


class Standing(NamedTuple):
    """Where a study stands, as it is shown."""

    step: str
    planned: str
    """What it will do, as it begins; else empty."""
    described: str
    remaining: Remaining


AnyProgress: TypeAlias = (
    Progress
    | SweepProgress
    | CampaignProgress
    | RunsProgress
    | ProofProgress
    | CheckProgress
)
Tell: TypeAlias = Callable[[AnyProgress], None]


_also: list[Tell] = []
"""Who else is told of progress."""


def tell_also(listener: Tell) -> None:
    """Let somebody else be told how far studies of this process have come.

    Args:
        listener: called with all that `progress_bar` is told, before that shows it.
    """
    _also.append(listener)


@contextlib.contextmanager
def progress_bar(console: Console) -> Iterator[Tell]:
    """Show a bar while a study goes on; give what is to be told of its progress.

    Where there is no terminal, lines on standard error say how far it has come. What
    the study will do is said in any case, before it does; nothing on a quiet console.
    """
    with _shown(console) as show:

        def tell(progress: AnyProgress) -> None:
            for listener in _also:
                listener(progress)
            show(progress)

        yield tell


@contextlib.contextmanager
def _shown(console: Console) -> Iterator[Tell]:
    if console.quiet:
        yield lambda _: None
    elif console.is_terminal:
        with _bar(console) as tell:
            yield tell
    else:
        with _lines(lambda line: print(line, file=sys.stderr, flush=True)) as tell:
            yield tell


@contextlib.contextmanager
def steps(console: Console) -> Iterator[Callable[[str], None]]:
    """Show the step at which a command is; give what is to be told of it.

    Where there is no terminal, a line on standard error says so once ten seconds have
    passed since the last; nothing on a quiet console.
    """
    if console.quiet:
        yield lambda step: None
    elif console.is_terminal:
        with console.status("") as status:
            yield status.update
    else:
        yield _Steps(lambda line: print(line, file=sys.stderr, flush=True))


class _Steps:
    """Lines that say at which step a command is, if that takes long."""

    def __init__(
        self,
        say: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ):
        self._say, self._clock, self._when = say, clock, clock()

    def __call__(self, step: str) -> None:
        """Say it, if the last line is some time ago."""
        now = self._clock()
        if now >= self._when + _PACE:
            self._say(step)
            self._when = now


@contextlib.contextmanager
def _bar(console: Console) -> Iterator[Tell]:
    bar = rich_progress.Progress(
        rich_progress.TextColumn("{task.description}"),
        rich_progress.BarColumn(),
        rich_progress.TaskProgressColumn(),
        rich_progress.TextColumn("{task.fields[left]}"),
        console=console,
        transient=True,
    )
    task = bar.add_task("preparing", total=None, left="")

    def tell(progress: AnyProgress) -> None:
        standing = standing_of(progress)
        if standing.planned:
            console.print(standing.planned, markup=False, highlight=False)
        bar.update(
            task,
            total=1.0,
            completed=standing.remaining.share,
            description=standing.described,
            left=f"{in_time(standing.remaining.seconds)} left",
        )

    with bar:
        yield tell


@contextlib.contextmanager
def _lines(say: Callable[[str], None], patience: float = _PACE) -> Iterator[Tell]:
    """Say in lines how far a study has come; and that it prepares, if that takes long.

    Args:
        say: takes a line.
        patience: without a line, s.
    """
    log = _Log(say)
    waiting = threading.Timer(patience, say, ["Preparing; what will be done follows"])
    waiting.daemon = True
    waiting.start()

    def tell(progress: AnyProgress) -> None:
        waiting.cancel()
        log(progress)

    try:
        yield tell
    finally:
        waiting.cancel()


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

    def __call__(self, progress: AnyProgress) -> None:
        """Say how far a study has come, if it has come far enough since last time."""
        standing = standing_of(progress)
        step, share = standing.step, standing.remaining.share
        now = self._clock()
        if standing.planned:
            self._say(standing.planned)
        elif (
            step != self._step
            or _tenths(share) > _tenths(self._share)
            or now >= self._when + _PACE
        ):
            left = in_time(standing.remaining.seconds)
            self._say(f"{share:4.0%}, {left} left: {standing.described}")
        else:
            return
        self._step, self._share, self._when = step, share, now


def _tenths(share: float) -> int:
    return int(10.0 * share + 1e-9)


def standing_of(progress: AnyProgress) -> Standing:
    """Return where a study stands, in words."""
    if isinstance(progress, SweepProgress):
        step, begins, plan = "sweep", progress.done == 0, str(progress)
        described = f"{progress.done} of {progress.total} variants"
    elif isinstance(progress, CampaignProgress):
        step, begins, plan = progress.step, not progress.step, str(progress)
        where = {CONFIRM: " in Drake", MEASURE: " measured"}.get(step, "")
        described = f"{progress.done} of {progress.total} draws{where}"
    elif isinstance(progress, RunsProgress):
        step, begins, plan = progress.what, progress.done == 0, str(progress)
        described = f"{progress.done} runs"
    elif isinstance(progress, ProofProgress):
        step, begins, plan = progress.claim, not progress.claim, str(progress)
        described = (
            f"bound {progress.done + 1} of {progress.total}, {progress.claim}: "
            f"{progress.boxes} boxes"
        )
    elif isinstance(progress, CheckProgress):
        step, begins, plan = progress.claim, progress.done == 0, str(progress)
        described = f"{progress.done} of {progress.total} claims checked"
    else:
        step, plan = progress.search.search, str(progress.effort)
        begins, described = step == PLAN, _described(progress)
    planned = plan[0].upper() + plan[1:] if begins else ""
    return Standing(step, planned, described, progress.remaining)


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
