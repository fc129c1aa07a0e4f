"""The frozen plan of a campaign: what is drawn, how it is flown, what is kept of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.jax.batch import TOLERANCE
from drakesep.analysis.metrics.of_run import metric_named
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_positive


CHUNK = 32_768
"""Draws of a chunk: what is flown, kept and lost at once."""
MOST_RUNS = 10_000_000
"""Of a campaign that keeps the metrics of every run."""


@typed
@dataclass(frozen=True, kw_only=True)
class CampaignPlan:
    """What a campaign draws and flies: whoever has it flies the same.

    Draws are numbered from 0. Chunks of them are flown apart, in any order and by
    anyone; what comes of a draw depends on the plan and on its number alone.

    Raises:
        ValueError: a number is out of its range, a metric is unknown or stands twice,
            or nothing varies.
    """

    case: AnalysisCase
    """With the tolerances, how they are distributed, and the requirements."""
    runs: int
    """Draws."""
    seed: int = 0
    """Of the draws."""
    metrics: tuple[str, ...] = ()
    """Names of what is kept of every run."""
    chunk: int = CHUNK
    """Draws of each chunk but the last, which may have fewer."""
    tolerance: float = TOLERANCE
    """Of the batch engine's steps; see `Batch`."""

    def __post_init__(self) -> None:
        """Check the values."""
        for name, least in (("runs", 1), ("seed", 0), ("chunk", 1)):
            value = getattr(self, name)
            if value < least:
                raise InputError(f"{name}: must be {least} or more, got {value}")
        if self.runs > MOST_RUNS:
            raise InputError(f"runs: must be {MOST_RUNS} or fewer, got {self.runs}")
        check_positive("tolerance", self.tolerance)
        for name in self.metrics:
            if not metric_named(name).told_by(self.case.separation):
                raise InputError(f"metrics: {name}: no run of the case tells it")
            if self.metrics.count(name) > 1:
                raise InputError(f"metrics: {name} must stand once")
        if not self.case.tolerances and not self.case.failure_cases:
            raise InputError("dispersions: a campaign needs something that varies")

    @classmethod
    def of(
        cls,
        case: AnalysisCase,
        runs: int,
        *,
        seed: int = 0,
        also: Sequence[str] = (),
        chunk: int | None = None,
    ) -> Self:
        """Return a plan that keeps what the requirements of a case are judged by.

        Args:
            case: that is flown.
            runs: draws.
            seed: of the draws.
            also: names of metrics that are kept beside these.
            chunk: draws of a chunk; None: `CHUNK`.

        Raises:
            ValueError: as the class says.
        """
        judges = [
            requirement.judged_by
            for requirement in case.requirements
            if not requirement.measured_apart and case.tells(requirement)
        ]
        metrics = tuple(dict.fromkeys([*judges, *also]))
        return cls(
            case=case,
            runs=runs,
            seed=seed,
            metrics=metrics,
            chunk=CHUNK if chunk is None else chunk,
        )

    @property
    def chunks(self) -> int:
        """How many there are."""
        return -(-self.runs // self.chunk)

    def indices(self, chunk: int) -> NDArray[np.int64]:
        """Return the numbers of a chunk's draws.

        Args:
            chunk: its number, from 0.

        Raises:
            ValueError: there is no such chunk.
        """
        if not 0 <= chunk < self.chunks:
            raise InputError(f"chunk: must be from 0 to {self.chunks - 1}, got {chunk}")
        first = chunk * self.chunk
        return np.arange(first, min(first + self.chunk, self.runs), dtype=np.int64)
