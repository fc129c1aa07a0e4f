"""Table of how improbable it is to be beyond limits."""

from collections.abc import Sequence

import pandas as pd

from drakesep.analysis.campaigns.subset_simulation import RareProbability
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.tables.requirement_tables import identity_columns, limit_columns
from drakesep.units import unit_of


_CONFIDENCE = 0.95
"""Of the intervals."""


def rare_events_table(
    found: Sequence[tuple[Requirement, RareProbability]], bodies: Sequence[str]
) -> pd.DataFrame:
    """Return a row for each requirement: the probability to be beyond its limit.

    Args:
        found: of each requirement.
        bodies: names of those that leave; that of the first pair is the first.
    """
    rows = []
    for requirement, rare in found:
        _, low, high = rare.within(_CONFIDENCE)
        rows.append(
            {
                **limit_columns(requirement, unit_of(requirement.metric)),
                "probability": rare.probability,
                # How little those are that have not reached the limit nobody knows.
                "from": 0.0 if rare.unreached else low,
                "to": high,
                "variation": rare.variation,
                "simulations": len(rare.replicates),
                "unreached": rare.unreached,
                "runs": rare.runs,
                "untold": rare.untold,
                **identity_columns(requirement, bodies),
            }
        )
    return pd.DataFrame(rows)
