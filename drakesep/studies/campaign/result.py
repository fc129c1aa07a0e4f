"""What came of a campaign: shares, verdict, draws, and what Drake says of some."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.flights import CampaignFlights, FlownDraws
from drakesep.analysis.campaigns.gathering import KeptDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.shares import ShareFinding
from drakesep.analysis.metrics.requirements import (
    Requirement,
    Verdict,
    verdict_on_all,
)
from drakesep.plots.campaign_draws import curves_of
from drakesep.plots.campaign_points import scatters_of
from drakesep.plots.pictures import OfCampaign
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import RecordedPlan, write_draws
from drakesep.results.catalogue.names import CAMPAIGN
from drakesep.results.folder import ResultsFolder
from drakesep.systems.checks import InputError
from drakesep.tables.campaign_convergence import convergence_table
from drakesep.tables.campaign_tables import (
    ConfirmedDraw,
    campaign_table,
    confirmed_table,
    draws_table,
    histograms_table,
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
    flown: KeptDraws = field(repr=False)
    """What is kept of all draws."""
    findings: tuple[ShareFinding, ...]
    """Of each requirement."""
    confirmed: tuple[ConfirmedDraw, ...] = field(default=(), repr=False)
    """Draws that were flown in Drake."""
    found: Mapping[Requirement, float] = field(default_factory=dict, repr=False)
    """The worst case that searches have found of each requirement, in SI; none, if the
    campaign was flown alone."""

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
        return campaign_table(
            *(self.findings, self.flown.failed, self._bodies, self.found),
            self.worst_failure_cases,
        )

    @functools.cached_property
    def worst_failure_cases(self) -> Mapping[Requirement, str]:
        """The failure cases of which the worst draws are, where something fails."""
        names = [one.name for one in self.flights.failures]
        of_draws = {
            one.requirement: one.draw_of_rank(1) for one in self.findings if one.ranked
        }
        if not names or not of_draws:
            return {}
        failure = self.flights.drawn([*of_draws.values()]).failure.tolist()
        return {
            requirement: names[k]
            for requirement, k in zip(of_draws, failure, strict=True)
            if k >= 0
        }

    @property
    def _bodies(self) -> list[str]:
        """Names of those that leave."""
        return [pair.B for pair in self.case.separation.pairs]

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
    def convergence(self) -> pd.DataFrame:
        """A row for each requirement and number of draws: what the first ones say.

        None where no rows are kept.
        """
        if not isinstance(self.flown, FlownDraws):
            return pd.DataFrame()
        return convergence_table(
            self.plan, self.flown.metrics, self.findings, self._bodies
        )

    @functools.cached_property
    def draws(self) -> pd.DataFrame:
        """A row for each draw: what it varies, its metrics, and how it ended.

        Raises:
            ValueError: no rows are kept.
        """
        if not isinstance(self.flown, FlownDraws):
            raise InputError("draws: must be of a campaign that keeps rows")
        return draws_table(self.flights, self.flown)

    @functools.cached_property
    def histograms(self) -> pd.DataFrame:
        """A row for each metric and bin of its histogram, where no rows are kept."""
        if isinstance(self.flown, FlownDraws):
            return pd.DataFrame()
        return histograms_table(self.plan, self.flown)

    def some(self, numbers: Sequence[int]) -> FlownDraws:
        """Return what came of some draws, flown again where no rows are kept.

        Args:
            numbers: of the draws, one or more.
        """
        if isinstance(self.flown, FlownDraws):
            return self.flown.some(numbers)
        return self.flights.fly(np.array(numbers, np.int64))

    @property
    def failures(self) -> Mapping[int, str]:
        """Why runs failed, by the numbers of their draws.

        Where no rows are kept, of the first that did.
        """
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
        self.write_tables(results)
        self.draw(results.path)
        results.end(failed=self.failure, verdict=self.verdict)

    def write_tables(self, results: ResultsFolder) -> None:
        """Write all draws and the tables into a folder that is locked."""
        folder = results.path
        write_draws(folder, self.recorded, self.flown)
        write_csv(self.requirements, folder / "campaign.csv")
        write_csv(self.worst, folder / "campaign_worst.csv")
        write_csv(self.statistics, folder / "campaign_statistics.csv")
        write_csv(self.sensitivities, folder / "campaign_sensitivities.csv")
        if len(self.convergence):
            write_csv(self.convergence, folder / "campaign_convergence.csv")
        if not isinstance(self.flown, FlownDraws):
            write_csv(self.histograms, folder / "campaign_histograms.csv")
        elif self.plan.runs <= _ROWS:
            write_csv(self.draws, folder / "campaign_runs.csv.gz")
        results.keep()

    def draw(self, folder: Path) -> None:
        """Draw what is required over the draws into a folder."""
        self.picture.save(folder)

    @property
    def picture(self) -> OfCampaign:
        """What shows what is required over the draws."""
        curves = curves_of(self.findings, self.plan, self.flown, self.found)
        scatters = (
            scatters_of(self.findings, self.plan, self.flown, self.sensitivities)
            if isinstance(self.flown, FlownDraws)
            else ()
        )
        return OfCampaign(
            name=self.case.name,
            runs=self.plan.runs,
            curves=curves,
            scatters=scatters,
        )
