"""The study of rare events: how improbable it is to be beyond each limit."""

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.flights import CampaignFlights
from drakesep.analysis.campaigns.of_case import probability_beyond
from drakesep.analysis.campaigns.subset_simulation import (
    RareProbability,
    chains_of,
    most_runs,
)
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.case_file.case import Case
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import RARE_EVENTS
from drakesep.results.folder import Output, begun
from drakesep.studies.campaign.flight import seconds_of
from drakesep.studies.campaign.sample import not_confirmed, sample_of
from drakesep.studies.one_table import OneTable
from drakesep.studies.runs_progress import OnRuns, TellingRuns
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, unknown
from drakesep.tables.rare_events_table import rare_events_table


@dataclass(frozen=True, kw_only=True)
class RareEvents(OneTable):
    """How improbable it is to be beyond each limit of a case."""

    FILE: ClassVar = "rare_events.csv"

    found: tuple[tuple[Requirement, RareProbability], ...]
    """Of each requirement that was looked at."""

    @functools.cached_property
    def table(self) -> pd.DataFrame:
        """A row for each requirement: the probability, with its interval."""
        bodies = [pair.B for pair in self.case.separation.pairs]
        return rare_events_table(self.found, bodies)


@typed
def rare_events(
    case: Case | AnalysisCase | str | Path,
    requirements: Sequence[str] = (),
    *,
    per_level: int = 1800,
    replicates: int = 10,
    least: float = 1e-9,
    seed: int = 0,
    output: Output | None = None,
    on_progress: OnRuns | None = None,
) -> RareEvents:
    """Tell how improbable it is to be beyond limits, by subset simulation.

    Of launches in which nothing fails, over the distributions that the case states.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        requirements: that are looked at, by id or by the metric that judges them; all
            of which runs tell without measuring how near parts come, if none.
        per_level: draws of each simulation at each level.
        replicates: simulations, two or more.
        least: probability below which a simulation ends.
        seed: of all numbers.
        output: folder that receives the table.
        on_progress: called as it goes on.

    Raises:
        ValueError: the case or an argument is wrong, there is no such requirement, the
            batch engine cannot fly the case, or the folder cannot be written.
    """
    how = {"per_level": per_level, "replicates": replicates, "least": least}
    arguments = {"requirements": list(requirements), **how, "seed": seed}
    asked = Asked.of(RARE_EVENTS, case, arguments, seed=seed)
    chains_of(per_level, 0.1, replicates, least)
    wanted = _wanted(asked.case, requirements)
    names = tuple(dict.fromkeys(one.judged_by for one in wanted))
    flights = sample_of(asked, names, seed)
    total = len(wanted) * most_runs(per_level, replicates, least)
    what = f"probabilities beyond {len(wanted)} limits, by subset simulation"
    with begun(output, asked) as folder:
        telling = TellingRuns(on_progress, what, total, seconds_of(flights, total))
        found = tuple(
            (one, _beyond(asked.case, one, flights, telling, seed=seed, **how))
            for one in wanted
        )
        study = RareEvents(
            asked=asked, found=found, failure=not_confirmed(asked, flights)
        )
        study = replace(study, asked=asked.over())
        if folder is not None:
            study.write(folder)
    return study


def _wanted(case: AnalysisCase, names: Sequence[str]) -> list[Requirement]:
    """Return the requirements of some names; all that runs tell, if there is none.

    Raises:
        ValueError: there is none of a name, or none at all.
    """
    told = [r for r in case.requirements if not r.measured_apart and case.tells(r)]
    if not told:
        raise InputError(
            "requirements: must be one that runs tell without measuring how near parts "
            "come, got none"
        )
    known = {name: None for one in told for name in (one.id, one.judged_by) if name}
    for name in names:
        if name not in known:
            raise InputError(unknown("requirement", name, known))
    return [r for r in told if not names or {r.id, r.judged_by} & {*names}]


def _beyond(
    case: AnalysisCase,
    requirement: Requirement,
    flights: CampaignFlights,
    telling: TellingRuns,
    **how: float,
) -> RareProbability:
    """Return the probability to be beyond a limit."""
    sign = 1.0 if requirement.from_above else -1.0
    column = flights.plan.metrics.index(requirement.judged_by)

    def value(points: Array) -> Array:
        found = flights.metrics_at(points)[:, column]
        telling.flown(len(points))
        return sign * found

    return probability_beyond(case, value, sign * requirement.limit, **how)
