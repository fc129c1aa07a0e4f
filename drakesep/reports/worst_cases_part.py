"""Worst cases with the evidence for them, and which of them decide requirements."""

from collections.abc import Sequence
from typing import NamedTuple

from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.reports.cells import Cell, Columns, Heading, Row, Table, table_of
from drakesep.reports.studies import Studies, Study
from drakesep.tables.roles import Worst, label_of


_ACROSS = 20
"""Worst cases beside each other in a table of where they are, by their letters."""
_FOUND: Columns = {
    "objective": "worst case",
    "unit": "unit",
    "worst": "by the searches",
    "in_drake": "in Drake",
    "difference": "difference",
    "beaten_by": "beaten by",
    "found_by": "found by",
    "flown_by": "searched on",
}
_BELIEVED: Columns = {
    "objective": "worst case",
    "starts": "ascents",
    "ended_there": "of them ended there",
    "unfinished": "unfinished",
    "at_bounds": "parameters at a bound",
    "active_constraints": "other constraints",
    "optimality_residual": "slope that is left",
    "random_samples": "random samples",
    "failed_samples": "of them failed",
    "fraction_beyond_at_95_percent": "share that may be worse, at 95 %",
}
_TOLD = {"about": "about", "remark": "remark", "run": "first in run"}


class WorstCasesPart(NamedTuple):
    """Of the studies that searched."""

    found: Table
    believed: Table
    points: Sequence[Table]
    remarks: Table


def of(studies: Studies) -> WorstCasesPart | None:
    """Return what a report says of worst cases; None if none were searched."""
    searched = [study for study in studies.all if study.has("evidence.csv")]
    if not searched:
        return None
    rows = [row for study in searched for row in study.rows("evidence.csv")]
    return WorstCasesPart(
        found=_lettered(table_of(rows, _FOUND)),
        believed=_lettered(table_of(rows, _BELIEVED)),
        points=[table for study in searched for table in _points(study, rows)],
        remarks=table_of(studies.rows("remarks.csv"), _TOLD),
    )


def _points(study: Study, evidence: Sequence[Row]) -> list[Table]:
    rows = study.rows("worst_points.csv")
    there = rows[0].values if rows else {}
    names = [str(row.get("objective")) for row in evidence]
    rank = {name: k for k, name in enumerate(names)}
    names = [name for name in names if name in there]
    tables = []
    for k in range(0, len(names), _ACROSS):
        mine = names[k : k + _ACROSS]
        letters = [Heading(_letter(rank[name])) for name in mine]
        headings = [Heading("parameter"), *letters]
        cells = [[row["parameter"], *(row[name] for name in mine)] for row in rows]
        tables.append(Table(headings, cells))
    return tables


def _lettered(table: Table) -> Table:
    """Return a table whose rows begin with letters, by which others name them."""
    rows = [[Cell(_letter(k)), *row] for k, row in enumerate(table.rows)]
    return Table([Heading(""), *table.headings], rows)


def _letter(k: int) -> str:
    """Return a, b, ..., z, aa, ab, ... of 0, 1, ..."""
    before = _letter(k // 26 - 1) if k >= 26 else ""
    return before + chr(ord("a") + k % 26)


def deciding(study: Study) -> list[str]:
    """Return the objectives whose worst cases decide requirements, and the paper's."""
    runs = {row.get("which_run") for row in study.rows("requirements.csv")}
    names = [str(row.get("objective")) for row in study.rows("evidence.csv")]
    chosen = [n for n in names if label_of(Worst(n)) in runs or n in OBJECTIVES]
    return chosen or names
