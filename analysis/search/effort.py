"""How hard to search."""

import dataclasses
from dataclasses import dataclass, field
from typing import TypedDict, Unpack

from drakesep.analysis.search.sqp import AscentSettings
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
    "flips": 1,
    "corners": 0,
    "seed": 0,
}
