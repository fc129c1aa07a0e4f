"""Variants of a case: parameters over values, one run each, in one table."""

import contextlib
import functools
import itertools
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
import pandas as pd

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.case_file.case import Case
from drakesep.case_file.values import parameter_of
from drakesep.results.asked import Asked
from drakesep.results.catalogue.names import SWEEP
from drakesep.results.folder import Output, ResultsFolder, begun
from drakesep.studies.remarks import Remark, remarks, save_remarks
from drakesep.studies.saved import SavedStudy
from drakesep.studies.variant_engines import (
    Flown,
    InDrake,
    OnBatch,
    Values,
    VariantEngine,
)
from drakesep.studies.worst_case.effort import in_time
from drakesep.studies.worst_case.pace import Pace, Remaining
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_finite
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Separation
from drakesep.tables.columns import write_csv
from drakesep.tables.variants import Variant, variants_table
from drakesep.units import unit_of


Engine: TypeAlias = Literal["drake", "batch"]
MOST = 100_000
"""Variants of a sweep."""
_FEW = 100
"""Variants that Drake has flown before the batch engine's programs are compiled."""


@dataclass(frozen=True, kw_only=True)
class SweepProgress:
    """Where a sweep stands."""

    parameters: tuple[str, ...]
    """With their units."""
    engine: Engine
    """That flies."""
    done: int
    """Variants; 0 as it begins, with what it will do."""
    total: int
    """Variants."""
    remaining: Remaining
    """What is left of it."""

    def __str__(self) -> str:
        """Return what it will do, in a line."""
        flown = {"drake": "in Drake", "batch": "on the batch engine"}[self.engine]
        return (
            f"{self.total} variants of {' and '.join(self.parameters)}, flown {flown}; "
            f"about {in_time(self.remaining.seconds)}"
        )


@dataclass(frozen=True, kw_only=True)
class Sweep(SavedStudy):
    """Variants of a case, over all combinations of some values."""

    asked: Asked = field(repr=False)
    """With the case."""
    values: Mapping[str, tuple[float, ...]]
    """Of each parameter that is swept, by name with unit."""
    engine: Engine
    """That has flown them."""
    variants: tuple[Variant, ...] = field(default=(), repr=False)
    """In the order of the values, the last parameter's the fastest."""
    remarks: tuple[Remark, ...] = field(default=(), repr=False)
    """What should be told of their runs, each of a body or a spring once; where the
    batch engine tells metrics alone, of those at the ends of the parameters' values."""

    @property
    def case(self) -> AnalysisCase:
        """The case."""
        return self.asked.case

    @functools.cached_property
    def table(self) -> pd.DataFrame:
        """A row for each variant: parameters, metrics, and how it fares."""
        return variants_table(self.variants, self.case)

    @property
    def completed(self) -> bool:
        """Whether no run failed."""
        return not self._failed

    @property
    def failure(self) -> str:
        """What failed; empty if nothing did."""
        if not self._failed:
            return ""
        first = self._failed[0]
        return (
            f"{len(self._failed)} of {len(self.variants)} variants failed; first "
            f"number {first}: {self.variants[first - 1].outcome.message}"
        )

    @property
    def _failed(self) -> list[int]:
        """Numbers of the variants that failed."""
        return [n for n, one in enumerate(self.variants, 1) if one.outcome.failed]

    def write(self, results: ResultsFolder) -> None:
        """Write it into the folder of its study, which ends."""
        self._write_table(results)
        if len(self.values) == 1 and self.case.requirements:
            # Half a second to import, where something is drawn.
            from drakesep.plots.sweep import save_sweep

            save_sweep(self.variants, self.case, results.path)
        results.end(failed=self.failure)

    def _write_table(self, results: ResultsFolder) -> None:
        if self.variants:
            write_csv(self.table, results.path / "sweep.csv")
            save_remarks(self.remarks, results.path)
            results.keep()


@typed
def sweep(
    case: Case | AnalysisCase | str | Path,
    values: Mapping[str, Sequence[float]],
    *,
    engine: Engine | None = None,
    output: Output | None = None,
    workers: int | None = None,
    on_progress: Callable[[SweepProgress], None] | None = None,
) -> Sweep:
    """Fly a case once for each combination of some values.

    Args:
        case: a case, in SI or as a file holds it, a case file, or the name of a
            built-in case.
        values: of each parameter that is swept, by name with unit,
            ``payload.mass_kg``.
        engine: that flies; None: Drake, as `simulate` does, if there are at most 100
            variants or the batch engine cannot fly the case; else that.
        output: folder that receives the table, and a plot if one parameter is swept.
        workers: number of processes that fly Drake; one per core if None.
        on_progress: called as the sweep goes on.

    Raises:
        ValueError: the case or a value is wrong, the batch engine is asked for and
            cannot fly the case, or the folder cannot be written.
    """
    engine = engine_named(engine)
    swept = {str(name): tuple(map(float, each)) for name, each in values.items()}
    asked = Asked.of(SWEEP, case, {"values": swept, "engine": engine})
    case = asked.case
    grid = _grid(case.separation, swept)
    clearances = _required_clearances(case)
    on_batch = _on_batch(case, grid, clearances, engine)
    study = Sweep(asked=asked, values=swept, engine="batch" if on_batch else "drake")
    with begun(output, asked) as folder, contextlib.ExitStack() as stack:
        flies: VariantEngine = on_batch or stack.enter_context(
            InDrake(case, clearances, len(grid), workers)
        )
        told = _Told(study, len(grid), on_progress)
        try:
            for flown in _flown(flies, grid, told):
                study = _with(study, flown)
            if not flies.whole_runs:
                study = _with_remarks_at_ends(study, grid)
        except BaseException:
            if folder is not None:  # what was done is not lost
                study._write_table(folder)
            raise
        study = replace(study, asked=asked.over())
        if folder is not None:
            study.write(folder)
    return study


def _with(study: Sweep, flown: Sequence[Flown]) -> Sweep:
    """Return a sweep with the next variants, and what should be told of them."""
    numbered = enumerate(flown, 1 + len(study.variants))
    runs = {n: one.run for n, one in numbered if one.run is not None}
    return replace(
        study,
        variants=(*study.variants, *(one.variant for one in flown)),
        remarks=_remarks(study, runs),
    )


def _with_remarks_at_ends(study: Sweep, grid: Sequence[Values]) -> Sweep:
    """Return a sweep with remarks on the variants at the ends of parameters' values.

    They are flown in Drake: the batch engine has told metrics alone.
    """
    lengths = [len(each) for each in study.values.values()]
    ends = itertools.islice(itertools.product(*((0, n - 1) for n in lengths)), _FEW)
    places = sorted({int(np.ravel_multi_index(end, lengths)) for end in ends})
    with InDrake(study.case, (), len(places), workers=1) as drake:
        flown = drake.fly([grid[place] for place in places])
    found = zip(places, flown, strict=True)
    runs = {place + 1: one.run for place, one in found if one.run is not None}
    return replace(study, remarks=_remarks(study, runs))


def _remarks(study: Sweep, runs: Mapping[int, Run]) -> tuple[Remark, ...]:
    """Return the remarks of a sweep and of more runs, by the numbers of variants."""
    labelled = {f"variant {number}": run for number, run in runs.items()}
    return tuple(remarks(labelled, study.remarks))


def engine_named(name: str | None) -> Engine | None:
    """Return the engine of a name; None if it is None.

    Raises:
        ValueError: there is none of this name.
    """
    match name:
        case "drake" | "batch" | None:
            return name
    raise InputError(f"engine: must be 'drake' or 'batch', got {name!r}")


def _grid(
    separation: Separation, values: Mapping[str, Sequence[float]]
) -> list[Values]:
    """Return all combinations, in SI.

    Raises:
        ValueError: a parameter is unknown or has no value, a value is not finite, or
            there are too many.
    """
    if not values:
        raise InputError("values: must be of one parameter or more, got none")
    total = math.prod(map(len, values.values()))
    if total > MOST:
        raise InputError(f"values: must make at most {MOST} variants, got {total}")
    columns: dict[str, list[float]] = {}
    for key, each in values.items():
        name = parameter_of(separation, key)
        if not each:
            raise InputError(f"{key}: must have one value or more, got none")
        check_finite(key, *each)
        columns[name] = [unit_of(name).to_si(value) for value in each]
    rows = itertools.product(*columns.values())
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _required_clearances(case: AnalysisCase) -> list[LowestClearance]:
    """Return what measures how near parts come, where there is a limit on it.

    Raises:
        ValueError: parts overlap while mated.
    """
    metrics = {r.metric: None for r in case.requirements if r.measured_apart}
    clearances = [case.lowest_clearance(metric) for metric in metrics]
    for clearance in clearances:
        clearance.check_apart()
    return clearances


def _on_batch(
    case: AnalysisCase,
    grid: Sequence[Values],
    clearances: Sequence[LowestClearance],
    engine: Engine | None,
) -> OnBatch | None:
    """Return the batch engine, if it is to fly."""
    if engine == "drake" or (engine is None and len(grid) <= _FEW):
        return None
    try:
        return OnBatch(case, tuple(grid[0]), clearances)
    except InputError:
        if engine == "batch":
            raise
        return None


def _flown(
    flies: VariantEngine, grid: Sequence[Values], told: "_Told"
) -> Iterator[list[Flown]]:
    """Yield the variants, some at a time."""
    flies.prepare()
    began = time.perf_counter()
    first = flies.fly(grid[: flies.fewest])
    calls = len(grid) / flies.fewest
    seconds = (time.perf_counter() - began) * max(1.0, calls / flies.workers)
    told.plan(seconds)
    yield first
    for start in range(len(first), len(grid), flies.together):
        told.done(start)
        yield flies.fly(grid[start : start + flies.together])
    told.done(len(grid))


class _Told:
    """Tells the user how far a sweep has come."""

    def __init__(
        self,
        study: Sweep,
        total: int,
        on_progress: Callable[[SweepProgress], None] | None,
    ):
        self._study, self._total, self._on_progress = study, total, on_progress
        self._pace = Pace({})

    def plan(self, seconds: float) -> None:
        """Tell what will be done, and how long it takes."""
        self._pace = Pace({SWEEP: seconds})
        self.done(0)

    def done(self, number: int) -> None:
        """Tell how many variants are done."""
        if self._on_progress is not None:
            study = self._study
            self._on_progress(
                SweepProgress(
                    parameters=tuple(study.values),
                    engine=study.engine,
                    done=number,
                    total=self._total,
                    remaining=self._pace.at(SWEEP, number, self._total),
                )
            )
