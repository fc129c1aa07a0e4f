"""Tolerances as a case file states them: numbers, shares of the nominal, patterns."""

import fnmatch
import re
from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator

from drakesep.case_file.errors import CaseError
from drakesep.systems.checks import unknown
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation
from drakesep.units import unit_of, with_unit


_PERCENT = re.compile(r"\s*(\d+(?:\.\d+)?(?:[eE]-?\d+)?)\s*%\s*")
_WILD = re.compile(r"[*?\[]")


def _check(value: Any) -> Any:
    if isinstance(value, str):
        found = _PERCENT.fullmatch(value)
        if found is None or float(found[1]) == 0.0:
            raise ValueError(
                "must be a number, or a share of the nominal such as 5 %, got "
                f"{value!r}"
            )
    elif isinstance(value, int | float) and not isinstance(value, bool):
        if not value > 0:
            raise ValueError(f"must be > 0, got {value}")
    return value


Tolerance: TypeAlias = Annotated[float | str, BeforeValidator(_check)]
"""To either side: a number in the unit of the key, or a share such as ``5 %``."""


def tolerances_in_si(
    separation: Separation, dispersions: Mapping[str, float | str]
) -> dict[str, float]:
    """Return tolerances to either side by parameter names without units, in SI.

    Args:
        separation: gives the nominal values.
        dispersions: by names with units, or by patterns of such names, as
            ``spring_*.force_max_N``: each parameter that fits has its own. One that is
            named has what stands at its name.

    Raises:
        CaseError: a name is unknown, a pattern fits none, two patterns fit the same
            parameter, or a share is one of zero.
    """
    nominal = parameters(separation)
    names = {with_unit(name): name for name in nominal}
    found: dict[str, tuple[str, float | str]] = {}
    for key, value in dispersions.items():
        for fitting in _fitting(key, names):
            named = fitting in dispersions
            if named and fitting != key:
                continue
            if not named and fitting in found:
                raise CaseError(
                    f"{fitting}: must fit one pattern, got {found[fitting][0]} and "
                    f"{key}"
                )
            found[fitting] = key, value
    return {
        names[key]: _in_si(key, names[key], value, nominal[names[key]])
        for key, (_, value) in found.items()
    }


def _fitting(key: str, names: Mapping[str, str]) -> list[str]:
    """Return the names that a key means."""
    if not _WILD.search(key):
        if key not in names:
            raise CaseError(unknown("parameter", key, names))
        return [key]
    fitting = [name for name in names if fnmatch.fnmatchcase(name, key)]
    if not fitting:
        raise CaseError(f"{key}: must fit a parameter, got none")
    return fitting


def _in_si(key: str, name: str, value: float | str, nominal: float) -> float:
    if not isinstance(value, str):
        return unit_of(name).to_si(value)
    found = _PERCENT.fullmatch(value)
    assert found is not None  # _check
    if nominal == 0.0:
        raise CaseError(
            f"{key}: a share must be of a nominal that is not zero, got {value} of 0"
        )
    return abs(nominal) * float(found[1]) / 100.0
