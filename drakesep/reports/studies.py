"""The folders that a report is made of: one case, and what was studied of it."""

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.reports.cells import EMPTY, Cell, Row, input_cell
from drakesep.results.catalogue.names import CASE, STUDY
from drakesep.results.provenance import DIRTY
from drakesep.results.reading import Results, read_results
from drakesep.results.recorded_case import recorded_text
from drakesep.results.study_record import Ended, StudyRecord
from drakesep.systems.checks import InputError


_WORDS = frozenset({"id", "source", "requirement", "axis", "pair", "label"})
"""Columns of words, though they be digits: an id of 4.10 is none of 4.1."""
_NUMBER = re.compile(r"-?(?:inf|\d+(?:\.\d*)?(?:e[-+]?\d+)?)")
_ONE_OF = {
    "campaign.csv": "campaign",
    "rare_events.csv": "study of rare events",
    "proofs.csv": "study with proofs",
}
"""Tables whose answers are of the case itself, whichever study has them."""
_ONCE = ("verify", "worst-case", "campaign")
"""Studies whose answers are of the case itself: two of them would contradict."""


@dataclass(frozen=True)
class Study:
    """A results folder, by its name in a report."""

    tag: str
    """Its name, which no other folder of the report has."""
    results: Results

    @property
    def record(self) -> StudyRecord:
        """What was asked, with what, and how it ended."""
        return self.results.record

    @property
    def kind(self) -> str:
        """The name of the study."""
        return self.record.study

    @property
    def ended(self) -> bool:
        """Whether it came to its end, and nothing in it failed."""
        return self.record.ended is Ended.COMPLETED

    @property
    def is_dirty(self) -> bool:
        """Whether drakesep had changes that are in no commit."""
        return (self.record.commit or "").endswith(DIRTY)

    def has(self, file: str) -> bool:
        """Return whether the study has left a file."""
        return _has(self.results, file)

    def rows(self, file: str) -> list[Row]:
        """Return the rows of a table; none if the study has left no such table."""
        if not self.has(file):
            return []
        with (self.results.folder / file).open(newline="", encoding="utf-8") as table:
            records = list(csv.DictReader(table))
        return [
            Row({k: _read(k, x) for k, x in values.items()}, f"{self.tag}/{file}:{i}")
            for i, values in enumerate(records, start=1)
        ]

    def fact(self, *keys: str) -> Cell:
        """Return what stands in ``study.json``, by its keys from the outermost."""
        value: Any = self.record.__dict__
        for key in keys:
            value = value.get(key) if isinstance(value, Mapping) else None
        if isinstance(value, Ended):
            value = value.value
        return Cell(value, f"{self.tag}/{STUDY}:{'.'.join(keys)}")

    def input(self, *keys: str, value: Any) -> Cell:
        """Return what the case says, as ``case.json`` has it.

        Args:
            keys: where it stands: a kind and a name.
            value: that stands there.
        """
        return input_cell(value, f"{self.tag}/{CASE}:{':'.join(keys)}")


@dataclass(frozen=True)
class Studies:
    """All that a report tells of."""

    all: tuple[Study, ...]

    @property
    def first(self) -> Study:
        """That the case is read from."""
        return self.all[0]

    @property
    def case(self) -> AnalysisCase:
        """That all are of."""
        return self.first.results.case

    def of(self, *kinds: str) -> list[Study]:
        """Return the studies of some kinds, in the order of these."""
        return [each for kind in kinds for each in self.all if each.kind == kind]

    def rows(self, file: str) -> list[Row]:
        """Return the rows of a table, of all studies that have it."""
        return [row for study in self.all for row in study.rows(file)]

    def first_fact(self, *keys: str) -> Cell:
        """Return what the first study says under some keys that says anything there."""
        told = (study.fact(*keys) for study in self.all)
        return next((cell for cell in told if cell), EMPTY)


def _has(results: Results, file: str) -> bool:
    return any(each["name"] == file for each in results.record.files)


def _read(column: str, text: str) -> Any:
    """Return what a cell says: a number, or words, though they be digits."""
    if column in _WORDS or not _NUMBER.fullmatch(text):
        return text
    return int(text) if text.lstrip("-").isdecimal() else float(text)


def read_studies(folders: Iterable[str | Path]) -> Studies:
    """Return the studies in some folders.

    Args:
        folders: of results, of the same case.

    Raises:
        ValueError: there is none, one holds no results, two are of different cases, or
            two give the same answers.
    """
    results = [read_results(folder) for folder in folders]
    if not results:
        raise InputError("folders: must be one or more folders of results, got none")
    first, *others = results
    for other in others:
        if _compared(other.case) != _compared(first.case):
            raise InputError(
                f"{other.folder}: must be of the case that {first.folder} is of, "
                f"{first.case.name!r}, with the same values; got {other.case.name!r}"
            )
    for kind in _ONCE:
        same = [str(one.folder) for one in results if one.record.study == kind]
        if len(same) > 1:
            raise InputError(
                f"folders: must hold one study {kind!r}, got {' and '.join(same)}"
            )
    for file, what in _ONE_OF.items():
        several = [str(one.folder) for one in results if _has(one, file)]
        if len(several) > 1:
            raise InputError(
                f"folders: must hold one {what}, got {' and '.join(several)}"
            )
    names = _tags([one.folder for one in results])
    return Studies(tuple(map(Study, names, results)))


def _compared(case: AnalysisCase) -> str:
    """Return a case as text, but for shares of launches: campaigns ask for theirs."""
    plain = tuple(
        replace(one, share=None, confidence=None, sides="one")
        for one in case.requirements
    )
    return recorded_text(replace(case, requirements=plain))


def _tags(folders: Sequence[Path]) -> list[str]:
    """Return a name for each folder: its own, with those above it if need be."""
    for depth in range(1, max(len(folder.parts) for folder in folders) + 1):
        tags = ["/".join(folder.parts[-depth:]) for folder in folders]
        if len(set(tags)) == len(tags):
            return [tag.replace(":", "_") for tag in tags]
    raise InputError("folders: must be different ones, got one twice")
