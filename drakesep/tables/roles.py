"""What a run of a study is, and how it ended.

Roles and outcomes are types. The label of a run, its role in a table and its status are
made from them here, and nowhere is anything read from these texts.
"""

import enum
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

from drakesep.analysis.analysis_case import AnalysisCase, PublishedCase
from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.analysis.search.problem import FROM_NOMINAL
from drakesep.systems.checks import InputError


@dataclass(frozen=True, slots=True)
class Nominal:
    """The run that nothing changes."""


@dataclass(frozen=True, slots=True)
class Changed:
    """A run with values of the user's own."""


@dataclass(frozen=True, slots=True)
class Published:
    """A worst case that others have found."""

    case: PublishedCase


@dataclass(frozen=True, slots=True)
class SearchEnd:
    """Where a search by SQP ended that began at the nominal."""

    search: str
    objective: str
    """Its name."""


@dataclass(frozen=True, slots=True)
class Worst:
    """The worst that all searches have found."""

    objective: str
    """Its name."""


Role: TypeAlias = Nominal | Changed | Published | SearchEnd | Worst


def label_of(role: Role) -> str:
    """Return the label of a run, by which tables, plots and files name it."""
    match role:
        case Nominal():
            return "nominal"
        case Changed():
            return "run"
        case Published(published):
            return published.label
        case SearchEnd(search, objective):
            return f"{search}_{objective}"
        case Worst(objective):
            return f"worst_{objective}"


NOMINAL, CHANGED, PUBLISHED, WORST = "nominal", "changed", "published", "worst"
"""Roles as tables have them; that of a search's end is the search's name."""


def role_in_tables(role: Role) -> str:
    """Return the role of a run as the column `role` has it."""
    match role:
        case Nominal():
            return NOMINAL
        case Changed():
            return CHANGED
        case Published():
            return PUBLISHED
        case SearchEnd(search, _):
            return search
        case Worst():
            return WORST


def objective_of(role: Role) -> str | None:
    """Return the name of the objective that a run was found for; None if none was."""
    match role:
        case SearchEnd(_, objective) | Worst(objective):
            return objective
        case _:
            return None


def check_labels(case: AnalysisCase, objectives: Iterable[str]) -> None:
    """Raise InputError if a published run bears the label of one of our own.

    Args:
        case: that has the published runs.
        objectives: names of those whose worst cases are looked for.
    """
    ours: list[Role] = [Nominal()]
    ours += [SearchEnd(FROM_NOMINAL, name) for name in OBJECTIVES]
    ours += [Worst(name) for name in objectives]
    taken = set(map(label_of, ours))
    for published in case.published:
        if published.label in taken:
            raise InputError(
                f"published: label {published.label!r} is taken by our own runs"
            )


class Ending(enum.Enum):
    """How a run of a study ended, or the search that found it; the value says it."""

    COMPLETED = "completed"
    """The run."""
    CONFIRMED = "confirmed"
    """The run, with what the search says of it."""
    CONVERGED = "converged"
    """The search."""
    STALLED = "stopped without further ascent"
    """The search."""
    ITERATION_LIMIT = "stopped at the iteration limit"
    """The search."""
    FAILED = "failed"
    """The run, the search, or the comparison of the two."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a run of a study ended, and why if it failed."""

    ending: Ending
    message: str = ""

    @property
    def failed(self) -> bool:
        """Whether the run failed, or the search that found it."""
        return self.ending is Ending.FAILED

    @property
    def as_wanted(self) -> bool:
        """Whether there is nothing to say of it."""
        return self.ending in (Ending.COMPLETED, Ending.CONFIRMED, Ending.CONVERGED)

    def __str__(self) -> str:
        """Return it as the column `status` has it."""
        text = self.ending.value
        return f"{text}: {self.message}" if self.failed else text


COMPLETED = Outcome(Ending.COMPLETED)
CONFIRMED = Outcome(Ending.CONFIRMED)


def failed(why: str) -> Outcome:
    """Return the outcome of what failed."""
    return Outcome(Ending.FAILED, why)
