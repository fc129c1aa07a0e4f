"""What is required over time: the nominal, the run that decides it, and the limit."""

import math
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drakesep.plots.limits import LIMIT, limit_words
from drakesep.plots.motion import draw_limit, fit, mark
from drakesep.plots.panels import ROTATION, TRANSLATION, Panel, panels_of
from drakesep.plots.shown_runs import ShownRuns
from drakesep.plots.style import wrapped
from drakesep.systems.model.separation import Pair


_ACROSS = 2
_CELL, _ROW = 3.5, 2.1
"""Width and height of a panel, in."""
_NOMINAL: dict[str, Any] = {"color": "#000000", "lw": 1.0, "ls": (0, (2, 1.5))}
_WORST: dict[str, Any] = {"color": "#0072B2", "lw": 1.6}
_END: dict[str, Any] = {"color": "#555555", "ls": ":", "lw": 1.0}


class _Drawn(NamedTuple):
    panel: Panel
    pair: Pair


def required_figure(shown: ShownRuns) -> Figure | None:
    """Return a panel for each signal that is limited; None if none is.

    Args:
        shown: the runs of a study, and those that decide requirements.
    """
    separation = shown.run.separation
    drawn = [
        _Drawn(panel, pair)
        for pair in separation.pairs
        for topic in (TRANSLATION, ROTATION)
        for panel in panels_of(topic, separation, pair, shown.decided)
        if panel.decided
    ]
    if not drawn:
        return None
    down = math.ceil(len(drawn) / _ACROSS)
    figure = Figure(figsize=(_CELL * _ACROSS, _ROW * down + 0.3), layout="constrained")
    grid = figure.subplots(down, _ACROSS, squeeze=False)
    for axes, each in zip(grid.flat, drawn, strict=False):
        _draw(axes, each, shown)
    for axes in grid.flat[len(drawn) :]:
        axes.set_visible(False)
    handles = [
        Line2D([], [], label="worst by the requirement", marker="o", ms=4, **_WORST),
        Line2D([], [], label=shown.reference.label, **_NOMINAL),
        Line2D([], [], label="limit", **LIMIT),
        Line2D([], [], label="end of separation", **_END),
    ]
    figure.legend(
        **{"handles": handles, "loc": "outside lower center", "ncols": len(handles)},
        **{"frameon": False, "fontsize": 8},
    )
    return figure


def _draw(axes: Axes, drawn: _Drawn, shown: ShownRuns) -> None:
    panel, pair = drawn
    deciding = {decided.run.label: decided.run for decided in panel.decided}
    styles = dict.fromkeys(deciding, _WORST)
    styles[shown.reference.label] = _NOMINAL
    runs = {**deciding, shown.reference.label: shown.reference}
    lines = {}
    for label, style in styles.items():
        run = runs[label].run
        values = panel.unit.per_si * panel.values(run)
        [lines[label]] = axes.plot(run.motion_of(pair.B).time, values, **style)
    for decided in panel.decided:
        draw_limit(axes, panel, decided)
        mark(axes, panel, decided, lines[decided.run.label])
    axes.set_xlim(0.0, shown.run.separation.duration)
    fit(axes)
    if math.isfinite(end := shown.run.end_of(pair.B)):
        axes.axvline(end, **_END)
    limits = ", ".join(limit_words(d.finding.requirement) for d in panel.decided)
    whose = f"{pair.B}: " if len(shown.run.separation.pairs) > 1 else ""
    title = f"{whose}{panel.title} ({limits})".replace("_", " ")
    axes.set_title(wrapped(title, _CELL - 0.5, 8), fontsize=8)
    axes.set_xlabel("time (s)", fontsize=7)
    axes.set_ylabel(panel.unit.symbol, fontsize=7)
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3)
