"""The objectives of the paper: nominal, published, and worst."""

import math
from collections.abc import Sequence

import pandas as pd

from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.analysis.search.problem import FROM_NOMINAL
from drakesep.tables.labelled_run import LabelledRun, nominal_of
from drakesep.tables.roles import SearchEnd, Worst
from drakesep.units import unit_of


def comparison_table(runs: Sequence[LabelledRun]) -> pd.DataFrame:
    """Return, for each objective of the paper, its values: nominal, published, worst.

    SQP is the paper's method; the worst is that of all runs. Increases are percentages
    of the nominal and of the published magnitude.
    """
    flown = [one for one in runs if one.metrics]
    searched = {one.objective for one in flown}
    rows = []
    for objective in [name for name in OBJECTIVES if name in searched]:
        name = f"G_{objective}"
        unit = unit_of(name)
        published = [
            one.metrics[name]
            for one in flown
            if one.published and objective in one.published.objectives
        ]
        # Of runs as bad, one that is a worst case.
        worst_run = max(
            flown, key=lambda one: (one.metrics[name], isinstance(one.role, Worst))
        )
        nominal, worst = nominal_of(flown).metrics[name], worst_run.metrics[name]
        reference = max(published, default=math.nan)
        sqp = SearchEnd(FROM_NOMINAL, objective)
        by_sqp = [one.metrics[name] for one in flown if one.role == sqp]
        rows.append(
            {
                "objective": name,
                "unit": unit.symbol,
                "nominal": unit.from_si(nominal),
                "published": unit.from_si(reference),
                "sqp": unit.from_si(max(by_sqp, default=math.nan)),
                "worst": unit.from_si(worst),
                "which_run": worst_run.label,
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
