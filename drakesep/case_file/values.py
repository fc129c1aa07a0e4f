"""Parameter values by the names that carry their units."""

import math
from collections.abc import Mapping

from drakesep.case_file.errors import CaseError
from drakesep.systems.checks import check_finite, unknown
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation
from drakesep.units import unit_of, with_unit


def values_in_si(
    separation: Separation, values: Mapping[str, float]
) -> dict[str, float]:
    """Return parameter values in SI, by the names without units.

    Args:
        separation: whose parameters they are.
        values: by the names with units, such as ``payload.cg_x_mm``.

    Raises:
        CaseError: a name is unknown.
        ValueError: a value is not a number.
    """
    known = _names(separation)
    in_si = {}
    for key, value in values.items():
        name = _known(key, known)
        if value != math.inf:  # never, of a time of release
            check_finite(key, value)
        in_si[name] = unit_of(name).to_si(value)
    return in_si


def parameter_of(separation: Separation, key: str) -> str:
    """Return the parameter that a name with unit means.

    Raises:
        CaseError: the name is unknown.
    """
    return _known(key, _names(separation))


def _names(separation: Separation) -> dict[str, str]:
    return {with_unit(name): name for name in parameters(separation)}


def _known(key: str, names: Mapping[str, str]) -> str:
    if key not in names:
        raise CaseError(unknown("parameter", key, names))
    return names[key]
