"""Tables of what speaks for a worst case."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.judge import CONFIDENCE, WorstCase
from drakesep.analysis.search.problem import Searched
from drakesep.analysis.search.registry import SEARCHES
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.tables.columns import in_units, shown, unit_of_objective
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Worst
from drakesep.tables.table_4 import MARK, MARKS
from drakesep.units import unit_of, with_unit


_LISTED = 10
"""Local maxima that a table lists."""


class Flown(NamedTuple):
    """How searches were told an objective."""

    by: str
    """`BATCH` by its metrics; or run by run, whole runs of the batch engine or of
    Drake."""
    run_by_run: int
    """How many runs that took; 0 by its metrics."""


BATCH = "batch"
BATCH_RUNS, DRAKE_RUNS = "batch, run by run", "Drake, run by run"


def evidence_table(
    worst: Sequence[WorstCase],
    objectives: Sequence[Objective],
    runs: Sequence[LabelledRun],
    flown: Mapping[str, Flown],
) -> pd.DataFrame:
    """Return a row for each worst case, with why it may be believed.

    Values are those of the metric that an objective makes large or small.
    """
    in_drake_of = {
        one.role: one.objective_in_drake
        for one in runs
        if one.objective_in_drake is not None
    }
    beaten_by = {one.role: one.beaten_by for one in runs}
    rows = []
    for case in worst:
        objective, proof = objectives[case.objective], case.evidence
        in_drake = in_drake_of.get(Worst(case.name), math.nan)
        maxima = [
            f"{shown(objective, value):.8g} ({count})"
            for value, count in proof.local_maxima
        ]
        more = len(maxima) - _LISTED
        rows.append(
            {
                "objective": case.name,
                "unit": unit_of_objective(objective).symbol,
                "worst": shown(objective, case.value),
                "in_drake": shown(objective, in_drake),
                "difference": shown(objective, in_drake - case.value),
                "beaten_by": beaten_by.get(Worst(case.name), ""),
                "found_by": case.search,
                "flown_by": flown[case.name].by,
                "run_by_run": flown[case.name].run_by_run,
                **{
                    name: shown(objective, proof.by_search[name])
                    for name in SEARCHES
                    if name in proof.by_search
                },
                "starts": proof.starts,
                "ended_there": proof.ended_there,
                "local_maxima": ", ".join(maxima[:_LISTED])
                + (f", {more} more" if more > 0 else ""),
                "unfinished": proof.unfinished,
                "at_bounds": sum(bool(mark) for mark in proof.optimality.active),
                "active_constraints": " ".join(
                    dict.fromkeys(label for label, _ in proof.optimality.constraints)
                ),
                "optimality_residual": proof.optimality.residual,
                "random_samples": proof.samples,
                "failed_samples": proof.failed_samples,
                f"fraction_beyond_at_{CONFIDENCE:.0%}".replace("%", "_percent"): (
                    proof.fraction
                ),
            }
        )
    return pd.DataFrame(rows)


def searches_table(
    searched: Sequence[Searched], share_unphysical: float
) -> pd.DataFrame:
    """Return a row for each search: what it looked at, and what failed."""
    return pd.DataFrame(
        {
            "search": search.search,
            "what": search.note,
            "points": search.points,
            "failed": sum(search.failures.values()),
            "first_failure": next(iter(search.failures), ""),
            "unphysical_share_of_tolerances": share_unphysical,
        }
        for search in searched
    )


def candidates_table(
    searched: Sequence[Searched], objectives: Sequence[Objective], box: ToleranceBox
) -> pd.DataFrame:
    """Return a row for the best point of each search, for each objective."""
    rows = []
    for search in searched:
        for k, objective in enumerate(objectives):
            best = search.best(k)
            if best is not None:
                rows.append(
                    {
                        "objective": objective.name,
                        "search": search.search,
                        "value": shown(objective, best.value),
                        "unit": unit_of_objective(objective).symbol,
                        **in_units(box.values(best.u)),
                    }
                )
    return pd.DataFrame(rows)


def worst_points_table(worst: Sequence[WorstCase], box: ToleranceBox) -> pd.DataFrame:
    """Return a row for each parameter: M, m, or its value, at each worst case."""
    columns: dict[str, list[str]] = {"parameter": [with_unit(n) for n in box.names]}
    for case in worst:
        sides = box.sides_of(case.u, MARK).tolist()
        columns[case.name] = [
            MARKS.get(side) or f"{unit_of(name).from_si(case.values[name]):.6g}"
            for name, side in zip(box.names, sides, strict=True)
        ]
    return pd.DataFrame(columns)


def sensitivities_table(
    worst: Sequence[WorstCase],
    objectives: Sequence[Objective],
    nominal_slopes: np.ndarray | None,
    box: ToleranceBox,
) -> pd.DataFrame:
    """Return what a whole tolerance does to each objective's metric, to first order.

    Also what either of its sides does, where they differ: the larger is the tolerance.
    A row for each objective and parameter, those that matter most at the worst case
    first; the multiplier is what the objective would gain for a whole tolerance more.
    """
    rows = []
    for case in worst:
        assert nominal_slopes is not None
        objective, first_order = objectives[case.objective], case.evidence.optimality
        order = np.argsort(-np.abs(first_order.slopes), kind="stable")
        for i in order.tolist():
            dispersion, from_si = box.dispersions[i], unit_of(box.names[i]).from_si
            slopes = {
                "nominal": shown(objective, nominal_slopes[case.objective, i]),
                "worst": shown(objective, first_order.slopes[i]),
            }
            rows.append(
                {
                    "objective": case.name,
                    "unit": unit_of_objective(objective).symbol,
                    "parameter": with_unit(dispersion.name),
                    "tolerance": from_si(box.tolerance[i]),
                    "minus": from_si(dispersion.sides.minus),
                    "plus": from_si(dispersion.sides.plus),
                    **{f"per_tolerance_at_{at}": x for at, x in slopes.items()},
                    **{
                        f"downward_at_{at}": x * box.lower[i]
                        for at, x in slopes.items()
                    },
                    **{f"upward_at_{at}": x * box.upper[i] for at, x in slopes.items()},
                    "at_worst": first_order.active[i],
                    "multiplier": abs(shown(objective, first_order.multipliers[i])),
                }
            )
    return pd.DataFrame(rows)
