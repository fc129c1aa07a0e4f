"""Laws on floats as straight lines of arithmetic: the same numbers, without calls.

A law that is written on vectors calls a function for each of their operations, which
makes a tuple: on floats that takes several times as long as what it computes. A law
without a branch on its numbers is noted once, operation by operation, by calling it
with scalars that note what is done to them; then it is compiled as one line after the
other.
"""

import functools
import math
from collections.abc import Callable, Iterator
from typing import Any


_DEEPEST = 20
"""Operations within each other in a line: Python reads two hundred brackets."""


@functools.cache
def straight_line(law: Callable[..., Any], *fixed: Any) -> Callable[..., Any]:
    """Return a law on floats, compiled when it is first called.

    Args:
        law: from tuples of scalars or None, however nested, to such. It adds,
            subtracts, multiplies and divides them, takes powers and magnitudes,
            compares them, to multiply by what comes of it, and takes the functions of
            `LINE_OPS`; structures are the same at every call.
        fixed: its first arguments, on which it may branch.

    Raises:
        TypeError: when it is first called: the law does something else.
    """
    compiled: list[Callable[..., Any]] = []

    def call(*arguments: Any) -> Any:
        if not compiled:
            compiled.append(_compile(functools.partial(law, *fixed), arguments))
        return compiled[0](*arguments)

    return call


def line_if_straight(law: Callable[..., Any], *fixed: Any) -> Callable[..., Any]:
    """Return a law as a straight line if it is one, and as it is if not.

    Args:
        law: as for `straight_line`, but perhaps one that is not drakesep's own.
        fixed: likewise.
    """
    as_it_is = functools.partial(law, *fixed)
    try:
        chosen = straight_line(law, *fixed)
    except TypeError:  # something is fixed that has no hash
        return as_it_is

    def call(*arguments: Any) -> Any:
        nonlocal chosen
        try:
            return chosen(*arguments)
        except TypeError:
            chosen = as_it_is
            return chosen(*arguments)

    return call


def _compile(law: Callable[..., Any], arguments: tuple[Any, ...]) -> Callable[..., Any]:
    notes: dict[Any, _Noted] = {}
    scalars, pattern = _name(arguments, notes, iter(range(10**6)))
    result = law(*scalars)
    _count_uses(result)
    lines: list[str] = [f"def line(*arguments):\n    {pattern} = arguments"]
    types: dict[str, Any] = {}
    returned = _written(result, lines, types)
    exec("\n    ".join([*lines, f"return {returned}"]), types)
    line: Callable[..., Any] = types["line"]
    return line


class _Noted:
    """A scalar that notes what is done to it."""

    __slots__ = ("depth", "name", "notes", "of", "sign", "uses")

    def __init__(self, notes: "dict[Any, _Noted]", sign: str, of: tuple[Any, ...]):
        self.notes, self.sign, self.of = notes, sign, of
        self.name, self.depth, self.uses = "", 0, 0

    def _note(self, sign: str, *of: Any) -> "_Noted":
        # What is computed twice is computed once.
        key = sign, *(id(x) if isinstance(x, _Noted) else x for x in of)
        if key not in self.notes:
            self.notes[key] = _Noted(self.notes, sign, of)
        return self.notes[key]

    def __add__(self, other: Any) -> Any:
        return self if _is(other, 0.0) else self._note("+", self, other)

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __sub__(self, other: Any) -> Any:
        return self if _is(other, 0.0) else self._note("-", self, other)

    def __rsub__(self, other: Any) -> Any:
        return -self if _is(other, 0.0) else self._note("-", other, self)

    def __mul__(self, other: Any) -> Any:
        if _is(other, 0.0):
            return 0.0
        return self if _is(other, 1.0) else self._note("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        return self * other

    def __truediv__(self, other: Any) -> Any:
        return self._note("/", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._note("/", other, self)

    def __pow__(self, other: float) -> Any:
        return self._note("**", self, other)

    def __neg__(self) -> Any:
        return self._note("-", self)

    def __abs__(self) -> Any:
        return self._note("abs", self)

    def __lt__(self, other: Any) -> Any:
        return self._note("<", self, other)

    def __le__(self, other: Any) -> Any:
        return self._note("<=", self, other)

    def __gt__(self, other: Any) -> Any:
        return self._note(">", self, other)

    def __ge__(self, other: Any) -> Any:
        return self._note(">=", self, other)

    def __eq__(self, other: object) -> Any:
        raise TypeError("a law that asks for equal numbers is no straight line")

    def __bool__(self) -> bool:
        raise TypeError("a law that branches on its numbers is no straight line")


class _LineOps:
    """The functions of `math`, which are noted of scalars that note."""

    def __getattr__(self, name: str) -> Callable[..., Any]:
        function: Callable[..., Any] = getattr(math, name)

        def noted(*arguments: Any) -> Any:
            for x in arguments:
                if isinstance(x, _Noted):
                    return x._note(name, *arguments)
            return function(*arguments)

        return noted


LINE_OPS: Any = _LineOps()
"""Module of the elementary functions, for a law that is to be a straight line."""


def _is(x: Any, number: float) -> bool:
    return not isinstance(x, _Noted) and x == number


def _name(
    value: Any, notes: dict[Any, _Noted], numbers: Iterator[int]
) -> tuple[Any, str]:
    """Return nested tuples with scalars that note, and what takes them apart."""
    if value is None:
        return None, "_"
    if not isinstance(value, tuple):
        scalar = _Noted(notes, "", ())
        scalar.name = f"x{next(numbers)}"
        return scalar, scalar.name
    noted = [_name(entry, notes, numbers) for entry in value]
    entries = [scalar for scalar, _ in noted]
    made = type(value)(*entries) if hasattr(value, "_fields") else tuple(entries)
    return made, f"({''.join(pattern + ', ' for _, pattern in noted)})"


def _count_uses(value: Any) -> None:
    if isinstance(value, tuple):
        for entry in value:
            _count_uses(entry)
    elif isinstance(value, _Noted):
        value.uses += 1
        if value.uses == 1:
            _count_uses(value.of)


def _written(value: Any, lines: list[str], types: dict[str, Any]) -> str:
    """Return an expression, before which lines are to be run."""
    if isinstance(value, tuple):
        entries = "".join(_written(entry, lines, types) + ", " for entry in value)
        if hasattr(value, "_fields"):
            name = f"{type(value).__module__}_{type(value).__name__}".replace(".", "_")
            types[name] = type(value)
            return f"{name}({entries})"
        return f"({entries})"
    if not isinstance(value, _Noted):
        return repr(value)
    if not value.name:
        operands = [_written(entry, lines, types) for entry in value.of]
        if value.sign.isidentifier():
            types[value.sign] = getattr(math, value.sign, None) or abs
            written = f"{value.sign}({', '.join(operands)})"
        else:
            before = operands.pop(0) if len(operands) == 2 else ""
            written = f"({before} {value.sign} {operands[0]})"
        depths = [x.depth for x in value.of if isinstance(x, _Noted)]
        value.depth = 1 + max(depths)
        if value.uses == 1 and value.depth < _DEEPEST:
            return written
        value.name, value.depth = f"y{len(lines)}", 0
        lines.append(f"{value.name} = {written}")
    return value.name
