"""What is required over the parameters that it depends on most: draws as points."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.plots.campaign_points import Against, Scatter
from drakesep.plots.limits import LIMIT, limit_words
from drakesep.plots.style import save_plot, wrapped
from drakesep.systems.arrays import Array
from drakesep.units import unit_of


_ACROSS, _CELL = 4, 3.9
"""Panels beside each other, and the width of each, in."""
HEIGHT = 0.82
"""Of a panel, as a part of its width."""
_AWAY = 2.0
"""A limit that is further from the points than so many of their spans is told by an
arrow, not by a line: else all of them would lie on one."""


def save_scatter(name: str, scatters: Sequence[Scatter], folder: Path) -> None:
    """Write campaign_scatter.png into a folder."""
    save_plot(scatter_figure(name, scatters), folder / "campaign_scatter.png")


def scatter_figure(
    name: str,
    scatters: Sequence[Scatter],
    *,
    most_across: int = _ACROSS,
    cell: float = _CELL,
) -> Figure:
    """Return a panel for each requirement and parameter: draws, limit, deciding draw.

    Args:
        name: of the case.
        scatters: of each requirement, one or more, each over one parameter or more.
        most_across: panels beside each other, at most.
        cell: width of a panel, in.
    """
    panels = [(one, against) for one in scatters for against in one.over]
    across = min(len(panels), most_across)
    down = math.ceil(len(panels) / across)
    figure = Figure(
        figsize=(cell * across, HEIGHT * cell * down + 0.6), layout="constrained"
    )
    grid = figure.subplots(down, across, squeeze=False)
    for axes, (one, against) in zip(grid.flat, panels, strict=False):
        _draw(axes, one, against, cell)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    most = max(len(one.values) for one in scatters)
    title = (
        f"{name}: the first {most} draws over the parameters of largest rank "
        "correlation; dashed: limit, arrow: one that is far beyond, diamond: draw that "
        "decides"
    )
    figure.suptitle(wrapped(title, cell * across - 0.2, 11), fontsize=11)
    return figure


def _draw(axes: Axes, one: Scatter, against: Against, cell: float) -> None:
    required, unit = one.requirement, unit_of(one.requirement.metric)
    of_parameter = unit_of(against.parameter)
    x = of_parameter.from_si(1.0) * against.values
    y = unit.from_si(1.0) * one.values
    axes.plot(x, y, ".", color="#666666", markersize=2.5, alpha=0.6)
    if math.isfinite(one.deciding):
        at = of_parameter.from_si(against.deciding), unit.from_si(one.deciding)
        axes.plot(*at, "D", markersize=7, mec="black", mfc="white", zorder=6)
    limit = unit.from_si(required.limit)
    arrow = _beyond(limit, y)
    if not arrow:
        axes.axhline(limit, **LIMIT)
    stem, axis = required.quantity
    whose = f", {required.pair}" if required.pair else ""
    title = f"{stem} {axis}".strip().replace("_", " ") + whose
    titles = (title, f"{arrow}{limit_words(required)}")
    lines = [wrapped(line, cell - 0.9, 9) for line in titles]
    axes.set_title("\n".join(lines), fontsize=9)
    words = f"{against.parameter} ({of_parameter.symbol}), {against.correlation:+.2f}"
    axes.set_xlabel(wrapped(words, cell - 0.9, 8), fontsize=8)
    axes.set_ylabel(unit.symbol, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.ticklabel_format(useOffset=False)
    axes.grid(alpha=0.3)


def _beyond(limit: float, values: Array) -> str:
    """Return an arrow to a limit that is far from the values; empty if it is not."""
    told = values[np.isfinite(values)]
    if not len(told):
        return ""
    away = _AWAY * (told.max() - told.min())
    if limit > told.max() + away:
        return "↑ "
    return "↓ " if limit < told.min() - away else ""
