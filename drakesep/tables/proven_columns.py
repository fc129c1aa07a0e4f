"""What is proven of a requirement, as columns beside what else is said of it."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from drakesep.analysis.metrics.requirements import Requirement, Verdict
from drakesep.units import Unit


if TYPE_CHECKING:
    from drakesep.analysis.bounds.answers import ProvenAnswer


def proven_columns(answer: "ProvenAnswer", unit: Unit) -> dict[str, float]:
    """Return the bound, and its gap to the worst found."""
    return {
        "proven_bound": unit.from_si(answer.value),
        "gap_percent": 100.0 * answer.gap,
    }


def beside_requirement(
    requirement: Requirement, unit: Unit, proven: "Mapping[Requirement, ProvenAnswer]"
) -> dict[str, str | float]:
    """Return what a row of a requirement says of its bound, if one was asked for.

    Args:
        requirement: of the row.
        unit: of its limit.
        proven: the answers, by the requirements.
    """
    answer = proven.get(requirement)
    if answer is None:
        nothing = dict.fromkeys(("proven_bound", "gap_percent"), math.nan)
        return {**nothing, "proven": Verdict.NOT_LOOKED_AT.value}
    return {**proven_columns(answer, unit), "proven": answer.verdict}
