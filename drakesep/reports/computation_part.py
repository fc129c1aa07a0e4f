"""How the answers were computed: engines, searches, accuracy, and confirmations."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from drakesep.reports.cells import Cell, Columns, Heading, Table, table_of
from drakesep.reports.studies import Studies, Study


_SEARCHES: Columns = {
    "search": "search",
    "what": "what it looked at",
    "points": "runs",
    "failed": "of them failed",
    "first_failure": "why the first failed",
    "unphysical_share_of_tolerances": "share of the tolerances that no body can have",
}


class ComputationPart(NamedTuple):
    """Of all studies."""

    searches: Table
    plans: Sequence[tuple[Study, Table]]
    drawn: bool
    """Whether a campaign was flown."""


def of(studies: Studies) -> ComputationPart:
    """Return how the answers of some studies were computed."""
    return ComputationPart(
        table_of(studies.rows("searches.csv"), _SEARCHES),
        [(study, _plan(study)) for study in studies.all if study.record.plan],
        any(study.has("campaign.csv") for study in studies.all),
    )


def _plan(study: Study) -> Table:
    plan: Mapping[str, object] = study.record.plan
    cells = []
    for key, value in plan.items():
        cell = study.fact("plan", key)
        if isinstance(value, list | tuple):
            cell = Cell(", ".join(map(str, value)), cell.place)
        elif isinstance(value, bool):
            cell = Cell("yes" if value else "no", cell.place)
        cells.append([Cell(key), cell])
    return Table([Heading("setting"), Heading("value")], cells)
