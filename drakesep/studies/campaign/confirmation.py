"""Draws of a campaign flown in Drake, and held against the batch engine."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drakesep.analysis.campaigns.flights import FlownDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.screens import has_separated, measured_in
from drakesep.analysis.campaigns.shares import ShareFinding
from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.metrics.objectives import highest
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.studies.campaign.result import Campaign
from drakesep.studies.worst_case.confirmation import may_differ
from drakesep.systems.model.run import Run
from drakesep.tables.campaign_tables import ConfirmedDraw
from drakesep.tables.roles import CONFIRMED, Outcome, failed


MOST = 32
"""Draws of a requirement that are flown in Drake: of more that decide its verdict, the
worst, the one that is its bound, and others evenly between."""
SAMPLE = 16
"""Draws at random that are flown in Drake."""


class Chosen(NamedTuple):
    """A draw that is to be flown in Drake."""

    draw: int
    requirement: Requirement | None = None
    """Whose verdict it decides; None: it was drawn at random."""
    rank: int | None = None
    """1: the worst of all draws."""
    is_bound: bool = False
    """Whether the verdict is that on this draw: those that are worse may be beyond."""

    def is_within(self, value: float) -> bool:
        """Return whether a value of it meets its requirement, if it has one."""
        required = self.requirement
        return required is None or required.keeps(required.margin(value))


def most_confirmed(plan: CampaignPlan) -> int:
    """Return how many draws are flown in Drake at most."""
    return SAMPLE + MOST * len(plan.case.requirements)


def chosen(study: Campaign) -> list[Chosen]:
    """Return the draws that decide the verdicts, and some at random."""
    draws = [
        one
        for finding in study.findings
        for one in _deciding(finding)
        if tells(study, one.draw, finding.requirement.judged_by)
    ]
    # None of those that were drawn: another stream, of the same seed.
    rng = np.random.default_rng([study.plan.seed, SAMPLE])
    count = min(SAMPLE, study.plan.runs)
    sample = sorted(rng.choice(study.plan.runs, size=count, replace=False).tolist())
    return [*draws, *map(Chosen, sample)]


def tells(study: Campaign, draw: int, metric: str) -> bool:
    """Return whether a draw tells a metric: not a clearance that was not measured."""
    flown = study.flown
    return not isinstance(flown, FlownDraws) or flown.tells(draw, metric, study.plan)


def _deciding(finding: ShareFinding) -> Iterator[Chosen]:
    if finding.beyond is None:
        return
    last, decides = (finding.size.allowed or 0) + 1, finding.deciding_rank
    # Of two limits together, the draw that decides has another rank to each.
    many = min(MOST - finding.together, last)
    ranks = np.unique(np.linspace(1, last, many).round().astype(int))
    if decides is not None:
        ranks = np.union1d(ranks, decides)
    answer = finding.alone
    known = 0 if answer is None else answer.tally.untold + len(answer.tally.worst_draws)
    for rank in ranks[ranks <= known].tolist():
        draw = finding.draw_of_rank(rank)
        yield Chosen(draw, finding.requirement, rank, rank == decides)


def confirmed(
    study: Campaign,
    draws: Sequence[Chosen],
    pool: DrakePool,
    on_progress: Callable[[int, int], None] = lambda *_: None,
) -> Campaign:
    """Return a campaign with what Drake says of some draws.

    What it does not confirm shows nothing.

    Args:
        study: with all draws.
        draws: that are chosen.
        pool: that flies its separation in Drake.
        on_progress: told how many are done, and of how many.
    """
    flown = confirmed_draws(study, draws, pool, on_progress)
    doubtful = {one.metric for one in flown if one.outcome.failed}
    findings = tuple(
        replace(one, confirmed=one.requirement.judged_by not in doubtful)
        for one in study.findings
    )
    return replace(study, findings=findings, confirmed=tuple(flown))


def confirmed_draws(
    study: Campaign,
    draws: Sequence[Chosen],
    pool: DrakePool,
    on_progress: Callable[[int, int], None] = lambda *_: None,
) -> list[ConfirmedDraw]:
    """Return what Drake says of the draws that decide the verdicts, and of a sample.

    Args:
        study: with all draws.
        draws: that are chosen.
        pool: that flies its separation in Drake.
        on_progress: told how many are done, and of how many.
    """
    numbers = sorted({one.draw for one in draws})
    values = study.flights.values(numbers)
    # What differs from the nominal by nothing tells what that is.
    compared = [(one, metric) for one in draws for metric in _compared(one, study)]
    # To measure a clearance takes as long as to fly.
    measured = sum(metric in study.plan.clearances for _, metric in compared)
    total = len(numbers) + 1 + measured

    def tell(done: int, _: int) -> None:
        on_progress(done, total)

    nominal, *runs = pool.fly([{}, *values], tell)
    told = _Told(study, dict(zip(numbers, values, strict=True)), nominal)
    flown = dict(zip(numbers, runs, strict=True))
    confirmed, done = [], total - measured
    for one, metric in compared:
        confirmed.append(told.confirmed(one, metric, flown[one.draw]))
        if metric in study.plan.clearances:
            done += 1
            tell(done, total)
    return confirmed


def _compared(one: Chosen, study: Campaign) -> Sequence[str]:
    """Return the metrics that are compared: of a draw at random all that judge."""
    if one.requirement is not None:
        return (one.requirement.judged_by,)
    judges = (each.requirement.judged_by for each in study.findings)
    told = {*study.plan.metrics, *study.plan.clearances}
    return [name for name in dict.fromkeys(judges) if name in told]


class _Told:
    """What Drake tells of draws."""

    def __init__(
        self, study: Campaign, values: Mapping[int, Mapping[str, float]], nominal: Run
    ):
        self._study, self._values = study, values
        self._rows = {draw: row for row, draw in enumerate(values)}
        self._flown = study.some([*values])
        self._nominal = nominal
        self._metrics: dict[int, Mapping[str, float]] = {}
        self._clearances: dict[tuple[int, str], float] = {}

    def confirmed(self, one: Chosen, metric: str, run: Run) -> ConfirmedDraw:
        """Return a draw, with what both engines say of a metric.

        Args:
            one: the draw.
            metric: in question.
            run: of it in Drake.
        """
        study = self._study
        row = self._rows[one.draw]
        value = self._flown.value_of(row, metric, study.plan)
        drake_failed = "" if has_separated(run) else run.message or run.not_separated
        told = math.nan if drake_failed else self._in(run, metric, value)
        which = int(self._flown.failure[row])
        batch_failed = self._flown.reasons.get(one.draw, "")
        if batch_failed or drake_failed:
            never = any(map(math.isinf, self._values[one.draw].values()))
            outcome = _of_failed(batch_failed, drake_failed or never)
        else:
            nominal = np.nan_to_num(self._in(self._nominal, metric, value))
            clearance = study.flights.clearances.get(metric)
            objective = highest(metric) if clearance is None else clearance
            within = may_differ(objective, study.case, value, float(nominal))
            if self._flown.tells(row, metric, study.plan):
                outcome = _of_values(one, value, told, within)
            else:
                outcome = _of_bound(value, told, within)
        return ConfirmedDraw(
            draw=one.draw,
            metric=metric,
            value=value,
            in_drake=told,
            values=self._values[one.draw],
            failure=study.flights.failures[which].name if which >= 0 else "",
            requirement=one.requirement,
            rank=one.rank,
            outcome=outcome,
        )

    def _in(self, run: Run, metric: str, likely: float) -> float:
        """Return what a run in Drake tells of a metric, about which it may be."""
        case, key = self._study.case, (id(run), metric)
        clearance = self._study.flights.clearances.get(metric)
        if clearance is not None:
            if key not in self._clearances:
                self._clearances[key] = measured_in(run, clearance, likely)
            return self._clearances[key]
        if not has_separated(run):
            return math.nan
        if id(run) not in self._metrics:
            names = self._study.plan.metrics
            told = metrics_of_run(run, case.limits_of_pairs, names)
            self._metrics[id(run)] = told
        return self._metrics[id(run)].get(metric, math.nan)


def _of_failed(on_batch: str, in_drake: str | bool) -> Outcome:
    """Return whether a run that failed did so in both engines.

    Args:
        on_batch: why it failed there; empty if it did not.
        in_drake: the same; or whether something never lets go, which Drake flies.
    """
    if on_batch and in_drake:
        return CONFIRMED
    if on_batch:
        return failed(f"on the batch engine alone: {on_batch}")
    return failed(f"in Drake alone: {in_drake}")


def _of_bound(at_least: float, in_drake: float, within: float) -> Outcome:
    """Return whether Drake gives no less than what is said to be so at least.

    Where nothing is, it may tell anything, or nothing.
    """
    if math.isinf(at_least) or in_drake >= at_least - within:
        return CONFIRMED
    return failed(
        f"Drake gives {in_drake:.9g} where the batch engine proves {at_least:.9g} (SI)"
    )


def _of_values(one: Chosen, value: float, in_drake: float, within: float) -> Outcome:
    """Return whether both engines say the same of a draw.

    Of the bound, also whether it is within the limit: a limit that lies between what
    both say decides nothing. NaN of a run whose window does not end.
    """
    if math.isnan(value) and math.isnan(in_drake):
        return CONFIRMED
    same_side = one.is_within(value) == one.is_within(in_drake)
    if abs(in_drake - value) <= within and (same_side or not one.is_bound):
        return CONFIRMED
    return failed(
        f"Drake gives {in_drake:.9g} where the batch engine gives {value:.9g} (SI)"
    )
