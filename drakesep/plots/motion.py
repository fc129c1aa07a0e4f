"""Pictures of the motion, after the paper's Figs. 6 and 7, and of sensitivities."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.metrics.metric import Metric, Moment, Outer, Signal, Window
from drakesep.analysis.metrics.of_run import time_of
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.style import COLOURS, DASHES, LIMIT, save_plot
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.model.parameter_table import ROLL_PITCH_YAW, XYZ
from drakesep.systems.model.run import Run
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Changed, Nominal, Published
from drakesep.units import unit_of


class _Row(NamedTuple):
    quantity: str
    title: str
    axes: tuple[str, ...]


_TRANSLATION = (
    _Row("relative_velocity", "relative velocity", XYZ),
    _Row("acceleration", "acceleration of the CG", XYZ),
    _Row("linear_momentum_change", "linear momentum change", XYZ),
)
_ROTATION = (
    _Row("angle", "angle", ROLL_PITCH_YAW),
    _Row("rate", "rate", XYZ),
    _Row("angular_momentum_change", "angular momentum change", XYZ),
)
_PUBLISHED = ("#757575", "#A6A6A6", "#CCCCCC")


def save_motion(
    runs: Sequence[LabelledRun], limits: Sequence[Requirement], folder: Path
) -> None:
    """Write translation.png and rotation.png of completed runs into a folder.

    Those of other bodies that leave end with their names.
    """
    for pair in _reference(runs).separation.pairs:
        first = pair == _reference(runs).separation.pairs[0]
        body, end = ("", "") if first else (pair.B, f"_{pair.B}")
        for name, figure in (
            ("translation", translation_figure(runs, limits, body)),
            ("rotation", rotation_figure(runs, limits, body)),
        ):
            save_plot(figure, folder / f"{name}{end}.png")


def translation_figure(
    runs: Sequence[LabelledRun], limits: Sequence[Requirement], body: str = ""
) -> Figure:
    """Return relative velocity, acceleration and linear momentum over time.

    Args:
        runs: completed, the reference among them.
        limits: that may be drawn.
        body: that leaves; the first if empty.
    """
    return _figure("Translation of {B} from {A}", _TRANSLATION, runs, limits, body)


def rotation_figure(
    runs: Sequence[LabelledRun], limits: Sequence[Requirement], body: str = ""
) -> Figure:
    """Return angles, rates and angular momentum over time; see above."""
    return _figure("Rotation of {B}", _ROTATION, runs, limits, body)


def _figure(
    title: str,
    rows: Sequence[_Row],
    runs: Sequence[LabelledRun],
    limits: Sequence[Requirement],
    body: str,
) -> Figure:
    separation = _reference(runs).separation
    pair = separation.pair_of(body or separation.B)
    facts = PairFacts.of(separation, pair)
    figure = Figure(figsize=(12, 9), layout="constrained")
    panels = figure.subplots(len(rows), 3, sharex=True, squeeze=False)
    for row, line in zip(rows, panels, strict=True):
        for i, axes in enumerate(line):
            _draw(axes, row, i, runs, pair.B)
            axes.set_title(f"{row.title}, {row.axes[i]}", fontsize=10)
            for requirement in limits:
                metric = _of_component(requirement, row.quantity, i, facts)
                if metric is not None and metric.pair == body:
                    _draw_limit(axes, requirement, metric, runs)
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    handles, labels = panels[0][0].get_legend_handles_labels()
    limited = [a for a in panels.flat if a.get_gid() == "limited"]
    if limited:
        handles.append(limited[0].get_lines()[-1])
        labels.append("limit")
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=_columns_of_legend(labels),
        frameon=False,
    )
    figure.suptitle(title.format(A=pair.A, B=pair.B).replace("_", " "))
    return figure


def _columns_of_legend(labels: Sequence[str]) -> int:
    """Return in how many columns labels stand beside each other, none of them cut."""
    longest = max(map(len, labels))
    return min(5, max(1, _LEGEND // (longest + _HANDLE)))


_LEGEND, _HANDLE = 120, 7
"""Characters that fit below a figure, and those that a line with its gaps takes."""


def _reference(runs: Sequence[LabelledRun]) -> Run:
    """Return the run that the others are seen against."""
    return next(o.run for o in runs if isinstance(o.role, Nominal | Changed))


def _draw(
    axes: Axes, row: _Row, i: int, runs: Sequence[LabelledRun], body: str
) -> None:
    unit = unit_of(f"{row.quantity}_{row.axes[i]}")
    counts = {True: 0, False: 0}
    for one in runs:
        published = isinstance(one.role, Published)
        colours = _PUBLISHED if published else COLOURS
        k = counts[published]
        counts[published] += 1
        motion = one.run.motion_of(body)
        axes.plot(
            motion.time,
            getattr(motion, row.quantity)[:, i] * unit.per_si,
            color=colours[k % len(colours)],
            linestyle="-" if published else DASHES[k % len(DASHES)],
            linewidth=2.4 if published else 1.5,
            zorder=1 if published else 2,
            label=one.label,
        )
    end = _reference(runs).end_of(body)
    axes.axvline(
        end, color="#555555", linestyle=":", linewidth=1.0, label="end of separation"
    )
    axes.set_ylabel(unit.symbol)
    axes.set_xlim(motion.time[0], motion.time[-1])
    axes.grid(alpha=0.3)


def _of_component(
    requirement: Requirement, quantity: str, i: int, facts: PairFacts
) -> Metric | None:
    """Return the metric that is limited, if it is a value of a component itself."""
    found = find_metric(requirement.metric)
    if found is None:
        return None
    metric, axis = found
    signal = metric.signal
    if signal is None or signal.quantity != quantity or not metric.is_of_signal_itself:
        return None
    component = signal.components[metric.axes.index(axis)]
    return metric if _field_component(signal, component, facts) == i else None


def _field_component(signal: Signal, component: int, facts: PairFacts) -> int | None:
    """Return which component of its field a signal's is; None if it is none of them."""
    if signal.law is None:
        return component
    if signal.outer is not Outer.ITSELF:
        return None
    # What the law makes of each unit vector tells which of them it takes.
    taken = [
        i
        for i, unit in enumerate(np.eye(3))
        if signal.law(tuple(unit), facts, np)[component] == 1.0
    ]
    return taken[0] if len(taken) == 1 else None


def _draw_limit(
    axes: Axes, requirement: Requirement, metric: Metric, runs: Sequence[LabelledRun]
) -> None:
    limit = metric.sign * unit_of(requirement.metric).from_si(requirement.limit)
    curves = axes.lines[: len(runs)]
    data = np.concatenate([np.asarray(line.get_ydata()) for line in curves])
    sides = [limit]
    if metric.is_magnitude and data.min() < -0.2 * limit:
        sides.append(-limit)
    # What holds at a moment is drawn until then.
    when, run = metric.when, _reference(runs)
    ends = when[:2] if isinstance(when, Window) else (Moment.START, when)
    times = (time_of(end, run, metric.pair) for end in ends)
    span = [min(time, run.separation.duration) for time in times]
    for side in sides:
        axes.plot(span, (side, side), color=LIMIT, linestyle=(0, (8, 3)), linewidth=1.2)
    axes.set_gid("limited")
