"""The objectives of a case, and those of them that are wanted."""

from collections.abc import Sequence

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.objective import LOWEST, LowestClearance
from drakesep.analysis.metrics.objectives import (
    OBJECTIVES,
    AnyObjective,
    Objective,
    as_objective,
)
from drakesep.case_file.case import Case
from drakesep.systems.checks import InputError


def case_objectives(case: Case | AnalysisCase) -> dict[str, Objective]:
    """Return the objectives of a case by name: the paper's, and each requirement's."""
    record = case.in_si() if isinstance(case, Case) else case
    objectives = [*OBJECTIVES.values(), *record.requirement_objectives]
    return {objective.name: objective for objective in objectives}


def choose_objectives(
    case: AnalysisCase, wanted: Sequence[AnyObjective] | AnyObjective | None
) -> tuple[Objective, ...]:
    """Return the objectives that are wanted; all of the case if None.

    Raises:
        ValueError: one is unknown, or two have the same name.
    """
    known = case_objectives(case)
    if wanted is None:
        return tuple(known.values())
    if case.has_clearance:
        clearance = case.lowest_clearance()
        known.setdefault(clearance.name, clearance)
    listed = [wanted] if isinstance(wanted, str) or callable(wanted) else wanted
    if LOWEST in listed and not case.has_clearance:
        raise InputError(
            "lowest_clearance: needs geometry on two bodies that does not touch while "
            "mated, got none"
        )
    if not listed:
        raise InputError("objectives: must be one or more, got none")
    chosen = [
        known[objective]
        if isinstance(objective, str) and objective in known
        else as_objective(objective, known)
        for objective in dict.fromkeys(listed)
    ]
    names = [objective.name for objective in chosen]
    for objective in chosen:
        if objective.name in known and objective is not known[objective.name]:
            raise InputError(
                f"objectives: {objective.name!r} is the name of one of the case's own; "
                "give yours another with objective.named(...)"
            )
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"objectives: names must differ, got {name!r} twice; "
                "give one another with objective.named(...)"
            )
    return tuple(chosen)


def the_clearance(objectives: Sequence[Objective]) -> LowestClearance | None:
    """Return the first of objectives that is a clearance; None if there is none."""
    return next((o for o in objectives if isinstance(o, LowestClearance)), None)
