"""How fast a case flies on this machine, measured before its study."""

import functools
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.objectives import Needs, Objective
from drakesep.results.recorded_runs import save_runs
from drakesep.systems.arrays import Array
from drakesep.systems.model.run import Run
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Nominal


_TRIES = 3
"""Of a measurement, of which the median counts."""
_LONG = 0.5
"""Of a try, s, after which there is no other: it is long enough to be told from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Speed:
    """What things take, s."""

    drake: float
    """A run in Drake."""
    call: float = 0.0
    """The least that is flown at once on the batch engine, on one core."""
    run: float = 0.0
    """A run on the batch engine among very many, on one core."""
    whole_run: float = 0.0
    """A run on the batch engine with its motion, where an objective needs that, and to
    tell those of it that do."""
    measurement: float = 0.0
    """A measurement of a run, where an objective needs one."""
    recording: float = 0.0
    """To write down a run with its motion."""
    cores: int = 1
    """That fly on the batch engine at once."""


def measured_speed(
    case: AnalysisCase,
    objectives: Sequence[Objective],
    batch: Batch | None,
    nominal: Run,
    drake: float,
) -> Speed:
    """Return how fast a case flies.

    What is flown for it are random points of the tolerances, always the same.

    Args:
        case: whose tolerances are searched.
        objectives: that are searched.
        batch: that flies, compiled; None if Drake does.
        nominal: run of the case.
        drake: seconds that it took.
    """
    longest = 0.0
    for objective in objectives:
        if objective.expensive:
            measure = functools.partial(objective.of_run, nominal, case.limits_of_pairs)
            measure()  # prepared
            longest = max(longest, _seconds(measure))
    recording = _seconds(lambda: _recorded(nominal, case))
    if batch is None:
        return Speed(drake=drake, measurement=longest, recording=recording)
    rng = np.random.default_rng(0)
    most = _CHUNKS * batch.workers * batch.chunk
    rows = case.tolerance_set.rows(case.tolerance_set.draw(most, rng))
    call = _seconds(lambda: batch.run(rows[: batch.chunk]))
    told = [o for o in objectives if o.needs is Needs.RUN]
    whole_run = 0.0
    if told or longest:
        few = rows[: len(case.box) + 2]  # as an ascent flies at once
        batch.runs(few)  # compiled

        def flown_and_told() -> None:
            for run in batch.runs(few):
                if run.motion is not None:
                    for objective in told:
                        objective.of_run(run, case.limits_of_pairs)

        whole_run = _seconds(flown_and_told) / len(few)
    return Speed(
        drake=drake,
        call=call,
        run=_run(batch, rows, call),
        whole_run=whole_run,
        measurement=longest,
        recording=recording,
        cores=batch.workers,
    )


_CHUNKS = 8
"""For each core, at most, that tell what a run takes among very many."""


def _run(batch: Batch, rows: Array, call: float) -> float:
    """Return what a run takes among very many, on one core, s.

    Args:
        batch: that flies.
        rows: (n, n_p) of whole chunks for each core.
        call: seconds that a chunk alone takes, with what is done once in a call.
    """
    for_each = min(_CHUNKS, int(_LONG / call))
    if not for_each:
        return call / batch.chunk
    many = rows[: for_each * batch.workers * batch.chunk]
    return batch.workers * _seconds(lambda: batch.run(many)) / len(many)


def _recorded(run: Run, case: AnalysisCase) -> None:
    with tempfile.TemporaryDirectory() as folder:
        one = LabelledRun(role=Nominal(), run=run, metrics={})
        save_runs([one], case.separation, Path(folder))


def _seconds(work: Callable[[], object]) -> float:
    """Return what work takes, s."""
    tries: list[float] = []
    while len(tries) < _TRIES:
        began = time.perf_counter()
        work()
        tries.append(time.perf_counter() - began)
        if tries[-1] > _LONG:
            break
    return statistics.median(tries)
