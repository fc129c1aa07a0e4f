"""Results folders of the past, as a list: what was asked, and how it ended."""

from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from drakesep.systems.checks import InputError


_DEEP = 3
"""Folders below that of the results, in which those of studies may stand."""
_MOST = 300
"""That are listed; the newest."""


class Past(NamedTuple):
    """A study of the past."""

    folder: Path
    name: str
    """Of its folder, below that of all results."""
    case: str
    study: str
    begun: str
    """Local time."""
    seconds: float
    ended: str
    verdict: str
    unreadable: str
    """Why its `study.json` cannot be read; empty if it can."""


def past_results(root: Path) -> list[Past]:
    """Return the studies below a folder, the newest first.

    Args:
        root: folder of all results.
    """
    from drakesep.results.catalogue.names import STUDY

    files = [
        file
        for depth in range(1, _DEEP + 1)
        for file in root.glob("/".join(["*"] * depth) + f"/{STUDY}")
    ]
    newest = sorted(files, key=lambda file: file.stat().st_mtime_ns, reverse=True)
    return [_past(file.parent, root) for file in newest[:_MOST]]


def _past(folder: Path, root: Path) -> Past:
    from drakesep.results.study_record import StudyRecord

    name = str(folder.relative_to(root))
    try:
        record = StudyRecord.read(folder)
        assert record is not None
    except (InputError, AssertionError) as error:
        return Past(folder, name, "", "", "", 0.0, "", "", str(error) or "gone")
    begun = datetime.fromisoformat(record.begun).astimezone()
    return Past(
        folder=folder,
        name=name,
        case=str(record.case["name"]),
        study=record.study,
        begun=begun.strftime("%Y-%m-%d %H:%M:%S"),
        seconds=record.seconds,
        ended=record.ended.value,
        verdict=record.verdict or "",
        unreadable="",
    )
