"""Checks of input: each error names the field, what was wanted and what was got."""

import difflib
import math
from collections.abc import Iterable


def check_finite(name: str, *values: float) -> None:
    """Raise ValueError if a value is NaN or infinite."""
    for value in values:
        if not math.isfinite(value):
            raise ValueError(f"{name} must be finite, got {value}")


def check_positive(name: str, value: float) -> None:
    """Raise ValueError if the value is not finite and above zero."""
    check_finite(name, value)
    if value <= 0:
        raise ValueError(f"{name} must be > 0, got {value}")


def check_not_negative(name: str, value: float) -> None:
    """Raise ValueError if the value is not finite or is below zero."""
    check_finite(name, value)
    if value < 0:
        raise ValueError(f"{name} must be >= 0, got {value}")


def unknown(kind: str, name: str, known: Iterable[str]) -> str:
    """Return the message for a name that is not known, with the nearest that is."""
    names = [str(k) for k in known]
    nearest = difflib.get_close_matches(str(name), names, n=1, cutoff=0.5)
    hint = f"did you mean {nearest[0]!r}?" if nearest else f"known: {', '.join(names)}"
    return f"unknown {kind} {name!r}; {hint}"
