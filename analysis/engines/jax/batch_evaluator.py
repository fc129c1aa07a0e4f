"""Tells a search the objectives by the batch engine."""

from collections.abc import Iterator, Sequence
from concurrent import futures

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.engines.evaluator import Evaluated, Progress
from drakesep.analysis.engines.jax.batch import Batch, BatchResult
from drakesep.analysis.engines.jax.compiling_threads import compiling_threads
from drakesep.analysis.engines.jax.together import Ask, OneOfMany
from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.metrics.objectives import Limits, MetricObjective, Objective
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run


_COMPILERS = 2
"""Programs that are compiled beside each other."""


class BatchEvaluator:
    """Flies on the batch engine; knows derivatives of what metrics tell."""

    def __init__(
        self,
        batch: Batch,
        objectives: Sequence[Objective],
        limits: Limits,
        *,
        derivatives: bool = True,
        ask: Ask | None = None,
    ):
        """Prepare.

        Args:
            batch: that flies; it must have the same limits, and tell the metrics that
                the objectives read.
            objectives: to be told.
            limits: (3,) of the deviations, as `metrics_of_run` takes them.
            derivatives: whether to use those of the batch engine: differences cost less
                where runs take many steps.
            ask: flies its rows with those of others (see `OneOfMany`); the batch
                does, by itself, if None.

        Raises:
            ValueError: the batch does not tell a metric.
        """
        self._derivatives = derivatives
        self._preparing: list[futures.Future[BatchResult]] = []
        self._batch = batch
        self._flies = batch if ask is None else OneOfMany(batch, ask)
        self.concurrent = ask is None
        self.names = batch.names
        self.objectives = tuple(objectives)
        self._by_metrics = {
            k: objective
            for k, objective in enumerate(self.objectives)
            if isinstance(objective, MetricObjective)
        }
        for objective in self._by_metrics.values():
            for name in sorted(objective.reads.difference(batch.metrics)):
                raise InputError(
                    f"{objective.name}: needs a batch that tells {name}: make it with "
                    f"metrics=[{name!r}]"
                )
        self._of_runs = RunEvaluator(self._flies.runs, batch.names, objectives, limits)

    def exact(self, k: int) -> bool:
        """Return whether derivatives are to be had: of what metrics alone tell."""
        return self._derivatives and k in self._by_metrics

    def all(
        self,
        rows: Array,
        on_progress: Progress | None = None,
        of: Sequence[int] | None = None,
    ) -> Evaluated:
        """Return every objective at every row; NaN for those that are not asked for.

        Args:
            rows: (n, n_p) of the parameters, in SI.
            on_progress: called now and then.
            of: which objectives; all if None.
        """
        asked = range(len(self.objectives)) if of is None else of
        by_metrics = [k for k in asked if k in self._by_metrics]
        others = [k for k in asked if k not in self._by_metrics]
        values = np.full((len(rows), len(self.objectives)), np.nan)
        failures: dict[int, str] = {}
        if by_metrics:
            result = self._flies.run(rows, on_progress=on_progress)
            metrics = _by_name(result)
            for k in by_metrics:
                values[:, k] = self._by_metrics[k].of_metrics(metrics)
            failures |= result.failures
        if others:
            told = self._of_runs.all(rows, on_progress, others)
            values[:, others] = told.values[:, others]
            failures |= told.failures
        return Evaluated(values, failures)

    def one(self, rows: Array, which: Sequence[int]) -> Evaluated:
        """Return one objective at each row: the which[i]-th at row i."""
        by_metrics = np.array([k in self._by_metrics for k in which], dtype=bool)
        values = np.full(len(rows), np.nan)
        failures: dict[int, str] = {}
        unended: set[int] = set()
        parts: list[tuple[NDArray[np.intp], Evaluated]] = []
        if by_metrics.any():
            index = np.flatnonzero(by_metrics)
            result = self._flies.run(rows[index])
            told = self._tell(result, [which[i] for i in index.tolist()])
            parts.append((index, Evaluated(told, dict(result.failures))))
        if not by_metrics.all():
            index = np.flatnonzero(~by_metrics)
            parts.append(
                (
                    index,
                    self._of_runs.one(rows[index], [which[i] for i in index.tolist()]),
                )
            )
        for index, part in parts:
            values[index] = part.values
            failures |= {int(index[i]): why for i, why in part.failures.items()}
            unended |= {int(index[i]) for i in part.unended}
        return Evaluated(values, failures, frozenset(unended))

    def near(self, rows: Array, k: int) -> Evaluated:
        """Return an objective at the first row, and about it at the others."""
        if k in self._by_metrics:
            return self.one(rows, [k] * len(rows))
        return self._of_runs.near(rows, k)

    def runs(self, rows: Array, k: int) -> list[Run]:
        """Return the run of each row, completed or failed, for an objective."""
        return self._of_runs.runs(rows, k)

    def run_by_run(self, k: int) -> int | None:
        """Return how many whole runs were flown until now to tell an objective.

        None if metrics tell it.
        """
        return None if k in self._by_metrics else self._of_runs.run_by_run(k)

    def prepare(self) -> None:
        """Begin to compile what searches need, beside whatever comes next."""
        nominal = self._batch.nominal[None]
        # What goes wrong here goes wrong again where it is told of. No daemons: a
        # process that ends within the compiler does so with a crash.
        pool = compiling_threads(_COMPILERS)
        if self._by_metrics:
            self._preparing.append(pool.submit(self._batch.run, nominal))
        if any(map(self.exact, range(len(self.objectives)))):
            self._preparing.append(pool.submit(self._batch.jacobian, nominal))
        if len(self._by_metrics) < len(self.objectives):
            pool.submit(self._batch.runs, nominal)
        pool.shutdown(wait=False)

    def wait(self) -> None:
        """Wait until what metrics tell can be told at once."""
        futures.wait(self._preparing)

    def slopes(self, rows: Array, which: Sequence[int]) -> tuple[Evaluated, Array]:
        """Return one objective at each row, and its derivatives (n, n_p)."""
        self.wait()
        result = self._batch.jacobian(rows)
        assert result.jacobian is not None
        slopes = np.zeros((len(rows), len(self.names)))
        places = {name: m for m, name in enumerate(result.metrics)}
        for i, (k, metrics) in enumerate(zip(which, _row_by_row(result), strict=True)):
            for name, weight in self._by_metrics[k].weights(metrics).items():
                if weight != 0.0:  # else its slope may be undefined
                    slopes[i] += weight * result.jacobian[i, places[name]]
        return Evaluated(self._tell(result, which), dict(result.failures)), slopes

    def _tell(self, result: BatchResult, which: Sequence[int]) -> Array:
        """Return (n,) one objective at each row, those of an objective at once."""
        asked, metrics = np.asarray(which), _by_name(result)
        values = np.empty(len(asked))
        for k in np.unique(asked).tolist():
            mine = asked == k
            some = {name: column[mine] for name, column in metrics.items()}
            values[mine] = self._by_metrics[k].of_metrics(some)
        return values


def _by_name(result: BatchResult) -> dict[str, Array]:
    """Return the metrics (n,) of a batch."""
    # All at once: column by column a frame takes longer than a few rows to fly.
    return dict(zip(map(str, result.metrics), result.metrics.to_numpy().T, strict=True))


def _row_by_row(result: BatchResult) -> Iterator[dict[str, Array]]:
    """Yield the metrics of each row of a batch."""
    names = list(map(str, result.metrics))
    for row in result.metrics.to_numpy():
        yield dict(zip(names, row, strict=True))
