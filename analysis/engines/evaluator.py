"""What tells a search the objectives at points: the batch engine, or run by run."""

import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent import futures
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.engines.jax.batch import Batch, BatchResult
from drakesep.analysis.metrics.objectives import About, Limits, Objective
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run, RunStatus


Progress: TypeAlias = Callable[[int, int], None]
"""Told how many rows are done, and of how many."""


class Evaluated(NamedTuple):
    """What was found at rows of parameter values."""

    values: Array
    """(n,) of one objective for each row, or (n, m) of all; NaN where a run failed."""
    failures: dict[int, str]
    """Why runs failed, by row."""


class Evaluator(Protocol):
    """Tells objectives at rows (n, n_p) of parameter values, in SI."""

    names: tuple[str, ...]
    """(n_p,) of the parameters."""
    objectives: tuple[Objective, ...]
    concurrent: bool
    """Whether several threads may ask at once."""

    def exact(self, k: int) -> bool:
        """Return whether `slopes` knows those of an objective."""
        ...

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
        ...

    def one(self, rows: Array, which: Sequence[int]) -> Evaluated:
        """Return one objective at each row: the which[i]-th at row i."""
        ...

    def near(self, rows: Array, k: int) -> Evaluated:
        """Return an objective at the first row, and about it at the others."""
        ...

    def slopes(self, rows: Array, which: Sequence[int]) -> tuple[Evaluated, Array]:
        """Return one objective at each row, and its derivatives (n, n_p)."""
        ...

    def runs(self, rows: Array) -> list[Run]:
        """Return the run of each row, completed or failed."""
        ...


class RunEvaluator:
    """Flies run by run, whoever flies; knows no derivatives."""

    concurrent = False

    def __init__(
        self,
        fly: Callable[[Array], list[Run]],
        names: Sequence[str],
        objectives: Sequence[Objective],
        limits: Limits = (math.inf,) * 3,
    ):
        """Prepare.

        Args:
            fly: returns the runs of rows (n, n_p).
            names: (n_p,) of the parameters.
            objectives: to be told.
            limits: (3,) of the deviations, as `metrics_of_run` takes them.
        """
        self._fly = fly
        self._limits = limits
        self.names = tuple(names)
        self.objectives = tuple(objectives)
        # What is asked for at a row and, a little later, about it.
        self._last: OrderedDict[tuple[int, bytes], About] = OrderedDict()

    def exact(self, k: int) -> bool:
        """Return False: differences must do."""
        return False

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
        values = np.full((len(rows), len(self.objectives)), np.nan)
        failures: dict[int, str] = {}
        expensive = any(self.objectives[k].expensive for k in asked)
        size = 1 if expensive else _ROWS
        for first in range(0, len(rows), size):
            part = rows[first : first + size]
            for i, run in enumerate(self._fly(part), first):
                if run.status is RunStatus.FAILED:
                    failures[i] = run.message
                else:
                    values[i, asked] = [self._tell(k, run, rows[i]) for k in asked]
            if on_progress is not None:
                on_progress(first + len(part), len(rows))
        return Evaluated(values, failures)

    def one(self, rows: Array, which: Sequence[int]) -> Evaluated:
        """Return one objective at each row: the which[i]-th at row i."""
        values = np.full(len(rows), np.nan)
        failures = {}
        for i, run in enumerate(self._fly(rows)):
            if run.status is RunStatus.FAILED:
                failures[i] = run.message
            else:
                values[i] = self._tell(which[i], run, rows[i])
        return Evaluated(values, failures)

    def near(self, rows: Array, k: int) -> Evaluated:
        """Return an objective at the first row, and about it at the others."""
        values = np.full(len(rows), np.nan)
        runs = self._fly(rows)
        failures = {
            i: run.message
            for i, run in enumerate(runs)
            if run.status is RunStatus.FAILED
        }
        if not failures:
            about = self._about(k, runs[0], rows[0])
            values[:] = [about.value, *map(about.near, runs[1:])]
        return Evaluated(values, failures)

    def slopes(self, rows: Array, which: Sequence[int]) -> tuple[Evaluated, Array]:
        """Refuse."""
        raise TypeError("there are no derivatives run by run")

    def runs(self, rows: Array) -> list[Run]:
        """Return the run of each row, completed or failed."""
        return self._fly(rows)

    def _tell(self, k: int, run: Run, row: Array) -> float:
        return self._about(k, run, row).value

    def _about(self, k: int, run: Run, row: Array) -> About:
        objective = self.objectives[k]
        key = k, row.tobytes()
        known = self._last.get(key)
        if known is not None:
            return known
        point = ", ".join(
            f"{name} = {x:.9g}" for name, x in zip(self.names, row, strict=True)
        )
        try:
            about = objective.about(run, self._limits)
        except InputError:
            raise
        except Exception as error:  # whatever a user's function raises
            raise InputError(
                f"objective {objective.name} must give a number for every run, got "
                f"{type(error).__name__}: {error}, at {point}"
            ) from error
        if not math.isfinite(about.value):
            raise InputError(
                f"objective {objective.name} must be finite for every run, got "
                f"{about.value} at {point}; let it return a number for such a run too, "
                "a low one if the run is harmless"
            )
        if objective.expensive:
            self._last[key] = about
            if len(self._last) > _KEPT:
                self._last.popitem(last=False)
        return about


_ROWS = 64
"""Between two tellings of progress."""
_KEPT = 1024
"""Answers to expensive questions."""
_COMPILERS = 2
"""Programs that are compiled beside each other."""


class BatchEvaluator:
    """Flies on the batch engine; knows derivatives of what metrics tell."""

    concurrent = True

    def __init__(
        self,
        batch: Batch,
        objectives: Sequence[Objective],
        limits: Limits,
        *,
        derivatives: bool = True,
    ):
        """Prepare.

        Args:
            batch: that flies; it must have the same limits.
            objectives: to be told.
            limits: (3,) of the deviations, as `metrics_of_run` takes them.
            derivatives: whether to use those of the batch engine: differences cost less
                where runs take many steps.
        """
        self._derivatives = derivatives
        self._preparing: futures.Future[BatchResult] | None = None
        self._batch = batch
        self.names = batch.names
        self.objectives = tuple(objectives)
        self._of_runs = RunEvaluator(batch.runs, batch.names, objectives, limits)

    def exact(self, k: int) -> bool:
        """Return whether derivatives are to be had: of what metrics alone tell."""
        return self._derivatives and self.objectives[k].of_metrics_alone

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
        of_metrics = [k for k in asked if self.objectives[k].of_metrics_alone]
        others = [k for k in asked if not self.objectives[k].of_metrics_alone]
        values = np.full((len(rows), len(self.objectives)), np.nan)
        failures: dict[int, str] = {}
        if of_metrics:
            result = self._batch.run(rows, on_progress=on_progress)
            metrics = result.metrics.to_numpy()
            for k in of_metrics:
                values[:, k] = self.objectives[k].of_metrics(metrics)
            failures |= result.failures
        if others:
            told = self._of_runs.all(rows, on_progress, others)
            values[:, others] = told.values[:, others]
            failures |= told.failures
        return Evaluated(values, failures)

    def one(self, rows: Array, which: Sequence[int]) -> Evaluated:
        """Return one objective at each row: the which[i]-th at row i."""
        of_metrics = np.array(
            [self.objectives[k].of_metrics_alone for k in which], dtype=bool
        )
        values = np.full(len(rows), np.nan)
        failures: dict[int, str] = {}
        parts: list[tuple[NDArray[np.intp], Evaluated]] = []
        if of_metrics.any():
            index = np.flatnonzero(of_metrics)
            result = self._batch.run(rows[index])
            told = self._tell(
                result.metrics.to_numpy(), [which[i] for i in index.tolist()]
            )
            parts.append((index, Evaluated(told, dict(result.failures))))
        if not of_metrics.all():
            index = np.flatnonzero(~of_metrics)
            parts.append(
                (
                    index,
                    self._of_runs.one(rows[index], [which[i] for i in index.tolist()]),
                )
            )
        for index, part in parts:
            values[index] = part.values
            failures |= {int(index[i]): why for i, why in part.failures.items()}
        return Evaluated(values, failures)

    def near(self, rows: Array, k: int) -> Evaluated:
        """Return an objective at the first row, and about it at the others."""
        if self.objectives[k].of_metrics_alone:
            return self.one(rows, [k] * len(rows))
        return self._of_runs.near(rows, k)

    def runs(self, rows: Array) -> list[Run]:
        """Return the run of each row, completed or failed."""
        return self._of_runs.runs(rows)

    def prepare(self) -> None:
        """Begin to compile what searches need, beside whatever comes next."""
        nominal = self._batch.nominal[None]
        # What goes wrong here goes wrong again where it is told of. No daemons: a
        # process that ends within the compiler does so with a crash.
        pool = futures.ThreadPoolExecutor(_COMPILERS)
        if any(objective.of_metrics_alone for objective in self.objectives):
            pool.submit(self._batch.run, nominal)
        if any(map(self.exact, range(len(self.objectives)))):
            self._preparing = pool.submit(self._batch.jacobian, nominal)
        if not all(objective.of_metrics_alone for objective in self.objectives):
            pool.submit(self._batch.runs, nominal)
        pool.shutdown(wait=False)

    def slopes(self, rows: Array, which: Sequence[int]) -> tuple[Evaluated, Array]:
        """Return one objective at each row, and its derivatives (n, n_p)."""
        if self._preparing is not None:
            futures.wait([self._preparing])
        result = self._batch.jacobian(rows)
        assert result.jacobian is not None
        metrics = result.metrics.to_numpy()
        weights = np.stack(
            [self.objectives[k].weights(metrics[i]) for i, k in enumerate(which)]
        )
        # A metric of weight 0 counts for nothing, even where its slope is undefined.
        terms = np.where(weights[..., None] == 0.0, 0.0, result.jacobian)
        slopes = np.einsum("nm,nmp->np", weights, terms)
        values = self._tell(metrics, which)
        return Evaluated(values, dict(result.failures)), slopes

    def _tell(self, metrics: Array, which: Sequence[int]) -> Array:
        return np.array(
            [
                float(self.objectives[k].of_metrics(row))
                for k, row in zip(which, metrics, strict=True)
            ]
        )
