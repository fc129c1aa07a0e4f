"""Many runs at once: metrics, their derivatives and motion of a whole batch.

The batch engine integrates the same equations as the Drake systems, in JAX and double
precision, many samples side by side. Drake stays the reference. How a batch is flown is
told in `drakesep.systems.batch.integrator`.
"""

import copy
import functools
import math
import os
import threading
from collections.abc import (
    Callable,
    Collection,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
)
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import jax
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from drakesep.analysis.engines.jax.batch_input import (
    check_free,
    check_limits,
    check_names,
)
from drakesep.analysis.engines.jax.compiled import (
    Program,
    call,
    compiler_options,
    keep_programs,
)
from drakesep.analysis.engines.jax.compiling_threads import compiling_threads
from drakesep.analysis.engines.jax.flights import Flown, MetricsFlight, SlopesFlight
from drakesep.analysis.engines.jax.metrics_fold import MetricsFold
from drakesep.analysis.engines.jax.sampled_runs import SampledRun
from drakesep.analysis.metrics.of_run import metric_named
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.analysis.metrics.requirements import Limits
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.integrator import (
    BatchIntegrator,
    FinalState,
    LaneStatus,
)
from drakesep.systems.batch.lanes import Lanes
from drakesep.systems.batch.motion import MotionFold
from drakesep.systems.batch.relative_places import CURVED, PLACE, PlacesFold
from drakesep.systems.batch.row_checks import RowChecks
from drakesep.systems.checks import (
    InputError,
    check_distinct,
    check_finite,
    check_positive,
    unknown,
)
from drakesep.systems.model.parameters import (
    check_read,
    declarations,
    parameters,
    places_of_parts,
    with_values,
)
from drakesep.systems.model.relative_places import RelativePlaces
from drakesep.systems.model.run import Run, RunStatus
from drakesep.systems.model.separation import Separation


Progress = Callable[[int, int], None]
"""Told how many rows are done, and of how many."""

Values: TypeAlias = ArrayLike | pd.DataFrame

TOLERANCE = 1e-7
"""Of a run's error estimate, in SI; metrics are within 1e-8 of their values by it."""
MAX_STEPS = 20_000
_CHUNK = {"cpu": 128}
"""Rows that are flown together: on a CPU as many as its cache holds."""
_CHUNK_OF_ACCELERATOR = 65_536
_WORKERS = 4
"""Of an accelerator."""
_RUNS = 32
"""Rows whose motion is sampled together."""
_TIMES = 256
"""Sample times come in multiples of this: each number of them is a program."""
_PLACES = 2**20
"""Numbers of places of rows that are flown together, at most."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchResult:
    """What came of a batch of n rows."""

    names: tuple[str, ...]
    """(n_p,) of the parameters."""
    metrics: pd.DataFrame
    """(n, n_m) metrics of each row, in SI; NaN in rows that failed."""
    failures: Mapping[int, str]
    """Why a row failed, by its number from 0."""
    steps: NDArray[np.int64]
    """(n,) integration steps tried for each row; 0 if it was not flown."""
    jacobian: Array | None = field(default=None, repr=False)
    """(n, n_m, n_p) derivatives of the metrics with the parameters, if asked for."""


@typed
class Batch:
    """Flies a separation for whole arrays of parameter values.

    It tells the metrics that are registered when it is made. Programs are compiled at
    first use, for a separation and the names of the parameters that vary, and kept on
    disk across processes: in JAX's cache, which is put into the user's cache folder
    unless JAX has been told of another. Rows are flown in chunks, on all cores: memory
    does not grow with their number, and no result depends on the number of workers. An
    interrupt is raised at once; see `compiling_threads` for when the process ends.

    Attributes:
        separation: that is flown.
        names: (n_p,) of the parameters that vary.
        nominal: (n_p,) their values in the separation.
        metrics: (n_m,) names of what it tells.
        chunk: rows that are flown together.
        workers: threads that fly chunks.
    """

    def __init__(
        self,
        separation: Separation,
        names: Sequence[str],
        *,
        deviation_limits: Limits = (math.inf,) * 3,
        metrics: Iterable[str] = (),
        without: Collection[str] = (),
        tolerance: float = TOLERANCE,
        max_steps: int = MAX_STEPS,
        chunk: int | None = None,
        workers: int | None = None,
    ):
        """Prepare.

        Args:
            separation: to be flown and varied.
            names: (n_p,) parameters that vary; see `drakesep.systems.model.parameters`.
            deviation_limits: (3,) limits of roll, pitch and yaw, rad, for the time
                until which all stay within theirs; infinite where there is none; or
                those of several pairs, see `Limits`.
            metrics: names of others to tell beside those that are registered, if steps
                tell them; see `drakesep.analysis.metrics.quantities`.
            without: stems of registered ones that are not to be told, as nobody asks
                for them: the paper's four take a fifth of a run.
            tolerance: of the error estimates of all steps of a run together, in SI.
            max_steps: after which a row has failed.
            chunk: rows that are flown together; what suits the machine if None.
            workers: threads that fly chunks; one per core if None, four on a GPU: some
                prepare chunks while one is flown.

        Raises:
            ValueError: a parameter is unknown, named twice or none that the equations
                read, a metric is unknown or named twice, or a number is not positive.
        """
        metrics = list(metrics)
        check_distinct("metrics", metrics)
        nominal = parameters(separation)
        check_names(names, nominal)
        check_limits(deviation_limits, separation.pairs)
        check_free(separation)
        check_positive("tolerance", tolerance)
        keep_programs()
        platform = jax.default_backend()
        chunk = _CHUNK.get(platform, _CHUNK_OF_ACCELERATOR) if chunk is None else chunk
        if workers is None:
            workers = (os.cpu_count() or 1) if platform == "cpu" else _WORKERS
        for what, number in (
            ("max_steps", max_steps),
            ("chunk", chunk),
            ("workers", workers),
        ):
            if number < 1:
                raise InputError(f"{what} must be a whole number >= 1, got {number}")
        self.separation = separation
        self.names = tuple(names)
        self.chunk, self.workers = chunk, workers
        self._max_steps = max_steps
        self._nominal = nominal
        self.nominal = np.array([nominal[name] for name in names])
        self._whole: Batch | None = None  # this one, until it holds some
        self._all_names, self._free = self.names, np.arange(len(names))
        self._lane = self.nominal  # of all of the programs' parameters
        self._equations = BatchEquations(separation, names)
        read = {*self._equations.read, *places_of_parts(separation)}
        check_read(names, read, "the batch engine")
        self._row_checks = RowChecks(separation, names)
        integrator = functools.partial(
            BatchIntegrator, self._equations, tolerance=tolerance, max_steps=max_steps
        )
        self._integrator = integrator()
        usual = [m for m in registered_metrics() if m.stem not in without]
        told = dict.fromkeys([*usual, *map(metric_named, metrics)])
        known = ["", *(pair.B for pair in separation.pairs)]
        for metric in told:
            if metric.of_steps and metric.pair not in known:
                raise InputError(unknown("body that leaves", metric.pair, known))
        self._fold = MetricsFold(self._equations, deviation_limits, tuple(told))
        self.metrics = self._fold.names
        compiled = functools.partial(
            jax.jit, compiler_options=compiler_options(platform)
        )
        # Lanes of slopes carry twice as much, and a row has n_p.
        few = -(-chunk // (2 * len(names)))
        flight = functools.partial(MetricsFlight, fold=self._fold, params=self._params)
        # Where times vary, those that coincide must be told apart.
        declared = declarations(separation)
        timed = any(declared[name].kind == "time" for name in names)
        slopes = SlopesFlight(flight(integrator(one_by_one=timed)))
        self._metrics = Program(compiled, flight(self._integrator), chunk)
        self._metrics_and_slopes = Program(compiled, slopes, few)
        self._motion = compiled(self._fly_motion)
        self._flown_as = compiled, flight
        self._places: tuple[Program, PlacesFold] | None = None  # see `watching`
        self._watched: dict[Any, tuple[Program, PlacesFold]] = {}

    @typed
    def holding(self, values: Mapping[str, float]) -> "Batch":
        """Return a batch that flies by the same programs, with some parameters held.

        They have other values than in this one's separation, and do not vary.

        Args:
            values: new ones, in SI, by name, of parameters that the programs vary:
                those of this batch, or such as it holds.

        Raises:
            ValueError: a parameter is another, or a value is not physical.
        """
        for name, value in values.items():
            if name not in self._all_names:
                raise InputError(unknown("parameter", name, self._all_names))
            check_finite(name, value)
        held = copy.copy(self)
        held._whole = self.whole
        held.separation = with_values(self.separation, values)
        held._lane = self._lane.copy()
        for name, value in values.items():
            held._lane[self._all_names.index(name)] = value
        free = [i for i in self._free if self._all_names[i] not in values]
        held._free = np.array(free, dtype=np.intp)
        held.names = tuple(self._all_names[i] for i in free)
        held.nominal = held._lane[held._free]
        held._row_checks = RowChecks(held.separation, held.names)
        return held

    @property
    def whole(self) -> "Batch":
        """The batch that flies by the same programs, and holds no parameter."""
        return self if self._whole is None else self._whole

    def whole_rows(self, values: Values) -> Array:
        """Return rows (n, n_p) of parameters as rows of `whole`, with what is held.

        Raises:
            ValueError: the values are not n_p columns.
        """
        rows = self._check_values(values)
        return self._filled(rows, len(rows)).T

    @typed
    def run(
        self, values: Values, *, on_progress: Progress | None = None
    ) -> BatchResult:
        """Fly each row of values.

        Args:
            values: (n, n_p) of the parameters, in SI, in their order; or a frame with
                their names.
            on_progress: called every few chunks.

        Raises:
            ValueError: the values are not n_p columns.
        """
        return self._run(self._metrics, values, on_progress)

    @typed
    def jacobian(
        self, values: Values, *, on_progress: Progress | None = None
    ) -> BatchResult:
        """Fly each row of values, with the derivatives of all metrics.

        They are exact: those of the integration itself, in forward mode. At a kink of a
        metric they lie between both sides'; see
        `drakesep.analysis.engines.jax.metrics_fold`.

        Args:
            values: (n, n_p) of the parameters, in SI, in their order; or a frame with
                their names.
            on_progress: called every few chunks.

        Raises:
            ValueError: the values are not n_p columns.
        """
        return self._run(self._metrics_and_slopes, values, on_progress)

    @typed
    def runs(self, values: Values) -> list[Run]:
        """Fly each row of values, and return the runs with their sampled motion.

        They are like those of `Simulation.run`, for whatever takes one: an objective, a
        table, a plot. A row that is not physical is a failed run of the nominal.

        Args:
            values: (n, n_p) of the parameters, in SI, in their order; or a frame with
                their names.

        Raises:
            ValueError: the values are not n_p columns.
        """
        rows = self._check_values(values)
        runs: list[Run] = []
        for part, flown, failures in self._fly_parts(self._metrics, rows):
            runs += self._sampled(rows[part], flown.final, failures)
        return runs

    @typed
    def watching(
        self, ends: Sequence[tuple[str, str]], times: Sequence[float]
    ) -> "Batch":
        """Return a batch that tells where bodies are as seen from others, too.

        Args:
            ends: (k,) names of bodies A and B.
            times: (T,) that rise, within the run, s.
        """
        watching, key = copy.copy(self), (tuple(ends), tuple(times))
        if key not in self._watched:  # compiled once
            compiled, flight = self._flown_as
            fold = PlacesFold(self._equations, ends, times)
            of_row = (PLACE + CURVED) * len(ends) * len(times)
            chunk = min(self.chunk, max(_PLACES // of_row, 1))
            program = Program(compiled, flight(self._integrator, fold=fold), chunk)
            self._watched[key] = program, fold
        watching._places = self._watched[key]
        return watching

    @typed
    def places(self, values: Values) -> Iterator[tuple[slice, RelativePlaces]]:
        """Yield where bodies are in parts of the rows, in order, if it is `watching`.

        Of a row that fails, nothing it says holds.

        Args:
            values: (n, n_p) of the parameters, in SI, in their order; or a frame with
                their names.

        Raises:
            ValueError: the values are not n_p columns, or nothing is watched.
        """
        if self._places is None:
            raise InputError("places: a batch must be `watching` bodies, got none")
        program, fold = self._places
        for part, flown, _ in self._fly_parts(program, self._check_values(values)):
            yield part, fold.places_of(flown.metrics)

    # Chunks of rows.

    def _check_values(self, values: Values) -> Array:
        if isinstance(values, pd.DataFrame):
            if set(values.columns) != set(self.names):
                raise InputError(
                    f"columns must be the parameters {', '.join(self.names)}, "
                    f"got {', '.join(map(str, values.columns))}"
                )
            values = values[list(self.names)]
        elif np.iscomplexobj(values):
            raise InputError("values must be real numbers, got complex ones")
        rows = np.asarray(values, dtype=float)
        if rows.ndim != 2 or rows.shape[1] != len(self.names):
            raise InputError(
                f"values must have a column for each of the {len(self.names)} "
                f"parameters, got an array of shape {rows.shape}"
            )
        return rows

    def _run(
        self,
        program: Program,
        values: Values,
        on_progress: Progress | None,
    ) -> BatchResult:
        rows = self._check_values(values)
        failures: dict[int, str] = {}
        metrics = np.empty((len(rows), len(self._fold.names)))
        steps = np.empty(len(rows), dtype=np.int64)
        jacobian = None
        if program is self._metrics_and_slopes:
            jacobian = np.empty((*metrics.shape, len(self.names)))
        for part, flown, failed in self._fly_parts(program, rows):
            metrics[part] = flown.metrics.T
            steps[part] = flown.final.steps
            if jacobian is not None:
                jacobian[part] = np.transpose(flown.slopes, (2, 1, 0))[..., self._free]
            failures |= {part.start + i: why for i, why in failed.items()}
            if on_progress is not None:
                on_progress(part.stop, len(rows))
        metrics[list(failures)] = np.nan
        if jacobian is not None:
            jacobian[list(failures)] = np.nan
        index = values.index if isinstance(values, pd.DataFrame) else None
        return BatchResult(
            names=self.names,
            metrics=pd.DataFrame(metrics, index=index, columns=list(self._fold.names)),
            failures=failures,
            steps=steps,
            jacobian=jacobian,
        )

    def _fly_parts(
        self, program: Program, rows: Array
    ) -> Iterator[tuple[slice, Flown, dict[int, str]]]:
        """Yield parts of the rows in order, of some chunks, and what came of them.

        With why rows failed, by their numbers in the part.
        """
        chunks = -(-len(rows) // program.chunk)
        most = min(chunks // self.workers, program.affordable)
        size = program.chunk * max(most, 1)
        parts = [
            slice(start, min(start + size, len(rows)))
            for start in range(0, len(rows), size)
        ]

        over = threading.Event()

        def fly(part: slice) -> tuple[slice, Flown, dict[int, str]]:
            mine = rows[part]
            unflown = self._row_checks.failures(mine)
            lanes = self._filled(mine, program.lanes)
            lanes[:, list(unflown)] = self._lane[:, None]
            return part, program(lanes, len(mine), lambda: not over.is_set()), unflown

        pool = compiling_threads(self.workers)
        try:
            for part, flown, unflown in pool.map(fly, parts):
                yield part, _without(flown, unflown), self._why_not(flown) | unflown
        finally:
            # An interrupt does not wait: threads end after the call that they are in.
            over.set()
            pool.shutdown(wait=False, cancel_futures=True)

    def _filled(self, rows: Array, count: int) -> Array:
        """Return lanes (all, count) of fewer rows: every call has the same size."""
        lanes = np.tile(self._lane[:, None], count)
        lanes[self._free, : len(rows)] = rows.T
        return lanes

    def _why_not(self, flown: Flown) -> dict[int, str]:
        """Return why rows of a part failed."""
        final = flown.final
        finite = np.isfinite(flown.metrics).all(axis=0)
        if flown.slopes is not None:
            finite &= np.isfinite(flown.slopes).all(axis=(0, 1))
        failed = (final.status != LaneStatus.COMPLETED) | ~finite
        return {
            i: self._reason(_of_row(final, i)) for i in np.flatnonzero(failed).tolist()
        }

    def _reason(self, final: FinalState) -> str:
        """Return why one row failed."""
        separation = self.separation
        late = [a.lets_go for a in separation.attachments] & np.isinf(final.released)
        parts = [
            separation.may_part(attachment) for attachment, _ in separation.pushing
        ]
        return LaneStatus(int(final.status)).message.format(
            held=_names(separation.attachments, late),
            left=_names(separation.springs, parts & np.isinf(final.stroke_ends)),
            time=final.time,
            max_steps=self._max_steps,
        )

    # The programs.

    def _params(self, values: Lanes) -> Any:
        p = {**self._nominal, **dict(zip(self._all_names, values, strict=True))}
        return self._equations.params(p, values.shape[1])

    def _fly_motion(self, values: Lanes, times: Lanes) -> Lanes:
        fold, params = MotionFold(self._equations, times), self._params(values)
        signals: Lanes = self._integrator.fly(params, fold).folded.signals
        return signals

    # Sampled motion.

    def _sampled(
        self, rows: Array, final: FinalState, reasons: Mapping[int, str]
    ) -> list[Run]:
        """Return the runs of rows (n, n_p), of which some failed.

        Args:
            rows: that were flown.
            final: how they ended.
            reasons: why those failed that did, by row.
        """
        runs: dict[int, Run] = {}
        flown = [i for i in range(len(rows)) if i not in reasons]
        for begin in range(0, len(flown), _RUNS):
            chunk = flown[begin : begin + _RUNS]
            plans = [
                SampledRun.of(self.separation, final, i, lane, self._values(rows[i]))
                for lane, i in enumerate(chunk)
            ]
            signals = self._sample_motion(self._filled(rows[chunk], _RUNS), plans)
            made = (plan.run(signals) for plan in plans)
            runs |= zip(chunk, made, strict=True)
        return [
            runs[i] if i in runs else self._failed(row, reasons[i])
            for i, row in enumerate(rows)
        ]

    def _failed(self, row: Array, reason: str) -> Run:
        """Return a run that failed; of the nominal, if the row is not physical."""
        physical = not self._row_checks.failures(row[None])
        values = self._values(row) if physical else {}
        return Run(
            separation=with_values(self.separation, values),
            status=RunStatus.FAILED,
            message=reason,
        )

    def _values(self, row: Array) -> dict[str, float]:
        """Return the values that are not the nominal ones."""
        changed = np.flatnonzero(row != self.nominal).tolist()
        return {self.names[i]: float(row[i]) for i in changed}

    def _sample_motion(self, lanes: Array, plans: Sequence["SampledRun"]) -> Array:
        longest = max(len(plan.times) for plan in plans)
        times = np.full((-(-longest // _TIMES) * _TIMES, _RUNS), np.inf)
        for plan in plans:
            times[: len(plan.times), plan.lane] = plan.times
        signals: Array = np.asarray(call(self._motion, lanes, times))
        return signals


def _of_row(final: FinalState, row: int) -> FinalState:
    mine: FinalState = jax.tree.map(lambda x: x[..., row], final)
    return mine


def _without(flown: Flown, rows: Collection[int]) -> Flown:
    """Return what came of lanes, of which those of some rows count as not flown."""
    steps = flown.final.steps.copy()
    steps[list(rows)] = 0
    return flown._replace(final=flown.final._replace(steps=steps))


def _names(owners: Sequence[Any], chosen: NDArray[np.bool_]) -> list[str]:
    return [owner.name for owner, it in zip(owners, chosen, strict=True) if it]
