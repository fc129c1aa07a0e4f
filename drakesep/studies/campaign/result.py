"""What came of a campaign: shares, verdict, draws, and what Drake says of some."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.flights import CampaignFlights, FlownDraws
from drakesep.analysis.campaigns.order_statistics import runs_needed
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import ShareFinding, of_launches, size_of
from drakesep.analysis.metrics.requirements import Verdict, verdict_on_all
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import RecordedPlan, write_draws
from drakesep.results.catalogue import CAMPAIGN
from drakesep.results.folder import ResultsFolder
from drakesep.systems.checks import InputError
from drakesep.tables.campaign_tables import (
    ConfirmedDraw,
    campaign_table,
    confirmed_table,
    draws_table,
    sensitivities_table,
    statistics_table,
)
from drakesep.tables.columns import write_csv


_ROWS = 20_000
"""Draws that are written as a table beside the arrays."""


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """Many independent draws of what varies in a case, flown."""

    asked: Asked = field(repr=False)
    """With the case."""
    recorded: RecordedPlan = field(repr=False)
    """The plan."""
    flights: CampaignFlights = field(repr=False)
    """That can fly any draw again."""
    flown: FlownDraws = field(repr=False)
    """All draws."""
    findings: tuple[ShareFinding, ...]
    """Of each requirement."""
    confirmed: tuple[ConfirmedDraw, ...] = field(default=(), repr=False)
    """Draws that were flown in Drake."""

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.plan.case

    @property
    def plan(self) -> CampaignPlan:
        """What was drawn and flown."""
        return self.recorded.plan

    @functools.cached_property
    def requirements(self) -> pd.DataFrame:
        """A row for each requirement and axis: the share that is shown."""
        bodies = [pair.B for pair in self.case.separation.pairs]
        return campaign_table(self.findings, self.flown, bodies)

    @functools.cached_property
    def worst(self) -> pd.DataFrame:
        """A row for each draw that was flown in Drake, and quantity."""
        return confirmed_table(self.confirmed, self.flights.names, self.case)

    @functools.cached_property
    def statistics(self) -> pd.DataFrame:
        """A row for each metric: mean, deviation, quantiles with intervals."""
        return statistics_table(self.plan, self.flown)

    @functools.cached_property
    def sensitivities(self) -> pd.DataFrame:
        """A row for each metric and parameter: their rank correlation."""
        return sensitivities_table(self.flights, self.flown)

    @functools.cached_property
    def draws(self) -> pd.DataFrame:
        """A row for each draw: what it varies, its metrics, and how it ended."""
        return draws_table(self.flights, self.flown)

    def value_of(self, draw: int, metric: str) -> float:
        """Return what a draw tells of a metric or clearance of the plan, in SI.

        Of a clearance that was not measured, what it is at least. NaN if its run
        failed.
        """
        if metric not in self.plan.clearances:
            return float(self.flown.metrics[draw, self.plan.metrics.index(metric)])
        assert self.flown.clearances is not None
        i = self.plan.clearances.index(metric)
        return float(self.flown.clearances.at_least[draw, i])

    def tells(self, draw: int, metric: str) -> bool:
        """Return whether that is the value itself, not only what it is at least."""
        of_draws = self.flown.clearances
        if metric not in self.plan.clearances or of_draws is None:
            return True
        return bool(of_draws.measured[draw, self.plan.clearances.index(metric)])

    @property
    def failures(self) -> Mapping[int, str]:
        """Why runs failed, by the numbers of their draws."""
        return self.flown.reasons

    @property
    def verdict(self) -> str | None:
        """On all requirements; None if there is none."""
        if not self.findings:
            return None
        return verdict_on_all(one.verdict for one in self.findings).value

    @property
    def passed(self) -> bool:
        """Whether the share is shown of every requirement."""
        return self.verdict == Verdict.MET.value

    @property
    def of_every_run(self) -> int:
        """How many requirements every run must meet, which no campaign can show."""
        return sum(not one.requirement.statistical for one in self.findings)

    @property
    def failure(self) -> str:
        """Which draws Drake does not confirm; empty if there are none."""
        differ = [one for one in self.confirmed if one.outcome.failed]
        if not differ:
            return ""
        draws = sorted({one.draw for one in differ})
        first = differ[0]
        return (
            f"Drake does not confirm {len(draws)} of "
            f"{len({one.draw for one in self.confirmed})} draws; draw {first.draw}, "
            f"{first.metric}: {first.outcome.message}"
        )

    @property
    def completed(self) -> bool:
        """Whether Drake confirms what the batch engine says."""
        return not self.failure

    def save(self, directory: str | Path) -> None:
        """Write tables, plot and `study.json` into a folder.

        Raises:
            ValueError: it cannot be written, another study is writing it, or it holds
                the results of another kind of study.
        """
        with ResultsFolder(directory, CAMPAIGN) as folder:
            folder.begin(self.asked)
            self.recorded.write(folder.path)
            self.write(folder)

    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
        folder = results.path
        write_draws(folder, self.recorded, self.flown)
        write_csv(self.requirements, folder / "campaign.csv")
        write_csv(self.worst, folder / "campaign_worst.csv")
        write_csv(self.statistics, folder / "campaign_statistics.csv")
        write_csv(self.sensitivities, folder / "campaign_sensitivities.csv")
        if self.plan.runs <= _ROWS:
            write_csv(self.draws, folder / "campaign_runs.csv.gz")
        results.keep()
        if any(one.beyond is not None for one in self.findings):
            # Half a second to import, where something is drawn.
            from drakesep.plots.campaign import save_campaign

            save_campaign(self.findings, self.plan, self.flown, folder)
        results.end(failed=self.failure, verdict=self.verdict)


def with_confirmed(study: Campaign, confirmed: Sequence[ConfirmedDraw]) -> Campaign:
    """Return a campaign with what Drake says of some draws.

    What it does not confirm shows nothing.
    """
    doubtful = {one.metric for one in confirmed if one.outcome.failed}
    findings = tuple(
        replace(one, confirmed=one.requirement.judged_by not in doubtful)
        for one in study.findings
    )
    return replace(study, findings=findings, confirmed=tuple(confirmed))


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
