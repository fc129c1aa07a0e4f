"""What flies the variants of a case: the batch engine where it can, else Drake."""

import os
import time
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import NamedTuple, Protocol, Self, TypeAlias

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.engines.drake_pool import WORKERS_START, DrakePool
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.run import Run
from drakesep.tables.labelled_run import measured
from drakesep.tables.roles import Changed, failed
from drakesep.tables.variants import Variant


Values: TypeAlias = Mapping[str, float]
"""Of parameters by name, in SI."""


class Flown(NamedTuple):
    """A variant, and its run."""

    variant: Variant
    run: Run | None
    """None: it could not begin, or the engine told its metrics alone."""


class VariantEngine(Protocol):
    """Flies variants of a case, all with the same parameters."""

    fewest: int
    """How many take as long as one."""
    together: int
    """How many are flown at once, so that progress is told often enough."""
    workers: int
    """That fly them."""
    whole_runs: bool
    """Whether whole runs are flown, not metrics alone."""

    def prepare(self) -> None:
        """Do what is done once, such as compiling."""

    def fly(self, values: Sequence[Values]) -> list[Flown]:
        """Return the variants of some values; one that cannot be flown has failed."""


class InDrake:
    """Flies variants in Drake, as `simulate` does; a context manager."""

    whole_runs = True

    def __init__(
        self,
        case: AnalysisCase,
        clearances: Sequence[LowestClearance],
        count: int,
        workers: int | None,
    ):
        """Prepare.

        Args:
            case: that is varied.
            clearances: that are required, and measured of each.
            count: of variants.
            workers: number of processes; None: one per core, if that is worth it.
        """
        self._case, self._clearances = case, clearances
        self._pool = DrakePool(case.separation, case.integration, workers=1)
        began = time.perf_counter()
        [self._nominal] = self._pool.fly([{}])
        if workers is None and count * (time.perf_counter() - began) < WORKERS_START:
            workers = 1
        self.workers = workers or os.cpu_count() or 1
        if self.workers > 1:
            flown = case.separation, case.integration
            self._pool = DrakePool(*flown, workers=self.workers)
        self.fewest, self.together = 1, 8 * self.workers

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._pool.__exit__(kind, error, trace)

    def prepare(self) -> None:
        """Measure a run: the first takes several times as long as others."""
        _measured(self._case, {}, self._nominal, self._clearances)

    def fly(self, values: Sequence[Values]) -> list[Flown]:
        """Return the variants of some values; one that cannot be flown has failed."""
        refused = [self._refusal(one) for one in values]
        sound = [one for one, why in zip(values, refused, strict=True) if not why]
        flown = iter(self._pool.fly(sound))
        return [
            Flown(Variant(values=one, outcome=failed(why)), None)
            if why
            else _measured(self._case, one, next(flown), self._clearances)
            for one, why in zip(values, refused, strict=True)
        ]

    def _refusal(self, values: Values) -> str:
        """Return why values are not physical; empty if they are."""
        try:
            with_values(self._case.separation, values)
        except InputError as error:
            return str(error)
        return ""


class OnBatch:
    """Flies variants on the batch engine."""

    def __init__(
        self,
        case: AnalysisCase,
        names: Sequence[str],
        clearances: Sequence[LowestClearance],
    ):
        """Prepare.

        Args:
            case: that is varied.
            names: of the parameters that vary.
            clearances: that are required, and measured of each.

        Raises:
            ValueError: the batch engine cannot fly the separation, or does not read a
                parameter.
        """
        self._case, self._clearances = case, clearances
        told = metrics_of(case.separation, case.metrics)
        reached = [m for m in told if m.comes_about(case.separation)]
        self._names = [name for metric in told for name in metric.names]
        self._batch = Batch(
            case.separation,
            names,
            deviation_limits=case.limits_of_pairs,
            metrics=[name for metric in reached for name in metric.names],
        )
        # What steps do not tell, the sampled motion does.
        steps_tell = all(metric.of_steps for metric in reached)
        self.whole_runs = bool(clearances) or not steps_tell
        self.fewest = 16 if self.whole_runs else self._batch.chunk
        self.together = self.fewest * (4 if self.whole_runs else 32)
        self.workers = 1 if self.whole_runs else self._batch.workers

    def prepare(self) -> None:
        """Compile its programs."""
        nominal = dict(zip(self._batch.names, self._batch.nominal, strict=True))
        self.fly([nominal])

    def fly(self, values: Sequence[Values]) -> list[Flown]:
        """Return the variants of some values; one that cannot be flown has failed."""
        rows = np.array([[one[name] for name in self._batch.names] for one in values])
        if self.whole_runs:
            runs = self._batch.runs(rows)
            pairs = zip(values, runs, strict=True)
            return [_measured(self._case, *pair, self._clearances) for pair in pairs]
        result = self._batch.run(rows)
        # NaN of a metric that looks beyond the end of the run.
        metrics = result.metrics.reindex(columns=self._names).to_dict("records")
        return [
            Flown(variant, None)
            for variant in (
                Variant(values=one, outcome=failed(result.failures[i]))
                if i in result.failures
                else Variant(values=one, metrics={str(k): x for k, x in row.items()})
                for i, (one, row) in enumerate(zip(values, metrics, strict=True))
            )
        ]


def _measured(
    case: AnalysisCase,
    values: Values,
    run: Run,
    clearances: Sequence[LowestClearance],
) -> Flown:
    """Return a variant that has been flown."""
    one = measured(Changed(), run, case, clearances)
    variant = Variant(values=values, metrics=one.metrics, outcome=one.outcome)
    return Flown(variant, run)
