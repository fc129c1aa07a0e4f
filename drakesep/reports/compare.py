"""What changed between two studies: in what was asked, and in what was found."""

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from drakesep.case_file.yaml_text import read_yaml
from drakesep.files import path_of, written
from drakesep.reports.differences import (
    ABSENT,
    PRESENT,
    Difference,
    KeyedTable,
    Tolerated,
    differences,
    gap,
    keyed,
)
from drakesep.results.case_json import to_json
from drakesep.results.catalogue.file_kind import FileKind
from drakesep.results.listing import names_of
from drakesep.results.reading import Results, read_results
from drakesep.results.recorded_case import as_recorded
from drakesep.results.study_record import Ended
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_not_negative


INPUT, ANSWER = "input", "answer"
_SUMMARY = "study"
"""What answers of a study are of that stand in no table."""


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """What changed between two studies."""

    first: Path
    """Folder of the one."""
    second: Path
    """Folder of the other."""
    tolerance: float | None
    """Relative, of numbers in answers; None: the last digit counts."""
    table: pd.DataFrame = field(repr=False)
    """A row for each change: ``kind`` (`input` or `answer`), ``where`` it is, ``row``
    and ``column``, ``first``, ``second``, and of numbers their ``difference`` and the
    ``relative_difference``, a part of the larger magnitude; ``beyond``, whether that is
    more than is tolerated."""

    @property
    def inputs(self) -> pd.DataFrame:
        """The changes in what was asked."""
        return self.table[self.table["kind"] == INPUT]

    @property
    def answers(self) -> pd.DataFrame:
        """The changes in what was found."""
        return self.table[self.table["kind"] == ANSWER]

    @property
    def same(self) -> bool:
        """Whether no answer differs by more than is tolerated."""
        return not bool(self.answers["beyond"].any())

    def save(self, file: str | Path) -> None:
        """Write the table as a CSV file.

        Args:
            file: its path.
        """
        with written(path_of("file", file)) as beside:
            self.table.to_csv(beside, index=False)


@typed
def compare(
    first: str | Path | Results,
    second: str | Path | Results,
    *,
    tolerance: float | None = None,
) -> Comparison:
    """Compare what two results folders hold; nothing is flown.

    Inputs are the case by its keys, arguments, what was planned, seed, versions,
    commit and hashes of meshes and models. Answers are the verdict and the rows of all
    tables, matched by what they are of. Of tables over time, and of a campaign's draws,
    the greatest difference in each column is told. How hard something was, such as how
    many runs a search took, is told and never beyond the tolerance.

    Args:
        first: a folder of results.
        second: another; its study may be another, if both have some table.
        tolerance: by how much a number may differ, as a part of the larger magnitude,
            to be the same. With it, what differs by less than `accuracy`, that of the
            integration, times the largest number of its unit in the table is the same
            too: it is round-off about zero. None: the last digit counts.

    Raises:
        ValueError: a folder is none of a study, both are the same, a study is under
            way, they have no table in common, or the tolerance is negative.
    """
    if tolerance is not None:
        check_not_negative("tolerance", tolerance)
    both = [x if isinstance(x, Results) else read_results(x) for x in (first, second)]
    one, other = both
    if one.folder.resolve() == other.folder.resolve():
        raise InputError(f"folders must be two, got {one.folder} twice")
    for each in both:
        if each.record.ended is Ended.UNDER_WAY:
            raise InputError(f"{each.folder}: its study must have ended, got under way")
    rows = [_row(INPUT, where, change) for where, change in _inputs(one, other)]
    rows += [
        _row(ANSWER, where, change) for where, change in _answers(one, other, tolerance)
    ]
    return Comparison(
        first=one.folder,
        second=other.folder,
        tolerance=tolerance,
        table=pd.DataFrame(rows, columns=_COLUMNS),
    )


_COLUMNS = (
    *("kind", "where", "row", "column", "first", "second"),
    *("difference", "relative_difference", "beyond"),
)


def _row(kind: str, where: str, change: Difference) -> tuple[Any, ...]:
    by = gap(change.first, change.second)
    told, relative = (by, math.nan) if math.isfinite(by) else (math.nan, math.nan)
    if math.isfinite(by) and by != 0.0:
        relative = abs(by) / max(abs(float(change.first)), abs(float(change.second)))
    return kind, where, *change[:4], told, relative, change.beyond


def _inputs(first: Results, second: Results) -> Iterator[tuple[str, Difference]]:
    one, other = first.record, second.record
    yield from _changed("study", one.study, other.study)
    yield from _changed("case", *_cases(first, second))
    for name in ("arguments", "plan", "seed", "versions", "commit"):
        yield from _changed(name, getattr(one, name), getattr(other, name))
    yield from _changed("named_files", _named_files(first), _named_files(second))


def _cases(first: Results, second: Results) -> tuple[Any, Any]:
    """Return both cases by the keys of case files; in SI, if one was made so."""
    texts = [each.record.case.get("text") for each in (first, second)]
    if None not in texts:
        one, other = (read_yaml(str(text)) for text in texts)
        return one, other
    return to_json(as_recorded(first.case)), to_json(as_recorded(second.case))


def _named_files(results: Results) -> dict[str, str | None]:
    """Return the hashes of files by their paths from the case file, if it is one."""
    source = results.record.case.get("source")
    from_file = isinstance(source, str) and Path(source).is_absolute()
    home = Path(str(source)).parent if from_file else Path("/")
    files = results.record.named_files
    return {os.path.relpath(path, home): sha256 for path, sha256 in files.items()}


def _changed(where: str, first: Any, second: Any) -> Iterator[tuple[str, Difference]]:
    """Yield the changes between two trees of data, by their keys."""
    before, after = dict(_leaves(first)), dict(_leaves(second))
    for key in {**before, **after}:
        was, got = before.get(key, ABSENT), after.get(key, ABSENT)
        if was != got:
            yield where, Difference("", key, was, got, True)


def _leaves(data: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the keys of data and their values; a list of plain values is one."""
    if isinstance(data, Mapping):
        for name, value in data.items():
            yield from _leaves(value, f"{key}.{name}".lstrip("."))
    elif isinstance(data, list) and any(isinstance(x, Mapping) for x in data):
        for number, value in enumerate(data, 1):
            yield from _leaves(value, f"{key} (entry {number})".lstrip())
    elif isinstance(data, list):
        yield key, ", ".join(map(str, data))
    elif data is not None:
        yield key, data


def _answers(
    first: Results, second: Results, tolerance: float | None
) -> Iterator[tuple[str, Difference]]:
    one, other = first.record, second.record
    for name in ("verdict", "ended", "message"):
        was, got = (getattr(each, name) for each in (one, other))
        texts = [x.value if isinstance(x, Ended) else x for x in (was, got)]
        yield from _changed(_SUMMARY, {name: texts[0]}, {name: texts[1]})
    # A run alone is compared with a run alone, whatever they are called.
    label = one.runs[0] if len(one.runs) == len(other.runs) == 1 else None
    kinds, others = _tables(first, label), _tables(second, label)
    if not kinds.keys() & others.keys():
        raise InputError(
            f"folders must have a table in common, got none: {first.folder} is of "
            f"{one.study!r}, {second.folder} of {other.study!r}"
        )
    tolerated = Tolerated()
    if tolerance is not None:
        accuracy = max(each.case.integration.accuracy for each in (first, second))
        tolerated = Tolerated(tolerance, accuracy)
    for name in {**kinds, **others}:
        if name not in kinds or name not in others:
            sides = (PRESENT, ABSENT) if name in kinds else (ABSENT, PRESENT)
            yield name, Difference("", "", *sides, True)
            continue
        tables = _keyed(first, *kinds[name]), _keyed(second, *others[name])
        is_long = kinds[name][1].is_long
        for found in differences(*tables, tolerated, is_long=is_long):
            yield name, found


def _tables(results: Results, label: str | None) -> dict[str, tuple[str, FileKind]]:
    """Return the tables of a folder, in the order of the catalogue.

    Args:
        results: the folder.
        label: by which its only run is known; None: all have their own.

    Returns:
        Their names and kinds, by the names under which they are compared.
    """
    listed = {str(file["name"]) for file in results.record.files}
    labels = tuple(results.record.runs)
    names, known = (_names(results, x) for x in (labels, (label,) if label else labels))
    return {
        known_as: (name, kind)
        for (name, kind), (known_as, _) in zip(names, known, strict=True)
        if kind.row and name in listed
    }


def _names(results: Results, labels: tuple[str, ...]) -> Iterator[tuple[str, FileKind]]:
    bodies = [pair.B for pair in results.case.separation.others]
    return names_of(results.record.study, labels, bodies)


def _keyed(results: Results, name: str, kind: FileKind) -> KeyedTable:
    try:
        frame = results.table(name)
    except (OSError, ValueError, EOFError) as error:
        file = results.folder / name
        raise InputError(f"{file}: must be a table, got: {error}") from error
    return keyed(frame, kind.key, _units(results, name))


def _units(results: Results, name: str) -> dict[str, str]:
    """Return the units of the columns of a table, as the folder says them."""
    [file] = [x for x in results.record.files if x["name"] == name]
    return {str(x["name"]): str(x["unit"]) for x in file.get("columns", ())}
