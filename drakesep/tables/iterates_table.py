"""Table of the iterates of searches by SQP: the way of each of their ascents."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.problem import Iterate, Searched
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.tables.columns import shown, unit_of_objective
from drakesep.units import unit_of, with_unit


def iterates_of(searched: Sequence[Searched]) -> list[tuple[str, Iterate]]:
    """Return all iterates with the names of their searches, one search after another.

    Within a search by objective and start, whatever was flown beside what.

    Args:
        searched: what came of each search.
    """
    return [
        (search.search, Iterate(one.objective, one.start, iteration))
        for search in searched
        for one in sorted(search.candidates, key=lambda c: (c.objective, c.start))
        if one.ascent is not None
        for iteration in one.ascent.history
    ]


def iterates_table(
    iterates: Sequence[tuple[str, Iterate]],
    objectives: Sequence[Objective],
    box: ToleranceBox,
) -> pd.DataFrame:
    """Return a row for each iterate.

    Args:
        iterates: each with the name of its search.
        objectives: of the study.
        box: the tolerances.
    """
    each = [(objectives[i.objective], i.iteration) for _, i in iterates]
    u = np.reshape([iteration.u for _, iteration in each], (-1, len(box)))
    values = box.nominal + box.tolerance * u
    return pd.DataFrame(
        {
            "objective": [objective.name for objective, _ in each],
            "search": [search for search, _ in iterates],
            "start": [iterate.start for _, iterate in iterates],
            "iteration": [iteration.number for _, iteration in each],
            "value": [shown(objective, i.value) for objective, i in each],
            "unit": [unit_of_objective(objective).symbol for objective, _ in each],
            "evaluations": [iteration.evaluations for _, iteration in each],
            **{
                with_unit(name): [*map(unit_of(name).from_si, column)]
                for name, column in zip(box.names, values.T.tolist(), strict=True)
            },
        }
    )
