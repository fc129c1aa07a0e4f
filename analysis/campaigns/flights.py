"""The draws of a campaign, flown on the batch engine."""

import copy
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drakesep.analysis.campaigns.draws import Drawn, Draws
from drakesep.analysis.campaigns.plan import ROWS, CampaignPlan
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.metrics.of_run import metric_named, metrics_of_run
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.run import RunStatus


Progress = Callable[[int, int], None]
"""Told how many draws are done, and of how many."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FlownDraws:
    """What came of n draws that follow each other."""

    first: int
    """Number of the first."""
    metrics: Array
    """(n, m) what the plan keeps, in SI; NaN of runs that failed."""
    failure: NDArray[np.int16]
    """(n,) which failure case a draw has, by its place in `CampaignFlights.failures`;
    -1: none."""
    attempts: NDArray[np.int32]
    """(n,) how often values were drawn before that cannot be."""
    reasons: Mapping[int, str]
    """Why runs failed, by the number of the draw."""

    def __len__(self) -> int:
        return len(self.metrics)

    @property
    def failed(self) -> int:
        """How many runs failed."""
        return len(self.reasons)

    @property
    def again(self) -> int:
        """How often values were drawn that cannot be."""
        return int(self.attempts.sum())

    def some(self, numbers: Sequence[int]) -> "FlownDraws":
        """Return what came of some of the draws, in their order.

        Args:
            numbers: of the draws, one or more.
        """
        rows = np.asarray(numbers) - self.first
        return FlownDraws(
            first=numbers[0],
            metrics=self.metrics[rows],
            failure=self.failure[rows],
            attempts=self.attempts[rows],
            reasons={i: self.reasons[i] for i in numbers if i in self.reasons},
        )


@typed
class CampaignFlights:
    """Flies the draws of a plan."""

    def __init__(self, plan: CampaignPlan, *, workers: int | None = None):
        """Prepare; programs are compiled as the first draws fly.

        Args:
            plan: of the campaign.
            workers: threads that fly; one per core if None.

        Raises:
            ValueError: the batch engine cannot fly the case.
        """
        case = plan.case
        self.plan = plan
        self._draws = Draws(case, plan.seed)
        nominal = parameters(case.separation)
        fails = {
            name: nominal[name]
            for failure in self._draws.failures
            for name, value in failure.values.items()
            if name not in self._draws.names and math.isfinite(value)
        }
        if not (self._draws.names or fails):
            raise InputError("failure_cases: what never lets go is all that varies")
        entries = [metric_named(name) for name in plan.metrics]
        of_paper = {metric.stem for metric in registered_metrics() if metric.objective}
        asked = not of_paper.isdisjoint(metric.stem_of_any for metric in entries)
        batch = Batch(
            case.separation,
            (*self._draws.names, *fails),
            deviation_limits=case.limits_of_pairs,
            metrics=plan.metrics,
            without=() if asked else of_paper,
            tolerance=plan.tolerance,
            workers=workers,
        )
        self._batch = batch.holding(fails)
        # What steps do not tell, the motion does, run by run.
        self._whole_runs = not all(metric.of_steps for metric in entries)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters that are drawn."""
        return self._draws.names

    @property
    def failures(self) -> tuple[FailureCase, ...]:
        """The failure cases that may happen in a draw."""
        return self._draws.failures

    @property
    def together(self) -> int:
        """Draws that are flown together on all cores."""
        return _WHOLE if self._whole_runs else self._batch.chunk * self._batch.workers

    def with_spans(self) -> "CampaignFlights":
        """Return what flies the plan with spans of histograms, from its first draws.

        Where rows are kept, itself: there are none. They are one and a half times as
        wide as these draws lie apart, to either side of them.
        """
        if self.plan.keep == ROWS:
            return self
        first = self.fly(np.arange(min(_FIRST, self.plan.runs), dtype=np.int64))
        spans = tuple(map(_span, first.metrics.T))
        prepared = copy.copy(self)
        prepared.plan = replace(self.plan, spans=spans)
        return prepared

    def chunk(self, number: int, on_progress: Progress | None = None) -> FlownDraws:
        """Fly a chunk of the plan.

        Args:
            number: of the chunk.
            on_progress: called now and then.

        Raises:
            ValueError: there is no such chunk.
        """
        return self.fly(self.plan.indices(number), on_progress)

    def drawn(self, indices: ArrayLike) -> Drawn:
        """Return draws by their numbers (n,)."""
        return self._draws.at(np.asarray(indices, dtype=np.int64))

    def values(self, indices: ArrayLike) -> list[dict[str, float]]:
        """Return what draws change of the separation, by name, in SI.

        What has failed has its failed value, and does not vary.

        Args:
            indices: (n,) numbers of the draws.
        """
        drawn, names = self.drawn(indices), self._draws.names
        return [
            {**dict(zip(names, row.tolist(), strict=True)), **self._failed(which)}
            for row, which in zip(drawn.values, drawn.failure.tolist(), strict=True)
        ]

    def _failed(self, which: int) -> Mapping[str, float]:
        return self.failures[which].values if which >= 0 else {}

    def fly(
        self, indices: NDArray[np.int64], on_progress: Progress | None = None
    ) -> FlownDraws:
        """Fly draws that follow each other.

        Args:
            indices: (n,) their numbers.
            on_progress: called now and then.
        """
        drawn = self.drawn(indices)
        metrics = np.full((len(indices), len(self.plan.metrics)), np.nan)
        reasons: dict[int, str] = {}
        done = 0

        def tell(part: int, _: int) -> None:
            if on_progress is not None:
                on_progress(done + part, len(indices))

        for failure, rows in self._by_failure(drawn.failure):
            values = drawn.values[rows]
            flown, failed = self._fly(failure, values, tell)
            metrics[rows] = flown
            reasons |= {
                int(indices[rows[i]]): why.replace("\n", " ")
                for i, why in failed.items()
            }
            done += len(rows)
        return FlownDraws(
            first=int(indices[0]),
            metrics=metrics,
            failure=drawn.failure.astype(np.int16),
            attempts=drawn.attempts.astype(np.int32),
            reasons=dict(sorted(reasons.items())),
        )

    def metrics_at(
        self, values: Array, on_progress: Progress = lambda *_: None
    ) -> Array:
        """Return what the plan keeps of launches in which nothing fails, (n, m) in SI.

        NaN of runs that failed.

        Args:
            values: (n, n_p) of the parameters that are drawn, in SI.
            on_progress: called now and then.
        """
        return self._fly(None, values, on_progress)[0]

    def _by_failure(
        self, which: NDArray[np.int_]
    ) -> Iterator[tuple[FailureCase | None, NDArray[np.intp]]]:
        """Yield the rows of the design, and of each failure case."""
        for k in np.unique(which).tolist():
            yield self.failures[k] if k >= 0 else None, np.flatnonzero(which == k)

    def _fly(
        self, failure: FailureCase | None, values: Array, on_progress: Progress
    ) -> tuple[Array, Mapping[int, str]]:
        """Return the metrics of rows, and why some failed."""
        batch, held = self._batch, failure.values if failure else {}
        never = [name for name, value in held.items() if math.isinf(value)]
        if failure and never:
            # Met by nobody, as it is in Drake: it does not separate.
            why = f"{failure.name}: {', '.join(never)}: does not separate"
            failed = dict.fromkeys(range(len(values)), why)
            return np.full((len(values), len(self.plan.metrics)), np.nan), failed
        if held:
            batch = batch.holding(held)
        columns = [self._draws.names.index(name) for name in batch.names]
        rows = values[:, columns]
        if self._whole_runs:
            return self._whole(batch, rows, on_progress)
        result = batch.run(rows, on_progress=on_progress)
        kept = result.metrics[[*self.plan.metrics]].to_numpy()
        return kept, result.failures

    def _whole(
        self, batch: Batch, rows: Array, on_progress: Progress
    ) -> tuple[Array, Mapping[int, str]]:
        """The same of whole runs, some at a time: their motion takes memory."""
        names, limits = self.plan.metrics, self.plan.case.limits_of_pairs
        metrics = np.full((len(rows), len(names)), np.nan)
        failed: dict[int, str] = {}
        for first in range(0, len(rows), _WHOLE):
            for i, run in enumerate(batch.runs(rows[first : first + _WHOLE]), first):
                if run.status is RunStatus.FAILED or run.not_separated:
                    failed[i] = run.message or run.not_separated
                    continue
                told = metrics_of_run(run, limits, names)
                metrics[i] = [told[name] for name in names]
                if not np.isfinite(metrics[i]).all():
                    failed[i] = _untold(names, metrics[i])
                    metrics[i] = np.nan
            on_progress(min(first + _WHOLE, len(rows)), len(rows))
        return metrics, failed


_FIRST = 2048
"""Draws that tell how far histograms go."""


def _span(values: Array) -> tuple[float, float]:
    told = values[np.isfinite(values)]
    if not len(told):
        return 0.0, 1.0
    least, greatest = float(told.min()), float(told.max())
    beyond = 1.5 * (greatest - least) or 1e-3 * abs(least) or 1.0
    return least - beyond, greatest + beyond


_WHOLE = 64
"""Whole runs that are flown at once."""


def _untold(names: Sequence[str], values: Array) -> str:
    untold = [name for name, x in zip(names, values, strict=True) if not np.isfinite(x)]
    return f"no number for {', '.join(untold)}"
