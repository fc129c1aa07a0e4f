"""A study under way: what its steps fly with, and where they write."""

import contextlib
import functools
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, wait
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Protocol, TypeVar

from threadpoolctl import threadpool_limits

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.drake_pool import WORKERS_START, DrakePool
from drakesep.analysis.engines.evaluator import Evaluator
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.engines.jax.batch_evaluator import BatchEvaluator
from drakesep.analysis.engines.jax.shared_batch import shared_batch
from drakesep.analysis.engines.jax.together import Ask
from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.metrics.objectives import MetricObjective, Objective
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import Problem, Searched, SearchProgress
from drakesep.results.folder import ResultsFolder
from drakesep.studies.background_process import BackgroundProcess
from drakesep.studies.worst_case.effort import StudyEffort, planned_effort
from drakesep.studies.worst_case.pace import Pace
from drakesep.studies.worst_case.plan import PLAN, OnProgress, Progress, StudyPlan
from drakesep.studies.worst_case.speed import measured_speed
from drakesep.systems.arrays import Array
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.run import Run
from drakesep.systems.simulation.shared_simulation import shared_simulation


class _HasTables(Protocol):
    def write_tables(self, results: ResultsFolder) -> None: ...


_Study = TypeVar("_Study", bound=_HasTables)
_Kind = TypeVar("_Kind")


@dataclass(frozen=True, kw_only=True)
class Session:
    """What the steps of a study have in common."""

    plan: StudyPlan
    nominal: Run
    """That nothing changes; it has completed."""
    drake: float
    """Seconds that it took."""
    published: tuple[Run, ...]
    """Of the published cases, in their order."""
    pool: DrakePool
    evaluator: Evaluator
    """Flies what is searched."""
    batch: Batch | None
    """That does, if it is not Drake."""
    background: BackgroundProcess
    """Measures and draws."""
    on_progress: OnProgress | None = None
    _drawings: list[Future[None]] = field(default_factory=list)

    @property
    def problem(self) -> Problem:
        """What is searched: the objectives, over the tolerances."""
        tolerances = self.plan.case.tolerance_set
        return Problem(tolerances=tolerances, evaluator=self.evaluator)

    @functools.cached_property
    def effort(self) -> StudyEffort:
        """What is searched and how hard, by how fast the case flies; measured once.

        A study that goes on with another does what that had planned.
        """
        plan = self.plan
        if (kept := self.kept(PLAN, dict)) is not None:
            [planned] = kept
            return StudyEffort(**planned)
        if isinstance(self.evaluator, BatchEvaluator):
            self.evaluator.wait()
        speed = measured_speed(
            plan.case, plan.objectives, self.batch, self.nominal, self.drake
        )
        return planned_effort(
            plan.case,
            plan.objectives,
            plan.searches,
            plan.effort,
            plan.growth,
            speed,
            plan.minutes,
            failures=len(plan.failures),
            draws=plan.draws,
            draws_in_drake=plan.draws_in_drake,
            proofs=plan.proofs,
            proof_seconds=plan.proof_seconds,
        )

    def evaluator_of(
        self,
        failed: AnalysisCase,
        failure: FailureCase,
        which: Sequence[Objective],
        ask: Ask,
    ) -> Evaluator:
        """Return what flies a failure case, by what flies the design.

        Args:
            failed: the case in which something has failed.
            failure: what has.
            which: objectives that are searched.
            ask: flies what the batch engine is asked, with what others ask.
        """
        never = any(map(math.isinf, failure.values.values()))  # of no program's rows
        if self.batch is None or never:
            return _in_drake(failed, which, self.pool, failure.values)
        batch, limits = self.batch.holding(failure.values), failed.limits_of_pairs
        return BatchEvaluator(batch, which, limits, derivatives=False, ask=ask)

    @property
    def settings(self) -> SearchSettings:
        """How hard it is searched."""
        return self.effort.settings

    @functools.cached_property
    def _pace(self) -> Pace:
        seconds = self.effort.seconds
        done = [found.search for found in self.finished]
        return Pace({name: s for name, s in seconds.items() if name not in done})

    def begin(self) -> None:
        """Plan what is searched, and only then begin the folder, if there is one.

        Raises:
            ValueError: it takes too long.
        """
        plan = self.plan
        options = self.effort.options if plan.objectives else {}
        if plan.folder is not None:
            plan.folder.begin(plan.asked)
            plan.folder.plan(options)
            if plan.objectives:
                plan.folder.keep_part(PLAN, [_fields(self.effort)])

    @functools.cached_property
    def finished(self) -> tuple[Searched, ...]:
        """What came of the first searches, if an earlier study has finished them."""
        found: list[Searched] = []
        for name in self.effort.searches:
            kept = self.kept(name, Searched)
            if kept is None:
                break
            found += kept
        return tuple(found)

    def keep_search(self, found: Searched) -> None:
        """Keep what came of a search, for a study that goes on with this one."""
        self.keep(found.search, [found])

    def once(
        self, name: str, kind: type[_Kind], find: Callable[[], Sequence[_Kind]]
    ) -> Sequence[_Kind]:
        """Return records that an earlier study has found, or find and keep them.

        Args:
            name: of the part of the study that they are.
            kind: of the records.
            find: finds them.
        """
        kept = self.kept(name, kind)
        if kept is not None:
            return kept
        found = find()
        self.keep(name, found)
        return found

    def keep(self, name: str, records: Sequence[Any]) -> None:
        """Keep a part of the study, for a study that goes on with this one."""
        if self.plan.folder is not None:
            self.plan.folder.keep_part(name, records)

    def kept(self, name: str, kind: type[_Kind]) -> tuple[_Kind, ...] | None:
        """Return the records of a part, if an earlier study has kept it."""
        folder = self.plan.folder
        return None if folder is None else folder.part(name, kind)

    def tell_plan(self) -> None:
        """Tell the user what the study will do, before it does."""
        self.tell(SearchProgress(search=PLAN, done=0, total=None))

    def tell(self, progress: SearchProgress) -> None:
        """Tell the user how far a step has come."""
        if self.on_progress is not None:
            self.on_progress(
                Progress(
                    objectives=self.plan.objectives,
                    box=self.plan.case.box,
                    search=progress,
                    effort=self.effort,
                    remaining=self._pace.at(
                        progress.search, progress.done, progress.total
                    ),
                )
            )

    def telling(self, step: str) -> Callable[[int, int], None]:
        """Return what tells the user how much of a step is done, and of how much."""

        def tell(done: int, total: int) -> None:
            self.tell(SearchProgress(search=step, done=done, total=total))

        return tell

    def write_down(
        self,
        study: _Study,
        write: Callable[[_Study, ResultsFolder], None] | None = None,
    ) -> _Study:
        """Return what a step leaves, with its tables in the folder, if there is one.

        Args:
            study: as far as it has come.
            write: writes those tables that are new; all if None.
        """
        folder = self.plan.folder
        if folder is not None:
            if write is None:
                study.write_tables(folder)
            else:
                write(study, folder)
            folder.keep()
        return study

    def draw(self, save: Callable[[Path], None]) -> None:
        """Begin to draw into the folder, if there is one, while the study goes on."""
        folder = self.plan.folder
        if folder is None:
            return

        def listed(_: Future[None]) -> None:
            with contextlib.suppress(OSError):  # the study's own next writing raises it
                folder.keep()

        drawing = self.background.submit(save, folder.path)
        drawing.add_done_callback(listed)
        self._drawings.append(drawing)

    def wait_for_drawings(self) -> None:
        """Wait until all is drawn that has been begun, or has failed."""
        wait(self._drawings)

    def check_drawings(self) -> None:
        """Raise what drawing has raised."""
        for drawing in self._drawings:
            drawing.result()


def _fields(effort: StudyEffort) -> dict[str, Any]:
    return {f.name: getattr(effort, f.name) for f in fields(effort)}


@contextlib.contextmanager
def session(
    plan: StudyPlan, background: BackgroundProcess, on_progress: OnProgress | None
) -> Iterator[Session]:
    """Fly the nominal and the published runs, and begin to compile what searches fly.

    What is refused is refused before the results of an earlier study are taken out of
    the folder: `Session.begin` does that, once it is known what the study takes.

    Args:
        plan: what is asked.
        background: under way.
        on_progress: called as the study goes on.

    Raises:
        ValueError: the batch engine cannot fly the separation, parts overlap, or the
            study that is to be resumed is another.
        RuntimeError: the nominal run fails.
    """
    case = plan.case
    if plan.resume and plan.folder is not None:
        plan.folder.resume(plan.asked)
    batch = checked_batch(plan)
    nominal, drake = _fly_nominal(case)
    if nominal.motion is None:
        if plan.folder is not None:  # it says so, and keeps nothing of the last study
            plan.folder.begin(plan.asked)
        raise RuntimeError(f"the nominal run failed: {nominal.message}")
    each = len(plan.objectives) * (1 + len(plan.failures))
    several = drake * (len(case.published) + each)
    few = batch is not None and several < WORKERS_START and plan.workers is None
    workers = 1 if few else plan.workers
    # SLSQP solves systems of some tens of unknowns: spread over threads, they take no
    # shorter, and threads that wait for the next spin, at the cost of whoever flies.
    with (
        threadpool_limits(limits=1, user_api="blas"),
        DrakePool(case.separation, case.integration, workers=workers) as pool,
    ):
        published = pool.fly([published.values for published in case.published])
        evaluator: Evaluator = (
            _in_drake(case, plan.objectives, pool)
            if batch is None
            else _on_batch(case, plan.objectives, batch)
        )
        under_way = Session(
            plan=plan,
            nominal=nominal,
            drake=drake,
            batch=batch,
            published=tuple(published),
            pool=pool,
            evaluator=evaluator,
            background=background,
            on_progress=on_progress,
        )
        try:
            yield under_way
        finally:
            under_way.wait_for_drawings()  # what has been begun is not lost
        under_way.check_drawings()


def checked_batch(plan: StudyPlan) -> Batch | None:
    """Return the batch engine of a plan, None if Drake flies alone.

    Raises:
        ValueError: it cannot fly the separation; or parts overlap while mated that are
            not said to touch, and are to be measured.
    """
    for clearance in plan.clearances.values():
        clearance.check_apart()
    return _batch_of(plan) if plan.on_batch_engine else None


def _fly_nominal(case: AnalysisCase) -> tuple[Run, float]:
    """Return the nominal run, and the seconds that it took."""
    simulation = shared_simulation(case.separation, case.integration)
    began = time.perf_counter()
    nominal = simulation.run({})
    return nominal, time.perf_counter() - began


def _batch_of(plan: StudyPlan) -> Batch:
    """Return what flies the design; failure cases fly by its programs, too."""
    case, objectives = plan.case, plan.objectives
    read = {
        name: None
        for objective in objectives
        if isinstance(objective, MetricObjective)
        for name in sorted(objective.reads)
    }
    # All four or none, so that studies of a case share their programs.
    of_paper = {m.stem for m in registered_metrics() if m.objective}
    asked = case.objectives or not of_paper.isdisjoint(read)
    nominal = parameters(case.separation)
    fail = {
        name: nominal[name]
        for failure in plan.failures
        for name, value in failure.values.items()
        if name not in case.box.names and math.isfinite(value)
    }
    batch = shared_batch(
        case.separation,
        (*case.box.names, *fail),
        case.limits_of_pairs,
        metrics=read,
        without=() if asked else of_paper,
    )
    return batch.holding(fail)


def _on_batch(
    case: AnalysisCase, objectives: Sequence[Objective], batch: Batch
) -> BatchEvaluator:
    # Derivatives cost 2.5 runs for each parameter, differences one, and compiling them
    # as long as a whole study; where both end is the same.
    evaluator = BatchEvaluator(
        batch, objectives, case.limits_of_pairs, derivatives=False
    )
    evaluator.prepare()  # its programs are compiled beside what comes next
    return evaluator


def _in_drake(
    case: AnalysisCase,
    objectives: Sequence[Objective],
    pool: DrakePool,
    held: Mapping[str, float] | None = None,
) -> RunEvaluator:
    names = case.box.names

    def fly(rows: Array) -> list[Run]:
        return pool.fly(
            [
                {**(held or {}), **dict(zip(names, row.tolist(), strict=True))}
                for row in rows
            ]
        )

    return RunEvaluator(fly, names, objectives, case.limits_of_pairs)
