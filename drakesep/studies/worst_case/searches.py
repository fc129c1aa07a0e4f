"""Which searches a study runs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import FROM_NOMINAL
from drakesep.analysis.search.registry import check_search
from drakesep.systems.checks import InputError
from drakesep.systems.model.separation import Separation


DEFAULT_SEARCHES = ("samples", "vertices", FROM_NOMINAL, "multistart")
"""Chance, then the corners, then uphill from the nominal and from the best of those."""
DRAKE = "drake"
"""The name by which a user asks that Drake alone flies: SQP from the nominal, with
differences."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WantedSearches:
    """The searches that a user asks for."""

    names: tuple[str, ...] | None = None
    """In the order in which they go; None: what suits the case."""
    drake_alone: bool = False
    """Whether Drake flies every run, and the batch engine none."""

    @classmethod
    def named(cls, searches: Sequence[str] | None, separation: Separation) -> Self:
        """Return the searches of these names.

        Args:
            searches: names out of `SEARCHES`, or `DRAKE` alone; None: what suits.
            separation: that is searched; with recontact, Drake alone suits it.

        Raises:
            ValueError: there is none, one is unknown, or Drake is beside others.
        """
        if searches is None:
            if separation.recontact is None:
                return cls()
            searches = [DRAKE]
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


def default_searches(
    parameters: int, settings: SearchSettings, objectives: Sequence[Objective]
) -> tuple[str, ...]:
    """Return the searches of a study that is not told which.

    Vertices, while all are affordable; else flips of bounds, unless all objectives are
    expensive.

    Args:
        parameters: how many are dispersed.
        settings: what is affordable.
        objectives: that are searched.
    """
    cheap = not all(objective.expensive for objective in objectives)
    instead = ("corners",) if cheap else ()
    wide = ("vertices",) if 2**parameters <= settings.vertices else instead
    return tuple(
        name
        for wanted in DEFAULT_SEARCHES
        for name in (wide if wanted == "vertices" else (wanted,))
    )
