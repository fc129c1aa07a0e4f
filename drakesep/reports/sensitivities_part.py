"""What each tolerance does, and how far each alone may grow."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from drakesep.reports.cells import Columns, Row, Table, table_of
from drakesep.reports.pictures import Picture, tornado_pictures
from drakesep.reports.studies import Studies
from drakesep.reports.worst_cases_part import deciding


_SHOWN = 3
"""Parameters that are told of for each worst case: those that matter most there."""
_SLOPES: Columns = {
    "objective": "worst case",
    "unit": "unit",
    "parameter": "parameter",
    "minus": "below by",
    "plus": "above by",
    "downward_at_worst": "change if lowered by that",
    "upward_at_worst": "change if raised by that",
    "at_worst": "at worst",
}
_GROWTH: Columns = {
    "requirement axis pair": "requirement",
    "parameter": "parameter",
    "minus": "below by",
    "plus": "above by",
    "factor": "factor",
    "violated_minus": "violated below by",
    "violated_plus": "violated above by",
}


_SHARES: Columns = {
    "metric": "metric",
    "parameter": "parameter",
    "first": "share by itself",
    "first_error": "give or take, at 95 %",
    "total": "share with others",
    "total_error": "give or take, at 95 %",
}


class SensitivitiesPart(NamedTuple):
    """Of the studies that searched."""

    slopes: Table
    growth: Table
    shares: Table
    """Of the variance of metrics."""
    pictures: Sequence[Picture]


def of(studies: Studies) -> SensitivitiesPart | None:
    """Return what a report says of sensitivities; None if there is nothing."""
    found = [study for study in studies.all if study.has("sensitivities.csv")]
    growth = [r for r in studies.rows("tolerances.csv") if _violates(r)]
    shares = _largest(studies.rows("sobol_indices.csv"))
    if not found and not growth and not shares:
        return None
    slopes, pictures = [], []
    for study in found:
        names = deciding(study)
        pictures += list(tornado_pictures(study, names))
        rows = study.rows("sensitivities.csv")
        for name in names:
            slopes += [r for r in rows if r.get("objective") == name][:_SHOWN]
    return SensitivitiesPart(
        slopes=table_of(slopes, _SLOPES),
        growth=table_of(growth, _GROWTH),
        shares=table_of(shares, _SHARES),
        pictures=pictures,
    )


def _largest(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of the parameters from which most comes of each metric."""
    by_metric: dict[object, list[Row]] = {}
    for row in rows:
        by_metric.setdefault(row.get("metric"), []).append(row)
    return [
        row
        for mine in by_metric.values()
        for row in sorted(mine, key=lambda r: -float(r.get("total", 0.0)))[:_SHOWN]
    ]


def _violates(row: Row) -> bool:
    factor = row.get("factor")
    return factor is not None and 0.0 < factor < math.inf
