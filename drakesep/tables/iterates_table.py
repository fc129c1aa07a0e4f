"""Table of the iterates of searches by SQP: the way of each of their ascents."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.problem import Iterate, Searched
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.tables.columns import in_units, shown, unit_of_objective


def iterates_table(
    searched: Sequence[Searched], objectives: Sequence[Objective], box: ToleranceBox
) -> pd.DataFrame:
    """Return a row for each iterate: of one search after another, in its order.

    Within a search by objective and start, whatever was flown beside what.

    Args:
        searched: what came of each search.
        objectives: of the study.
        box: the tolerances.
    """
    rows = []
    for search in searched:
        ascents = [c for c in search.candidates if c.ascent is not None]
        for one in sorted(ascents, key=lambda c: (c.objective, c.start)):
            assert one.ascent is not None
            for iteration in one.ascent.history:
                iterate = Iterate(one.objective, one.start, iteration)
                rows.append(iterate_row(search.search, iterate, objectives, box))
    return pd.DataFrame(rows)


def iterate_row(
    search: str, iterate: Iterate, objectives: Sequence[Objective], box: ToleranceBox
) -> dict[str, Any]:
    """Return the row of an iterate.

    Args:
        search: its name.
        iterate: of it.
        objectives: of the study.
        box: the tolerances.
    """
    objective, iteration = objectives[iterate.objective], iterate.iteration
    return {
        "objective": objective.name,
        "search": search,
        "start": iterate.start,
        "iteration": iteration.number,
        "value": shown(objective, iteration.value),
        "unit": unit_of_objective(objective).symbol,
        "evaluations": iteration.evaluations,
        **in_units(box.values(iteration.u)),
    }
