"""Rows of named numbers in a Context.

A LeafSystem keeps its numbers in a numeric parameter of the Context, which is a plain
vector. Here it is packed from named tuples and given back as such: floats, and tuples
of floats, as many as in an example.
"""

from collections.abc import Iterator, Sequence
from typing import Any, Generic, TypeVar

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    NumericParameterIndex,
    ValueProducer,
)


Row = TypeVar("Row", bound=tuple[Any, ...])


class Rows(Generic[Row]):
    """The rows that one numeric parameter of a system's Context holds."""

    def __init__(self, system: LeafSystem, examples: Sequence[Row]):
        """Declare the parameter.

        Args:
            system: whose Context holds it.
            examples: a row like each; rows may differ from each other.
        """
        self._examples = list(examples)
        size = sum(1 for _ in _numbers(self._examples))
        self._parameter = system.DeclareNumericParameter(BasicVector(size))
        # Read once for a run: numbers of a Context cost more than what is made of them.
        self._rows = system.DeclareCacheEntry(
            "rows",
            ValueProducer(allocate=lambda: Value[object](), calc=self._calc_rows),
            {system.numeric_parameter_ticket(NumericParameterIndex(self._parameter))},
        )

    def write(self, context: Context, rows: Sequence[Row]) -> None:
        """Write the rows into a Context."""
        parameter = context.get_mutable_numeric_parameter(self._parameter)
        parameter.SetFromVector(list(_numbers(rows)))

    def read(self, context: Context) -> list[Row]:
        """Return the rows of a Context."""
        rows: list[Row] = self._rows.Eval(context)
        return rows

    def _calc_rows(self, context: Context, output: AbstractValue) -> None:
        parameter = context.get_numeric_parameter(self._parameter)
        numbers = iter(parameter.value().tolist())
        output.set_value([_like(example, numbers) for example in self._examples])


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, tuple | list):
        for entry in value:
            yield from _numbers(entry)
    else:
        yield float(value)


def _like(example: Any, numbers: Iterator[float]) -> Any:
    if not isinstance(example, tuple):
        return next(numbers)
    entries = [_like(entry, numbers) for entry in example]
    return type(example)(*entries) if hasattr(example, "_fields") else tuple(entries)
