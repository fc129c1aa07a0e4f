"""The draws of a campaign, flown on the batch engine."""

import copy
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drakesep.analysis.campaigns.draws import Drawn, Draws
from drakesep.analysis.campaigns.plan import ROWS, CampaignPlan
from drakesep.analysis.campaigns.screens import (
    TOGETHER,
    TRIED,
    BatchScreens,
    DrawnClearances,
    measured_in,
)
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
    clearances: DrawnClearances | None = None
    """How near parts come, by the plan's clearances; None: it has none."""

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
            clearances=None
            if self.clearances is None
            else DrawnClearances(
                at_least=self.clearances.at_least[rows],
                measured=self.clearances.measured[rows],
            ),
        )

    def value_of(self, row: int, metric: str, plan: CampaignPlan) -> float:
        """Return what a draw tells of a metric or clearance of the plan, in SI.

        Of a clearance that was not measured, what it is at least; NaN of a run that
        failed.

        Args:
            row: of the draw.
            metric: in question.
            plan: of the campaign.
        """
        if metric not in plan.clearances:
            return float(self.metrics[row, plan.metrics.index(metric)])
        assert self.clearances is not None
        return float(self.clearances.at_least[row, plan.clearances.index(metric)])

    def tells(self, row: int, metric: str, plan: CampaignPlan) -> bool:
        """Return whether that is the value itself, not only what it is at least.

        Also of a run that failed, of which there is nothing to measure.
        """
        if metric not in plan.clearances or self.clearances is None:
            return True
        i = plan.clearances.index(metric)
        failed = math.isnan(self.clearances.at_least[row, i])
        return failed or bool(self.clearances.measured[row, i])


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
        self.draws = Draws(case, plan.seed)
        nominal = parameters(case.separation)
        fails = {
            name: nominal[name]
            for failure in self.draws.failures
            for name, value in failure.values.items()
            if name not in self.draws.names and math.isfinite(value)
        }
        if not (self.draws.names or fails):
            raise InputError("failure_cases: what never lets go is all that varies")
        entries = [metric_named(name) for name in plan.metrics]
        of_paper = {metric.stem for metric in registered_metrics() if metric.objective}
        asked = not of_paper.isdisjoint(metric.stem_of_any for metric in entries)
        batch = Batch(
            case.separation,
            (*self.draws.names, *fails),
            deviation_limits=case.limits_of_pairs,
            metrics=plan.metrics,
            without=() if asked else of_paper,
            tolerance=plan.tolerance,
            workers=workers,
        )
        self._batch = batch.holding(fails)
        # What steps do not tell, the motion does, run by run.
        self._whole_runs = not all(metric.of_steps for metric in entries)
        self.clearances = {
            name: case.lowest_clearance(name) for name in plan.clearances
        }
        for clearance in self.clearances.values():
            clearance.check_apart()
        self._screens: dict[str, BatchScreens] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters that are drawn."""
        return self.draws.names

    @property
    def failures(self) -> tuple[FailureCase, ...]:
        """The failure cases that may happen in a draw."""
        return self.draws.failures

    @property
    def together(self) -> int:
        """Draws that are flown together on all cores."""
        if self._whole_runs:
            return _WHOLE
        return TOGETHER if self.clearances else self._batch.chunk * self._batch.workers

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
        return self.draws.at(np.asarray(indices, dtype=np.int64))

    def values(self, indices: ArrayLike) -> list[dict[str, float]]:
        """Return what draws change of the separation, by name, in SI.

        What has failed has its failed value, and does not vary.

        Args:
            indices: (n,) numbers of the draws.
        """
        return self.draws.changed_by(np.asarray(indices, dtype=np.int64))

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
        at_least = np.full((len(indices), len(self.clearances)), np.nan)
        reasons: dict[int, str] = {}
        done = 0

        def tell(part: int, _: int) -> None:
            if on_progress is not None:
                on_progress(done + part, len(indices))

        for failure, mine in self._by_failure(drawn.failure):
            for rows in self._together(mine):
                values = drawn.values[rows]
                flown, failed = self._fly(failure, values, tell)
                metrics[rows] = flown
                reasons |= {
                    int(indices[rows[i]]): why.replace("\n", " ")
                    for i, why in failed.items()
                }
                if self.clearances and not _never(failure):
                    at_least[rows] = self._at_least(failure, values)
                    at_least[rows[[*failed]]] = np.nan
                done += len(rows)
        clearances = None
        if self.clearances:
            measured = np.zeros(at_least.shape, bool)
            clearances = DrawnClearances(at_least=at_least, measured=measured)
        return FlownDraws(
            first=int(indices[0]),
            metrics=metrics,
            failure=drawn.failure.astype(np.int16),
            attempts=drawn.attempts.astype(np.int32),
            reasons=dict(sorted(reasons.items())),
            clearances=clearances,
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

    def _together(self, rows: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
        """Yield the rows that are flown together: what is screened takes memory."""
        size = TOGETHER if self.clearances else len(rows)
        for first in range(0, len(rows), size):
            yield rows[first : first + size]

    def _at_least(self, failure: FailureCase | None, values: Array) -> Array:
        """Return (n, c) how near parts come at least in rows, m."""
        batch, columns = self._flown_by(failure)
        name = failure.name if failure else ""
        if name not in self._screens:
            tried = self.drawn(np.arange(min(TRIED, self.plan.runs))).values
            clearances = [*self.clearances.values()]
            self._screens[name] = BatchScreens(batch, clearances, tried[:, columns])
        return self._screens[name].at_least(values[:, columns])

    def measured(self, name: str, draws: Mapping[int, float]) -> Array:
        """Return (n,) how near parts come in draws, m; NaN of one that does not tell.

        The same whatever else is measured.

        Args:
            name: of a clearance of the plan.
            draws: what is known of each at least, m, by its number.
        """
        clearance, found = self.clearances[name], []
        drawn = self.drawn([*draws])
        for i, at_least in enumerate(draws.values()):
            which = int(drawn.failure[i])
            failure = self.failures[which] if which >= 0 else None
            if _never(failure):
                found.append(math.nan)
                continue
            batch, columns = self._flown_by(failure)
            [run] = batch.runs(drawn.values[i : i + 1, columns])
            found.append(measured_in(run, clearance, at_least))
        return np.array(found)

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
        if failure and (never := _never(failure)):
            # Met by nobody, as it is in Drake: it does not separate.
            why = f"{failure.name}: {', '.join(never)}: does not separate"
            failed = dict.fromkeys(range(len(values)), why)
            return np.full((len(values), len(self.plan.metrics)), np.nan), failed
        batch, columns = self._flown_by(failure)
        rows = values[:, columns]
        if self._whole_runs:
            return self._whole(batch, rows, on_progress)
        result = batch.run(rows, on_progress=on_progress)
        kept = result.metrics[[*self.plan.metrics]].to_numpy()
        return kept, result.failures

    def _flown_by(self, failure: FailureCase | None) -> tuple[Batch, list[int]]:
        """Return what flies a failure case, and which columns of values it takes."""
        batch = self._batch.holding(failure.values) if failure else self._batch
        return batch, [self.draws.names.index(name) for name in batch.names]

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


def _never(failure: FailureCase | None) -> list[str]:
    """Return the names of what never happens in a failure case."""
    held = failure.values if failure else {}
    return [name for name, value in held.items() if math.isinf(value)]


def _untold(names: Sequence[str], values: Array) -> str:
    untold = [name for name, x in zip(names, values, strict=True) if not np.isfinite(x)]
    return f"no number for {', '.join(untold)}"
