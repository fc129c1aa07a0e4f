"""Chunks of a campaign put together, in whatever order they come."""

import numpy as np

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.plan import CampaignPlan


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
        self._metrics = np.empty((plan.runs, len(plan.metrics)))
        self._failure = np.empty(plan.runs, np.int16)
        self._attempts = np.empty(plan.runs, np.int32)
        self._reasons: dict[int, str] = {}

    def add(self, number: int, flown: FlownDraws) -> None:
        """Add a chunk that is missing.

        Args:
            number: of the chunk.
            flown: what came of its draws.
        """
        self.missing.remove(number)
        mine = slice(flown.first, flown.first + len(flown))
        self._metrics[mine], self._failure[mine] = flown.metrics, flown.failure
        self._attempts[mine] = flown.attempts
        self._reasons |= flown.reasons

    def whole(self) -> FlownDraws:
        """Return what came of all draws, once no chunk is missing."""
        return FlownDraws(
            first=0,
            metrics=self._metrics,
            failure=self._failure,
            attempts=self._attempts,
            reasons=dict(sorted(self._reasons.items())),
        )
