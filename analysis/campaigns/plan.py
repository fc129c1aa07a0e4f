"""The frozen plan of a campaign: what is drawn, how it is flown, what is kept of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.screen import can_be_screened
from drakesep.analysis.engines.jax.batch import TOLERANCE
from drakesep.analysis.metrics.of_run import metric_named
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_distinct, check_positive


Keep: TypeAlias = Literal["rows", "worst"]
"""What is kept of draws: the metrics of each; or counts, histograms and the worst."""
ROWS, WORST = "rows", "worst"
CHUNKS = {ROWS: 32_768, WORST: 262_144}
"""Draws of a chunk, by what is kept: what is flown, written and lost at once."""
MOST_RUNS = {ROWS: 10_000_000, WORST: 10_000_000_000}
"""Of a campaign, by what is kept."""
BINS = 200
"""Of a histogram."""


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
    clearances: tuple[str, ...] = ()
    """Names of the clearances that are screened in every run, and measured in some."""
    chunk: int = CHUNKS[ROWS]
    """Draws of each chunk but the last, which may have fewer."""
    keep: Keep = "rows"
    """What is kept of the draws."""
    spans: tuple[tuple[float, float], ...] = ()
    """From where to where the histogram of each metric goes, in SI: fixed before
    any draw is flown, so that those of all chunks add up. None, where rows are kept."""
    tolerance: float = TOLERANCE
    """Of the batch engine's steps; see `Batch`."""

    def __post_init__(self) -> None:
        """Check the values."""
        for name, least in (("runs", 1), ("seed", 0), ("chunk", 1)):
            value = getattr(self, name)
            if value < least:
                raise InputError(f"{name}: must be {least} or more, got {value}")
        if self.keep not in MOST_RUNS:
            raise InputError(f"keep: must be rows or worst, got {self.keep!r}")
        if self.runs > MOST_RUNS[self.keep]:
            raise InputError(
                f"runs: must be {MOST_RUNS[self.keep]} or fewer where {self.keep} are "
                f"kept, got {self.runs}"
            )
        if self.spans and len(self.spans) != len(self.metrics):
            raise InputError(
                f"spans: must be one for each of {len(self.metrics)} metrics, got "
                f"{len(self.spans)}"
            )
        check_positive("tolerance", self.tolerance)
        check_distinct("metrics", self.metrics)
        for name in self.metrics:
            if not metric_named(name).told_by(self.case.separation):
                raise InputError(f"metrics: {name}: no run of the case tells it")
        for name in self.clearances:
            required = [r for r in self.case.requirements if r.metric == name]
            if not any(one.measured_apart for one in required):
                raise InputError(f"clearances: {name}: must be one that is required")
            if self.keep != ROWS:
                raise InputError(f"clearances: {name}: must be none without rows")
            if self.clearances.count(name) > 1:
                raise InputError(f"clearances: {name} must stand once")
        if not self.case.tolerances and not self.case.failure_probabilities:
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
        keep: Keep | None = None,
    ) -> Self:
        """Return a plan that keeps what the requirements of a case are judged by.

        Args:
            case: that is flown.
            runs: draws.
            seed: of the draws.
            also: names of metrics that are kept beside these.
            chunk: draws of a chunk; None: as `CHUNKS` says.
            keep: what of the draws; None: rows, unless they are too many for that.

        Raises:
            ValueError: as the class says.
        """
        metrics = tuple(dict.fromkeys([*judged_metrics(case), *also]))
        if keep is None:
            keep = "rows" if runs <= MOST_RUNS[ROWS] else "worst"
        return cls(
            case=case,
            runs=runs,
            seed=seed,
            metrics=metrics,
            clearances=tuple(_screened(case)) if keep == ROWS else (),
            chunk=CHUNKS.get(keep, 1) if chunk is None else chunk,
            keep=keep,
        )

    @property
    def chunks(self) -> int:
        """How many there are."""
        return -(-self.runs // self.chunk)

    def edges(self, metric: int) -> list[float]:
        """Return the edges of the histogram of a metric.

        Args:
            metric: its place among those that are kept.
        """
        least, greatest = self.spans[metric]
        return [*map(float, np.linspace(least, greatest, BINS + 1))]

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


def judged_metrics(case: AnalysisCase) -> list[str]:
    """Return the metrics by which requirements of a case are judged, as runs tell them.

    Without what is measured apart.
    """
    return [
        requirement.judged_by
        for requirement in case.requirements
        if not requirement.measured_apart and case.tells(requirement)
    ]


def _screened(case: AnalysisCase) -> dict[str, None]:
    """Return the names of the clearances that are required and can be screened."""
    varied = {*case.tolerances}
    for failure in case.failure_cases:
        if failure.name in case.failure_probabilities:
            varied |= {*failure.values}
    return {
        one.metric: None
        for one in case.requirements
        if one.measured_apart
        and can_be_screened(case.lowest_clearance(one.metric), case.separation, varied)
    }
