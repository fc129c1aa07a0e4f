"""What a reader asks first: is it met, what is the worst, who says so."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from drakesep.analysis.failure_cases import DESIGN
from drakesep.reports.cells import EMPTY, Cell, Row
from drakesep.reports.compliance import (
    MET,
    NO_VERDICT,
    NOT_LOOKED_AT,
    NOT_MET,
    Entry,
    Matrix,
    worst_verdict,
)
from drakesep.reports.studies import Studies, Study
from drakesep.tables.failure_tables import CASE, HELD, margin_share


_NEAREST = 3
"""Requirements that are told of first."""


class Finding(NamedTuple):
    """What one kind of study says."""

    about: str
    verdict: str
    names: Sequence[Cell] = ()
    """Of what is not as it should be."""


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What stands first in a report."""

    verdict: str
    """On everything together."""
    findings: Sequence[Finding]
    nearest: Sequence[Entry]
    """Requirements beyond their limits, or nearest to them, the worst first."""
    contacts: Sequence[Row]
    """Clearances at which parts touch in some draws, of campaign.csv."""
    worst_failure: Row | None
    """The failure case that is worst by a requirement, of failure_cases.csv."""
    searches: Sequence[Row]
    """Of searches.csv."""
    draws: Cell
    """How many launches a campaign has drawn."""
    unfinished: Sequence[Study]
    """Studies that did not come to their end."""

    @property
    def touches_where_met(self) -> bool:
        """Whether parts touch in draws although what is required is met."""
        return any(row.get("verdict") == MET for row in self.contacts)


def summary_of(studies: Studies, matrix: Matrix) -> Summary:
    """Return the summary of some studies.

    Args:
        studies: that are reported.
        matrix: their compliance matrix.
    """
    failures = [r for r in studies.rows("failure_cases.csv") if r.get(CASE) != DESIGN]
    findings = _findings(studies, matrix, failures)
    unfinished = [study for study in studies.all if not study.ended]
    judged = [finding.verdict for finding in findings if finding.about != _CLEARANCE]
    if any(study.kind in ("verify", "campaign") for study in unfinished):
        judged.append(NO_VERDICT)
    told = [one for one in matrix.entries if one.deciding.margin or _is_broken(one)]
    return Summary(
        verdict=worst_verdict(judged),
        findings=findings,
        nearest=sorted(told, key=_nearest_first)[:_NEAREST],
        contacts=[
            row
            for row in studies.rows("campaign.csv")
            if row.get("measured", 0) and row.get("worst", 1.0) <= 0.0
        ],
        worst_failure=_worst_of(failures),
        searches=studies.rows("searches.csv"),
        draws=next((row["runs"] for row in studies.rows("campaign.csv")), EMPTY),
        unfinished=unfinished,
    )


_CLEARANCE = "Clearance in a single run"


def _findings(
    studies: Studies, matrix: Matrix, failures: Sequence[Row]
) -> list[Finding]:
    found = []
    if matrix:
        beyond = matrix.with_verdict(NOT_MET) or [
            entry for entry in matrix.entries if entry.verdict.value != MET
        ]
        names = [entry.asked["requirement"] for entry in beyond]
        found.append(Finding("Requirements on the design", matrix.verdict, names))
    if failures:
        words = [_as_verdict(str(row.get("verdict"))) for row in failures]
        verdict = worst_verdict(words)
        names = [
            row[CASE]
            for row, word in zip(failures, words, strict=True)
            if word == verdict != MET
        ]
        found.append(Finding("Failure cases", verdict, names))
    for study in studies.of("clearance"):
        verdict = study.record.verdict or NO_VERDICT
        found.append(Finding(_CLEARANCE, verdict))
    return found


def _as_verdict(word: str) -> str:
    """Return what the verdict of a failure case says of requirements."""
    if word == HELD:
        return NOT_MET
    return word if word in (MET, NOT_MET, NOT_LOOKED_AT) else NO_VERDICT


def _is_broken(entry: Entry) -> bool:
    return bool(entry.verdict.value == NOT_MET)


def _nearest_first(entry: Entry) -> tuple[bool, float]:
    """Return by what entries are told of: what is broken, then what is nearest to it.

    What is broken by a run that failed may have no margin, or one that is kept.
    """
    share = _margin_share(entry) if entry.deciding.margin else 0.0
    return not _is_broken(entry), share


def _margin_share(entry: Entry) -> float:
    nominal = entry.nominal.value if entry.nominal else 0.0
    decided = entry.deciding
    worst = decided.value.value if decided.value else 0.0
    limit, margin = entry.asked.get("limit"), decided.margin.value
    return margin_share(
        {"limit": limit, "nominal": nominal, "worst": worst, "margin": margin}
    )


def _worst_of(failures: Sequence[Row]) -> Row | None:
    """Return the failure case that is farthest beyond a limit, or nearest to one."""

    def share(row: Row) -> float:
        limit, worst = float(row.get("nearest_limit")), float(row.get("nearest_worst"))
        away = abs(worst - limit) / (abs(limit) or 1.0)
        beyond = row.get("verdict") == NOT_MET or row.get("beyond", 0) > 0
        return -away if beyond else away

    told = [row for row in failures if row["nearest_worst"]]
    return min(told, key=share, default=None)
