"""Requirements on any function of a run, beside those on its metrics.

Whole runs tell it, one by one. Nobody knows what it takes: it is searched as what is
expensive, so that the searches for others are as wide as without it.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

from drakesep.analysis.metrics.metric import Sense
from drakesep.analysis.metrics.objectives import (
    Limits,
    Needs,
    Objective,
    SignedMetric,
)
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement, Sides, check_statistical
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_finite
from drakesep.systems.model.run import Run


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class FunctionRequirement:
    """Limits on a function of a run: from above, from below, or both.

    Raises:
        ValueError: the name is that of a metric or cannot stand in one of a file, or
            there is no limit, or they leave nothing between them.
    """

    name: str
    """In tables; of letters, digits and _."""
    function: Callable[[Run], float]
    """Of a completed `Run`, in the unit; it must give a finite number for each."""
    unit: str = ""
    """In which the function and the limits are, as tables have it."""
    at_most: float | None = None
    at_least: float | None = None
    id: str = ""
    """By which others know it, such as ``UM-4.2``."""
    source: str = ""
    """Where it comes from."""
    share: float | None = None
    """Of launches that must be within each limit; see `Requirement`."""
    confidence: float | None = None
    """At which that is to be shown."""
    sides: Sides = "one"
    """Whether the share is of each limit by itself."""

    def __post_init__(self) -> None:
        """Check the values."""
        if not re.fullmatch(r"[A-Za-z]\w*", self.name, re.ASCII):
            raise InputError(
                "requirements: name must be of letters, digits and _, "
                f"got {self.name!r}"
            )
        if find_metric(self.name) is not None:
            raise InputError(f"requirements: {self.name!r} is the name of a metric")
        check_statistical(self.name, self.share, self.confidence, self.sides)
        for limit in self.limits:
            check_finite(f"{self.name}: limit", limit.limit)
        if not self.limits:
            raise InputError(f"{self.name}: must have at_most or at_least, got none")
        if self.at_least is not None and self.at_most is not None:
            if self.at_least > self.at_most:
                raise InputError(
                    f"{self.name}: at_least must not be above at_most, got "
                    f"{self.at_least:g} and {self.at_most:g}"
                )
        elif self.sides == "two":
            raise InputError(
                f"{self.name}: of two sides must have at_most and at_least, got one"
            )

    def of(self, run: Run) -> float:
        """Return the function of a completed run.

        Raises:
            ValueError: it raises something, or gives no finite number.
        """
        try:
            value = float(self.function(run))
        except Exception as error:  # whatever a user's function raises
            raise InputError(
                f"{self.name}: must give a number for every run, got "
                f"{type(error).__name__}: {error}"
            ) from error
        check_finite(f"{self.name} of every run", value)
        return value

    @property
    def column(self) -> str:
        """What it is called in tables of runs: its name with its unit."""
        unit = re.sub(r"\W+", "_", self.unit).strip("_")
        return f"{self.name}_{unit}" if unit else self.name

    @property
    def limits(self) -> tuple[Requirement, ...]:
        """Its limits, each by itself, in its unit."""
        sides: tuple[tuple[Sense, float | None], ...] = (
            ("<=", self.at_most),
            (">=", self.at_least),
        )
        return tuple(
            Requirement(
                metric=self.name,
                sense=sense,
                limit=x,
                id=self.id,
                source=self.source,
                share=self.share,
                confidence=self.confidence,
                sides=self.sides,
            )
            for sense, x in sides
            if x is not None
        )

    @property
    def objectives(self) -> tuple[Objective, ...]:
        """What leads out of each limit."""
        return tuple(
            _OfFunction(self, 1.0 if limit.from_above else -1.0)
            for limit in self.limits
        )


class _OfFunction(Objective):
    """A function of a run that is required, or less it."""

    needs = Needs.RUN

    def __init__(self, required: FunctionRequirement, sign: float):
        way = "highest" if sign > 0.0 else "lowest"
        self.name = f"{way}_{required.name}"
        self.shown_as = SignedMetric(required.name, sign, required.unit)
        self._required, self._sign = required, sign

    @property
    def expensive(self) -> bool:
        return True

    def of_run(self, run: Run, limits: Limits) -> float:
        return self._sign * self._required.of(run)
