"""What is required in failure cases beside the design: nominal, worst and limits."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.metrics.requirements import Verdict
from drakesep.plots.limits import LIMIT, SIGNS
from drakesep.plots.style import COLOURS, save_plot, wrapped
from drakesep.tables.failure_tables import CASE, margin_share


_ACROSS, _MOST = 3, 9
"""Panels beside each other, and in all."""
_CELL = 4.2
"""Width of a panel, in."""
TITLE = 0.9
"""What titles take of a figure, in."""
_ROW = 0.22
"""Height of a failure case, in."""


def save_failure_cases(requirements: pd.DataFrame, folder: Path) -> None:
    """Write failure_cases.png into a folder.

    Args:
        requirements: of the design and of each failure case, as
            failure_requirements.csv has them.
        folder: of the results.
    """
    save_plot(failure_figure(requirements), folder / "failure_cases.png")


def failure_figure(
    requirements: pd.DataFrame, *, most_across: int = _ACROSS, cell: float = _CELL
) -> Figure:
    """Return a panel for each requirement, with a row for the design and each case.

    Of many requirements, those with the least margins.

    Args:
        requirements: as failure_requirements.csv has them.
        most_across: panels beside each other, at most.
        cell: width of a panel, in.
    """
    groups = panels_of(requirements)
    shown = sorted(sorted(groups, key=_least_margin)[:_MOST], key=lambda g: g.index[0])
    across = min(len(shown), most_across)
    down = math.ceil(len(shown) / across)
    height = row_height(requirements) * down + TITLE
    figure = Figure(figsize=(cell * across + 1.2, height), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharey=True)
    for axes, mine in zip(grid.flat, shown, strict=False):
        _draw(axes, mine, cell)
    for axes in grid.flat[len(shown) :]:
        axes.set_visible(False)
    title = (
        "Failure cases: nominal (open), worst over the tolerances (filled; x: not met)"
    )
    if len(shown) < len(groups):
        title += f"; the {len(shown)} requirements of least margin, of {len(groups)}"
    figure.suptitle(wrapped(title, cell * across, 11), fontsize=11)
    return figure


def row_height(requirements: pd.DataFrame) -> float:
    """Return the height of a row of panels, in."""
    return _ROW * requirements[CASE].nunique() + 1.1


def panels_of(requirements: pd.DataFrame) -> list[pd.DataFrame]:
    """Return the rows of each requirement."""
    keys = ["requirement", "axis", "pair", "sense", "limit", "unit", "id"]
    return [mine for _, mine in requirements.groupby(keys, sort=False, dropna=False)]


def _least_margin(group: pd.DataFrame) -> float:
    """Return the least margin as a share of its limit; 0 of what was not looked at."""
    shares = map(margin_share, group.to_dict("records"))
    return min(0.0 if math.isnan(share) else share for share in shares)


def _draw(axes: Axes, mine: pd.DataFrame, cell: float) -> None:
    """Draw one requirement in the design and in each failure case."""
    y = np.arange(len(mine))
    beyond = (mine["verdict"] == Verdict.NOT_MET.value).to_numpy()
    untold = mine["worst"].isna().to_numpy()
    nominal, worst = mine["nominal"].to_numpy(), mine["worst"].to_numpy()
    axes.hlines(y, nominal, worst, color="#999999", linewidth=1.0)
    axes.plot(nominal, y, "o", color=COLOURS[0], markerfacecolor="white", markersize=4)
    axes.plot(worst[~beyond], y[~beyond], "o", color=COLOURS[1], markersize=5)
    axes.plot(worst[beyond], y[beyond], "X", color=COLOURS[2], markersize=7)
    beside = axes.get_yaxis_transform()
    for k in y[untold]:
        words = axes.text(0.02, float(k), "not looked at", transform=beside)
        words.set(fontsize=7, va="center", color="#555555", backgroundcolor="white")
        words.set_zorder(5)  # before the limit
    first = mine.iloc[0]
    axes.axvline(first["limit"], **LIMIT)
    axes.axhline(0.5, color="#cccccc", linewidth=0.8)
    axes.set_yticks(y, mine[CASE], fontsize=7)
    axes.set_ylim(len(mine) - 0.5, -0.5)
    axes.set_xlabel(first["unit"], fontsize=8)
    axes.tick_params(axis="x", labelsize=7)
    axes.grid(axis="x", alpha=0.3)
    name = f"{first['requirement']} {first['axis']}".strip()
    whose = f", {first['pair']}" if first["pair"] else ""
    limit = f"{SIGNS[first['sense']]} {first['limit']:.6g} {first['unit']}".strip()
    text = f"{name}{whose}: {limit}" + (f" ({first['id']})" if first["id"] else "")
    axes.set_title(wrapped(text, cell - 0.4, 8), fontsize=8)
