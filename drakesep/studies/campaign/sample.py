"""A sample of draws flown in Drake, to hold the batch engine against it."""

import numpy as np

from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import RecordedPlan
from drakesep.studies.campaign.confirmation import SAMPLE, Chosen, confirmed
from drakesep.studies.campaign.flight import shown


def sample_of(asked: Asked, metrics: tuple[str, ...], seed: int) -> CampaignFlights:
    """Return what flies a case's launches, with a plan of a sample of draws.

    Args:
        asked: with the case.
        metrics: that are told.
        seed: of the draws.

    Raises:
        ValueError: a metric is unknown or told by no run, nothing varies, or the
            batch engine cannot fly the case.
    """
    plan = CampaignPlan(case=asked.case, runs=SAMPLE, seed=seed, metrics=metrics)
    return CampaignFlights(plan)


def not_confirmed(asked: Asked, flights: CampaignFlights) -> str:
    """Return which draws of a sample Drake does not confirm; empty if there are none.

    Args:
        asked: with the case.
        flights: of `sample_of`.
    """
    case, plan = asked.case, flights.plan
    flown = flights.fly(np.arange(plan.runs, dtype=np.int64))
    study = shown(asked, RecordedPlan.of(plan), flights, flown)
    draws = [Chosen(number) for number in range(plan.runs)]
    with DrakePool(case.separation, case.integration, workers=1) as pool:
        return confirmed(study, draws, pool).failure
