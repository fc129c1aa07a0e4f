"""Up to which growth of the tolerances a requirement holds, in words."""

import math
from collections.abc import Mapping
from typing import Any, TypeAlias


Row: TypeAlias = Mapping[Any, Any]
"""Of `drakesep.tables.requirement_tables.requirements_table`."""


def all_by(row: Row) -> str:
    """Return the factor on all tolerances, or up to which none was found."""
    if math.isnan(row["growth_factor"]):
        return str(row["growth_by"])
    if math.isinf(row["growth_factor"]):
        return f"none up to {row['looked_up_to']:.4g}"
    return f"{row['growth_factor']:.4g}"


def one_by(row: Row) -> str:
    """Return the factor on the tolerance that violates it first, and its name."""
    name, factor = row["first_tolerance"], row["its_growth_factor"]
    if math.isinf(factor):
        return "none"
    return str(name) if math.isnan(factor) else f"{factor:.4g} {name}"
