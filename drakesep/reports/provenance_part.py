"""Where a report's numbers come from, and the commands that make them again."""

from collections.abc import Sequence
from typing import NamedTuple

from drakesep.reports.cells import Cell, Heading, Table
from drakesep.reports.studies import Studies, Study


class Provenance(NamedTuple):
    """Of all studies."""

    studies: Sequence[Study]
    facts: Table
    versions: Table
    named_files: Table


_FACTS = {
    ("study",): "study",
    ("ended",): "ended",
    ("verdict",): "verdict",
    ("message",): "why it failed",
    ("begun",): "begun (UTC)",
    ("seconds",): "took (s)",
    ("seed",): "seed",
    ("commit",): "commit of drakesep",
    ("case", "source"): "case",
    ("case", "sha256"): "SHA-256 of the case file",
}
"""Of a study, by their keys in ``study.json``."""


def of(studies: Studies) -> Provenance:
    """Return where the numbers of some studies come from."""
    several = studies.all
    names = [Heading(study.tag) for study in several]
    facts = _by_rows(
        [(said, [s.fact(*keys) for s in several]) for keys, said in _FACTS.items()]
    )
    libraries = dict.fromkeys(k for s in several for k in s.record.versions)
    versions = _by_rows(
        [(k, [s.fact("versions", k) for s in several]) for k in libraries]
    )
    hashed = dict.fromkeys(k for s in several for k in s.record.named_files)
    named = _by_rows([(k, [s.fact("named_files", k) for s in several]) for k in hashed])
    tables = [
        Table([Heading(first), *names], rows)
        for first, rows in (("", facts), ("library", versions), ("file", named))
    ]
    return Provenance(several, *tables)


def _by_rows(rows: Sequence[tuple[str, list[Cell]]]) -> list[list[Cell]]:
    """Return rows that begin with words, but those in which there is nothing."""
    return [[Cell(said), *cells] for said, cells in rows if any(cells)]
