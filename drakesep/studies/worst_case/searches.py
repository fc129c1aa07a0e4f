"""Which searches a study runs, and how hard, as the length of its runs allows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from drakesep.analysis.metrics.objectives import Needs, Objective
from drakesep.analysis.search.effort import Effort, SearchSettings
from drakesep.analysis.search.problem import FROM_NOMINAL
from drakesep.analysis.search.registry import check_search
from drakesep.systems.checks import InputError


DEFAULT_SEARCHES = ("samples", "vertices", FROM_NOMINAL, "multistart")
"""Chance, then the corners, then uphill from the nominal and from the best of those."""
DRAKE = "drake"
"""The name by which a user asks that Drake alone flies: SQP from the nominal, with
differences."""

_WHOLE_RUN = 800
"""Steps of a run in Drake that costs what an objective of a whole run does on the
batch engine, which samples its motion."""
_EXPENSIVE: Effort = {"samples": 32, "vertices": 32}
"""Where there are none but expensive objectives, a fraction of a second each."""
_LIGHT = 300
"""Steps of a Drake run up to which it is a light one: derivatives cost less than they
save, and workers take longer to start than to fly."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WantedSearches:
    """The searches that a user asks for."""

    names: tuple[str, ...] | None = None
    """In the order in which they go; None: what suits the case."""
    drake_alone: bool = False
    """Whether Drake flies every run, and the batch engine none."""

    @classmethod
    def named(cls, searches: Sequence[str] | None) -> Self:
        """Return the searches of these names.

        Args:
            searches: names out of `SEARCHES`, or `DRAKE` alone; None: what suits.

        Raises:
            ValueError: there is none, one is unknown, or Drake is beside others.
        """
        if searches is None:
            return cls()
        if not len(searches):
            raise InputError("searches: must be one or more, got none")
        drake_alone = list(searches) == [DRAKE]
        if isinstance(searches, str) or (DRAKE in searches and not drake_alone):
            raise InputError(
                f"searches: must be a list, and {DRAKE!r} stands alone in it, "
                f"got {searches!r}"
            )
        if drake_alone:
            return cls(names=(FROM_NOMINAL,), drake_alone=True)
        for name in searches:
            check_search(name, also=[DRAKE])
        return cls(names=tuple(searches))


def is_light(steps: int) -> bool:
    """Return whether a run of so many steps in Drake is a light one."""
    return steps <= _LIGHT


def default_searches(
    parameters: int, settings: SearchSettings, *, light: bool
) -> tuple[str, ...]:
    """Return the searches of a study that is not told which.

    Vertices, while all are affordable; else flips of bounds, if runs are light.

    Args:
        parameters: how many are dispersed.
        settings: what is affordable.
        light: whether very many runs are.
    """
    instead = ("corners",) if light else ()
    wide = ("vertices",) if 2**parameters <= settings.vertices else instead
    return tuple(
        name
        for wanted in DEFAULT_SEARCHES
        for name in (wide if wanted == "vertices" else (wanted,))
    )


def affordable(
    objectives: Sequence[Objective], steps: int, effort: Effort
) -> SearchSettings:
    """Return how hard to search, by what takes longest of what searches fly.

    Args:
        objectives: that are searched.
        steps: of the nominal run in Drake.
        effort: what is not to be chosen by them.
    """
    if all(objective.expensive for objective in objectives):
        chosen: Effort = _EXPENSIVE | effort
        return SearchSettings.affordable(steps, **chosen)
    whole_runs = any(o.needs is Needs.RUN for o in objectives)
    return SearchSettings.affordable(
        max(steps, _WHOLE_RUN if whole_runs else 0), **effort
    )
