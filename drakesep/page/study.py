"""A study that a page has asked for: how it stands, and what it has told so far.

It is a command in a process of its own. What is kept here is what is shown while it
goes on; what came of it stands in its folder.
"""

import contextlib
import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drakesep.page.study_process import StudyProcess


if TYPE_CHECKING:
    from drakesep.case_file.case import Case


class State(enum.Enum):
    """How a study stands; the value says it in a word."""

    RUNNING = "running"
    STOPPED = "stopped"
    DIED = "ended early"
    ENDED = "ended"
    REFUSED = "refused"


class Spare:
    """A process that is warm, for the next study of any page of this server."""

    def __init__(self) -> None:
        self._process: StudyProcess | None = None

    def ready(self) -> StudyProcess:
        """Return it, started if need be, for the next study to be prepared in it."""
        if self._process is None or not self._process.is_alive:
            self._process = StudyProcess()
        return self._process

    def take(self) -> StudyProcess:
        """Return it for a study: it is nobody else's any more."""
        process, self._process = self.ready(), None
        return process


SPARE = Spare()
"""Of the thread that serves the page, as all that is of a page."""

IterateKey = tuple[str, str, int, int]
"""Objective, search, start and iteration."""


@dataclass
class Study:
    """A study under way, or past.

    Attributes:
        arguments: of the command line, without `--resume`.
        where: folder in which the command is run.
        folder: that it writes.
        case: that it is of, whatever becomes of it on the page.
        state: how it stands.
        message: why it was refused, failed or died; empty if it did not.
        step: at which it is, in words.
        share: that is done, from 0 to 1.
        seconds: until it ends, about; None if that is not known.
        best: the best value of each objective so far, with its unit, by search.
        iterates: rows of `iterates.csv` by what tells them apart, as they came.
        falling: objectives whose values are worse the less they are.
        draws: what the draws of a campaign show, each time that was told.
        summary: what `--json` says of a study that has ended.
        exit_code: of one that has ended.
        version: a number that grows with all that it tells.
    """

    arguments: tuple[str, ...]
    where: Path
    folder: Path
    case: "Case"
    state: State = State.RUNNING
    message: str = ""
    step: str = "preparing"
    share: float = 0.0
    seconds: float | None = None
    best: dict[str, dict[str, Any]] = field(default_factory=dict)
    iterates: dict[IterateKey, Mapping[str, Any]] = field(default_factory=dict)
    falling: set[str] = field(default_factory=set)
    draws: list[Mapping[str, Any]] = field(default_factory=list)
    summary: Mapping[str, Any] = field(default_factory=dict)
    exit_code: int | None = None
    version: int = 0
    _process: StudyProcess | None = None

    @classmethod
    def begin(
        cls, arguments: Sequence[str], where: Path, folder: Path, case: "Case"
    ) -> "Study":
        """Begin a study.

        Args:
            arguments: of the command line, with where it writes.
            where: folder in which the command is run.
            folder: that it writes.
            case: that it is of.
        """
        study = cls(tuple(arguments), where, folder, case)
        study._run(())
        return study

    def _run(self, more: Sequence[str]) -> None:
        said = ("--json", "--quiet")
        self.state, self.message, self.step = State.RUNNING, "", "preparing"
        self.version += 1
        self._process = SPARE.take()
        self._process.run(
            (*self.arguments, *more, *said), where=self.where, folder=self.folder
        )

    @property
    def is_running(self) -> bool:
        """Whether it goes on."""
        return self.state is State.RUNNING

    @property
    def can_go_on(self) -> bool:
        """Whether it was stopped, or its process died."""
        return self.state in (State.STOPPED, State.DIED)

    @property
    def process(self) -> int | None:
        """Number of its process; None if that has ended."""
        return None if self._process is None else self._process.id

    def rows_of(self, objective: str) -> list[Mapping[str, Any]]:
        """Return the iterates of an objective."""
        return [row for key, row in self.iterates.items() if key[0] == objective]

    def worst_of(self, objective: str) -> Mapping[str, Any]:
        """Return the iterate of an objective that is worst so far."""
        worst = min if objective in self.falling else max
        return worst(self.rows_of(objective), key=lambda row: row["value"])

    def stop(self) -> None:
        """Stop it; it can go on."""
        if self._process is not None:
            self._process.stop()

    def go_on(self) -> None:
        """Go on from what is finished: what it tells again is the same.

        But for draws, which it tells of those that are flown from here on.
        """
        self.draws.clear()
        self._run(("--resume",))

    def hear(self) -> None:
        """Take in what it has told."""
        if self._process is not None:
            for event in self._process.events():
                getattr(self, f"_{event['event']}")(event)
                self.version += 1

    def _ready(self, event: Mapping[str, Any]) -> None:
        pass

    _warm = _ready

    def _progress(self, event: Mapping[str, Any]) -> None:
        self.step, self.share = event["text"], event["share"]
        self.seconds = event["seconds"]
        for objective, told in event["best"].items():
            self.best.setdefault(objective, {})[event["step"]] = told

    def _iterate(self, event: Mapping[str, Any]) -> None:
        row = event["row"]
        key = row["objective"], row["search"], row["start"], row["iteration"]
        self.iterates[key] = row
        if event["falls"]:
            self.falling.add(row["objective"])

    def _draws(self, event: Mapping[str, Any]) -> None:
        self.draws.append(event)

    def _ended(self, event: Mapping[str, Any]) -> None:
        self.summary, self.exit_code = event["summary"], event["exit_code"]
        self.message = self.summary.get("error") or ""
        refused = self.exit_code in (2, 3)
        if refused:  # its folder was made for it, and has nothing then
            with contextlib.suppress(OSError):
                self.folder.rmdir()
        self._over(State.REFUSED if refused else State.ENDED)

    def _stopped(self, event: Mapping[str, Any]) -> None:
        self._over(State.STOPPED)

    def _died(self, event: Mapping[str, Any]) -> None:
        self.message = f"{event['reason']}. Nothing that was finished is lost."
        self._over(State.DIED)

    def _over(self, state: State) -> None:
        self.state, self._process = state, None
        SPARE.ready()  # warm until it is wanted
