"""What a reader asks first: is it met, what is the worst, who says so."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from drakesep.analysis.failure_cases import DESIGN
from drakesep.analysis.metrics.metric import Kind
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement
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
from drakesep.tables.requirement_tables import limit_columns
from drakesep.units import unit_of


_NEAREST = 3
"""Requirements that are told of first."""


class Finding(NamedTuple):
    """What one kind of study says."""

    about: str
    verdict: str
    asked: Sequence[Row] = ()
    """Requirements that are not as they should be."""
    names: Sequence[Cell] = ()
    """Of failure cases with that verdict, if it is not good."""


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What stands first in a report."""

    verdict: str
    """On everything together."""
    findings: Sequence[Finding]
    nearest: Sequence[Entry]
    """Requirements beyond their limits, or nearest to them, the worst first."""
    nominal_beyond: Sequence[Entry]
    """Requirements that the nominal run is beyond."""
    contacts: Sequence[Row]
    """Clearances at which parts touch in some draws, of campaign.csv."""
    worst_failure: Row | None
    """What is worst by a requirement in a failure case, of failure_requirements.csv."""
    failure_contacts: Sequence[Row]
    """Clearances at which parts touch in failure cases, likewise."""
    searches: Sequence[Row]
    """Of searches.csv."""
    unsampled: Sequence[Entry]
    """Requirements whose worst found no random samples and no draws speak for."""
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
    failures = _of_failures(studies.rows("failure_cases.csv"))
    by_failure = _of_failures(studies.rows("failure_requirements.csv"))
    unfinished = [study for study in studies.all if not study.ended]
    judged = [_as_verdict(str(row.get("verdict"))) for row in failures]
    if matrix:
        judged.append(matrix.verdict)
    if any(study.kind in ("verify", "campaign") for study in unfinished):
        judged.append(NO_VERDICT)
    told = [one for one in matrix.entries if one.deciding.margin or _is_broken(one)]
    return Summary(
        verdict=worst_verdict(judged),
        findings=_findings(studies, matrix, failures),
        nearest=sorted(told, key=_nearest_first)[:_NEAREST],
        nominal_beyond=[one for one in matrix.entries if one.nominal_is_beyond],
        contacts=[
            row
            for row in studies.rows("campaign.csv")
            if row.get("measured", 0) and row.get("worst", 1.0) <= 0.0
        ],
        worst_failure=_worst_of(by_failure),
        failure_contacts=_touching(by_failure, studies.case.requirements),
        searches=studies.rows("searches.csv"),
        unsampled=[one for one in matrix.entries if one.is_unsampled],
        draws=next((row["runs"] for row in studies.rows("campaign.csv")), EMPTY),
        unfinished=unfinished,
    )


def _of_failures(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if row.get(CASE) != DESIGN]


def _findings(
    studies: Studies, matrix: Matrix, failures: Sequence[Row]
) -> list[Finding]:
    found = []
    if matrix:
        beyond = matrix.with_verdict(NOT_MET) or [
            entry for entry in matrix.entries if entry.verdict.value != MET
        ]
        asked = [entry.asked for entry in beyond]
        found.append(Finding("Requirements on the design", matrix.verdict, asked))
    found += _failure_findings(failures)
    for study in studies.of("clearance"):
        verdict = study.record.verdict or NO_VERDICT
        found.append(Finding("Clearance in a single run", verdict))
    return found


def _failure_findings(failures: Sequence[Row]) -> Iterator[Finding]:
    """Yield each verdict on failure cases that is not good; if there is none, the good.

    Where a body stays, which is worse than any limit, stands first.
    """
    named: dict[str, list[Cell]] = {}
    for row in failures:
        named.setdefault(str(row.get("verdict")), []).append(row[CASE])
    not_good = sorted(named.keys() - {MET}, key=lambda word: (word != HELD, word))
    for word in not_good:
        yield Finding("Failure cases", word, names=named[word])
    if named and not not_good:
        yield Finding("Failure cases", MET)


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
    decided = entry.deciding
    return _share(
        entry.asked["limit"], entry.nominal, decided.value, decided.margin.value
    )


def _share(limit: Cell, nominal: Cell, worst: Cell, margin: float) -> float:
    """Return a margin as a share of its limit, as tables of failure cases have it."""
    told = {"limit": limit, "nominal": nominal, "worst": worst, "margin": Cell(margin)}
    return margin_share({name: x.value if x else 0.0 for name, x in told.items()})


def _worst_of(rows: Sequence[Row]) -> Row | None:
    """Return what is farthest beyond a limit in a failure case, or nearest to one."""

    def share(row: Row) -> float:
        return _share(row["limit"], row["nominal"], row["worst"], row.get("margin"))

    return min((row for row in rows if row["margin"]), key=share, default=None)


def _touching(rows: Sequence[Row], asked: Sequence[Requirement]) -> list[Row]:
    """Return the rows of clearances at which parts touch."""
    clearances = {
        limit_columns(one, unit_of(one.metric))["requirement"]
        for one in asked
        if (found := find_metric(one.metric)) and found[0].kind is Kind.CLEARANCE
    }
    return [
        row
        for row in rows
        if row.get("requirement") in clearances and row.get("worst", 1.0) <= 0.0
    ]
