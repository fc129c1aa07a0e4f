"""Where two tables of the same kind differ, row by row and column by column."""

import math
import numbers
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from drakesep.results.catalogue.files import EFFORT, LABELS


PRESENT, ABSENT = "present", "absent"
"""Of a table, a row or a column that stands on one side alone."""


class Difference(NamedTuple):
    """A value that is not the same on both sides."""

    row: str
    """Values of its key; empty: of all rows."""
    column: str
    """Empty: of the whole row."""
    first: Any
    """None: there is no value."""
    second: Any
    beyond: bool
    """Whether it is more than what is tolerated."""


@dataclass(frozen=True)
class Tolerated:
    """By how much numbers may differ and be the same."""

    relative: float = 0.0
    """Of the larger magnitude."""
    round_off: float = 0.0
    """Of the largest magnitude in the table that has the same unit: what is smaller
    is noise about zero, of which every digit differs."""


@dataclass(frozen=True)
class KeyedTable:
    """A table, whose index names its rows."""

    frame: pd.DataFrame
    key: Sequence[str]
    """Columns of which these names are made."""
    units: Mapping[str, str]
    """Of columns; ``as `unit` says`` is that in the row's column `unit`."""

    @property
    def values(self) -> list[str]:
        """Names of the columns that are no key."""
        return [name for name in self.frame.columns if name not in self.key]

    def units_of(self, column: str) -> pd.Series:
        """Return the unit of each value in a column."""
        unit = self.units.get(column, "")
        told_by = re.search(r"`(\w+)`", unit)
        if told_by and told_by[1] in self.frame:
            return self.frame[told_by[1]].fillna("").astype(str)
        return pd.Series(unit, index=self.frame.index)

    def largest(self) -> dict[str, float]:
        """Return the largest magnitude of each unit."""
        found: dict[str, float] = {}
        for name in self.values:
            if not _may_be_round_off(self.frame[name]):
                continue
            sizes = self.frame[name].abs().where(np.isfinite(self.frame[name]))
            for unit, size in sizes.groupby(self.units_of(name)).max().items():
                if unit == "":  # shares, factors: nothing makes noise about their zero
                    continue
                found[str(unit)] = float(np.fmax(found.get(str(unit), 0.0), size))
        return found


def keyed(
    frame: pd.DataFrame, key: Sequence[str], units: Mapping[str, str]
) -> KeyedTable:
    """Return a table with names for its rows.

    Args:
        frame: the table.
        key: columns that tell its rows apart.
        units: of columns, as `KeyedTable` has them.
    """
    return KeyedTable(frame.set_axis(_names(frame, key), axis=0), key, units)


def _names(frame: pd.DataFrame, key: Sequence[str]) -> list[str]:
    """Return a name for each row, by its key; the second of a name is ``name (2)``."""
    columns = [frame[name] for name in key if name in frame]
    told: list[str] = []
    seen: dict[str, int] = {}
    for values in zip(*columns, strict=True) if columns else [()] * len(frame):
        name = ", ".join(str(x) for x in values if not pd.isna(x) and x != "")
        seen[name] = count = seen.get(name, 0) + 1
        told.append(f"{name} ({count})".lstrip() if count > 1 or not name else name)
    return told


def _may_be_round_off(column: pd.Series) -> bool:
    """Return whether a column holds numbers that are no counts."""
    return bool(pd.api.types.is_float_dtype(column))


def differences(
    first: KeyedTable, second: KeyedTable, tolerated: Tolerated, *, is_long: bool
) -> list[Difference]:
    """Return where two tables differ.

    Args:
        first: a table.
        second: another of the same kind. If each has one row, these are compared,
            whatever they are called.
        tolerated: what is not beyond.
        is_long: whether of each column only the greatest difference is told.
    """
    if len(first.frame) == len(second.frame) == 1:
        named = second.frame.set_axis(first.frame.index, axis=0)
        second = replace(second, frame=named)
    sides = first.frame.index, second.frame.index
    common = sides[0].intersection(sides[1], sort=False)
    found = _unmatched("row", *sides, by_count=is_long)
    found += _unmatched("column", pd.Index(first.values), pd.Index(second.values))
    scales = first.largest(), second.largest()
    for name in first.values:
        if name not in second.frame:
            continue
        a, b = (table.frame[name].loc[common] for table in (first, second))
        floor = np.zeros(len(common))
        if _may_be_round_off(a) and _may_be_round_off(b):
            units = first.units_of(name).loc[common]
            largest = [max(scale.get(unit, 0.0) for scale in scales) for unit in units]
            floor = tolerated.round_off * np.array(largest)
        of_column = _of_column(name, a, b, tolerated.relative, floor)
        found += _greatest(of_column) if is_long else of_column
    return found


def _unmatched(
    what: str, first: pd.Index, second: pd.Index, *, by_count: bool = False
) -> list[Difference]:
    """Return the rows or columns that only one side has."""
    found = [
        Difference(
            row=name if what == "row" else "",
            column=name if what == "column" else "",
            first=sides[0],
            second=sides[1],
            beyond=name not in EFFORT,
        )
        for names, others, sides in (
            (first, second, (PRESENT, ABSENT)),
            (second, first, (ABSENT, PRESENT)),
        )
        for name in names.difference(others, sort=False)
    ]
    if by_count and found:
        return [Difference("", "rows", len(first), len(second), True)]
    return found


def _of_column(
    name: str, first: pd.Series, second: pd.Series, relative: float, floor: np.ndarray
) -> list[Difference]:
    if name in LABELS:
        first, second = (_as_labels(each) for each in (first, second))
    x, y = [
        pd.to_numeric(each, errors="coerce").to_numpy(float) for each in (first, second)
    ]
    as_numbers = ~np.isnan(x) & ~np.isnan(y)
    texts = [each.astype(object).where(each.notna(), None) for each in (first, second)]
    same_text = np.array([a == b for a, b in zip(*texts, strict=True)], dtype=bool)
    differs = np.where(as_numbers, x != y, ~same_text)
    with np.errstate(invalid="ignore"):  # infinite on both sides
        near = np.abs(x - y) <= relative * np.fmax(np.abs(x), np.abs(y)) + floor
    near &= np.isfinite(x) & np.isfinite(y)
    beyond = differs & ~(as_numbers & near) & (name not in EFFORT)
    was, got = _as_told(texts[0], x), _as_told(texts[1], y)
    rows = [str(row) for row in first.index]
    return [
        Difference(rows[i], name, was[i], got[i], bool(beyond[i]))
        for i in np.flatnonzero(differs).tolist()
    ]


def _as_labels(numbers: pd.Series) -> pd.Series:
    """Return numbers that are names as words, which no arithmetic takes for numbers."""
    told = [None if pd.isna(x) else f"number {int(x)}" for x in numbers]
    return pd.Series(told, index=numbers.index, dtype=object)


def _as_told(texts: pd.Series, parsed: np.ndarray) -> list[Any]:
    """Return values as they stand, numbers among texts as numbers."""
    return [
        number if isinstance(text, str) and not math.isnan(number) else text
        for text, number in zip(texts, parsed, strict=True)
    ]


def _greatest(found: Sequence[Difference]) -> list[Difference]:
    """Return the greatest difference; of those that are beyond, if any is."""
    if not found:
        return []
    return [max(found, key=lambda one: (one.beyond, abs(gap(one.first, one.second))))]


def gap(first: Any, second: Any) -> float:
    """Return the second number less the first; infinite if they are not two numbers."""
    for value in (first, second):
        if not isinstance(value, numbers.Real) or isinstance(value, bool):
            return math.inf
    x, y = float(first), float(second)
    return y - x if math.isfinite(x) and math.isfinite(y) else math.inf
