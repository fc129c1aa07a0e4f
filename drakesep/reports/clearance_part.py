"""How near parts come in single runs, with the animation that shows it."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from drakesep.reports.cells import Columns, Table, table_of
from drakesep.reports.pictures import Picture, clearance_picture
from drakesep.reports.studies import Studies, Study


_NEAREST = 20
"""Pairs of parts that are told of."""
_SUMMARY: Columns = {
    "first": "part",
    "first_body": "of body",
    "second": "to part",
    "second_body": "of body",
    "clearance_mm": ("smallest distance", "mm"),
    "time_s": ("when", "s"),
    "separation_mm": ("at separation", "mm"),
    "contact_time_s": ("first contact", "s"),
    "closing_speed_m_s": ("closing speed", "m/s"),
    "status": "status",
}


class Clearances(NamedTuple):
    """Of one study."""

    study: Study
    summary: Table
    more: bool
    """Whether there are pairs that come less near than those shown."""
    picture: Picture


class ClearancePart(NamedTuple):
    """Of all."""

    each: Sequence[Clearances]
    animations: Sequence[tuple[str, str]]
    """Where each stands from the page, and of which folder it is."""


def of(studies: Studies, page: Path) -> ClearancePart | None:
    """Return what a report says of clearances; None if there is nothing.

    Args:
        studies: that are reported.
        page: that the report is written into.
    """
    each = []
    for study in studies.all:
        rows = study.rows("clearance_summary.csv")
        if rows:
            summary = table_of(rows[:_NEAREST], _SUMMARY)
            more = len(rows) > _NEAREST
            each.append(Clearances(study, summary, more, clearance_picture(study)))
    animations = [
        (os.path.relpath(file, page.parent), study.tag)
        for study in studies.all
        if (file := _animation(study)).exists() and file != page
    ]
    return ClearancePart(each, animations) if each or animations else None


def _animation(study: Study) -> Path:
    """Return where `animate` puts the animation of a folder."""
    folder = study.results.folder
    return folder.with_name(f"{folder.name}.html")
