"""What is told of a study that goes on, as data that JSON knows."""

import math
from typing import Any, Protocol

from drakesep.cli.progress import AnyProgress, standing_of
from drakesep.studies.campaign.progress import CampaignProgress
from drakesep.studies.worst_case.plan import Progress
from drakesep.tables.columns import shown, unit_of_objective
from drakesep.tables.draws_so_far import DrawsSoFar
from drakesep.tables.iterates_table import iterates_table


class Tell(Protocol):
    """Takes an event."""

    def __call__(self, event: str, **what: Any) -> None:
        """Take it, with what it says."""


class Told:
    """Tells events of the progress of a study."""

    def __init__(self, tell: Tell):
        """Prepare.

        Args:
            tell: takes the events.
        """
        self._tell = tell
        self._draws = DrawsSoFar()

    def __call__(self, progress: AnyProgress) -> None:
        """Tell where a study stands, and the iterate that it has come to, if it has."""
        standing = standing_of(progress)
        best: dict[str, Any] = {}
        if isinstance(progress, CampaignProgress):
            self._chunk(progress)
        if isinstance(progress, Progress):
            self._iterate(progress)
            for k, value in progress.search.best.items():
                objective = progress.objectives[k]
                best[objective.name] = {
                    "value": _number(shown(objective, value)),
                    "unit": unit_of_objective(objective).symbol,
                }
        self._tell(
            "progress",
            step=standing.step,
            text=standing.planned or standing.described,
            share=standing.remaining.share,
            seconds=_number(standing.remaining.seconds),
            best=best,
        )

    def _iterate(self, progress: Progress) -> None:
        search = progress.search
        if search.iterate is None:
            return
        table = iterates_table(
            [(search.search, search.iterate)], progress.objectives, progress.box
        )
        [row] = table.to_dict("records")
        objective = progress.objectives[search.iterate.objective]
        self._tell("iterate", row=row, falls=shown(objective, 1.0) < 0.0)

    def _chunk(self, progress: CampaignProgress) -> None:
        if progress.chunk is None or progress.plan is None:
            return
        draws, requirements = self._draws.add(progress.plan, progress.chunk)
        self._tell(
            "draws",
            draws=draws,
            before=progress.flown_before,
            of=progress.plan.runs,
            requirements=requirements,
        )


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
