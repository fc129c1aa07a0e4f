"""A campaign beside worst cases: the statistical answer on the same requirements."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.shares import ShareFinding
from drakesep.analysis.metrics.objectives import highest
from drakesep.analysis.metrics.requirements import Finding, Requirement
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import RecordedPlan
from drakesep.studies.campaign.confirmation import (
    chosen,
    confirmed,
    most_confirmed,
    tells,
)
from drakesep.studies.campaign.flight import ChunksUnderWay, home_of, shown
from drakesep.studies.campaign.measuring import with_measured
from drakesep.studies.campaign.result import Campaign
from drakesep.studies.campaign.settings import CampaignSettings
from drakesep.studies.verified import Verification
from drakesep.studies.worst_case.confirmation import may_differ
from drakesep.studies.worst_case.effort import CAMPAIGN
from drakesep.studies.worst_case.plan import StudyPlan
from drakesep.studies.worst_case.session import Session
from drakesep.systems.checks import InputError


@dataclass(frozen=True, kw_only=True)
class CampaignBeside:
    """A campaign that is to be flown once the worst cases are known."""

    asked: Asked
    flights: CampaignFlights

    @classmethod
    def of(cls, settings: CampaignSettings, asked: Asked) -> Self:
        """Prepare.

        Args:
            settings: of the campaign.
            asked: of the study of worst cases, whose case has the shares.

        Raises:
            ValueError: a setting is wrong, so few runs can show nothing, nothing
                varies, or the batch engine cannot fly the case.
        """
        if not asked.case.tolerances:
            raise InputError(
                "dispersions: a campaign beside worst cases needs some, got none"
            )
        own = settings.beside(asked)
        flights = CampaignFlights(settings.plan(own.case)).with_spans()
        return cls(asked=own, flights=flights)

    def planned(self, plan: StudyPlan) -> StudyPlan:
        """Return a plan that tells how many draws there will be."""
        mine = self.flights.plan
        return replace(plan, draws=mine.runs, draws_in_drake=most_confirmed(mine))

    def flown(self, study: Verification, under_way: Session) -> Verification:
        """Return a study with its campaign, from the chunks that are there.

        Args:
            study: with its worst cases.
            under_way: the session that has found them.
        """
        plan = self.flights.plan
        folder, tell = under_way.plan.folder, under_way.telling(CAMPAIGN)
        recorded = RecordedPlan.of(plan)
        with home_of(folder) as home:
            if folder is not None:
                recorded.write(folder.path)
                folder.keep()
            chunks = ChunksUnderWay(recorded, self.flights, home)
            before = plan.runs - chunks.left
            tell(before, plan.runs)
            flown = with_measured(
                self.flights,
                chunks.flown(None, lambda done: tell(before + done, plan.runs)),
                recorded,
                home,
                workers=under_way.plan.workers,
            )
        campaign = shown(self.asked, recorded, self.flights, flown)
        campaign = confirmed(campaign, chosen(campaign), under_way.pool)
        worst = {one.requirement: one.worst for one in study.findings}
        own = {r: worst[r] for r in plan.case.requirements}
        campaign = replace(campaign, asked=campaign.asked.over(), found=own)
        study = replace(study, campaign=campaign)
        return replace(study, missed=missed(study.findings, campaign))


def missed(findings: Sequence[Finding], campaign: Campaign) -> dict[Requirement, int]:
    """Return draws that are worse than the worst case that was searched.

    Of each requirement one, if there is one within the tolerances, in which nothing
    fails: what was searched has it, and the search has missed it.

    Args:
        findings: over the runs that searches have led to.
        campaign: that was flown beside them.
    """
    of_runs = {one.requirement: one for one in findings}
    worse = {
        share.requirement: _first_within(_worse(share, of_runs, campaign), campaign)
        for share in campaign.findings
    }
    return {
        requirement: draw for requirement, draw in worse.items() if draw is not None
    }


def _worse(
    share: ShareFinding, of_runs: Mapping[Requirement, Finding], campaign: Campaign
) -> list[int]:
    """Return draws of less margin than the worst case, the least first."""
    if share.alone is None:
        return []
    one, name = of_runs[share.requirement], share.requirement.judged_by
    objective = campaign.flights.clearances.get(name) or highest(name)
    within = may_differ(objective, campaign.case, one.worst, one.nominal)
    least = one.margin - within
    if math.isnan(least):
        return []
    tally = share.alone.tally
    pairs = zip(tally.worst_draws, tally.worst_margins, strict=True)
    worse = [d for d, m in pairs if m < least]
    return [draw for draw in worse if tells(campaign, draw, name)]


def _first_within(draws: Sequence[int], campaign: Campaign) -> int | None:
    """Return the first of some draws that lies in the set that was searched."""
    if not draws:
        return None
    searched, drawn = campaign.case.tolerance_set, campaign.flights.drawn(draws)
    u = (drawn.values - searched.box.nominal) / searched.box.tolerance
    inside = searched.contains(u) & (drawn.failure < 0)
    place = np.flatnonzero(inside)
    return draws[int(place[0])] if len(place) else None
