"""Chunks of a campaign put together, in whatever order they come."""

from typing import TypeAlias

import numpy as np

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.plan import ROWS, CampaignPlan
from drakesep.analysis.campaigns.screens import DrawnClearances
from drakesep.analysis.campaigns.shares import (
    ShareFinding,
    findings_of,
    share_findings,
)
from drakesep.analysis.campaigns.tallies import TalliedDraws


KeptDraws: TypeAlias = FlownDraws | TalliedDraws
"""What is kept of draws: a row for each; or counts, histograms and the worst."""


def kept(plan: CampaignPlan, flown: FlownDraws) -> KeptDraws:
    """Return what a plan keeps of draws."""
    return flown if plan.keep == ROWS else TalliedDraws.of(plan, flown)


def findings_of_kept(plan: CampaignPlan, flown: KeptDraws) -> list[ShareFinding]:
    """Return how each requirement of a plan's case fares, by what is kept of all draws.

    Args:
        plan: of the campaign.
        flown: all its draws.
    """
    failed = [*flown.reasons]
    if isinstance(flown, FlownDraws):
        return share_findings(plan, flown.metrics, failed, flown.clearances)
    return findings_of(plan, flown.counted(plan), failed)


class Gathered:
    """The chunks of a campaign that are there, put together.

    Attributes:
        missing: numbers of those that are not, in their order.
    """

    def __init__(self, plan: CampaignPlan):
        """Begin without any chunk.

        Args:
            plan: of the campaign.
        """
        self.missing = [*range(plan.chunks)]
        self._tallies: list[TalliedDraws] = []
        runs = plan.runs if plan.keep == ROWS else 0
        self._metrics = np.empty((runs, len(plan.metrics)))
        self._failure = np.empty(runs, np.int16)
        self._attempts = np.empty(runs, np.int32)
        self._at_least = np.empty((runs, len(plan.clearances)))
        self._reasons: dict[int, str] = {}

    def add(self, number: int, chunk: KeptDraws) -> None:
        """Add a chunk that is missing.

        Args:
            number: of the chunk.
            chunk: what is kept of its draws.
        """
        self.missing.remove(number)
        if isinstance(chunk, TalliedDraws):
            self._tallies.append(chunk)
            return
        mine = slice(chunk.first, chunk.first + len(chunk))
        self._metrics[mine], self._failure[mine] = chunk.metrics, chunk.failure
        self._attempts[mine] = chunk.attempts
        if chunk.clearances is not None:
            self._at_least[mine] = chunk.clearances.at_least
        self._reasons |= chunk.reasons

    def whole(self) -> KeptDraws:
        """Return what is kept of all draws, once no chunk is missing."""
        if self._tallies:
            return TalliedDraws.merged(self._tallies)
        clearances = None
        if self._at_least.size:
            measured = np.zeros(self._at_least.shape, bool)
            clearances = DrawnClearances(at_least=self._at_least, measured=measured)
        return FlownDraws(
            first=0,
            metrics=self._metrics,
            failure=self._failure,
            attempts=self._attempts,
            reasons=dict(sorted(self._reasons.items())),
            clearances=clearances,
        )
