"""What more and more of a campaign's draws say of the share that is required."""

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from drakesep.plots.limits import LIMIT, SIGNS
from drakesep.plots.style import wrapped


ROW = 2.0
"""Height of a panel, in."""
_LINE: dict[str, Any] = {"color": "#0072B2", "lw": 1.4, "marker": "o", "ms": 3}
_INTERVAL: dict[str, Any] = {"color": "#56B4E9", "alpha": 0.35, "lw": 0}
_AWAY = 2.0
"""A limit that is further from the values than so many of their spans is only told."""
OF = ["requirement", "axis", "pair", "sense", "limit"]


def convergence_figure(table: pd.DataFrame, *, across: int, cell: float) -> Figure:
    """Return a panel for each requirement: the quantile, its interval, and the limit.

    Args:
        table: as campaign_convergence.csv has it, with rows.
        across: panels beside each other.
        cell: width of a panel, in.
    """
    panels = [*table.groupby(OF, sort=False, dropna=False)]
    across = min(across, len(panels))
    down = math.ceil(len(panels) / across)
    figure = Figure(figsize=(cell * across, ROW * down + 0.3), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    for axes, (_, rows) in zip(grid.flat, panels, strict=False):
        _draw(axes, rows, cell)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    handles = [
        Line2D([], [], label="value below which the share is", **_LINE),
        Patch(label="its interval at 95 %", **_INTERVAL),
        Line2D([], [], label="limit", **LIMIT),
    ]
    figure.legend(
        **{"handles": handles, "loc": "outside lower center", "ncols": len(handles)},
        **{"frameon": False, "fontsize": 8},
    )
    return figure


def _draw(axes: Axes, rows: pd.DataFrame, cell: float) -> None:
    first = rows.iloc[0]
    told = rows[["quantile", "quantile_from", "quantile_to"]].to_numpy(float)
    finite = told[np.isfinite(told)]
    if not len(finite):
        axes.text(0.5, 0.5, "no draw tells", ha="center", transform=axes.transAxes)
        finite = np.array([first["limit"]])
    low, high = float(finite.min()), float(finite.max())
    span = (high - low) or abs(high) or 1.0
    limit = float(first["limit"])
    is_near = low - _AWAY * span <= limit <= high + _AWAY * span
    if is_near:
        low, high = min(low, limit), max(high, limit)
        axes.axhline(limit, **LIMIT)
    # Of too few draws an interval has no end: it is drawn as far as the panel.
    ends = np.clip(told[:, 1:], low - span, high + span)
    draws = rows["draws"].to_numpy(float)
    axes.fill_between(draws, ends[:, 0], ends[:, 1], **_INTERVAL)
    axes.plot(draws, told[:, 0], **_LINE)
    axes.set_xscale("log")
    axes.ticklabel_format(axis="y", useOffset=False)
    room = 0.08 * (high - low or span)
    axes.set_ylim(low - room, high + room)
    whose = f", {first['pair']}" if first["pair"] else ""
    arrow = "" if is_near else ("↑ " if limit > high else "↓ ")
    title = f"{first['requirement']} {first['axis']}".strip() + whose
    words = f"{arrow}{SIGNS[first['sense']]} {limit:.4g} {first['unit']}"
    share = f"{100.0 * first['quantile_of']:.6g} % of launches"
    lines = [wrapped(line, cell - 0.5, 8) for line in (title, f"{words}; {share}")]
    axes.set_title("\n".join(lines), fontsize=8)
    axes.set_xlabel("draws", fontsize=7)
    axes.set_ylabel(first["unit"], fontsize=7)
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3)
