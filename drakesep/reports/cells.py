"""Numbers and words of a report, each with the place where it stands in a folder.

A place is ``FOLDER/FILE:ROW:COLUMN`` of a table, with rows from 1, or
``FOLDER/FILE:KEY`` of what stands in JSON. Inputs are shown as they are; answers are
rounded for reading, and whole beside the cursor.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from drakesep.plots.limits import SIGNS


DIGITS = 4
"""Of answers, as they are shown."""
_WHOLE = 10
"""Digits of inputs: more are of binary fractions."""
_MOST = 17
"""Digits that a float has at most."""
_COUNTED = 1e9
"""Whole numbers below it are shown as they are."""
INPUTS = frozenset(
    {
        *("limit", "share", "confidence", "bound_of", "at_confidence", "looked_up_to"),
        *("minus", "plus", "tolerance", "nearest_limit"),
    }
)
"""Columns of what was asked, and of shares whose last digits matter."""
_SIGNED = frozenset({"sense", "decides"})
"""Columns that have the sense of a limit, which is shown by its sign."""
_KIND = {
    **{"unit": "whole", "limit": "whole"},
    **{"nearest requirement": "wide", "what has failed": "wide"},
}
"""By headings: what is not broken into lines, and what needs room."""
BEYOND = "beyond"
"""A value beyond its limit."""
NOTHING = "\N{EN DASH}"
"""Where a cell is empty."""
_MINUS = "\N{MINUS SIGN}"
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True, slots=True)
class Cell:
    """A number or words, as a report shows them.

    Attributes:
        value: as it was read; None: there is none.
        place: where it stands.
        digits: that are shown of a number.
        kind: how it looks: `BEYOND`, or as others do.
    """

    value: Any = None
    place: str = ""
    digits: int = DIGITS
    kind: str = ""

    @property
    def is_number(self) -> bool:
        """Whether it is a number."""
        return isinstance(self.value, int | float) and not isinstance(self.value, bool)

    @property
    def text(self) -> str:
        """What is shown."""
        if self.value is None or self.value == "":
            return NOTHING
        if not self.is_number:
            return str(self.value)
        return number_text(float(self.value), self.digits)

    @property
    def whole(self) -> str:
        """The number with all its digits; empty if they are shown, or it is none."""
        if not self.is_number:
            return ""
        whole = repr(self.value)
        return "" if whole.removesuffix(".0") == self.text else whole

    def __bool__(self) -> bool:
        """Return whether there is anything."""
        return self.value is not None and self.value != ""

    def told_from(self, other: "Cell") -> "Cell":
        """Return it with so many digits that it is not taken for another."""
        if not (self.is_number and other.is_number) or self.value == other.value:
            return self
        digits, shown = self.digits, _rounded(other.value, other.digits)
        while digits < _MOST and _rounded(self.value, digits) == shown:
            digits += 1
        return replace(self, digits=digits)


EMPTY = Cell()


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def number_text(value: float, digits: int) -> str:
    """Return a number with so many digits; small and large ones by powers of ten.

    Zeros at the end of what is rounded stay, so that 100.0 is not taken for the whole
    number 100, and fits the margin beside it.

    Args:
        value: the number.
        digits: that are shown; zeros at the end of inputs are left out.
    """
    if math.isinf(value):
        return f"{_MINUS if value < 0.0 else ''}∞"
    if value.is_integer() and abs(value) < _COUNTED:
        return f"{int(value)}".replace("-", _MINUS)
    zeros = "#" if digits < _WHOLE else ""
    mantissa, _, exponent = f"{value:{zeros}.{digits}g}".partition("e")
    mantissa = mantissa.removesuffix(".")
    if exponent:
        mantissa += f"·10{str(int(exponent)).translate(_RAISED)}"
    return mantissa.replace("-", _MINUS)


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table."""

    values: Mapping[str, Any]
    place: str
    """Of the row."""

    def __getitem__(self, column: str) -> Cell:
        """Return a cell; one with nothing if the table has no such column."""
        value = self.values.get(column)
        if column in _SIGNED and value:
            value = " ".join(SIGNS.get(word, word) for word in str(value).split(" "))
        digits = _WHOLE if column in INPUTS or "." in column else DIGITS
        return Cell(value, f"{self.place}:{column}", digits)

    def get(self, column: str, default: Any = None) -> Any:
        """Return what stands in a column as it was read, a default if nothing does."""
        cell = self[column]
        return cell.value if cell else default


@dataclass(frozen=True, slots=True)
class Heading:
    """What stands above a column."""

    text: str
    unit: str = ""
    is_number: bool = False
    cells: Sequence[Cell] = ()
    """That stand after the text."""

    @property
    def kind(self) -> str:
        """How the cells below it look, as `Cell.kind`."""
        return _KIND.get(self.text, "")


@dataclass(frozen=True, slots=True)
class Table:
    """A table as a report shows it."""

    headings: Sequence[Heading]
    rows: Sequence[Sequence[Cell | Sequence[Cell]]]
    """Of several cells together, those that are not empty stand beside each other."""

    def __bool__(self) -> bool:
        """Return whether it has rows."""
        return bool(self.rows)


def input_cell(value: Any, place: str) -> Cell:
    """Return what was asked, which is shown with all its digits."""
    return Cell(value, place, _WHOLE)


Columns: TypeAlias = Mapping[str, str | tuple[str, str]]
"""What is said of columns, by their names; with their unit if they have one."""


def table_of(rows: Sequence[Row], columns: Columns) -> Table:
    """Return a table of some columns of a file; those that are empty are left out.

    Args:
        rows: of the file.
        columns: that are told; of several names with blanks between, what stands there
            is told together.
    """
    headings, cells = [], []
    for names, said in columns.items():
        column = [[row[name] for name in names.split()] for row in rows]
        if any(any(several) for several in column):
            text, unit = (said, "") if isinstance(said, str) else said
            number = all(c.is_number or not c for several in column for c in several)
            headings.append(Heading(text, unit, number))
            cells.append([_together(several) for several in column])
    return Table(headings, [*zip(*cells, strict=True)] if cells else [])


def _together(several: Sequence[Cell]) -> Cell | Sequence[Cell]:
    return several[0] if len(several) == 1 else [cell for cell in several if cell]
