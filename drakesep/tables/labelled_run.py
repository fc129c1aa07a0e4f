"""Runs of a study under their labels, with their metrics."""

import functools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from drakesep.analysis.analysis_case import AnalysisCase, PublishedCase
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.metrics.functions import FunctionRequirement
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.checks import named
from drakesep.systems.equations.loads_of_run import joint_loads, largest_loads
from drakesep.systems.model.run import Run
from drakesep.tables.roles import (
    COMPLETED,
    Nominal,
    Outcome,
    Published,
    Role,
    failed,
    label_of,
    objective_of,
)


@dataclass(frozen=True, kw_only=True)
class LabelledRun:
    """A run of a study: what it is, its metrics, and how it ended."""

    role: Role
    run: Run
    metrics: Mapping[str, float]
    """Its metrics in SI, by name; empty if the run failed."""
    of_functions: Mapping[str, float] = field(default_factory=dict)
    """What functions tell of it that are required, by their names, in their units."""
    outcome: Outcome = COMPLETED
    """How it ended, or the search that found it."""
    iterations: int | None = None
    """Of that search."""
    evaluations: int = 1
    """Runs flown for it; of a worst case, by all searches for all objectives."""
    objective_in_drake: float | None = None
    """Of the objective whose worst case it is, in SI; None if the run failed."""
    beaten_by: str = ""
    """Of a worst case: label of another run that is worse than it; empty if none is."""
    nearest: Mapping[str, Clearance] = field(default_factory=dict, repr=False)
    """How near its parts come, by the clearances that were measured."""

    @property
    def label(self) -> str:
        """By which tables, plots and files name it."""
        return label_of(self.role)

    @property
    def status(self) -> str:
        """How it ended, as tables say it."""
        return str(self.outcome)

    @property
    def objective(self) -> str | None:
        """Name of the objective that it was found for; None if none was."""
        return objective_of(self.role)

    @property
    def tells_nothing(self) -> bool:
        """Whether it was not flown, or does not separate: it meets no requirement."""
        return self.run.motion is None or bool(self.run.not_separated)

    @functools.cached_property
    def largest_loads(self) -> tuple[float, float]:
        """The largest force, N, and torque, N m, of any joint; NaN if it failed."""
        if self.run.trajectory is None:
            return math.nan, math.nan
        return largest_loads(joint_loads(self.run).values())

    @property
    def at_most(self) -> dict[str, float]:
        """What clearances are at most, m: so near its parts come until it ends."""
        return {metric: found.minimum for metric, found in self.nearest.items()}

    @property
    def published(self) -> PublishedCase | None:
        """The publication that it comes from; None if it is our own."""
        return self.role.case if isinstance(self.role, Published) else None


def measured(
    role: Role,
    run: Run,
    case: AnalysisCase,
    clearances: Collection[LowestClearance] = (),
    likely: float = math.inf,
) -> LabelledRun:
    """Return a run with its metrics, and how near it comes where that is asked for.

    Args:
        role: what it is.
        run: completed or failed.
        case: whose requirements say what is looked at beside the registered metrics.
        clearances: that measure how near it comes.
        likely: how near that is about, if it is known, m.
    """
    if run.motion is None:
        return LabelledRun(role=role, run=run, metrics={}, outcome=failed(run.message))
    # Its motion is told, and what it does not separate by can be met by nobody.
    outcome = failed(run.not_separated) if run.not_separated else COMPLETED
    metrics = metrics_of_run(run, case.limits_of_pairs, case.metrics)
    nearest = {one.metric: one.nearest(run, likely) for one in clearances}
    for one in clearances:
        metrics[one.metric] = clearance_told(run, nearest[one.metric], one)
    return LabelledRun(
        role=role, run=run, metrics=metrics, nearest=nearest, outcome=outcome
    )


def told_by(functions: Iterable[FunctionRequirement], one: LabelledRun) -> LabelledRun:
    """Return a run with what functions tell of it, unless it failed.

    Raises:
        ValueError: a function gives no finite number.
    """
    if one.run.motion is None:
        return one
    with named(one.label):
        return replace(one, of_functions={f.name: f.of(one.run) for f in functions})


def clearance_told(run: Run, nearest: Clearance, by: LowestClearance) -> float:
    """Return how near parts come while it matters, m; NaN if that does not end.

    Args:
        run: a completed run.
        nearest: as it was measured.
        by: what has measured it.
    """
    return nearest.minimum if by.is_window_ended(run) else math.nan


def nominal_of(runs: Sequence[LabelledRun]) -> LabelledRun:
    """Return the run among those of a study that nothing changes."""
    return next(one for one in runs if isinstance(one.role, Nominal))
