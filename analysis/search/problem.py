"""What a search for the worst over a set of tolerances takes and gives.

A search takes the problem, settings and what earlier searches found, and returns its
candidates: points with the value of one objective.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias, TypedDict, Unpack

from drakesep.analysis.engines.evaluator import Evaluator
from drakesep.analysis.search.sqp import Ascent, AscentSettings, Iteration
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.checks import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """What is to be maximised, over which set."""

    tolerances: ToleranceSet
    evaluator: Evaluator
    """With the objectives, on the parameters of the set in their order."""
    only: tuple[int, ...] | None = None
    """Which of the objectives; all if None."""

    @property
    def asked(self) -> tuple[int, ...]:
        """The objectives that are searched, by their place among the evaluator's."""
        if self.only is not None:
            return self.only
        return tuple(range(len(self.evaluator.objectives)))

    def noted(self, what: str) -> str:
        """Return a note on a search, with for how many objectives it was."""
        count = len(self.evaluator.objectives)
        if len(self.asked) == count:
            return what
        return f"{what}, for {len(self.asked)} of {count} objectives"


class Effort(TypedDict, total=False):
    """Settings of a search that a study takes; see `SearchSettings`."""

    starts: int
    samples: int
    vertices: int
    generations: int
    corners: int
    seed: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchSettings:
    """How hard to search.

    Raises:
        ValueError: a number is out of range.
    """

    starts: int = 8
    """Of each objective, of the ascent from many."""
    samples: int = 50_000
    """Drawn at random from the set."""
    vertices: int = 2**18
    """That are affordable."""
    generations: int = 100
    """Of differential evolution."""
    corners: int = 4096
    """Drawn at random, where tolerances grow."""
    seed: int = 0
    """Of whatever is drawn at random."""
    ascent: AscentSettings = field(default_factory=AscentSettings)

    def __post_init__(self) -> None:
        """Check the values."""
        for name, least in _LEAST.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise InputError(
                    f"{name}: must be a whole number >= {least}, got {value}"
                )

    @classmethod
    def affordable(cls, steps: int, **effort: Unpack[Effort]) -> "SearchSettings":
        """Return settings for runs of so many integration steps.

        What staged releases of stiff joints cost a run, they take from its number.

        Args:
            steps: of the nominal run in Drake.
            effort: what is not to be chosen by them.
        """
        settings = cls(
            starts=_between(2, 3000 // steps, 8),
            samples=_between(1, 200_000_000 // steps**2, 50_000),
            vertices=_between(1, 1_300_000_000 // steps**2, 2**18),
            corners=_between(0, 20_000_000 // steps**2, 4096),
        )
        return dataclasses.replace(settings, **effort)


def _between(least: int, value: int, most: int) -> int:
    return min(max(value, least), most)


_LEAST = {
    "starts": 1,
    "samples": 1,
    "vertices": 1,
    "generations": 1,
    "corners": 0,
    "seed": 0,
}


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
    note: str
    """What was searched, in words."""
    objectives: tuple[int, ...]
    """That it looked for."""

    def best(self, objective: int) -> Candidate | None:
        """Return the best candidate of an objective; None if there is none."""
        mine = [c for c in self.candidates if c.objective == objective]
        return max(mine, key=lambda c: c.value, default=None)

    def joined(self, other: "Searched") -> "Searched":
        """Return this search with the same of other objectives."""
        failures = dict(self.failures)
        for why, count in other.failures.items():
            failures[why] = failures.get(why, 0) + count
        return dataclasses.replace(
            self,
            candidates=self.candidates + other.candidates,
            points=self.points + other.points,
            failures=failures,
            note=f"{self.note}; {other.note}",
            objectives=self.objectives + other.objectives,
        )


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
    iteration: tuple[int, Iteration] | None = None
    """Objective and iterate, of an ascent."""


Known: TypeAlias = Sequence[Candidate]
OnProgress: TypeAlias = Callable[[SearchProgress], None]
Search: TypeAlias = Callable[[Problem, SearchSettings, Known, OnProgress], Searched]
