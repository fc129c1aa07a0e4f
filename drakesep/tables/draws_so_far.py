"""What the draws of a campaign show while it is still flown."""

from typing import Any

import numpy as np

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.gathering import KeptDraws
from drakesep.analysis.campaigns.order_statistics import share_shown
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import of_launches
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.arrays import Array
from drakesep.tables.requirement_tables import limit_columns
from drakesep.units import unit_of


_BINS = 60
"""Of a histogram."""


class DrawsSoFar:
    """Chunks of a campaign, added up in whichever order they come.

    Of a campaign that keeps no rows, nothing is told before its end.
    """

    def __init__(self) -> None:
        """Begin without any."""
        self._metrics: list[Array] = []
        self._draws = 0

    def add(
        self, plan: CampaignPlan, chunk: KeptDraws
    ) -> tuple[int, list[dict[str, Any]]]:
        """Add a chunk.

        Args:
            plan: of the campaign.
            chunk: what is kept of its draws.

        Returns:
            The number of draws, and for each requirement that their metrics judge: its
            limit, how many of them are beyond it, the share of launches that is shown
            so far, and a histogram in its unit.
        """
        self._draws += len(chunk)
        if not isinstance(chunk, FlownDraws):
            return self._draws, []
        self._metrics.append(chunk.metrics)
        columns = dict(zip(plan.metrics, np.concatenate(self._metrics).T, strict=True))
        return self._draws, [
            self._shown(one, plan, columns)
            for one in plan.case.requirements
            if one.judged_by in columns
        ]

    def _shown(
        self, one: Requirement, plan: CampaignPlan, columns: dict[str, Array]
    ) -> dict[str, Any]:
        required, unit = of_launches(one, plan.case.requirements), unit_of(one.metric)
        margins = required.margins(columns)
        # What does not tell, such as a run that failed, counts as beyond.
        failures = int((required.beyond(margins) | np.isnan(margins)).sum())
        values = columns[one.judged_by]
        told = unit.from_si(1.0) * values[np.isfinite(values)]
        counts, edges = np.histogram(told, bins=_BINS) if len(told) else ((), ())
        return {
            **limit_columns(one, unit),
            "share": required.share,
            "confidence": required.confidence,
            "failures": failures,
            "share_shown": share_shown(self._draws, failures, required.confidence),
            "counts": [*map(int, counts)],
            "edges": [*map(float, edges)],
        }
