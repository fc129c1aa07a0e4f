"""Draws of which no rows are kept: counts, exact sums, histograms, and the worst.

So a campaign may have billions of draws. What is kept of its parts makes that of the
whole, to the bit, in whatever order they are put together; a draw comes again from its
number.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from drakesep.analysis.campaigns.answers import Tally, worst_to_keep
from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import Counted, counted
from drakesep.analysis.campaigns.statistics import Summary


_REASONS = 100
"""Runs that failed of which a part keeps the reason; the first of them."""
_REASONS_IN_ALL = 1000
"""The same of the whole."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TalliedDraws:
    """What is kept of draws that follow each other."""

    first: int
    """Number of the first."""
    runs: int
    """How many."""
    summaries: tuple[Summary, ...]
    """Of each metric that the plan keeps, in SI."""
    tallies: tuple[Tally | None, ...]
    """Of each requirement of the case; None of one that the metrics do not judge."""
    alone: tuple[Tally | None, ...]
    """The same of its own limit, where two are counted together; None: it is alone."""
    failed: int
    """Runs that failed."""
    again: int
    """How often values were drawn that cannot be."""
    reasons: Mapping[int, str]
    """Why the first of these failed, by the number of the draw."""

    def __len__(self) -> int:
        return self.runs

    @classmethod
    def of(cls, plan: CampaignPlan, flown: FlownDraws) -> Self:
        """Return what is kept of draws.

        Args:
            plan: with the histograms' edges.
            flown: draws, a row for each.
        """
        parts = counted(
            plan,
            flown.metrics,
            lambda size: worst_to_keep(size, len(flown)),
            first=flown.first,
        )
        few = [*flown.reasons.items()][:_REASONS]
        return cls(
            first=flown.first,
            runs=len(flown),
            summaries=tuple(
                Summary.of(flown.metrics[:, k], plan.edges(k))
                for k in range(len(plan.metrics))
            ),
            tallies=tuple(None if one is None else one.tally for one in parts),
            alone=tuple(
                None if one is None or one.alone is one.tally else one.alone
                for one in parts
            ),
            failed=flown.failed,
            again=flown.again,
            reasons=dict(few),
        )

    @classmethod
    def merged(cls, parts: Sequence[Self]) -> Self:
        """Return what is kept of all draws of a campaign.

        Args:
            parts: all of them, in any order.
        """
        summaries = zip(*(part.summaries for part in parts), strict=True)
        reasons = {i: why for part in parts for i, why in part.reasons.items()}
        return cls(
            first=min(part.first for part in parts),
            runs=sum(part.runs for part in parts),
            summaries=tuple(Summary.merged(each) for each in summaries),
            tallies=_merged([part.tallies for part in parts]),
            alone=_merged([part.alone for part in parts]),
            failed=sum(part.failed for part in parts),
            again=sum(part.again for part in parts),
            reasons=dict(sorted(reasons.items())[:_REASONS_IN_ALL]),
        )

    def counted(self, plan: CampaignPlan) -> list[Counted | None]:
        """Return what is known of each requirement of a plan's case.

        Args:
            plan: of the campaign.
        """
        of_metric = dict(zip(plan.metrics, self.summaries, strict=True))
        found: list[Counted | None] = []
        each = zip(plan.case.requirements, self.tallies, self.alone, strict=True)
        for one, tally, alone in each:
            if tally is None:
                found.append(None)
                continue
            summary = of_metric[one.judged_by]
            worst = summary.greatest if one.from_above else summary.least
            worst = worst if summary.told else math.nan
            found.append(Counted(tally, alone or tally, worst))
        return found


def _merged(parts: Sequence[Sequence[Tally | None]]) -> tuple[Tally | None, ...]:
    """Return the tallies of the whole, of those of its parts."""
    return tuple(
        None if each[0] is None else Tally.merged(filter(None, each))
        for each in zip(*parts, strict=True)
    )
