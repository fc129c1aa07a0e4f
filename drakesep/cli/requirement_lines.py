"""Tables of requirements as the command line prints them: narrow, whole rows.

The files have a column for everything; on a console of eighty columns a row is to be
read whole, and says by itself which requirement it is of.
"""

import math
from collections.abc import Sequence

import pandas as pd

from drakesep.tables.growth_words import Row, all_by, one_by
from drakesep.units import share_words


_VALUES = ("nominal", "worst", "value", "margin", "verdict")
"""Columns that follow the limit, as far as there are any."""


def requirement_lines(frame: pd.DataFrame, bodies: Sequence[str]) -> pd.DataFrame:
    """Return a row for each requirement, with its limit and what came of it.

    Args:
        frame: of `drakesep.tables.requirement_tables`.
        bodies: names of those that leave.
    """
    return pd.DataFrame(
        {
            **requirement_names_and_limits(frame, bodies),
            **{name: frame[name] for name in _VALUES if name in frame},
        }
    )


def requirement_names_and_limits(
    frame: pd.DataFrame, bodies: Sequence[str]
) -> dict[str, list[str]]:
    """Return what names each requirement, and its limit, as columns.

    Args:
        frame: of `drakesep.tables.requirement_tables`, or of campaigns.
        bodies: names of those that leave.
    """
    return {"requirement": _names(frame, bodies), "limit": _limits(frame)}


def growth_lines(frame: pd.DataFrame, bodies: Sequence[str]) -> pd.DataFrame:
    """Return how far tolerances may grow until each requirement is violated.

    Args:
        frame: of `drakesep.tables.requirement_tables.requirements_table`.
        bodies: names of those that leave.
    """
    return pd.DataFrame(
        {
            "requirement": _names(frame, bodies),
            "all by": list(map(all_by, frame.to_dict("records"))),
            "one alone by": list(map(one_by, frame.to_dict("records"))),
        }
    )


def _names(frame: pd.DataFrame, bodies: Sequence[str]) -> list[str]:
    """Return what names each requirement: quantity, axis, whose it is, and its id."""
    names = []
    for row in frame.to_dict("records"):
        name = f"{row['requirement']} {row['axis']}".strip()
        if row["pair"] not in ("", *bodies) or len(bodies) > 1:
            name += f", {row['pair'] or 'all'}"
        names.append(f"{name} ({row['id']})" if row["id"] else name)
    return names


def _share(row: Row) -> str:
    return "" if math.isnan(row["share"]) else share_words(row["share"])


def _limits(frame: pd.DataFrame) -> list[str]:
    return [
        f"{row['sense']} {row['limit']:.10g} {row['unit']}".strip() + _share(row)
        for row in frame.to_dict("records")
    ]
