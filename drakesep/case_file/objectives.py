"""The objectives of a case, and those of them that are wanted."""

from collections.abc import Sequence
from typing import TypeAlias

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
    """Return the objectives of a case by name.

    What leads out of each requirement; and the paper's, if it says `objectives: paper`.
    """
    record = case.in_si() if isinstance(case, Case) else case
    objectives = [*record.paper_objectives, *record.requirement_objectives]
    return {objective.name: objective for objective in objectives}


Wanted: TypeAlias = Sequence[AnyObjective] | AnyObjective
"""One or several."""


def choose_objectives(
    case: AnalysisCase, wanted: Wanted | None, also: Wanted = ()
) -> tuple[Objective, ...]:
    """Return the objectives that are wanted; all of the case if None.

    Args:
        case: with objectives of its own.
        wanted: instead of these.
        also: beside them.

    Raises:
        ValueError: there is none, one is unknown, or two have the same name.
    """
    own = case_objectives(case)
    known = {**OBJECTIVES, **own}
    if case.has_clearance and LOWEST not in known:
        known[LOWEST] = case.lowest_clearance()
    listed = [*(own if wanted is None else _listed(wanted)), *_listed(also)]
    if LOWEST in listed and not case.has_clearance:
        raise InputError(
            "lowest_clearance: needs geometry on two bodies that does not touch while "
            "mated, got none"
        )
    if not listed and wanted is None:
        raise InputError(
            f"objectives: {case.name} has no requirement and no 'objectives: paper': "
            f"must be given, such as {', '.join(OBJECTIVES)}, or highest_ or lowest_ "
            "and a metric; got none"
        )
    if not listed:
        raise InputError("objectives: must be one or more, got none")
    each = (
        known[objective]
        if isinstance(objective, str) and objective in known
        else as_objective(objective, known)
        for objective in dict.fromkeys(listed)
    )
    chosen = list(dict.fromkeys(each))
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


def _listed(wanted: Wanted) -> Sequence[AnyObjective]:
    return [wanted] if isinstance(wanted, str) or callable(wanted) else wanted


def the_clearance(objectives: Sequence[Objective]) -> LowestClearance | None:
    """Return the first of objectives that is a clearance; None if there is none."""
    return next((o for o in objectives if isinstance(o, LowestClearance)), None)
