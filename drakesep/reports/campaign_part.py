"""A campaign: what share of launches is within limits, and how surely."""

from collections.abc import Sequence
from typing import NamedTuple

from drakesep.reports.cells import EMPTY, Cell, Columns, Row, Table, table_of
from drakesep.reports.compliance import NOT_LOOKED_AT
from drakesep.reports.pictures import Picture
from drakesep.reports.studies import Studies


_SHOWN = 3
"""Parameters that are told of for each metric: those that matter most."""
_VERDICT, _BY_DRAWS = "verdict", "by_campaign"
"""What draws say, in campaign.csv and in answers.csv."""
_SHARES: Columns = {
    "requirement axis pair": "requirement",
    "unit": "unit",
    "sense limit": ("limit", ""),
    "failures": "beyond",
    "allowed": "allowed",
    "share_shown": "share shown",
    "bound_of": "bound of",
    "at_confidence": "at confidence",
    "bound": "bound",
    "worst": "worst draw",
    "measured": "measured",
    _VERDICT: "verdict",
}
_ANSWERS: Columns = {
    "requirement axis pair": "requirement",
    "unit": "unit",
    "sense limit": ("limit", ""),
    "nominal": "nominal",
    "bound": "bound",
    "worst_of_draws": "worst draw",
    "worst_case_found": "worst case found",
    "worst_case_beyond_bound": "how much worse than the bound",
    "missed_draw": "missed draw",
    _BY_DRAWS: "by the draws",
    "by_worst_case": "by the worst case",
    "decided_by": "decided by",
}
_CONFIRMED: Columns = {
    "decides": "decides",
    "draw": "draw",
    "unit": "unit",
    "value": "by the batch engine",
    "in_drake": "in Drake",
    "failure_case": "failure case",
    "status": "status",
}
_STATISTICS: Columns = {
    "metric": "metric",
    "draws": "draws",
    "untold": "untold",
    "mean": "mean",
    "deviation": "deviation",
    "least": "least",
    "low_3_sigma": "low 3 sigma",
    "median": "median",
    "high_3_sigma": "high 3 sigma",
    "greatest": "greatest",
}
_RANKS: Columns = {
    "metric": "metric",
    "parameter": "parameter",
    "rank_correlation": "rank correlation",
    "from": "from, at 95 %",
    "to": "to, at 95 %",
}


_RARE: Columns = {
    "requirement axis pair": "requirement",
    "unit": "unit",
    "limit": "limit",
    "probability": "probability to be beyond",
    "from": "from, at 95 %",
    "to": "to, at 95 %",
    "simulations": "simulations",
    "unreached": "unreached",
    "runs": "runs",
    "untold": "untold",
}


class CampaignPart(NamedTuple):
    """Of the campaign."""

    draws: Cell
    """How many there are; empty: no campaign was flown."""
    failed: Cell
    """Of them, those that failed."""
    shares: Table
    together: bool
    """Whether two limits are counted together."""
    of_every_run: bool
    """Whether something is required of every run."""
    has_verdicts: bool
    """Whether draws say of any requirement that it is met or not."""
    measures: bool
    """Whether clearances are measured, of some draws."""
    failing: Sequence[Row]
    """Requirements whose worst draw is of a failure case."""
    confirmed: Table
    statistics: Table
    ranks: Table
    rare: Table
    """Of a study of rare events."""
    answers: Table
    """Of answers.csv: draws and searches side by side."""
    pictures: Sequence[Picture]


def of(studies: Studies) -> CampaignPart | None:
    """Return what a report says of launches at random; None if none were flown."""
    # JAX comes with it.
    from drakesep.reports.campaign_pictures import campaign_pictures

    rare = studies.rows("rare_events.csv")
    found = [study for study in studies.all if study.has("campaign.csv")]
    if not found and not rare:
        return None
    worst = [r for r in studies.rows("campaign_worst.csv") if r.get("rank") == 1]
    rows = studies.rows("campaign.csv")
    return CampaignPart(
        draws=rows[0]["runs"] if rows else EMPTY,
        failed=rows[0]["failed"] if rows else EMPTY,
        shares=_judged(rows, _SHARES, _VERDICT),
        together=any(row.get("sides") == "two" for row in rows),
        of_every_run=any(not row["share"] for row in rows),
        has_verdicts=_is_judged(rows, _VERDICT),
        measures=any(row["measured"] for row in rows),
        failing=[row for row in rows if row["worst_failure_case"]],
        confirmed=table_of(worst, _CONFIRMED),
        statistics=table_of(studies.rows("campaign_statistics.csv"), _STATISTICS),
        ranks=table_of(_largest(studies.rows("campaign_sensitivities.csv")), _RANKS),
        rare=table_of(rare, _RARE),
        answers=_judged(studies.rows("answers.csv"), _ANSWERS, _BY_DRAWS),
        pictures=[*campaign_pictures(found[0])] if found else [],
    )


def _judged(rows: Sequence[Row], columns: Columns, verdict: str) -> Table:
    """Return a table without the verdict of the draws, where they can give none.

    What every run must keep they can disprove alone: a column of "not looked at" would
    be read as if nobody had looked.
    """
    is_judged = _is_judged(rows, verdict)
    told = {
        name: said for name, said in columns.items() if is_judged or name != verdict
    }
    return table_of(rows, told)


def _is_judged(rows: Sequence[Row], verdict: str) -> bool:
    """Return whether a verdict says something; a bound that is missing does, too."""
    return any(
        row["share"] or not row["bound"] or row.get(verdict) != NOT_LOOKED_AT
        for row in rows
    )


def _largest(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of the parameters that matter most for each metric."""
    by_metric: dict[object, list[Row]] = {}
    for row in rows:
        if row["rank_correlation"]:
            by_metric.setdefault(row.get("metric"), []).append(row)
    return [
        row
        for mine in by_metric.values()
        for row in sorted(mine, key=lambda r: -abs(r.get("rank_correlation")))[:_SHOWN]
    ]
