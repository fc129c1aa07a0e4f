"""Proven bounds beside the worst found, as shares of the limits."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.bounds.answers import NOT_COVERED
from drakesep.plots.limits import LIMIT, SIGNS
from drakesep.plots.style import COLOURS, save_plot, wrapped
from drakesep.systems.arrays import Array


Row: TypeAlias = Mapping[Any, Any]
_WIDTH, _ROW = 9.0, 0.36
"""In."""
_TITLE = (
    "What is proven: the worst found (dot), and the bound that no run within the "
    "tolerances is beyond (bar)"
)
_OF_LIMIT, _OF_FOUND = "share of the limit", "beyond the worst found, % of it"


def save_proofs(proofs: pd.DataFrame, folder: Path) -> None:
    """Write proofs.png into a folder.

    Args:
        proofs: as proofs.csv has them.
        folder: of the results.
    """
    save_plot(proofs_figure(proofs), folder / "proofs.png")


def proofs_figure(proofs: pd.DataFrame, *, width: float = _WIDTH) -> Figure:
    """Return a row for each requirement and objective.

    Found and bound as shares of the limit; where there is none, or it is zero, how far
    the bound is beyond what is found.

    Args:
        proofs: as proofs.csv has them.
        width: of the figure, in.
    """
    limit = proofs["limit"]
    by_limit = (limit.notna() & (limit != 0.0)).to_numpy()
    shown = [rows for rows in (proofs[by_limit], proofs[~by_limit]) if len(rows)]
    heights = [len(rows) + 1.6 for rows in shown]
    figure = Figure(figsize=(width, _ROW * sum(heights) + 0.9), layout="constrained")
    grid = figure.subplots(len(shown), 1, squeeze=False, height_ratios=heights)
    for axes, rows in zip(grid.flat, shown, strict=True):
        limited = bool(by_limit[rows.index[0]])
        _draw(axes, rows, *(_shares if limited else _gaps)(rows), limited=limited)
    figure.suptitle(wrapped(_TITLE, width - 0.5, 11), fontsize=11)
    return figure


def _shares(rows: pd.DataFrame) -> tuple[Array, Array]:
    """Return what is found and the bound, as shares of the limit."""
    scale = rows["limit"].abs()
    found, bound = rows["found"] / scale, rows["proven_bound"] / scale
    return found.to_numpy(), bound.to_numpy()


def _gaps(rows: pd.DataFrame) -> tuple[Array, Array]:
    """Return zeros and the gaps, per cent."""
    gaps = rows["gap_percent"].to_numpy()
    return 0.0 * gaps, gaps


def _draw(
    axes: Axes, rows: pd.DataFrame, found: Array, bound: Array, *, limited: bool
) -> None:
    """Draw some rows, with their limits if they are shares of these."""
    y, records = np.arange(len(rows)), rows.to_dict("records")
    axes.hlines(y, found, bound, color="#555555", linewidth=1.2)
    axes.plot(found, y, "o", color=COLOURS[1], markersize=5)
    axes.plot(bound, y, "|", color=COLOURS[0], markersize=13, markeredgewidth=2.2)
    beside = axes.get_yaxis_transform()
    for k, row in enumerate(records):
        if row["verdict"] == NOT_COVERED:
            text = axes.text(0.01, k, row["reason"], transform=beside)
            text.set(fontsize=7, va="center", color="#555555")
        elif limited:
            axes.vlines(np.sign(row["limit"]), k - 0.4, k + 0.4, **LIMIT)
    right = axes.secondary_yaxis("right")
    right.set_yticks(y, [_told(row) for row in records], fontsize=7)
    right.tick_params(length=0)
    axes.set_yticks(y, [_name(row) for row in records], fontsize=7)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlabel(_OF_LIMIT if limited else _OF_FOUND, fontsize=8)
    axes.tick_params(axis="x", labelsize=7)
    axes.grid(axis="x", alpha=0.3)
    axes.margins(x=0.08)


def _name(row: Row) -> str:
    """Return what a row is of, with its limit."""
    sense = str(row["sense"])
    if not row["requirement"]:
        return f"{row['objective']}, {'at most' if '<' in sense else 'at least'}"
    words = f"{row['requirement']} {row['axis']}".strip()
    whose = f", {row['pair']}" if row["pair"] else ""
    known = f" ({row['id']})" if row["id"] else ""
    limit = f"{SIGNS[sense]} {row['limit']:.6g} {row['unit']}".strip()
    return f"{words}{whose}{known}\n{limit}"


def _told(row: Row) -> str:
    """Return what is proven of it, in words."""
    if row["verdict"] == NOT_COVERED:
        return NOT_COVERED
    bound = f"{row['proven_bound']:.4g} {row['unit']}".strip()
    return f"{bound}: {row['verdict']}\ngap {row['gap_percent']:.2g} %"
