"""How far tolerances may grow before each requirement is violated."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.margins.tolerance_margins import Growth, Limit, grow
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


def find_growths(worst: Sequence[WorstCase], under_way: Session) -> FoundGrowths:
    """Return how far tolerances may grow before each requirement is violated.

    Args:
        worst: cases, from which to begin.
        under_way: the session that has found them.
    """
    limits = _limits(under_way.plan.case, {one.name: one for one in worst})

    def tell(done: int, total: int) -> None:
        under_way.tell(SearchProgress(search="growth", done=done, total=total))

    found = grow(
        under_way.problem,
        [limit for _, limit in limits],
        corners=under_way.settings.corners,
        seed=under_way.settings.seed,
        on_progress=tell,
    )
    least: dict[tuple[Requirement, int | None], Growth] = {}
    for (requirement, limit), growth in zip(limits, found, strict=True):
        key = requirement, limit.parameter
        if key not in least or growth.is_sooner_than(least[key]):
            least[key] = growth
    return FoundGrowths(
        tuple((r, growth) for (r, i), growth in least.items() if i is None),
        tuple((r, growth) for (r, i), growth in least.items() if i is not None),
    )


def _limits(
    case: AnalysisCase, worst: Mapping[str, WorstCase]
) -> list[tuple[Requirement, Limit]]:
    """Return what each direction of each requirement must not exceed.

    Of all tolerances, and of each; from the worst cases, by their objectives' names.
    """
    return [
        (
            requirement,
            Limit(
                objective=worst[objective.name].objective,
                value=_bound(requirement),
                u=worst[objective.name].u,
                parameter=parameter,
            ),
        )
        for requirement in case.requirements
        for objective in case.towards(requirement)
        if objective.name in worst and not objective.expensive
        for parameter in (None, *range(len(case.box)))
    ]


def _bound(requirement: Requirement) -> float:
    """Return what the objectives that lead out of a requirement must not exceed."""
    return requirement.limit if requirement.from_above else -requirement.limit
