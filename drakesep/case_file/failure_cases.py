"""Failure cases as a case file states them: by name, what is changed; or the usual."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BeforeValidator, Discriminator, Tag

from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.standard_failure_cases import standard_failure_cases
from drakesep.analysis.tolerances.sides import Tolerance, ends_of
from drakesep.case_file.dispersions import names_fitting
from drakesep.case_file.errors import UNNAMED, CaseError, shown
from drakesep.case_file.section import Name
from drakesep.systems.checks import named
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation
from drakesep.units import unit_of, with_unit


STANDARD = "standard"
_NEVER, _ENDS = "never", ("min", "max")


def _check_value(value: Any) -> Any:
    if value in (_NEVER, *_ENDS):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(
            "must be a number, 'min' or 'max' of its tolerance, or 'never' of a time "
            f"of release, got {shown(value)}"
        )
    if not math.isfinite(value):
        raise ValueError(f"must be finite, got {value}")
    return value


def _check_some(value: Any) -> Any:
    if isinstance(value, Mapping) and not value:
        raise ValueError("must change a parameter, got none")
    return value


def _check_all(value: Any) -> Any:
    if value != STANDARD and not isinstance(value, Mapping):
        raise ValueError(
            f"must be failure cases by name, or {STANDARD!r}, got {shown(value)}"
        )
    return value


Changed: TypeAlias = Annotated[float | str, BeforeValidator(_check_value)]
"""A number in the unit of the key; ``min`` or ``max``, an end of its tolerance; or of a
time of release ``never``."""
_Changes: TypeAlias = Annotated[dict[str, Changed], BeforeValidator(_check_some)]
FailureCases: TypeAlias = Annotated[
    Annotated[Literal["standard"], Tag(STANDARD)]
    | Annotated[dict[Name, _Changes], Tag(UNNAMED)],
    Discriminator(lambda value: STANDARD if value == STANDARD else UNNAMED),
    BeforeValidator(_check_all),
]
"""By name, what is changed: parameters with units, or patterns; or ``standard``."""


def failure_cases_in_si(
    separation: Separation, tolerances: Mapping[str, Tolerance], stated: FailureCases
) -> tuple[FailureCase, ...]:
    """Return failure cases in SI.

    Args:
        separation: the design.
        tolerances: about its values, by parameter name, in SI.
        stated: as a case file has them.

    Raises:
        CaseError: a name is unknown, a pattern fits none, or an end is one of a
            parameter without tolerance.
    """
    if isinstance(stated, str):
        return standard_failure_cases(separation, tolerances)
    failures = []
    for name, changes in stated.items():
        with named(name):
            values = _values(separation, tolerances, changes)
        failures.append(FailureCase(name=name, values=values))
    return tuple(failures)


def _values(
    separation: Separation,
    tolerances: Mapping[str, Tolerance],
    changes: Mapping[str, Changed],
) -> dict[str, float]:
    nominal = parameters(separation)
    names = {with_unit(name): name for name in nominal}
    values = {}
    for key, name, value in names_fitting(names, changes):
        if value in _ENDS:
            if name not in tolerances:
                raise CaseError(
                    f"{key}: must have a tolerance, of which {value!r} is an end, got "
                    "none"
                )
            ends = ends_of(nominal[name], tolerances[name])
            values[name] = ends[_ENDS.index(value)]
        elif value == _NEVER:
            if not name.endswith(".release_time"):
                raise CaseError(f"{key}: {_NEVER!r} must be of a time of release")
            values[name] = math.inf
        else:
            values[name] = unit_of(name).to_si(float(value))
    return values
