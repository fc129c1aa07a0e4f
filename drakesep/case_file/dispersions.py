"""Tolerances as a case file states them: numbers, shares, bounds, sides, patterns."""

import fnmatch
import math
import re
from collections.abc import Mapping
from typing import Annotated, Any, Self, TypeAlias, TypeVar

from pydantic import BeforeValidator, Discriminator, Tag, model_validator

from drakesep.analysis.tolerances import sides
from drakesep.analysis.tolerances.sides import Sides, check_matters
from drakesep.case_file.errors import UNNAMED, CaseError, shown
from drakesep.case_file.section import Section
from drakesep.systems.checks import unknown
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation
from drakesep.units import unit_of, with_unit


_PERCENT = re.compile(r"\s*(\d+(?:\.\d+)?(?:[eE]-?\d+)?)\s*%\s*")
_WILD = re.compile(r"[*?\[]")


def _check_side(value: Any) -> Any:
    if isinstance(value, str) and _PERCENT.fullmatch(value):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(
            "must be a number, or a share of the nominal such as 5 %, got "
            f"{shown(value)}"
        )
    if not 0 <= value < math.inf:
        raise ValueError(f"must be finite and >= 0, got {value}")
    return value


def _check(value: Any) -> Any:
    if isinstance(value, Mapping | ToleranceSection):
        return value
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if number and not 0 < value < math.inf:
        raise ValueError(f"must be finite and > 0, got {value}")
    _check_side(value)
    if _is_zero(value):
        raise ValueError(f"must be > 0, got {value!r}")
    return value


def _is_zero(side: float | str) -> bool:
    """Return whether a side that is checked is zero, or a share of 0 %."""
    share = _PERCENT.fullmatch(str(side))
    return float(share[1] if share else side) == 0.0


Side: TypeAlias = Annotated[float | str, BeforeValidator(_check_side)]
"""To one side: a number in the unit of the key, or a share such as ``5 %``."""


class ToleranceSection(Section):
    """A tolerance whose nominal need not be its middle, by its bounds or by its sides.

    Numbers are in the unit of the parameter.
    """

    lower: float | None = None
    """Least value of the parameter; with `upper`."""
    upper: float | None = None
    """Its greatest value."""
    minus: Side | None = None
    """How far it may go below its nominal, 0: not at all; with `plus`."""
    plus: Side | None = None
    """How far above."""

    @model_validator(mode="after")
    def _check_sides(self) -> Self:
        keys = ("lower", "upper", "minus", "plus")
        got = [key for key in keys if getattr(self, key) is not None]
        if got not in (["lower", "upper"], ["minus", "plus"]):
            raise ValueError(
                "must have lower and upper, or minus and plus, got "
                f"{' and '.join(got) or 'none'}"
            )
        if self.lower is not None and self.upper is not None:
            if not self.lower < self.upper:
                raise ValueError(
                    f"upper must be > lower, got {self.lower:g} to {self.upper:g}"
                )
        elif all(
            _is_zero(side) for side in (self.minus, self.plus) if side is not None
        ):
            raise ValueError("minus or plus must be > 0, got 0 for both")
        return self

    def in_si(self, key: str, name: str, nominal: float) -> Sides:
        """Return it.

        Args:
            key: of the parameter, for errors.
            name: of the parameter, without unit.
            nominal: value of the parameter, in SI.

        Raises:
            CaseError: the nominal is beyond a bound, or a share is one of zero.
        """
        unit = unit_of(name)
        if self.lower is None or self.upper is None:
            assert self.minus is not None
            assert self.plus is not None
            return Sides(
                minus=_in_si(f"{key}: minus", name, self.minus, nominal),
                plus=_in_si(f"{key}: plus", name, self.plus, nominal),
            )
        lower, upper = unit.to_si(self.lower), unit.to_si(self.upper)
        if not lower <= nominal <= upper:
            raise CaseError(
                f"{key}: lower and upper must hold the nominal, "
                f"{unit.from_si(nominal):g}, got {self.lower:g} to {self.upper:g}"
            )
        return Sides(minus=nominal - lower, plus=upper - nominal)


Tolerance: TypeAlias = Annotated[
    Annotated[float | str, Tag("number")] | Annotated[ToleranceSection, Tag(UNNAMED)],
    Discriminator(
        lambda value: (
            UNNAMED if isinstance(value, Mapping | ToleranceSection) else "number"
        )
    ),
    BeforeValidator(_check),
]
"""To either side, a number in the unit of the key or a share such as ``5 %``; or bounds
or sides."""


def tolerances_in_si(
    separation: Separation, dispersions: Mapping[str, Tolerance]
) -> dict[str, sides.Tolerance]:
    """Return tolerances by parameter names without units, in SI.

    Args:
        separation: gives the nominal values.
        dispersions: by names with units, or by patterns of such names, as
            ``spring_*.force_max_N``: each parameter that fits has its own. One that is
            named has what stands at its name.

    Raises:
        CaseError: a name is unknown, a pattern fits none, two patterns fit the same
            parameter, a share is one of zero, or a nominal is beyond a bound.
    """
    nominal = parameters(separation)
    names = {with_unit(name): name for name in nominal}
    tolerances = {}
    for key, name, value in names_fitting(names, dispersions):
        tolerance = _tolerance(key, name, value, nominal[name])
        check_matters(key, nominal[name], tolerance)
        tolerances[name] = tolerance
    return tolerances


_Value = TypeVar("_Value")


def names_fitting(
    names: Mapping[str, str], stated: Mapping[str, _Value]
) -> list[tuple[str, str, _Value]]:
    """Return what is stated of each parameter: its key, name and value.

    Args:
        names: of the parameters, by the same with their units.
        stated: values by names with units, or by patterns of such names: each
            parameter that fits has its own. One that is named has what stands at its
            name.

    Raises:
        CaseError: a name is unknown, a pattern fits none, or two patterns fit the same
            parameter.
    """
    found: dict[str, tuple[str, _Value]] = {}
    for key, value in stated.items():
        for fitting in _fitting(key, names):
            is_named = fitting in stated
            if is_named and fitting != key:
                continue
            if not is_named and fitting in found:
                raise CaseError(
                    f"{fitting}: must fit one pattern, got {found[fitting][0]} and "
                    f"{key}"
                )
            found[fitting] = key, value
    return [(name, names[name], value) for name, (_, value) in found.items()]


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


def _tolerance(
    key: str, name: str, value: Tolerance, nominal: float
) -> sides.Tolerance:
    if isinstance(value, ToleranceSection):
        return value.in_si(key, name, nominal)
    return _in_si(key, name, value, nominal)


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
