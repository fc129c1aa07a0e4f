"""How hard to search."""

import dataclasses
import math
from dataclasses import dataclass, field
from typing import TypedDict, Unpack

from drakesep.analysis.search.sqp import AscentSettings
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError


class Effort(TypedDict, total=False):
    """Settings of a search that a study takes; see `SearchSettings`."""

    starts: int
    samples: int
    vertices: int
    generations: int
    flips: int
    corners: int
    seed: int


@typed
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
    flips: int = 2**15
    """Corners that are flown for each objective, where all are too many: when as many
    have been, no further start is made."""
    corners: int = 4096
    """Drawn at random, where tolerances grow."""
    seed: int = 0
    """Of whatever is drawn at random."""
    ascent: AscentSettings = field(default_factory=AscentSettings)

    def __post_init__(self) -> None:
        """Check the values."""
        for name, least in _LEAST.items():
            value = getattr(self, name)
            if value < least:
                raise InputError(
                    f"{name}: must be a whole number >= {least}, got {value}"
                )

    @classmethod
    def of_grade(cls, grade: int, **effort: Unpack[Effort]) -> "SearchSettings":
        """Return settings of a grade of effort, each a quarter of the one before.

        Args:
            grade: 0 for all of it.
            effort: what is not to be chosen by it.
        """
        most = cls()
        settings = cls(
            starts=max(2, most.starts >> grade),
            samples=max(32, most.samples >> 2 * grade),
            # Of few parameters they cost less than flips, which each objective needs.
            vertices=max(1024, most.vertices >> 2 * grade),
            flips=max(64, most.flips >> 2 * grade),
            corners=most.corners >> 2 * grade,
        )
        return dataclasses.replace(settings, **effort)


def fewer_starts(starts: int) -> int:
    """Return from how many starts expensive objectives go, beside others: a quarter.

    Args:
        starts: of the others; the nominal among them is not left out.
    """
    return 1 + math.ceil((starts - 1) / 4)


_LEAST = {
    "starts": 1,
    "samples": 1,
    "vertices": 1,
    "generations": 1,
    "flips": 1,
    "corners": 0,
    "seed": 0,
}
