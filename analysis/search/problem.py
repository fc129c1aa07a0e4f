"""What a search for the worst over a set of tolerances takes and gives.

A search takes the problem, settings and what earlier searches found, and returns its
candidates: points with the value of one objective.
"""

import dataclasses
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

from drakesep.analysis.engines.evaluator import Evaluator
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.sqp import Ascent, Iteration
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.argument_types import typed


FROM_NOMINAL = "sqp"
"""Name of the search that begins at the nominal alone, as the paper's does."""
FROM_BEST = "best"
"""Name of the search that begins at the best point alone that is known."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """What is to be maximised, over which set."""

    tolerances: ToleranceSet
    evaluator: Evaluator
    """With the objectives, on the parameters of the set in their order."""
    only: tuple[int, ...] | None = None
    """Which of the objectives; all if None."""
    likely: Mapping[int, tuple[float, ...]] = field(default_factory=dict)
    """A point of the set, scaled, by objective: what was worst in a like problem."""

    @property
    def asked(self) -> tuple[int, ...]:
        """The objectives that are searched, by their place among the evaluator's."""
        if self.only is not None:
            return self.only
        return tuple(range(len(self.evaluator.objectives)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A point that a search found, for one objective."""

    objective: int
    u: tuple[float, ...]
    """Scaled."""
    value: float
    """Of the objective, in SI."""
    search: str
    """That found it."""
    ascent: Ascent | None = field(default=None, repr=False)
    """That ended there, if one did."""
    start: int = 0
    """Of the ascent: its number among those of the objective, from 1; 0 without."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Searched:
    """What came of a search."""

    search: str
    candidates: tuple[Candidate, ...]
    """Of a sweep the best of each objective, of an ascent its end; none of failed
    starts."""
    points: int
    """Flown."""
    failures: Mapping[str, int]
    """How many runs failed, by their reason."""
    what: Mapping[str, int]
    """What was searched, in words, and for how many objectives."""
    objectives: tuple[int, ...]
    """That it looked for."""
    of: int
    """Objectives of the study."""
    run_by_run: tuple[tuple[int, int], ...] = ()
    """Objectives that metrics do not tell, and how many whole runs each has taken."""

    @property
    def note(self) -> str:
        """What was searched, in a line; of a part of the objectives, of how many."""
        return "; ".join(
            what if count == self.of else f"{what}, for {count} of {self.of} objectives"
            for what, count in self.what.items()
        )

    def best(self, objective: int) -> Candidate | None:
        """Return the best candidate of an objective; None if there is none."""
        mine = [c for c in self.candidates if c.objective == objective]
        return max(mine, key=lambda c: c.value, default=None)

    def joined(self, other: "Searched") -> "Searched":
        """Return this search with the same of other objectives."""
        return dataclasses.replace(
            self,
            candidates=self.candidates + other.candidates,
            points=self.points + other.points,
            failures=_summed(self.failures, other.failures),
            what=_summed(self.what, other.what),
            objectives=self.objectives + other.objectives,
            run_by_run=self.run_by_run + other.run_by_run,
        )


def _summed(some: Mapping[str, int], others: Mapping[str, int]) -> dict[str, int]:
    """Return counts of both, those of the first before others."""
    return dict(Counter(some) + Counter(others))


def candidates_of(problem: Problem, done: Iterable[Searched]) -> list[Candidate]:
    """Return what searches have found for the objectives of a problem, in order."""
    return [
        c for found in done for c in found.candidates if c.objective in problem.asked
    ]


class Iterate(NamedTuple):
    """An iterate of one of many ascents."""

    objective: int
    """Its place among the evaluator's."""
    start: int
    """Number of the ascent among those of the objective, from 1."""
    iteration: Iteration


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchProgress:
    """Where a search stands, or what comes after the searches."""

    search: str
    done: int
    """Points flown, iterates of ascents, or runs or limits that are done with."""
    total: int | None
    """Of them; None if it is not known."""
    best: Mapping[int, float] = field(default_factory=dict)
    """Best values so far, in SI, by objective."""
    iterate: Iterate | None = None
    """That an ascent has come to, if this tells of one."""


Known: TypeAlias = Sequence[Candidate]
OnProgress: TypeAlias = Callable[[SearchProgress], None]
Search: TypeAlias = Callable[[Problem, SearchSettings, Known, OnProgress], Searched]
