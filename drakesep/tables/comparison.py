"""The objectives of the paper: nominal, published, and worst."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.tables.labelled_run import LabelledRun
from drakesep.units import unit_of


if TYPE_CHECKING:  # JAX comes with them
    pass


def comparison_table(runs: Sequence[LabelledRun]) -> pd.DataFrame:
    """Return, for each objective of the paper, its values: nominal, published, worst.

    SQP is the paper's method; the worst is that of all runs. Increases are percentages
    of the nominal and of the published magnitude.
    """
    flown = [labelled for labelled in runs if labelled.metrics]
    searched = {labelled.objective for labelled in flown}
    rows = []
    for objective in [name for name in OBJECTIVES if name in searched]:
        name = f"G_{objective}"
        unit = unit_of(name)
        values = {labelled.label: labelled.metrics[name] for labelled in flown}
        published = [
            values[labelled.label]
            for labelled in flown
            if labelled.published and objective in labelled.published.objectives
        ]
        # Of runs as bad, the one that bears the name.
        label = max(
            values, key=lambda label: (values[label], label.startswith("worst_"))
        )
        nominal, worst = flown[0].metrics[name], values[label]
        reference = max(published, default=math.nan)
        rows.append(
            {
                "objective": name,
                "unit": unit.symbol,
                "nominal": unit.from_si(nominal),
                "published": unit.from_si(reference),
                "sqp": unit.from_si(values.get(f"sqp_{objective}", math.nan)),
                "worst": unit.from_si(worst),
                "which_run": label,
                "above_nominal_percent": _increase(nominal, worst),
                "above_published_percent": _increase(reference, worst),
            }
        )
    return pd.DataFrame(rows)


_ROUND_OFF = 1e-12
"""A reference below this part of a value is zero but for round-off."""


def _increase(reference: float, value: float) -> float:
    if abs(reference) <= _ROUND_OFF * abs(value):
        return math.nan
    return 100.0 * (value - reference) / abs(reference)
