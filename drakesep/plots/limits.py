"""How plots draw limits, and what they say of them."""

from typing import Any

from drakesep.analysis.metrics.requirements import Requirement
from drakesep.units import share_words, unit_of


LIMIT: dict[str, Any] = {"color": "#B00020", "ls": (0, (8, 3)), "lw": 1.4, "zorder": 5}
"""How its line is drawn."""
SIGNS = {"<=": "≤", ">=": "≥", "<": "<", ">": ">"}
"""How senses of limits are written."""


def limit_words(requirement: Requirement) -> str:
    """Return a limit in words, with its id, such as ``UM-4.2: ≥ 30 mm``."""
    unit = unit_of(requirement.metric)
    words = "no contact"
    if not requirement.forbids_contact:
        limit = unit.from_si(requirement.limit)
        words = f"{SIGNS[requirement.sense]} {limit:.4g} {unit.symbol}"
    words += share_words(requirement.share)
    return f"{requirement.id}: {words}" if requirement.id else words
