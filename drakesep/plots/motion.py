"""Pictures of the motion, after the paper's Figs. 6 and 7, and of sensitivities."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.metrics.metric import Metric, Moment, Window
from drakesep.analysis.metrics.of_run import time_of
from drakesep.analysis.metrics.registry import find_metric
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.style import COLOURS, DASHES, LIMIT, save_plot
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
    """Write translation.png and rotation.png of completed runs into a folder."""
    save_plot(translation_figure(runs, limits), folder / "translation.png")
    save_plot(rotation_figure(runs, limits), folder / "rotation.png")


def translation_figure(
    runs: Sequence[LabelledRun], limits: Sequence[Requirement]
) -> Figure:
    """Return relative velocity, acceleration and linear momentum over time."""
    return _figure("Translation of {B} from {A}", _TRANSLATION, runs, limits)


def rotation_figure(
    runs: Sequence[LabelledRun], limits: Sequence[Requirement]
) -> Figure:
    """Return angles, rates and angular momentum over time."""
    return _figure("Rotation of {B}", _ROTATION, runs, limits)


def _figure(
    title: str,
    rows: Sequence[_Row],
    runs: Sequence[LabelledRun],
    limits: Sequence[Requirement],
) -> Figure:
    figure = Figure(figsize=(12, 9), layout="constrained")
    panels = figure.subplots(len(rows), 3, sharex=True, squeeze=False)
    for row, line in zip(rows, panels, strict=True):
        for i, axes in enumerate(line):
            _draw(axes, row, i, runs)
            axes.set_title(f"{row.title}, {row.axes[i]}", fontsize=10)
            for requirement in limits:
                metric = _of_component(requirement, row.quantity, i)
                if metric is not None:
                    _draw_limit(axes, requirement, metric, runs)
    for axes in panels[-1]:
        axes.set_xlabel("time (s)")
    handles, labels = panels[0][0].get_legend_handles_labels()
    limited = [a for a in panels.flat if a.get_gid() == "limited"]
    if limited:
        handles.append(limited[0].get_lines()[-1])
        labels.append("limit")
    figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False)
    separation = _reference(runs).separation
    figure.suptitle(title.format(A=separation.A, B=separation.B).replace("_", " "))
    return figure


def _reference(runs: Sequence[LabelledRun]) -> Run:
    """Return the run that the others are seen against."""
    return next(o.run for o in runs if isinstance(o.role, Nominal | Changed))


def _draw(axes: Axes, row: _Row, i: int, runs: Sequence[LabelledRun]) -> None:
    unit = unit_of(f"{row.quantity}_{row.axes[i]}")
    counts = {True: 0, False: 0}
    for one in runs:
        published = isinstance(one.role, Published)
        colours = _PUBLISHED if published else COLOURS
        k = counts[published]
        counts[published] += 1
        motion = one.run.completed_motion
        axes.plot(
            motion.time,
            getattr(motion, row.quantity)[:, i] * unit.per_si,
            color=colours[k % len(colours)],
            linestyle="-" if published else DASHES[k % len(DASHES)],
            linewidth=2.4 if published else 1.5,
            zorder=1 if published else 2,
            label=one.label,
        )
    end = _reference(runs).separation_end
    axes.axvline(
        end, color="#555555", linestyle=":", linewidth=1.0, label="end of separation"
    )
    axes.set_ylabel(unit.symbol)
    axes.set_xlim(motion.time[0], motion.time[-1])
    axes.grid(alpha=0.3)


def _of_component(requirement: Requirement, quantity: str, i: int) -> Metric | None:
    """Return the metric that is limited, if it is a value of a component itself."""
    found = find_metric(requirement.metric)
    if found is None:
        return None
    metric, axis = found
    signal = metric.signal
    if signal is None or signal.quantity != quantity or not metric.is_of_signal_itself:
        return None
    return metric if signal.components[metric.axes.index(axis)] == i else None


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
    span = [min(time_of(end, run), run.separation.duration) for end in ends]
    for side in sides:
        axes.plot(span, (side, side), color=LIMIT, linestyle=(0, (8, 3)), linewidth=1.2)
    axes.set_gid("limited")
