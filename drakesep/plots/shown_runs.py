"""Which runs of a study plots of the motion show."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.metric import Metric, Window
from drakesep.analysis.metrics.of_run import body_of, time_of
from drakesep.analysis.metrics.registry import find_metric, registered_metrics
from drakesep.analysis.metrics.requirements import Finding, assess
from drakesep.systems.model.run import Run
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Changed, Nominal, Published, Worst


class Decided(NamedTuple):
    """A requirement on a signal, and the run that decides it."""

    metric: Metric
    """That the requirement is about."""
    axis: str
    finding: Finding
    run: LabelledRun

    @property
    def window(self) -> tuple[float, float]:
        """When it holds in that run, s; both are the same of what holds at a moment."""
        when, run = self.metric.when, self.run.run
        body = body_of(self.metric, run.separation)
        ends = when[:2] if isinstance(when, Window) else (when, when)
        start, end = (min(time_of(t, run, body), run.separation.duration) for t in ends)
        return start, end


@dataclass(frozen=True, kw_only=True)
class ShownRuns:
    """Runs that plots show everywhere, and those that decide requirements.

    Made of what a results folder keeps: plots can be drawn again from it.
    """

    reference: LabelledRun
    """That the others are seen against."""
    compared: tuple[LabelledRun, ...]
    """Published runs, and worst cases of objectives that are of no requirement."""
    decided: tuple[Decided, ...]
    """In the order of the requirements."""

    @classmethod
    def of(cls, runs: Sequence[LabelledRun], case: AnalysisCase) -> Self:
        """Choose among runs of a study.

        Args:
            runs: with one that nothing, or the user, has changed.
            case: with the requirements.
        """
        completed = {one.label: one for one in runs if one.run.motion is not None}
        metrics = {label: one.metrics for label, one in completed.items()}
        reference = next(
            one for one in completed.values() if isinstance(one.role, Nominal | Changed)
        )
        required = {n for r in case.requirements for n in case.names_towards(r)}
        required |= {objective.name for objective in case.ends_of_windows}
        return cls(
            reference=reference,
            compared=tuple(
                one
                for one in completed.values()
                if isinstance(one.role, Published)
                or (isinstance(one.role, Worst) and one.objective not in required)
            ),
            decided=tuple(
                Decided(*found, finding, completed[finding.run])
                for finding in assess(case.requirements, metrics, reference.label)
                if (found := find_metric(finding.requirement.metric)) is not None
                and found[0].is_of_signal_itself
            ),
        )

    @property
    def run(self) -> Run:
        """The reference's."""
        return self.reference.run


def metrics_shown_by(one: LabelledRun) -> list[Metric]:
    """Return the metrics of the objectives for which a run is the worst, if known."""
    published = one.published
    names = [one.objective] if published is None else list(published.objectives)
    found = (_metric_of(name) for name in names if name is not None)
    return [metric for metric in found if metric is not None]


def bodies_shown_by(one: LabelledRun) -> list[str]:
    """Return the bodies that leave whose motion a run is to show.

    Of a worst case the body whose it is; of what is of none alone, as a clearance of
    all parts or a nominal run is, every body.
    """
    separation = one.run.separation
    metrics = [m for m in metrics_shown_by(one) if m.of_every_run]
    if isinstance(one.role, Worst) and metrics:
        return [body_of(metric, separation) for metric in metrics]
    return [pair.B for pair in separation.pairs]


def _metric_of(objective: str) -> Metric | None:
    """Return the metric of an objective; None of a user's own function."""
    for metric in registered_metrics():
        if metric.objective == objective:
            return metric
    _, _, after = objective.partition("_")  # highest or lowest
    before, _, _ = objective.rpartition("_")  # up or down
    found = find_metric(after) or find_metric(objective) or find_metric(before)
    return None if found is None else found[0]
