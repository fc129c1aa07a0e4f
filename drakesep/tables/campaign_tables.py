"""Tables of campaigns: what share of launches meets each requirement, and the draws."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.flights import CampaignFlights, FlownDraws
from drakesep.analysis.campaigns.gathering import KeptDraws
from drakesep.analysis.campaigns.plan import CampaignPlan
from drakesep.analysis.campaigns.screens import DrawnClearances
from drakesep.analysis.campaigns.sensitivity import rank_correlations
from drakesep.analysis.campaigns.shares import ShareFinding
from drakesep.analysis.campaigns.statistics import Estimate, Summary, quantile_within
from drakesep.analysis.campaigns.tallies import TalliedDraws
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.arrays import Array
from drakesep.systems.model.parameters import parameters
from drakesep.tables.columns import in_units
from drakesep.tables.requirement_tables import identity_columns, limit_columns
from drakesep.tables.roles import COMPLETED, Outcome, failed
from drakesep.units import Unit, unit_of, with_unit


def campaign_table(
    findings: Sequence[ShareFinding],
    failed: int,
    bodies: Sequence[str],
    found: Mapping[Requirement, float],
    failure_cases: Mapping[Requirement, str],
) -> pd.DataFrame:
    """Return a row for each requirement and axis: the share that is shown.

    Args:
        findings: of each requirement.
        failed: runs that did.
        bodies: names of those that leave; that of the first pair is the first.
        found: the worst case of each requirement, in SI, if worst cases were searched:
            else there is no column of it.
        failure_cases: of which the worst draws are, where something fails in them.
    """
    frame = pd.DataFrame(
        [_finding(one, failed, bodies, found, failure_cases) for one in findings]
    )
    return frame.astype({name: "Int64" for name in _WHOLE if name in frame})


_WHOLE = ("failures", "allowed", "worst_draw", "deciding_draw", "measured", "rank")
"""Columns of whole numbers that may be empty."""


def _finding(
    finding: ShareFinding,
    failed: int,
    bodies: Sequence[str],
    found: Mapping[Requirement, float],
    failure_cases: Mapping[Requirement, str],
) -> dict[str, object]:
    requirement, size = finding.requirement, finding.size
    unit = unit_of(requirement.metric)
    answer = finding.answer
    tells = answer is not None and bool(finding.ranked)
    worst_case = found.get(requirement, math.nan)
    return {
        **limit_columns(requirement, unit),
        "runs": size.runs,
        "failures": finding.beyond,
        "allowed": size.allowed if requirement.statistical else 0,
        "share_shown": math.nan if answer is None else answer.share_shown,
        "share_at_most": math.nan if answer is None else answer.share_at_most,
        "bound_of": size.share,
        "at_confidence": size.confidence,
        "bound": unit.from_si(finding.bound),
        "margin": unit.from_si(finding.margin),
        "worst": unit.from_si(finding.worst),
        "worst_margin": unit.from_si(requirement.margin(finding.worst)),
        "worst_draw": finding.draw_of_rank(1) if tells else None,
        "worst_failure_case": failure_cases.get(requirement, ""),
        **({"worst_case_found": unit.from_si(worst_case)} if found else {}),
        "deciding_draw": None if finding.alone is None else finding.alone.deciding_draw,
        "failed": failed,
        "measured": finding.measured,
        "consumers_risk": size.consumers_risk,
        "share_that_passes": size.share_that_passes(size.confidence),
        "verdict": finding.verdict.value,
        **identity_columns(requirement, bodies),
    }


@dataclass(frozen=True, kw_only=True)
class ConfirmedDraw:
    """A draw flown in Drake: what both engines say of a metric."""

    draw: int
    """Its number."""
    metric: str
    """That is compared."""
    value: float
    """By the batch engine, in SI; NaN of a run that failed."""
    in_drake: float
    """NaN of a run that failed."""
    values: Mapping[str, float]
    """What it changes of the separation, in SI, by name."""
    failure: str = ""
    """Name of its failure case."""
    requirement: Requirement | None = None
    """Whose verdict it decides; None: it was drawn at random."""
    rank: int | None = None
    """1: the worst of all draws; None: it was drawn at random."""
    outcome: Outcome = COMPLETED
    """Whether both say the same."""


def confirmed_table(
    confirmed: Sequence[ConfirmedDraw], names: Sequence[str], case: AnalysisCase
) -> pd.DataFrame:
    """Return a row for each draw that was flown in Drake, and metric.

    Args:
        confirmed: the draws.
        names: of the parameters that vary.
        case: with their nominal values.
    """
    nominal = parameters(case.separation)
    rows = []
    for one in confirmed:
        unit = unit_of(one.metric)
        quantity = with_unit(one.metric)
        rows.append(
            {
                "quantity": quantity,
                "decides": "" if one.requirement is None else _limit(one.requirement),
                "rank": one.rank,
                "draw": one.draw,
                "unit": unit.symbol,
                "value": unit.from_si(one.value),
                "in_drake": unit.from_si(one.in_drake),
                "failure_case": one.failure,
                "status": str(one.outcome),
                **in_units({n: one.values.get(n, nominal[n]) for n in names}),
            }
        )
    frame = pd.DataFrame(rows)
    return frame.astype({name: "Int64" for name in _WHOLE if name in frame})


def _limit(requirement: Requirement) -> str:
    """Return a limit in words."""
    limit = unit_of(requirement.metric).from_si(requirement.limit)
    return f"{with_unit(requirement.metric)} {requirement.sense} {limit:g}"


def draws_table(flights: CampaignFlights, flown: FlownDraws) -> pd.DataFrame:
    """Return a row for each draw: what it varies, and what came of it.

    In a failure case, what has failed has its failed value.

    Args:
        flights: that know what was drawn.
        flown: what came of it.
    """
    plan, names, failures = flights.plan, flights.names, flights.failures
    nominal = parameters(plan.case.separation)
    drawn = flights.drawn(range(flown.first, flown.first + len(flown)))
    also = [name for one in failures for name in one.values if name not in names]
    columns = {name: drawn.values[:, i].copy() for i, name in enumerate(names)}
    for name in dict.fromkeys(also):
        columns[name] = np.full(len(flown), nominal[name])
    for k, failure in enumerate(failures):
        for name, value in failure.values.items():
            columns[name][flown.failure == k] = value
    labels = np.array(["", *(one.name for one in failures)], dtype=object)
    status = np.full(len(flown), str(COMPLETED), dtype=object)
    for i, why in flown.reasons.items():
        status[i - flown.first] = str(failed(why))
    return pd.DataFrame(
        {
            "draw": np.arange(flown.first, flown.first + len(flown)),
            "failure_case": labels[flown.failure + 1],
            "status": status,
            **{with_unit(n): x * unit_of(n).per_si for n, x in columns.items()},
            **{
                with_unit(name): flown.metrics[:, i] * unit_of(name).per_si
                for i, name in enumerate(plan.metrics)
            },
            **_of_clearances(plan, flown.clearances),
        }
    )


def _of_clearances(
    plan: CampaignPlan, found: DrawnClearances | None
) -> dict[str, Array]:
    """Return columns of clearances: of all draws at least so much, of some measured."""
    columns: dict[str, Array] = {}
    if found is None:
        return columns
    for i, name in enumerate(plan.clearances):
        per_si, column = unit_of(name).per_si, with_unit(name)
        at_least = found.at_least[:, i] * per_si
        columns[column] = np.where(found.measured[:, i], at_least, np.nan)
        columns[f"at_least_{column}"] = at_least
    return columns


def statistics_table(plan: CampaignPlan, flown: KeptDraws) -> pd.DataFrame:
    """Return a row for each metric: mean, deviation, and quantiles with intervals.

    Runs that failed are left out, and counted. Quantiles are draws; where no rows are
    kept, they are as exact as histograms.

    Args:
        plan: of the campaign.
        flown: what is kept of all draws.
    """
    if isinstance(flown, FlownDraws):
        columns = [values[np.isfinite(values)] for values in flown.metrics.T]
        summaries = [Summary.of(values, (0.0, 1.0)) for values in flown.metrics.T]
        return pd.DataFrame(
            _statistics(name, one, partial(quantile_within, told))
            for name, one, told in zip(plan.metrics, summaries, columns, strict=True)
        )
    return pd.DataFrame(
        _statistics(name, one, one.quantile_within)
        for name, one in zip(plan.metrics, flown.summaries, strict=True)
    )


def _statistics(
    name: str, summary: Summary, quantile: Callable[[float, float], Estimate]
) -> dict[str, object]:
    """Return a row of a metric.

    Args:
        name: of the metric.
        summary: of the draws.
        quantile: tells that of a share, at a confidence.
    """
    unit, told = unit_of(name), summary.told
    nothing = Estimate(math.nan, math.nan, math.nan)
    row: dict[str, object] = {
        "metric": with_unit(name),
        "unit": unit.symbol,
        "draws": told,
        "untold": summary.untold,
        **interval_columns("mean", summary.mean_within(INTERVALS), unit),
        "deviation": unit.from_si(summary.deviation),
        "least": unit.from_si(summary.least if told else math.nan),
        "greatest": unit.from_si(summary.greatest if told else math.nan),
    }
    for label, share in QUANTILES.items():
        found = quantile(share, INTERVALS) if told else nothing
        row |= interval_columns(label, found, unit)
    return row


def histograms_table(plan: CampaignPlan, flown: TalliedDraws) -> pd.DataFrame:
    """Return a row for each metric and bin: how many draws lie in it.

    Args:
        plan: of the campaign.
        flown: what is kept of all draws.
    """
    frames = []
    for name, summary in zip(plan.metrics, flown.summaries, strict=True):
        unit, edges = unit_of(name), np.array(summary.histogram.edges)
        ends = unit.from_si(1.0) * np.array([-math.inf, *edges, math.inf])
        frames.append(
            pd.DataFrame(
                {
                    "metric": with_unit(name),
                    "unit": unit.symbol,
                    "from": ends[:-1],
                    "below": ends[1:],
                    "draws": summary.histogram.counts,
                }
            )
        )
    return pd.concat(frames, ignore_index=True)


QUANTILES = {"low_3_sigma": 0.00135, "median": 0.5, "high_3_sigma": 0.99865}
"""Shares of draws that are below, by the names of columns."""
INTERVALS = 0.95
"""Confidence of intervals of means, quantiles and correlations."""


def interval_columns(name: str, estimate: Estimate, unit: Unit) -> dict[str, object]:
    """Return a number and its interval, in a unit, by the names of columns."""
    value, low, high = map(unit.from_si, estimate)
    return {name: value, f"{name}_from": low, f"{name}_to": high}


def sensitivities_table(flights: CampaignFlights, flown: KeptDraws) -> pd.DataFrame:
    """Return a row for each metric and parameter: their rank correlation.

    Args:
        flights: that know what was drawn, and fly it again where no rows are kept.
        flown: what is kept of all draws.
    """
    first = np.arange(min(len(flown), _CORRELATED), dtype=np.int64)
    rows = flown if isinstance(flown, FlownDraws) else flights.fly(first)
    values, metrics = flights.drawn(first).values, rows.metrics[: len(first)]
    found = rank_correlations(values, metrics, INTERVALS)
    return pd.DataFrame(
        {
            "metric": with_unit(metric),
            "parameter": with_unit(parameter),
            "rank_correlation": found.value[i, j],
            "from": found.low[i, j],
            "to": found.high[i, j],
        }
        for j, metric in enumerate(flights.plan.metrics)
        for i, parameter in enumerate(flights.names)
    )


_CORRELATED = 100_000
"""Draws of which correlations are told at most: they are within 0.01 by these."""
