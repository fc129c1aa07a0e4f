"""Failure cases side by side with the design."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from drakesep.reports.cells import (
    BEYOND,
    EMPTY,
    Cell,
    Columns,
    Heading,
    Row,
    Table,
    table_of,
)
from drakesep.reports.compliance import NOT_MET
from drakesep.reports.pictures import Picture, failure_pictures
from drakesep.reports.studies import Studies
from drakesep.tables.failure_tables import CASE


_ACROSS = 5
"""Requirements beside each other in a table."""
_OUTCOMES: Columns = {
    CASE: "failure case",
    "changed": "what has failed",
    "verdict": "verdict",
    "not_met": "limits not met",
    "beyond": "worst beyond",
    "nearest_requirement nearest_axis nearest_pair": "nearest requirement",
    "nearest_limit": "its limit",
    "nearest_worst": "worst",
    "nearest_unit": "unit",
    "joint_force_N": ("joint force", "N"),
    "joint_torque_N_m": ("joint torque", "N m"),
}


class FailuresPart(NamedTuple):
    """Of the study that verified them."""

    outcomes: Table
    has_shares: bool
    """Whether something is required of a share of launches."""
    by_requirement: Sequence[Table]
    pictures: Sequence[Picture]


def of(studies: Studies) -> FailuresPart | None:
    """Return what a report says of failure cases; None if none were verified."""
    found = [s for s in studies.all if s.has("failure_requirements.csv")]
    if not found:
        return None
    [study] = found
    rows = study.rows("failure_requirements.csv")
    return FailuresPart(
        has_shares=any(row["share"] for row in rows),
        outcomes=table_of(study.rows("failure_cases.csv"), _OUTCOMES),
        by_requirement=_by_requirement(rows),
        pictures=list(failure_pictures(study)),
    )


def _by_requirement(rows: Sequence[Row]) -> list[Table]:
    """Return the worst by each requirement, a row for the design and each case."""
    names = ("requirement", "axis", "pair", "sense", "limit", "unit", "id")
    columns: dict[tuple[object, ...], dict[str, Row]] = {}
    cases: dict[str, Cell] = {}
    for row in rows:
        key = tuple(row.get(name, "") for name in names)
        case = str(row.get(CASE))
        cases.setdefault(case, row[CASE])
        columns.setdefault(key, {})[case] = row
    tables = []
    keys = list(columns)
    for k in range(0, len(keys), _ACROSS):
        mine = keys[k : k + _ACROSS]
        headings = [Heading("failure case"), *(_heading(columns[key]) for key in mine)]
        cells = [
            [cell, *(_worst(columns[key].get(case)) for key in mine)]
            for case, cell in cases.items()
        ]
        tables.append(Table(headings, cells))
    return tables


def _heading(column: dict[str, Row]) -> Heading:
    row = next(iter(column.values()))
    whose = [row[n] for n in ("requirement", "axis", "pair") if row[n]]
    cells = [*whose, row["sense"], row["limit"]]
    return Heading("", str(row.get("unit", "")), is_number=True, cells=cells)


def _worst(row: Row | None) -> Cell:
    if row is None:
        return EMPTY
    beyond = row.get("verdict") == NOT_MET or row.get("margin", 0.0) < 0.0
    worst = row["worst"].told_from(row["limit"])
    return replace(worst, kind=BEYOND) if beyond else worst
