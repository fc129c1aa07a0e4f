"""What a record says of its parameters: a table that stands beside its fields.

A parameter is a number that may vary from run to run. Everything that handles some
reads these tables: names and values, checks of records and of rows, units, both
engines. A new parameter is a field and its entry here.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from drakesep.systems.checks import InputError, check_entries, check_finite
from drakesep.systems.model.inertia import ENTRIES
from drakesep.systems.model.magnitudes import (
    MAGNITUDES,
    Kind,
    check_size,
    check_within,
)


XYZ = ("x", "y", "z")
ROLL_PITCH_YAW = ("roll", "pitch", "yaw")
_AXES = {*XYZ, *ROLL_PITCH_YAW, *ENTRIES}


class Range(NamedTuple):
    """The values that a parameter may have, in SI."""

    low: float = -math.inf
    high: float = math.inf
    """Does not belong to it."""
    closed: bool = False
    """Whether the lowest value belongs to it."""

    def holds(self, value: float) -> bool:
        """Return whether a value belongs to it."""
        above = value >= self.low if self.closed else value > self.low
        return above and value < self.high

    def text(self, kind: Kind) -> str:
        """Return what is wanted of a value, angles in deg."""
        low, high = (
            f"{math.degrees(x):g} deg" if kind == "angle" else f"{x:g}"
            for x in (self.low, self.high)
        )
        if self.low == -self.high:
            return "any" if math.isinf(self.high) else f"less than {high}"
        if math.isinf(self.high):
            return f">= {low}" if self.closed else f"> {low}"
        first = ">=" if self.closed else "above"
        return f"{first} {low.removesuffix(' deg')} and below {high}"


ANY = Range()
POSITIVE = Range(low=0.0)
NOT_NEGATIVE = Range(low=0.0, closed=True)
SHARE = Range(low=0.0, high=1.0, closed=True)
TILT = Range(low=-0.5 * math.pi, high=0.5 * math.pi)
TURN = Range(low=0.0, high=math.pi)


class Parameter(NamedTuple):
    """A number of a record that may vary."""

    stem: str
    """Of its name ``owner.stem`` or ``owner.stem_axis``."""
    axis: str
    """Empty if it has none."""
    field: str
    """Of the record."""
    entry: int | None
    """Which of the field's; None: the field is a number."""
    kind: Kind
    range: Range
    label: str
    """Of the field in errors."""
    optional: bool
    """Whether a record may be without it: it is infinite then, and does not vary."""

    @property
    def quantity(self) -> str:
        """Its name without the owner."""
        return with_axis(self.stem, self.axis)

    def of(self, record: Any) -> float:
        """Return its value in a record."""
        value = getattr(record, self.field)
        return float(value if self.entry is None else value[self.entry])

    @property
    def positive(self) -> bool:
        """Whether it must be above zero."""
        return self.range.low == 0.0 and not self.range.closed

    @property
    def limits(self) -> tuple[float, float]:
        """The least and the greatest value that it may have, in SI."""
        range_, magnitude = self.range, MAGNITUDES[self.kind]
        low = range_.low if range_.closed else math.nextafter(range_.low, math.inf)
        least = magnitude.least if self.positive else -magnitude.most
        high = math.nextafter(range_.high, -math.inf)
        return max(low, least), min(high, magnitude.most)

    def check(self, prefix: str, value: float) -> None:
        """Raise InputError unless its range holds a value, and its kind has its size.

        Args:
            prefix: of the error: the record's name.
            value: in SI.
        """
        check_finite(prefix + self.label, value)
        if not self.range.holds(value):
            angle = self.kind == "angle"
            got = f"{math.degrees(value):g} deg" if angle else str(value)
            raise InputError(
                f"{prefix}{self.label} must be {self.range.text(self.kind)}, got {got}"
            )
        check = check_size if self.positive else check_within
        check(self.kind, prefix + self.label, value)


def scalar(
    stem: str,
    kind: Kind,
    range: Range = ANY,
    *,
    axis: str = "",
    label: str = "",
    optional: bool = False,
) -> Parameter:
    """Return the parameter of a field that has its name and holds one number."""
    field = with_axis(stem, axis)
    label = label or stem.replace("_", " ")
    return Parameter(stem, axis, field, None, kind, range, label, optional)


def vector(
    stem: str, field: str, axes: tuple[str, ...], kind: Kind, *, label: str = ""
) -> tuple[Parameter, ...]:
    """Return the parameters of a field that holds a number for each axis."""
    label = label or stem
    return tuple(
        Parameter(stem, axis, field, i, kind, ANY, label, False)
        for i, axis in enumerate(axes)
    )


def with_axis(stem: str, axis: str) -> str:
    """Return the name of a quantity's component; the stem if there is no axis."""
    return f"{stem}_{axis}" if axis else stem


def split_axis(quantity: str) -> tuple[str, str]:
    """Return a quantity's name without its axis, and the axis; empty if none."""
    stem, _, last = quantity.rpartition("_")
    return (stem, last) if last in _AXES else (quantity, "")


class ParameterTable:
    """The parameters of a kind of record, in order.

    Attributes:
        by_quantity: the parameters by their names without the owner.
        by_field: the parameters of each field, in the order of its entries.
    """

    def __init__(self, *parameters: Parameter):
        self.by_quantity = {p.quantity: p for p in parameters}
        self.by_field: dict[str, tuple[Parameter, ...]] = {}
        for p in parameters:
            self.by_field[p.field] = (*self.by_field.get(p.field, ()), p)

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self.by_quantity.values())

    def check(self, prefix: str, record: Any) -> None:
        """Raise InputError unless every parameter of a record is in its range.

        Args:
            prefix: of the errors: the record's name and a colon.
            record: with the fields.
        """
        for field, parameters in self.by_field.items():
            value, first = getattr(record, field), parameters[0]
            if first.entry is not None:
                check_entries(prefix + first.label, value, len(parameters))
                check_within(first.kind, prefix + first.label, *value)
            elif not (first.optional and value == math.inf):
                first.check(prefix, value)
