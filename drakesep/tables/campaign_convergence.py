"""What more and more of a campaign's draws say of each requirement."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from drakesep.analysis.campaigns.order_statistics import share_at_most, share_shown
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import ShareFinding, of_launches
from drakesep.analysis.campaigns.statistics import Estimate, convergence
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.arrays import Array
from drakesep.tables.campaign_tables import INTERVALS, interval_columns
from drakesep.tables.requirement_tables import identity_columns, limit_columns
from drakesep.units import unit_of


_POINTS = 12
"""Numbers of draws, at most."""


def convergence_table(
    plan: CampaignPlan,
    metrics: Array,
    findings: Sequence[ShareFinding],
    bodies: Sequence[str],
) -> pd.DataFrame:
    """Return a row for each requirement and number of draws: what the first ones say.

    Without what is required of clearances: which draws are measured, all of them
    decide.

    Args:
        plan: of the campaign.
        metrics: (N, m) of all draws, in their order; NaN of runs that failed.
        findings: of each requirement, from all draws.
        bodies: names of those that leave; that of the first pair is the first.
    """
    columns = dict(zip(plan.metrics, metrics.T, strict=True))
    return pd.DataFrame(
        row
        for one in findings
        if one.answer is not None and one.requirement.judged_by in columns
        for row in _rows(one, plan.case.requirements, columns, bodies)
    )


def _rows(
    finding: ShareFinding,
    others: Sequence[Requirement],
    metrics: Mapping[str, Array],
    bodies: Sequence[str],
) -> Iterator[dict[str, object]]:
    requirement, share = finding.requirement, finding.size.share
    unit = unit_of(requirement.metric)
    required = of_launches(requirement, others)
    margins = required.margins(metrics)
    # What does not tell, such as a run that failed, counts as beyond.
    failures = np.cumsum(required.beyond(margins) | np.isnan(margins))
    below = share if requirement.from_above else 1.0 - share
    for first in convergence(metrics[requirement.judged_by], below, INTERVALS, _POINTS):
        beyond = int(failures[first.draws - 1])
        shares = share_within(beyond, first.draws, INTERVALS)
        yield {
            **limit_columns(requirement, unit),
            "draws": first.draws,
            **interval_columns("mean", first.mean, unit),
            "deviation": unit.from_si(first.deviation),
            "quantile_of": below,
            **interval_columns("quantile", first.quantile, unit),
            "failures": beyond,
            "share_beyond": shares.value,
            "share_beyond_from": shares.low,
            "share_beyond_to": shares.high,
            **identity_columns(requirement, bodies),
        }


def share_within(failures: int, draws: int, confidence: float) -> Estimate:
    """Return the share of launches beyond a limit, with its interval.

    That of Clopper and Pearson, half of the risk on each side
    (doi:10.1093/biomet/26.4.404).

    Args:
        failures: draws that are beyond.
        draws: all.
        confidence: of the interval.
    """
    each_side = (1.0 + confidence) / 2.0
    return Estimate(
        failures / draws,
        1.0 - share_at_most(draws, failures, each_side),
        1.0 - share_shown(draws, failures, each_side),
    )
