"""Checks of input: each error names the field, what was wanted and what was got."""

import contextlib
import difflib
import math
import numbers
from collections.abc import Iterable, Iterator, Sequence
from typing import TypeAlias


Vector3: TypeAlias = tuple[float, float, float]
"""Three numbers: a point, a force, roll pitch yaw."""

X_AXIS: Vector3 = (1.0, 0.0, 0.0)

DECIMALS = 1e-4
"""By which unit vectors that are written in decimals may miss length and angle."""


class InputError(ValueError):
    """Input that makes no sense; the message names the field."""


class DrakesepWarning(UserWarning):
    """Of what is doubtful; each of ours is one, so that it can be told from others'."""


def check_finite(name: str, *values: float) -> None:
    """Raise InputError if a value is no number, NaN or infinite."""
    for value in values:
        # All but all are plain floats, which are soonest told.
        if type(value) is not float and not _is_real(value):
            raise InputError(f"{name} must be a number, got {value!r}")
        if not math.isfinite(value):
            raise InputError(f"{name} must be finite, got {value}")


def _is_real(value: object) -> bool:
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def check_positive(name: str, value: float) -> None:
    """Raise InputError if the value is not finite and above zero."""
    check_finite(name, value)
    if value <= 0:
        raise InputError(f"{name} must be > 0, got {value}")


def check_not_negative(name: str, value: float) -> None:
    """Raise InputError if the value is not finite or is below zero."""
    check_finite(name, value)
    if value < 0:
        raise InputError(f"{name} must be >= 0, got {value}")


def check_share(name: str, value: float) -> None:
    """Raise InputError unless the value is above 0 and below 1."""
    check_finite(name, value)
    if not 0.0 < value < 1.0:
        raise InputError(f"{name} must be > 0 and < 1, got {value}")


def check_entries(name: str, entries: Sequence[float], count: int) -> None:
    """Raise InputError unless there are so many finite entries."""
    if len(entries) != count:
        raise InputError(f"{name} must have {count} entries, got {len(entries)}")
    check_finite(name, *entries)


def check_distinct(name: str, entries: Sequence[str]) -> None:
    """Raise InputError unless each entry stands once."""
    for entry in entries:
        if entries.count(entry) > 1:
            raise InputError(f"{name}: {entry} must stand once")


def check_unit(name: str, vector: Sequence[float]) -> None:
    """Raise InputError unless the vector has three entries and length one."""
    check_entries(name, vector, 3)
    length = math.hypot(*vector)
    if abs(length - 1.0) > DECIMALS:
        raise InputError(
            f"{name} must be of length 1, got {tuple(vector)} of length {length:.9g}"
        )


def unit_vector(name: str, vector: Sequence[float]) -> Vector3:
    """Return a vector of length one, of one that is so but for its decimals.

    Raises:
        ValueError: it is none.
    """
    check_unit(name, vector)
    length = math.hypot(*vector)
    x, y, z = (float(entry) / length for entry in vector)
    return x, y, z


def unknown(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the message for a name that is not known, with the nearest that is."""
    names = [str(k) for k in known]
    nearest = difflib.get_close_matches(str(name), names, n=1, cutoff=0.5)
    hint = f"did you mean {nearest[0]!r}?" if nearest else f"known: {', '.join(names)}"
    return f"unknown {kind} {name!r}; {hint}"


@contextlib.contextmanager
def named(name: str) -> Iterator[None]:
    """Say in errors what they are about."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{name}: {error}") from error
