"""How many runs of a study are flown, and how many there will be."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from drakesep.studies.worst_case.effort import in_time
from drakesep.studies.worst_case.pace import Pace, Remaining


@dataclass(frozen=True, kw_only=True)
class RunsProgress:
    """Where a study stands that flies many runs on the batch engine."""

    what: str
    """That is found, in words."""
    done: int
    """Runs."""
    total: int
    """Runs, at most."""
    remaining: Remaining
    """What is left of it."""

    def __str__(self) -> str:
        """Return what it will do, in a line."""
        return (
            f"{self.what}: up to {self.total} runs on the batch engine, and a sample "
            f"in Drake; about {in_time(self.remaining.seconds)}"
        )


OnRuns: TypeAlias = Callable[[RunsProgress], None]


class TellingRuns:
    """Tells the user how many runs are flown."""

    def __init__(
        self, on_progress: OnRuns | None, what: str, total: int, seconds: float
    ):
        """Tell what will be done, and how long it takes.

        Args:
            on_progress: called as it goes on; None: nobody is told.
            what: is found.
            total: runs, at most.
            seconds: that they take.
        """
        self._on_progress, self._what, self._total = on_progress, what, total
        self._done = 0
        self._pace = Pace({what: seconds}, time.monotonic)
        self._tell(0)

    def flown(self, runs: int) -> None:
        """Tell that so many more are flown."""
        self._done += runs
        self._tell(self._done)

    def _tell(self, done: int) -> None:
        if self._on_progress is not None:
            self._on_progress(
                RunsProgress(
                    what=self._what,
                    done=done,
                    total=self._total,
                    remaining=self._pace.at(self._what, done, self._total),
                )
            )
