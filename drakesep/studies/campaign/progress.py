"""How far a campaign has come, and what it will do."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from drakesep.analysis.campaigns.gathering import KeptDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.studies.worst_case.effort import in_time
from drakesep.studies.worst_case.pace import Pace, Remaining


FLY, MEASURE, CONFIRM = "fly", "clearance", "confirmation"
"""Its steps."""


@dataclass(frozen=True, kw_only=True)
class CampaignProgress:
    """Where a campaign stands."""

    step: str
    """`FLY`, `MEASURE` or `CONFIRM`; empty as it begins, with what it will do."""
    done: int
    """Draws of the step."""
    total: int
    """Draws of the step."""
    flown_before: int
    """Draws that an earlier campaign has flown, from which this one goes on."""
    remaining: Remaining
    """What is left of it."""
    measures: bool = False
    """Whether clearances are measured in some draws."""
    chunk: KeptDraws | None = None
    """Draws of the plan that have just been flown, and are in the folder."""
    plan: CampaignPlan | None = None
    """With a chunk: of the campaign."""

    def __str__(self) -> str:
        """Return what it will do, in a line."""
        before = self.flown_before
        there = f", {before} of them flown before" if before else ""
        measured = " how near parts come is measured where it decides;"
        return (
            f"{self.total} draws{there}, flown on the batch engine;"
            f"{measured if self.measures else ''} then those that decide in Drake; "
            f"about {in_time(self.remaining.seconds)}"
        )


OnProgress: TypeAlias = Callable[[CampaignProgress], None]


class Telling:
    """Tells the user how far a campaign has come."""

    def __init__(self, on_progress: OnProgress | None, runs: int, flown_before: int):
        """Prepare.

        Args:
            on_progress: called as it goes on; None: nobody is told.
            runs: draws of the campaign.
            flown_before: that are there already.
        """
        self._on_progress, self._runs = on_progress, runs
        self._before, self._measures, self._done = flown_before, False, 0
        self._pace = Pace({})

    def plan(self, seconds: float, measuring: float, confirming: float) -> None:
        """Tell what will be done, and how long it takes.

        Args:
            seconds: of what is flown on the batch engine.
            measuring: seconds of how near parts come.
            confirming: seconds of what is flown in Drake.
        """
        steps = {FLY: seconds, MEASURE: measuring, CONFIRM: confirming}
        self._pace, self._measures = Pace(steps, time.monotonic), measuring > 0.0
        self._tell("", 0, self._runs)

    def flown(self, done: int) -> None:
        """Tell how many draws are flown, beside those that were before."""
        self._tell(FLY, done, self._runs - self._before)

    def chunk_flown(self, plan: CampaignPlan, chunk: KeptDraws) -> None:
        """Tell what is kept of a chunk that has been flown and written."""
        self._done += len(chunk)
        total = self._runs - self._before
        self._tell(FLY, self._done, total, chunk=chunk, plan=plan)

    def measured(self, done: int, total: int) -> None:
        """Tell in how many draws it is measured how near parts come."""
        self._tell(MEASURE, done, total)

    def confirmed(self, done: int, total: int) -> None:
        """Tell how many draws are flown in Drake."""
        self._tell(CONFIRM, done, total)

    def _tell(self, step: str, done: int, total: int, **of_chunk: Any) -> None:
        if self._on_progress is not None:
            self._on_progress(
                CampaignProgress(
                    step=step,
                    done=done,
                    total=total,
                    flown_before=self._before,
                    remaining=self._pace.at(step or FLY, done, total),
                    measures=self._measures,
                    **of_chunk,
                )
            )
