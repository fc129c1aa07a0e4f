"""What each tolerance does to each objective, as a tornado plot."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from drakesep.plots.style import save_plot, wrapped


_BARS = 8
"""Parameters in a panel of the tornado plot: those that matter most."""
_ACROSS = 4
_CELL = 4.6
"""Width of a panel with its names, in."""


def save_tornado(sensitivities: pd.DataFrame, folder: Path) -> None:
    """Write tornado.png into a folder."""
    save_plot(tornado_figure(sensitivities), folder / "tornado.png", dpi=110)


def tornado_figure(
    sensitivities: pd.DataFrame, *, most_across: int = _ACROSS, cell: float = _CELL
) -> Figure:
    """Return what each tolerance does to each objective, to first order.

    A panel for each objective, with the parameters that matter most at its worst case;
    wide bars are slopes there, narrow ones at the nominal, each for all of the upper
    and of the lower side of a tolerance.

    Args:
        sensitivities: as `WorstCases.sensitivities` has them.
        most_across: panels beside each other, at most.
        cell: width of a panel with its names, in.
    """
    panels = list(sensitivities.groupby("objective", sort=False))
    down = -(-len(panels) // most_across)
    across = min(len(panels), most_across)
    figure = Figure(figsize=(cell * across, 2.9 * down + 0.6), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    for axes, (objective, rows) in zip(grid.flat, panels, strict=False):
        _draw_tornado(axes, str(objective), rows.head(_BARS), cell)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    handles, labels = grid.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    title = "Change for a whole side of a tolerance, to first order"
    parameters = sensitivities["parameter"].nunique()
    if parameters > _BARS:
        title += f"; of {parameters} parameters the {_BARS} that matter most"
    figure.suptitle(wrapped(title, cell * across - 0.2, 12))
    return figure


def _draw_tornado(axes: Axes, objective: str, rows: pd.DataFrame, cell: float) -> None:
    places = np.arange(len(rows))
    for at, height, colours, label in (
        ("worst", 0.8, ("#56B4E9", "#C7E6F7"), "at the worst case"),
        ("nominal", 0.35, ("#000000", "#999999"), "at the nominal"),
    ):
        for way, colour in zip(("upward", "downward"), colours, strict=True):
            widths = rows[f"{way}_at_{at}"]
            said = f"{way}, {label}"
            axes.barh(places, widths, height, color=colour, label=said)
    names = rows["parameter"].str.cat(rows["at_worst"].map(_MARKED))
    axes.set_yticks(places, list(names), fontsize=7)
    axes.invert_yaxis()
    axes.axvline(0.0, color="#555555", linewidth=0.8)
    # To the right, since the space above the names of parameters is free.
    title = wrapped(objective.replace("_", " "), cell - 0.2, 9)
    axes.set_title(title, fontsize=9, loc="right")
    axes.set_xlabel(rows["unit"].iloc[0], fontsize=8)
    axes.tick_params(axis="x", labelsize=7)
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.grid(axis="x", alpha=0.3)


_MARKED = {"M": "  M", "m": "  m", "": "   "}
