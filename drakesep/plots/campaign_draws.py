"""Curves of what draws of a campaign are kept, for each requirement."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.gathering import KeptDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import ShareFinding, nearest_of_draws
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.campaign_curves import Curve, curve_of_rows, curve_of_summary
from drakesep.systems.arrays import Array


def curves_of(
    findings: Sequence[ShareFinding],
    plan: CampaignPlan,
    draws: KeptDraws,
    found: Mapping[Requirement, float],
) -> list[Curve]:
    """Return a curve for each requirement that was looked at.

    Args:
        findings: of each requirement.
        plan: of the campaign.
        draws: what is kept of all.
        found: the worst case of each requirement, in SI; none, if none was searched.
    """
    return [
        _curve(one, plan, draws, found.get(one.requirement, math.nan))
        for one in findings
        if one.beyond is not None
    ]


def _curve(
    finding: ShareFinding, plan: CampaignPlan, draws: KeptDraws, worst_case: float
) -> Curve:
    required = finding.requirement
    if isinstance(draws, FlownDraws):
        told = _values(required, plan, draws)
        values, shares = curve_of_rows(told, required.from_above)
    else:
        summary = draws.summaries[plan.metrics.index(required.judged_by)]
        values, shares = curve_of_summary(summary, required.from_above)
    return Curve(
        requirement=required,
        values=values,
        shares=shares,
        bound_of=finding.size.share,
        bound=finding.bound,
        bound_share=(finding.size.rank or 1) / plan.runs,
        worst_case=worst_case,
    )


def _values(required: Requirement, plan: CampaignPlan, draws: FlownDraws) -> Array:
    """Return (N,) what all draws tell of a requirement.

    Of a clearance as far as it is known: infinite of draws that come after those.
    """
    if required.metric not in plan.clearances or draws.clearances is None:
        return draws.metrics[:, plan.metrics.index(required.judged_by)]
    nearest = nearest_of_draws(plan, required, draws.clearances)
    known = nearest.measured & (nearest.at_least <= nearest.known_to)
    values: Array = np.where(np.isnan(nearest.values) | known, nearest.values, np.inf)
    return values
