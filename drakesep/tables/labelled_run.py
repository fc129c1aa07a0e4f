"""Runs of a study under their labels, with their metrics."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from drakesep.analysis.analysis_case import AnalysisCase, PublishedCase
from drakesep.analysis.clearance.objective import CLEARANCE, LowestClearance
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.model.run import Run


NOMINAL = "nominal"
"""The label of the run that nothing changes."""


@dataclass(frozen=True, kw_only=True)
class LabelledRun:
    """A run of a study, under its label."""

    label: str
    run: Run
    metrics: Mapping[str, float]
    """Its metrics in SI, by name; empty if the run failed."""
    objective: str | None = None
    """Of the search that found it; None if none did."""
    iterations: int | None = None
    """Of that search."""
    evaluations: int = 1
    """Runs flown for it; of a worst case, by all searches for all objectives."""
    status: str = "completed"
    published: PublishedCase | None = field(default=None, repr=False)
    """The publication that it comes from."""
    objective_in_drake: float | None = None
    """Of the objective whose worst case it is, in SI; None if the run failed."""
    nearest: Clearance | None = field(default=None, repr=False)
    """How near its parts come; None if that was not asked for."""


def labelled_run(
    label: str,
    run: Run,
    case: AnalysisCase,
    clearance: LowestClearance | None = None,
    **found: object,
) -> LabelledRun:
    """Return a run with its metrics, and how near it comes if that is asked for."""
    metrics_: dict[str, float] = {}
    if run.motion is None:
        found["status"] = f"failed: {run.message}"
    else:
        metrics_ |= metrics_of_run(run, case.deviation_limits)
        if clearance is not None:
            found["nearest"] = nearest = clearance.nearest(run)
            metrics_[CLEARANCE] = nearest.minimum
    return LabelledRun(label=label, run=run, metrics=metrics_, **found)  # type: ignore[arg-type]


def references(
    case: AnalysisCase, runs: Sequence[Run], clearance: LowestClearance | None
) -> list[LabelledRun]:
    """Return the nominal run of a case, and the published ones after it."""
    nominal, *others = runs
    return [
        labelled_run(NOMINAL, nominal, case, clearance),
        *(
            labelled_run(published.label, run, case, clearance, published=published)
            for published, run in zip(case.published, others, strict=True)
        ),
    ]
