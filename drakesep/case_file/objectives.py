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
from drakesep.analysis.metrics.registry import find_metric
from drakesep.case_file.case import Case
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError


@typed
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
    every = [*(own if wanted is None else listed(wanted)), *listed(also)]
    if case.has_clearance and LOWEST not in known:
        known[LOWEST] = case.lowest_clearance()
    for name in every:
        if isinstance(name, str) and name not in known and _of_clearance(name):
            known[name] = case.lowest_clearance(name.removeprefix(_LOWEST))
    if not every and wanted is None:
        none = "no requirement" + " that its runs tell" * bool(case.requirements)
        raise InputError(
            f"objectives: {case.name} has {none} and no 'objectives: paper': "
            f"must be given, such as {', '.join(OBJECTIVES)}, or highest_ or lowest_ "
            "and a metric; got none"
        )
    if not every:
        raise InputError("objectives: must be one or more, got none")
    each = (
        known[objective]
        if isinstance(objective, str) and objective in known
        else as_objective(objective, known)
        for objective in dict.fromkeys(every)
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


def listed(wanted: Wanted) -> Sequence[AnyObjective]:
    """Return what is wanted as several, if it is one."""
    return [wanted] if isinstance(wanted, str) or callable(wanted) else wanted


_LOWEST = "lowest_"


def _of_clearance(name: str) -> bool:
    """Return whether an objective's name is that of one that makes parts come near."""
    found = find_metric(name.removeprefix(_LOWEST))
    return name.startswith(_LOWEST) and found is not None and not found[0].of_every_run


def clearances_of(objectives: Sequence[Objective]) -> dict[str, LowestClearance]:
    """Return those of objectives that are clearances, the first of each metric."""
    found: dict[str, LowestClearance] = {}
    for objective in objectives:
        if isinstance(objective, LowestClearance):
            found.setdefault(objective.metric, objective)
    return found
