"""Evidence for credibility by the factors of NASA-STD-7009B, from what was run.

How far the evidence goes is for people to judge: level and signature are left blank.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from drakesep.reports.cells import Cell, Row
from drakesep.reports.studies import Studies, Study


class Credibility(NamedTuple):
    """What speaks for the factors; the template says for which."""

    named_files: Sequence[tuple[str, Cell]]
    """Meshes and models, with their hashes."""
    largest_difference: Row | None
    """Of evidence.csv: the worst case that Drake tells most otherwise."""
    unconfirmed: Sequence[Cell]
    """How draws ended in Drake that are not confirmed there."""
    confirms: bool
    """Whether draws of a campaign were flown in Drake."""
    published: Sequence[Row]
    """Of comparison.csv: what others have published."""
    searches: Sequence[Row]
    campaign: Row | None
    """The first row of campaign.csv."""
    sensitivities: bool
    least_growth: Row | None
    """Of requirements.csv: that which is violated first as all tolerances grow."""
    failures: bool
    dispersed: bool
    unfinished: Sequence[Study]


def of(studies: Studies) -> Credibility:
    """Return what some studies say for the factors."""
    confirmed = studies.rows("campaign_worst.csv")
    campaign = studies.rows("campaign.csv")
    return Credibility(
        named_files=[
            (name, studies.first.fact("named_files", name))
            for name in studies.first.record.named_files
        ],
        largest_difference=_largest_difference(studies.rows("evidence.csv")),
        unconfirmed=[r["status"] for r in confirmed if r.get("status") != "confirmed"],
        confirms=bool(confirmed),
        published=[r for r in studies.rows("comparison.csv") if r["published"]],
        searches=studies.rows("searches.csv"),
        campaign=campaign[0] if campaign else None,
        sensitivities=bool(studies.rows("sensitivities.csv")),
        least_growth=_least_growth(studies.rows("requirements.csv")),
        failures=bool(studies.rows("failure_cases.csv")),
        dispersed=bool(studies.case.tolerance_set.box.dispersions),
        unfinished=[study for study in studies.all if not study.ended],
    )


def _largest_difference(rows: Sequence[Row]) -> Row | None:
    def share(row: Row) -> float:
        difference, worst = float(row.get("difference")), float(row.get("worst", 0.0))
        return abs(difference) / (abs(worst) or 1.0)

    return max((r for r in rows if r["difference"]), key=share, default=None)


def _least_growth(rows: Sequence[Row]) -> Row | None:
    finite = [r for r in rows if math.isfinite(r.get("growth_factor", math.inf))]
    return min(finite, key=lambda r: float(r.get("growth_factor")), default=None)
