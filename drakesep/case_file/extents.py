"""How far a value may go from its nominal, as case files state it."""

import math
import re
from collections.abc import Mapping
from typing import Annotated, Any, Self, TypeAlias

from pydantic import BeforeValidator, Discriminator, Tag, model_validator

from drakesep.analysis.tolerances import sides
from drakesep.analysis.tolerances.sides import Sides
from drakesep.case_file.errors import UNNAMED, CaseError, shown
from drakesep.case_file.section import Section
from drakesep.units import unit_of


_PERCENT = re.compile(r"\s*(\d+(?:\.\d+)?(?:[eE]-?\d+)?)\s*%\s*")


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


def check_width(value: Any) -> Any:
    """Return a number or a share; raise ValueError unless it is above zero."""
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
Width: TypeAlias = Annotated[float | str, BeforeValidator(check_width)]
"""The same, above zero."""


class BoundsSection(Section):
    """From where to where a value may go, by its bounds or by its sides.

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
    def check(self) -> Self:
        """Raise ValueError unless there are bounds, or sides."""
        self.check_bounds()
        return self

    def check_bounds(self) -> None:
        """Raise ValueError unless there are both bounds, or both sides."""
        got = self.bounds_given
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

    @property
    def bounds_given(self) -> list[str]:
        """The keys of bounds and of sides that are given."""
        keys = BoundsSection.model_fields
        return [key for key in keys if getattr(self, key) is not None]

    def sides_in_si(self, key: str, name: str, nominal: float) -> Sides:
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
                minus=side_in_si(f"{key}: minus", name, self.minus, nominal),
                plus=side_in_si(f"{key}: plus", name, self.plus, nominal),
            )
        lower, upper = unit.to_si(self.lower), unit.to_si(self.upper)
        if not lower <= nominal <= upper:
            raise CaseError(
                f"{key}: lower and upper must hold the nominal, "
                f"{unit.from_si(nominal):g}, got {self.lower:g} to {self.upper:g}"
            )
        return Sides(minus=nominal - lower, plus=upper - nominal)


def number_or_section(value: Any) -> str:
    """Return the tag of a section, or of a number."""
    return UNNAMED if isinstance(value, Mapping | Section) else "number"


def check_number(value: Any) -> Any:
    """Return a section, or what is above zero; raise ValueError if it is not."""
    section = number_or_section(value) == UNNAMED
    return value if section else check_width(value)


Extent: TypeAlias = Annotated[
    Annotated[float | str, Tag("number")] | Annotated[BoundsSection, Tag(UNNAMED)],
    Discriminator(number_or_section),
    BeforeValidator(check_number),
]
"""To either side, a number in the unit of the key or a share such as ``5 %``; or bounds
or sides."""


def extent_in_si(key: str, name: str, extent: Extent, nominal: float) -> sides.Extent:
    """Return it.

    Args:
        key: of the parameter, for errors.
        name: of the parameter, without unit.
        extent: as a case file has it.
        nominal: value of the parameter, in SI.

    Raises:
        CaseError: the nominal is beyond a bound, or a share is one of zero.
    """
    if isinstance(extent, BoundsSection):
        return extent.sides_in_si(key, name, nominal)
    return side_in_si(key, name, extent, nominal)


def side_in_si(key: str, name: str, side: Side, nominal: float) -> float:
    """Return a number or a share of the nominal.

    Args:
        key: of it, for errors.
        name: of the parameter, without unit.
        side: as a case file has it.
        nominal: value of the parameter, in SI.

    Raises:
        CaseError: a share is one of zero.
    """
    if not isinstance(side, str):
        return unit_of(name).to_si(side)
    found = _PERCENT.fullmatch(side)
    assert found is not None  # _check_side
    if nominal == 0.0:
        raise CaseError(
            f"{key}: a share must be of a nominal that is not zero, got {side} of 0"
        )
    return abs(nominal) * float(found[1]) / 100.0
