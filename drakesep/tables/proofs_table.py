"""Table of what is proven: bounds beside the worst found, and beside limits."""

import math
from collections.abc import Sequence

import pandas as pd

from drakesep.analysis.bounds.answers import ProvenAnswer
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.registry import find_metric
from drakesep.tables.proven_columns import proven_columns
from drakesep.tables.requirement_tables import (
    identity_columns,
    limit_columns,
    unit_of_limit,
)
from drakesep.units import SI, Unit, unit_of


def proofs_table(
    answers: Sequence[ProvenAnswer],
    bodies: Sequence[str],
    functions: Sequence[FunctionRequirement] = (),
) -> pd.DataFrame:
    """Return a row for each requirement and axis, then for each objective.

    Args:
        answers: of the requirements and the objectives.
        bodies: names of those that leave; that of the first pair is the first.
        functions: that are required, some of the answers are of them.
    """
    rows = []
    for answer in answers:
        requirement = answer.question.requirement
        unit = _unit(answer, functions)
        bound = answer.bound
        rows.append(
            {
                **_asked(answer, unit),
                "objective": answer.question.objective,
                **proven_columns(answer, unit),
                "found": unit.from_si(answer.found),
                "found_by": answer.found_by,
                "verdict": answer.verdict,
                "reason": answer.reason,
                "claim": "" if bound is None else answer.question.claim,
                "boxes": None if bound is None else bound.proof.boxes,
                **(
                    dict.fromkeys(("pair", "id", "source"), "")
                    if requirement is None
                    else identity_columns(requirement, bodies)
                ),
            }
        )
    return pd.DataFrame(rows).astype({"boxes": "Int64"})


def _unit(answer: ProvenAnswer, functions: Sequence[FunctionRequirement]) -> Unit:
    requirement, metric = answer.question.requirement, answer.question.metric
    if requirement is not None:
        return unit_of_limit(requirement, functions)
    return SI if find_metric(metric) is None else unit_of(metric)


def _asked(answer: ProvenAnswer, unit: Unit) -> dict[str, str | float]:
    """Return what a row says first: the limit, or the side of an objective."""
    requirement = answer.question.requirement
    if requirement is not None:
        return limit_columns(requirement, unit)
    return {
        **dict.fromkeys(("requirement", "axis"), ""),
        "unit": unit.symbol,
        "sense": "<=" if answer.question.side == "highest" else ">=",
        **dict.fromkeys(("limit", "share", "confidence"), math.nan),
        "sides": "",
    }
