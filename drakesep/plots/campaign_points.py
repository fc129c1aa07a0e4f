"""Points of what draws of a campaign are kept, for each quantity that is required."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import ShareFinding
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.arrays import Array
from drakesep.units import with_unit


_DRAWS, _REQUIREMENTS, _PARAMETERS = 2000, 6, 2
"""That are shown, at most; parameters of each requirement."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Against:
    """A parameter over which draws are shown; in SI."""

    parameter: str
    values: Array
    """(n,) of the draws."""
    deciding: float
    """Of the draw that decides; NaN if none does."""
    correlation: float
    """Its rank correlation with what is required."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scatter:
    """What is required, draw by draw; in SI."""

    requirement: Requirement
    values: Array
    """(n,) of the draws; NaN of runs that failed."""
    deciding: float
    """Of the draw that decides; NaN if none does."""
    over: tuple[Against, ...]
    """The parameters of largest rank correlation, the largest first."""


def scatters_of(
    findings: Sequence[ShareFinding],
    plan: CampaignPlan,
    flown: FlownDraws,
    sensitivities: pd.DataFrame,
    most: int = _DRAWS,
) -> list[Scatter]:
    """Return the first draws of each quantity that is required, of its worst axis.

    Without clearances: of most draws it is only known what they are at least.

    Args:
        findings: of each requirement.
        plan: of the campaign.
        flown: all draws, from the first.
        sensitivities: as `Campaign.sensitivities` has them.
        most: draws that are shown.
    """
    worst: dict[tuple[str, str, bool], ShareFinding] = {}
    for one in findings:
        required = one.requirement
        if one.answer is None or required.judged_by not in plan.metrics:
            continue
        key = required.pair, required.quantity[0], required.from_above
        if key not in worst or _least(one) < _least(worst[key]):
            worst[key] = one
    draws = Draws(plan.case, plan.seed)
    shown = range(min(len(flown), most))
    found = [
        _scatter(
            *(one, plan, draws, flown, shown),
            _largest(one.requirement, sensitivities),
        )
        for one in [*worst.values()][:_REQUIREMENTS]
    ]
    return [one for one in found if one.over]


def _least(finding: ShareFinding) -> float:
    """Return the margin of a requirement; of one whose bound is a failed run, none."""
    return -math.inf if math.isnan(finding.margin) else finding.margin


def _largest(required: Requirement, sensitivities: pd.DataFrame) -> dict[str, float]:
    """Return the largest rank correlations, by the parameter with its unit."""
    mine = sensitivities[sensitivities["metric"] == with_unit(required.judged_by)]
    known = mine.set_index("parameter")["rank_correlation"].dropna()
    order = known.abs().sort_values(ascending=False, kind="stable").index
    return {str(name): float(known[name]) for name in order[:_PARAMETERS]}


def _scatter(
    finding: ShareFinding,
    plan: CampaignPlan,
    draws: Draws,
    flown: FlownDraws,
    first: Sequence[int],
    correlations: dict[str, float],
) -> Scatter:
    place = plan.metrics.index(finding.requirement.judged_by)
    draw = None if finding.answer is None else finding.answer.deciding_draw
    shown = [*first, *([] if draw is None else [draw])]
    drawn = draws.changed_by(shown)
    metrics = np.append(flown.metrics[shown, place], [math.nan] * (draw is None))

    def over(name: str, correlation: float) -> Against:
        values = np.array([one[name] for one in drawn] + [math.nan] * (draw is None))
        return Against(
            parameter=name,
            values=values[:-1],
            deciding=float(values[-1]),
            correlation=correlation,
        )

    names = {with_unit(name): name for name in draws.names}
    return Scatter(
        requirement=finding.requirement,
        values=metrics[:-1],
        deciding=float(metrics[-1]),
        over=tuple(over(names[n], rho) for n, rho in correlations.items()),
    )
