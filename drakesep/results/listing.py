"""What stands in a results folder: its files, and what their columns mean."""

import csv
import functools
import gzip
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.search.registry import SEARCHES
from drakesep.results.catalogue.file_kind import Column, FileKind
from drakesep.results.catalogue.files import FILES
from drakesep.results.catalogue.names import GEOMETRY
from drakesep.systems.model.parameters import ParameterName
from drakesep.systems.model.separation import STACK, InitialMotion
from drakesep.units import records, split_unit, with_unit


class FileInFolder(NamedTuple):
    """A file that is there, and what it holds."""

    name: str
    what: str
    row: str
    columns: tuple[Column, ...]


def names_of(
    study: str, labels: Sequence[str], bodies: Sequence[str]
) -> Iterator[tuple[str, FileKind]]:
    """Yield the names that files of a study may have, each with its kind.

    Args:
        study: its name.
        labels: of its runs.
        bodies: that leave, but the first.
    """
    for kind in FILES:
        if study in kind.studies:
            for label in labels if kind.of_each_run else [""]:
                for body in bodies if kind.of_each_body else [""]:
                    yield kind.named(label, body), kind


def files_in(
    folder: Path,
    names: Iterable[tuple[str, FileKind]],
    ours: Callable[[Path], bool],
) -> tuple[FileInFolder, ...]:
    """Return the files of a study that are in a folder, with what they hold.

    Args:
        folder: of the study.
        names: that its files may have, each with its kind.
        ours: whether a file of such a name is the study's.
    """
    found = [
        FileInFolder(name, kind.what, kind.row, _columns_in(folder / name, kind))
        for name, kind in names
        if ours(folder / name)
    ]
    meshes = sorted(filter(ours, (folder / GEOMETRY).glob("*")))
    what = "A mesh of the case, as it was when it was measured."
    found += [FileInFolder(f"{GEOMETRY}/{file.name}", what, "", ()) for file in meshes]
    return tuple(found)


def _columns_in(file: Path, kind: FileKind) -> tuple[Column, ...]:
    if not kind.columns:
        return ()
    opened = gzip.open if file.suffix == ".gz" else open
    with opened(file, "rt", newline="", encoding="utf-8") as table:
        names = next(csv.reader(table), [])
    return tuple(described(kind, name) or Column(name, "", "") for name in names)


def described(kind: FileKind, name: str) -> Column | None:
    """Return what a column of a table is; None if that is not known.

    Args:
        kind: of the file.
        name: of the column.
    """
    for column in kind.columns:
        if column.name == name:
            return column
    for column in kind.columns:
        tell = _MANY.get(column.name, _as_it_stands)
        if "{" in column.name and (told := tell(column, name)) is not None:
            return told
    return None


def _as_it_stands(column: Column, name: str) -> Column | None:
    """Return a column whose name follows the pattern of another, with its meaning."""
    return Column(name, *column[1:]) if _pattern(column.name).fullmatch(name) else None


@functools.cache
def _pattern(name: str) -> re.Pattern[str]:
    parts = re.split(r"(\{\w+\})", name)
    return re.compile("".join(_PARTS.get(p) or re.escape(p) for p in parts))


_NAME = "[A-Za-z0-9][A-Za-z0-9_-]*"
_PARTS = {
    **{f"{{{what}}}": _NAME for what in ("body", "attachment", "spring", "part")},
    "{axis}": "w|x|y|z|roll|pitch|yaw".join(("(?:", ")")),
    "{side}": "(?:first|second)",
    "{label}": ".+",
    "{objective}": ".+",
}


def _of_parameter(column: Column, name: str) -> Column | None:
    owner, _, quantity = name.rpartition(".")
    stem, unit = split_unit(quantity)
    parts = ParameterName.of(f"{owner}.{stem}")
    of_stack = owner == STACK
    tables = [r.PARAMETERS for r in records() if (r is InitialMotion) == of_stack]
    found = next((p for t in tables for p in t if p.stem == parts.stem), None)
    if not owner or found is None:
        return None
    axis = f", {parts.axis}" if parts.axis else ""
    what = f"{found.label[:1].upper()}{found.label[1:]}{axis} of {owner}."
    return Column(name, unit.symbol, what)


def _of_metric(column: Column, name: str) -> Column | None:
    stem, unit = split_unit(name)
    found = find_metric(stem)
    if found is None or with_unit(stem) != name:
        return None
    metric, axis = found
    words = f"{metric.words[:1].upper()}{metric.words[1:]}"
    return Column(name, unit.symbol, f"{words}{': ' + axis if axis else ''}.")


def _of_search(column: Column, name: str) -> Column | None:
    return Column(name, *column[1:]) if name in SEARCHES else None


_MANY: Mapping[str, Callable[[Column, str], Column | None]] = {
    "{parameter}": _of_parameter,
    "{metric}": _of_metric,
    "{search}": _of_search,
}
"""Columns whose meaning is that of a registry."""
