"""How far tolerances may grow before each requirement is violated."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.margins.tolerance_margins import (
    Growth,
    Limit,
    grow,
    grow_along_rays,
)
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.analysis.search.judge import WorstCase
from drakesep.analysis.search.problem import SearchProgress
from drakesep.studies.worst_case.session import Session


Growths: TypeAlias = tuple[tuple[Requirement, Growth], ...]
"""Of each requirement the growth that violates it first, of its directions."""


class FoundGrowths(NamedTuple):
    """How far tolerances may grow."""

    of_all: Growths
    """All of them together."""
    of_single: Growths
    """One of them, the others as they are."""


def find_growths(
    worst: Sequence[WorstCase],
    under_way: Session,
    functions: Sequence[FunctionRequirement] = (),
) -> FoundGrowths:
    """Return how far tolerances may grow before each requirement is violated.

    Of what is expensive to tell, all of them together alone, along the ray to its worst
    case.

    Args:
        worst: cases, from which to begin.
        under_way: the session that has found them.
        functions: that are required beside the case's requirements.
    """
    problem = under_way.problem
    limits = _limits(under_way.plan.case, functions, {one.name: one for one in worst})
    objectives = problem.evaluator.objectives
    cheap = [(r, o) for r, o in limits if not objectives[o.objective].expensive]
    expensive = [(r, o) for r, o in limits if objectives[o.objective].expensive]
    searched = [
        (requirement, replace(limit, parameter=parameter))
        for requirement, limit in cheap
        for parameter in (None, *range(len(under_way.plan.case.box)))
    ]

    def tell(done: int, total: int) -> None:
        # Limits settle at the ends of long rounds, many at once.
        known = total if done == total else None
        under_way.tell(SearchProgress(search="growth", done=done, total=known))

    def together() -> list[Growth]:
        return grow(
            problem,
            [limit for _, limit in searched],
            corners=under_way.settings.corners,
            seed=under_way.settings.seed,
            on_progress=tell,
        )

    def along_rays() -> list[Growth]:
        return grow_along_rays(problem, [limit for _, limit in expensive])

    found = [
        *under_way.once("growth", Growth, together),
        *under_way.once("growth_along_rays", Growth, along_rays),
    ]
    least: dict[tuple[Requirement, int | None], Growth] = {}
    for (requirement, limit), growth in zip(
        [*searched, *expensive], found, strict=True
    ):
        key = requirement, limit.parameter
        if key not in least or growth.order < least[key].order:
            least[key] = growth
    return FoundGrowths(
        tuple((r, growth) for (r, i), growth in least.items() if i is None),
        tuple((r, growth) for (r, i), growth in least.items() if i is not None),
    )


def ways_out(
    case: AnalysisCase, functions: Sequence[FunctionRequirement]
) -> list[tuple[Requirement, str]]:
    """Return each requirement with the objectives that lead out of it, by name.

    Args:
        case: with requirements.
        functions: that are required beside these.
    """
    ways = [
        (requirement, name)
        for requirement in case.requirements
        for name in case.names_towards(requirement)
    ]
    ways += [
        (limit, objective.name)
        for function in functions
        for limit, objective in zip(function.limits, function.objectives, strict=True)
    ]
    return ways


def _limits(
    case: AnalysisCase,
    functions: Sequence[FunctionRequirement],
    worst: Mapping[str, WorstCase],
) -> list[tuple[Requirement, Limit]]:
    """Return what each direction of each requirement must not exceed.

    From the worst cases, by their objectives' names.
    """
    return [
        (
            requirement,
            Limit(
                objective=worst[name].objective,
                value=_bound(requirement),
                u=worst[name].u,
            ),
        )
        for requirement, name in ways_out(case, functions)
        if name in worst
    ]


def _bound(requirement: Requirement) -> float:
    """Return what the objectives that lead out of a requirement must not exceed."""
    return requirement.limit if requirement.from_above else -requirement.limit
