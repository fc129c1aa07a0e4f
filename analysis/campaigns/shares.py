"""What the draws of a campaign say of each requirement, of a share or of every run."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from drakesep.analysis.campaigns.answers import (
    CampaignAnswer,
    LaunchRequirement,
    Tally,
    launch_requirements,
)
from drakesep.analysis.campaigns.measuring import NearestOfDraws
from drakesep.analysis.campaigns.order_statistics import CampaignSize, runs_needed
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.screens import DrawnClearances
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
    share; of a limit of two sides, of both together. None: they were not looked at."""
    alone: CampaignAnswer | None = None
    """What they say of this limit by itself: where it stands alone, the same."""
    failed: tuple[int, ...] = ()
    """The first draws that do not tell, such as runs that failed: they come before all
    others."""
    worst: float = math.nan
    """Of all draws that tell, in SI."""
    measured: int | None = None
    """Draws that were measured, of a clearance: the others are proven not to come as
    near as decides it."""
    confirmed: bool = True
    """Whether Drake says the same of the draws that decide the verdict."""

    @property
    def beyond(self) -> int | None:
        """Draws beyond the limit, runs that failed among them; None: not looked at."""
        return None if self.answer is None else self.answer.failures

    @property
    def margin(self) -> float:
        """At the confidence, the share of launches has no less, to this limit alone.

        NaN: of a run that failed, or of none, where runs are too few.
        """
        if self.alone is None or math.isinf(self.alone.margin):
            return math.nan
        return self.alone.margin

    @property
    def bound(self) -> float:
        """At the confidence, the share of launches is no worse; NaN as the margin.

        The value of a draw: of two limits, each has its own.
        """
        side = -1.0 if self.requirement.from_above else 1.0
        return self.requirement.limit + side * self.margin

    @property
    def ranked(self) -> tuple[int, ...]:
        """Draws of the least margins, the least first, runs that failed before them.

        As many as are known, to this limit alone.
        """
        if self.alone is None:
            return ()
        return (*self.failed, *self.alone.tally.worst_draws)

    def draw_of_rank(self, rank: int) -> int:
        """Return the number of a draw, by how near it comes to this limit alone.

        Args:
            rank: 1 for the worst. Runs that failed are all alike: of more than are
                known by their numbers, the last of these stands for the others.
        """
        assert self.alone is not None
        tally = self.alone.tally
        if rank <= tally.untold:
            return self.failed[min(rank, len(self.failed)) - 1]
        return tally.worst_draws[rank - tally.untold - 1]

    @property
    def deciding_rank(self) -> int | None:
        """The rank of the draw on which the verdict is; None: it is at no rank here.

        That of two limits together has its rank on the side to which it is nearer; of
        what every run must keep, the worst decides.
        """
        if self.answer is None or self.alone is None:
            return None
        if not self.requirement.statistical:
            return 1
        last = (self.size.allowed or 0) + 1
        draw, tally = self.answer.deciding_draw, self.alone.tally
        if not self.together or draw is None:
            return last
        if draw not in tally.worst_draws:
            return None
        return tally.untold + tally.worst_draws.index(draw) + 1

    @property
    def together(self) -> bool:
        """Whether what fails and is allowed is of two limits together."""
        return self.answer is not None and len(self.answer.required.limits) > 1

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
    plan: CampaignPlan,
    metrics: Array,
    failed: Sequence[int],
    clearances: DrawnClearances | None = None,
) -> list[ShareFinding]:
    """Return how each requirement of a case fares, in their order.

    Args:
        plan: of the campaign.
        metrics: (N, m) of all draws; NaN of runs that failed.
        failed: numbers of the draws that did.
        clearances: of all draws, if the plan has any.
    """
    found = counted(plan, metrics, lambda size: (size.allowed or 0) + _MORE)
    findings = findings_of(plan, found, sorted(failed)[:_FAILED])
    return [
        _of_clearance(plan, one.requirement, clearances)
        if one.requirement.metric in plan.clearances and clearances is not None
        else one
        for one in findings
    ]


def nearest_of_draws(
    plan: CampaignPlan, requirement: Requirement, clearances: DrawnClearances
) -> NearestOfDraws:
    """Return how near parts come in all draws, by the clearance of a requirement."""
    required = of_launches(requirement, plan.case.requirements)
    i = plan.clearances.index(requirement.metric)
    return NearestOfDraws(
        required=required,
        size=size_of(required, plan.runs),
        at_least=clearances.at_least[:, i],
        measured=clearances.measured[:, i],
    )


def _of_clearance(
    plan: CampaignPlan,
    requirement: Requirement,
    clearances: DrawnClearances,
) -> ShareFinding:
    nearest = nearest_of_draws(plan, requirement, clearances)
    tally = nearest.tally((nearest.size.allowed or 0) + _MORE)
    told = nearest.at_least[nearest.measured]
    untold = np.flatnonzero(np.isnan(nearest.values))[:_FAILED]
    # Of a clearance nothing is required from above: its limit stands alone.
    answer = CampaignAnswer(required=nearest.required, tally=tally)
    return ShareFinding(
        requirement=requirement,
        size=nearest.size,
        answer=answer,
        alone=answer,
        failed=tuple(untold.tolist()),
        worst=float(np.nanmin(told)) if np.isfinite(told).any() else math.nan,
        measured=len(told),
    )


_FAILED = 100_000
"""Runs that failed which are known by their numbers."""


class Counted(NamedTuple):
    """What is known of draws for one requirement."""

    tally: Tally
    """Of its limits together."""
    alone: Tally
    """Of its own limit."""
    worst: float
    """Of all that tell, in SI; NaN if none does."""


def counted(
    plan: CampaignPlan,
    metrics: Array,
    kept: Callable[[CampaignSize], int],
    first: int = 0,
) -> list[Counted | None]:
    """Return what draws say of each requirement of a plan's case, in their order.

    None of one that the metrics do not judge.

    Args:
        plan: of the campaign.
        metrics: (n, m) of draws that follow each other; NaN of runs that failed.
        kept: how many worst are kept of a campaign of such a size.
        first: number of the first draw.
    """
    columns = dict(zip(plan.metrics, metrics.T, strict=True))
    found: list[Counted | None] = []
    for one in plan.case.requirements:
        required = of_launches(one, plan.case.requirements)
        apart = any(limit.measured_apart for limit in required.limits)
        if apart or not columns.keys() >= set(required.metrics):
            found.append(None)
            continue
        most = kept(size_of(required, plan.runs))
        tally = alone = Tally.of(required, columns, first=first, kept=most)
        if len(required.limits) > 1:
            own = LaunchRequirement(limits=(one,))
            alone = Tally.of(own, columns, first=first, kept=most)
        told = columns[one.judged_by]
        told = told[~np.isnan(told)]
        worst = math.nan
        if len(told):
            worst = float(told.max() if one.from_above else told.min())
        found.append(Counted(tally, alone, worst))
    return found


def findings_of(
    plan: CampaignPlan, found: Sequence[Counted | None], failed: Sequence[int]
) -> list[ShareFinding]:
    """Return how each requirement of a case fares, in their order.

    Args:
        plan: of the campaign.
        found: what all draws say of each requirement.
        failed: numbers of draws that failed, the first of them.
    """
    others = plan.case.requirements
    findings = []
    for one, known in zip(others, found, strict=True):
        required = of_launches(one, others)
        finding = ShareFinding(requirement=one, size=size_of(required, plan.runs))
        if known is not None:
            two = len(required.limits) > 1
            own = LaunchRequirement(limits=(one,)) if two else required
            finding = replace(
                finding,
                answer=CampaignAnswer(required=required, tally=known.tally),
                alone=CampaignAnswer(required=own, tally=known.alone),
                failed=tuple(failed),
                worst=known.worst,
            )
        findings.append(finding)
    return findings


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
