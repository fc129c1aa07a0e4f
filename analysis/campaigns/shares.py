"""What the draws of a campaign say of each requirement, of a share or of every run."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drakesep.analysis.campaigns.answers import (
    CampaignAnswer,
    LaunchRequirement,
    Tally,
    launch_requirements,
)
from drakesep.analysis.campaigns.order_statistics import CampaignSize, runs_needed
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.metrics.requirements import Requirement, Verdict
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


SHARE, CONFIDENCE = 0.99865, 0.90
"""Of which a bound is told where every run must keep a limit: 3 sigma of a normal
distribution, to one side, and what is customary with it."""
_MORE = 10
"""Draws that are ranked beside those that may be beyond the limit."""


@dataclass(frozen=True, kw_only=True)
class ShareFinding:
    """How a requirement fares over the draws of a campaign."""

    requirement: Requirement
    size: CampaignSize
    """Share, confidence, runs, and so how many may be beyond the limit."""
    answer: CampaignAnswer | None = None
    """What the draws say; of a limit that every run must keep, as if it were of a
    share. None: they were not looked at."""
    failed: tuple[int, ...] = ()
    """The first draws whose runs failed: they come before all others."""
    worst: float = math.nan
    """Of all draws that tell, in SI."""
    confirmed: bool = True
    """Whether Drake says the same of the draws that decide the verdict."""

    @property
    def beyond(self) -> int | None:
        """Draws beyond the limit, runs that failed among them; None: not looked at."""
        return None if self.answer is None else self.answer.failures

    @property
    def margin(self) -> float:
        """At the confidence, the share of launches has no less.

        NaN: of a run that failed, or of none, where runs are too few.
        """
        if self.answer is None or math.isinf(self.answer.margin):
            return math.nan
        return self.answer.margin

    @property
    def bound(self) -> float:
        """At the confidence, the share of launches is no worse; NaN as the margin."""
        side = -1.0 if self.requirement.from_above else 1.0
        return self.requirement.limit + side * self.margin

    @property
    def ranked(self) -> tuple[int, ...]:
        """Draws of the least margins, the least first, runs that failed before them."""
        if self.answer is None:
            return ()
        return (*self.failed, *self.answer.tally.worst_draws)

    @property
    def verdict(self) -> Verdict:
        """Whether the share is shown at the confidence, or that it is not met.

        That every run keeps a limit no number of draws shows; one that does not
        disproves it.
        """
        if self.answer is None:
            return Verdict.NOT_LOOKED_AT
        if not self.requirement.statistical:
            beyond = self.answer.tally.beyond and self.confirmed
            return Verdict.NOT_MET if beyond else Verdict.NOT_LOOKED_AT
        if self.answer.verdict is Verdict.MET and not self.confirmed:
            return Verdict.NOT_LOOKED_AT
        return self.answer.verdict


def share_findings(
    plan: CampaignPlan, metrics: Array, failed: Sequence[int]
) -> list[ShareFinding]:
    """Return how each requirement of a case fares, in their order.

    Args:
        plan: of the campaign.
        metrics: (N, m) of all draws; NaN of runs that failed.
        failed: numbers of the draws that did.
    """
    columns = dict(zip(plan.metrics, metrics.T, strict=True))
    first = tuple(sorted(failed)[:_FAILED])
    return [
        _finding(plan, one, of_launches(one, plan.case.requirements), columns, first)
        for one in plan.case.requirements
    ]


_FAILED = 100_000
"""Runs that failed which are known by their numbers: more than may be beyond."""


def of_launches(
    requirement: Requirement, others: Sequence[Requirement]
) -> LaunchRequirement:
    """Return what a requirement is of a share of launches, with its other side.

    Args:
        requirement: of a share; or of every run, which is taken as one of `SHARE`.
        others: of the case.
    """
    if requirement.statistical:
        known = launch_requirements(others)
        return next(one for one in known if requirement in one.limits)
    as_share = replace(requirement, share=SHARE, confidence=CONFIDENCE)
    return LaunchRequirement(limits=(as_share,))


def size_of(required: LaunchRequirement, runs: int) -> CampaignSize:
    """Return what so many draws can show of a requirement."""
    return CampaignSize(share=required.share, confidence=required.confidence, runs=runs)


def check_size(plan: CampaignPlan) -> None:
    """Raise InputError if so few runs can show nothing, however they turn out."""
    required = plan.case.requirements
    for one in required:
        size = size_of(of_launches(one, required), plan.runs)
        if one.statistical and size.allowed is None:
            least = runs_needed(size.share, size.confidence)
            raise InputError(
                f"runs: must be {least} or more to show a share of {size.share:g} at a "
                f"confidence of {size.confidence:g}, got {plan.runs}"
            )


def _finding(
    plan: CampaignPlan,
    requirement: Requirement,
    required: LaunchRequirement,
    columns: Mapping[str, Array],
    failed: tuple[int, ...],
) -> ShareFinding:
    size = size_of(required, plan.runs)
    apart = any(limit.measured_apart for limit in required.limits)
    if apart or not columns.keys() >= set(required.metrics):
        return ShareFinding(requirement=requirement, size=size)
    tally = Tally.of(required, columns, kept=(size.allowed or 0) + _MORE)
    told = columns[requirement.judged_by]
    told = told[~np.isnan(told)]
    worst = math.nan
    if len(told):
        worst = float(told.max() if requirement.from_above else told.min())
    return ShareFinding(
        requirement=requirement,
        size=size,
        answer=CampaignAnswer(required=required, tally=tally),
        failed=failed,
        worst=worst,
    )
