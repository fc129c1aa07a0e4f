"""What is played with: parameters between bounds, and the values that they have.

Bounds are those of the tolerances; of a parameter without, a share of its size to
either side.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drakesep.page.case_edit import words_and_unit
from drakesep.systems.model.parameters import parameters
from drakesep.units import unit_of, with_unit


if TYPE_CHECKING:
    from drakesep.case_file.case import Case

_SHARE = 0.2
_LEAST = {"mm": 50.0, "deg": 5.0, "deg/s": 1.0, "s": 0.5, "kg m²": 10.0}
"""To either side of what is 0."""
_STEPS = 200
"""Of a slider."""


@dataclass(frozen=True, slots=True)
class Played:
    """A parameter that has a slider, in the unit of its name."""

    name: str
    """With its unit."""
    nominal: float
    low: float
    high: float
    of_tolerance: bool
    """Whether the bounds are those of its tolerance."""

    @property
    def words(self) -> str:
        """Its name without the unit."""
        return words_and_unit(self.name)[0].replace("_", " ").replace(".", " · ")

    @property
    def unit(self) -> str:
        """Symbol."""
        return words_and_unit(self.name)[1]

    @property
    def step(self) -> float:
        """Of its slider: a round number, some hundreds of which are its range."""
        raw = (self.high - self.low) / _STEPS
        power = 10.0 ** math.floor(math.log10(raw))
        return power * next(
            k for k in (1.0, 2.0, 5.0, 10.0) if raw <= k * power * 1.0001
        )


def dispersed(case: "Case") -> list[Played]:
    """Return the parameters that have a tolerance, between its bounds."""
    return [
        Played(
            name=with_unit(each.name),
            nominal=_shown(each.name, each.nominal),
            low=_shown(each.name, each.bounds[0]),
            high=_shown(each.name, each.bounds[1]),
            of_tolerance=True,
        )
        for each in case.box.dispersions
        if each.bounds[0] < each.bounds[1]
    ]


def others(case: "Case") -> list[str]:
    """Return the other parameters that may be played with, by names with units."""
    held = set(case.box.names)
    return [
        with_unit(name)
        for name, value in parameters(case.separation).items()
        if name not in held and math.isfinite(value)
    ]


def other(case: "Case", name: str) -> Played:
    """Return a parameter without a tolerance, between bounds about its value.

    Args:
        case: that has it.
        name: with its unit.
    """
    [(key, value)] = [
        (key, value)
        for key, value in parameters(case.separation).items()
        if with_unit(key) == name
    ]
    nominal = _shown(key, value)
    half = abs(nominal) * _SHARE or _LEAST.get(unit_of(key).symbol, 1.0)
    low = nominal - half
    if nominal == 0.0 and unit_of(key).symbol == "s":  # nothing is before the start
        low = 0.0
    return Played(
        name=name, nominal=nominal, low=low, high=nominal + half, of_tolerance=False
    )


def _shown(name: str, value: float) -> float:
    """Return a value in the unit that it is shown in, free of round-off."""
    return float(f"{unit_of(name).from_si(value):.12g}")


class Playing:
    """The sliders of a case and where they stand.

    Attributes:
        played: parameters with a slider, by name with unit.
        values: those that are not nominal.
    """

    def __init__(self) -> None:
        self.played: dict[str, Played] = {}
        self.values: dict[str, float] = {}
        self._added: list[str] = []

    def follow(self, case: "Case") -> bool:
        """Take over what a case has become.

        Returns:
            Whether there are other sliders now.
        """
        known = {*others(case)}
        self._added = [name for name in self._added if name in known]
        found = [*dispersed(case), *(other(case, name) for name in self._added)]
        played = {each.name: each for each in found}
        self.values = {
            name: value
            for name, value in self.values.items()
            if name in played and value != played[name].nominal
        }
        changed = played != self.played
        self.played = played
        return changed

    def add(self, case: "Case", name: str) -> None:
        """Give another parameter a slider."""
        if name not in self.played:
            self._added.append(name)
            self.played[name] = other(case, name)

    def put(self, name: str, value: float) -> None:
        """Put a slider somewhere; what stands at its nominal is no change."""
        played = self.played[name]
        if math.isclose(
            value, played.nominal, abs_tol=1e-9 * (played.high - played.low)
        ):
            self.values.pop(name, None)
        else:
            self.values[name] = value

    def reset(self) -> None:
        """Put all sliders where they are nominal."""
        self.values = {}
