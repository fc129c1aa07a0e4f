"""Dispersions as a case file states them: of one parameter, or of all that fit."""

import fnmatch
import re
from collections.abc import Mapping
from typing import Annotated, TypeAlias, TypeVar

from pydantic import BeforeValidator, Discriminator, Tag

from drakesep.analysis.tolerances import sides
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.sides import check_matters
from drakesep.case_file.distributions import ToleranceSection
from drakesep.case_file.errors import UNNAMED, CaseError
from drakesep.case_file.extents import check_number, number_or_section, side_in_si
from drakesep.case_file.section import Section
from drakesep.systems.checks import unknown
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation
from drakesep.units import with_unit


_WILD = re.compile(r"[*?\[]")

Tolerance: TypeAlias = Annotated[
    Annotated[float | str, Tag("number")] | Annotated[ToleranceSection, Tag(UNNAMED)],
    Discriminator(number_or_section),
    BeforeValidator(check_number),
]
"""To either side, a number in the unit of the key or a share such as ``5 %``; or
bounds, sides, or a distribution."""


class RankCorrelationSection(Section):
    """Dispersed parameters that are correlated in a campaign.

    Each keeps its own distribution; searches do not look at it.
    """

    of: list[str]
    """Keys of `dispersions`, or patterns of such; any two are correlated."""
    rank: float
    """Spearman's rank correlation, between -1 and 1."""

    def in_si(self, separation: Separation) -> RankCorrelation:
        """Return it.

        Raises:
            CaseError: a name is unknown, or a pattern fits none.
        """
        names = {with_unit(name): name for name in parameters(separation)}
        of = names_fitting(names, dict.fromkeys(self.of))
        return RankCorrelation(names=tuple(name for _, name, _ in of), rank=self.rank)


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
        ValueError: there is no such distribution.
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
    return side_in_si(key, name, value, nominal)
