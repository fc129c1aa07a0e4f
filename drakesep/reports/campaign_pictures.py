"""Pictures of a campaign in a report: shares, convergence, and points of draws."""

import itertools
from collections.abc import Iterator, Sequence

import pandas as pd

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.gathering import findings_of_kept
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.plots.campaign_curves import Curve
from drakesep.plots.campaign_draws import curves_of
from drakesep.plots.campaign_points import Scatter, scatters_of
from drakesep.reports.pictures import (
    ACROSS,
    CELL,
    Picture,
    panels_in_height,
    parts,
    picture_of,
    table_of_study,
)
from drakesep.reports.studies import Study
from drakesep.results.campaign_files import (
    DRAWS,
    TALLIES,
    RecordedPlan,
    read_draws,
)
from drakesep.units import unit_of


_POINTS = 500
"""Draws that are shown as points: of more, a page takes megabytes."""


def campaign_pictures(study: Study) -> Iterator[Picture]:
    """Yield pictures of a campaign; none of one whose draws are not kept.

    Args:
        study: that has flown the campaign.
    """
    yield from _of_draws(study)
    if study.has("campaign_convergence.csv"):
        yield from _convergence(study)


def _of_draws(study: Study) -> Iterator[Picture]:
    if not (study.has(DRAWS) or study.has(TALLIES)):
        return
    recorded = RecordedPlan.read(study.results.folder, to_fly=False)
    flown, plan = read_draws(study.results.folder, recorded), recorded.plan
    findings = findings_of_kept(plan, flown)
    worst = [row.get("worst_case_found") for row in study.rows("campaign.csv")]
    found = {
        one.requirement: unit_of(one.requirement.metric).to_si(value)
        for one, value in zip(findings, worst, strict=True)
        if value is not None
    }
    yield from _shares(plan, curves_of(findings, plan, flown, found))
    if not isinstance(flown, FlownDraws):
        return
    correlations = study.results.table("campaign_sensitivities.csv")
    yield from _points(plan, scatters_of(findings, plan, flown, correlations, _POINTS))


def _shares(plan: CampaignPlan, curves: Sequence[Curve]) -> Iterator[Picture]:
    from drakesep.plots.campaign import ROW, campaign_figure, panels_of_curves

    panels = panels_of_curves(curves)
    for some in parts(panels, panels_in_height(ROW)):
        mine = [*itertools.chain(*some)]
        yield picture_of(
            campaign_figure(
                plan.case.name, plan.runs, mine, most_across=ACROSS, cell=CELL
            ),
            "Curves of the share of draws beyond each value of what is required, with "
            "the limits, the statistical bounds and the worst draws, as in the table.",
            "Share of draws beyond a value.",
        )


def _points(plan: CampaignPlan, scatters: Sequence[Scatter]) -> Iterator[Picture]:
    from drakesep.plots.campaign_scatter import HEIGHT, scatter_figure

    # Each has two panels, a row.
    for some in parts(scatters, panels_in_height(HEIGHT * CELL) // ACROSS):
        yield picture_of(
            scatter_figure(plan.case.name, some, most_across=ACROSS, cell=CELL),
            "Draws as points: what is required, over the two parameters of largest "
            "rank correlation, with the limit and the draw that decides.",
            "The first draws, over the parameters that matter most.",
        )


def _convergence(study: Study) -> Iterator[Picture]:
    from drakesep.plots.campaign_convergence import OF, ROW, convergence_figure

    table = table_of_study(study, "campaign_convergence.csv", "axis", "pair")
    panels = [rows for _, rows in table.groupby(OF, sort=False, dropna=False)]
    for some in parts(panels, panels_in_height(ROW)):
        yield picture_of(
            convergence_figure(pd.concat(some), across=ACROSS, cell=CELL),
            "A panel for each requirement: the value below which the share of launches "
            "is, by more and more of the draws, with its interval and the limit.",
            "What more and more draws say: where curve and interval come to rest, more "
            "draws change little.",
        )
