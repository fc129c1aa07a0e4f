"""How what is required is distributed over the draws of a campaign."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.plots.campaign_curves import Curve
from drakesep.plots.limits import LIMIT, limit_words
from drakesep.plots.style import COLOURS, DASHES, save_plot, wrapped
from drakesep.units import unit_of


_ACROSS = 3
_CELL = 4.6
"""Width of a panel, in."""
ROW = 3.8
"""Height of a panel, in."""
_RING: dict[str, Any] = {"marker": "o", "fillstyle": "none", "markersize": 9}


def save_campaign(name: str, runs: int, curves: Sequence[Curve], folder: Path) -> None:
    """Write campaign.png into a folder."""
    save_plot(campaign_figure(name, runs, curves), folder / "campaign.png")


def campaign_figure(
    name: str,
    runs: int,
    curves: Sequence[Curve],
    *,
    most_across: int = _ACROSS,
    cell: float = _CELL,
) -> Figure:
    """Return which share of draws is beyond each value of what is required.

    A panel for each quantity and side of its limit, with a curve for each axis, that
    ends at the worst draw; where it crosses the limit, it tells the share beyond that.
    Where the worst case was searched, it stands below, with how far that is beyond the
    bound, as a share of it.

    Args:
        name: of the case.
        runs: draws.
        curves: of each requirement, one or more.
        most_across: panels beside each other, at most.
        cell: width of a panel, in.
    """
    panels = panels_of_curves(curves)
    across = min(len(panels), most_across)
    down = math.ceil(len(panels) / across)
    figure = Figure(figsize=(cell * across, ROW * down + 0.6), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    for axes, mine in zip(grid.flat, panels, strict=False):
        required = mine[0].requirement
        _draw(axes, mine, runs)
        whose = f", {required.pair}" if required.pair else ""
        title = f"{required.quantity[0]}{whose}".replace("_", " ")
        axes.set_title(wrapped(title, cell - 1.0, 9), fontsize=9)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    title = (
        f"{name}: share of {runs} draws beyond a value; dashed: limit, ring: bound of "
        "the share that is required, dot: worst draw"
    )
    if any(one.requirement.sides == "two" for one in curves):
        title += "; of two sides, each limit by itself"
    if any(math.isfinite(one.worst_case) for one in curves):
        title += ", cross: worst case found, and how much worse than the bound"
    figure.suptitle(wrapped(title, cell * across - 0.2, 11), fontsize=11)
    return figure


def panels_of_curves(curves: Iterable[Curve]) -> list[list[Curve]]:
    """Return the curves of each panel: of one quantity, side of its limit and pair."""
    panels: dict[tuple[str, str, bool], list[Curve]] = {}
    for one in curves:
        required = one.requirement
        key = required.pair, required.quantity[0], required.from_above
        panels.setdefault(key, []).append(one)
    return [*panels.values()]


def _draw(axes: Axes, curves: Sequence[Curve], runs: int) -> None:
    """Draw the curves on one side of one quantity."""
    first = curves[0].requirement
    unit = unit_of(first.metric)
    several = len({one.requirement.limit for one in curves}) > 1
    for k, one in enumerate(curves):
        required, colour = one.requirement, COLOURS[k % len(COLOURS)]
        values = unit.from_si(1.0) * one.values
        label = required.quantity[1] or None
        style: dict[str, Any] = {"color": colour, "ls": DASHES[k % len(DASHES)]}
        axes.plot(values, one.shares, label=label, **style)
        if len(values):
            axes.plot(values[-1], one.shares[-1], "o", color=colour, markersize=5)
        bound = unit.from_si(one.bound)
        if math.isfinite(bound):
            axes.plot(bound, one.bound_share, color=colour, **_RING)
        if math.isfinite(one.worst_case):
            height = _below(k + 0.6, runs)
            value = unit.from_si(one.worst_case)
            worse = (value - bound) * (1.0 if required.from_above else -1.0)
            words = f"{100.0 * worse / abs(bound):+.2g} %" if bound else ""
            _draw_worst_case(axes, bound, value, height, words, colour)
    for k, one in enumerate(curves):
        required, colour = one.requirement, COLOURS[k % len(COLOURS)]
        axes.axvline(
            unit.from_si(required.limit),
            **LIMIT | ({"color": colour} if several else {}),
            label=limit_words(required) if several or not k else None,
        )
    for required_share in {one.bound_of for one in curves}:
        axes.axhline(
            1.0 - required_share, color="#555555", linestyle=":", linewidth=1.0
        )
    found = any(math.isfinite(one.worst_case) for one in curves)
    axes.set_yscale("log")
    axes.set_ylim(_below(len(curves) if found else 0, runs), 1.3)
    if not first.from_above:
        axes.invert_xaxis()  # worse is to the right
    axes.set_xlabel(unit.symbol)
    axes.set_ylabel("share of draws beyond", fontsize=8)
    axes.grid(alpha=0.3)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            **{"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "ncols": 2},
            **{"fontsize": 7, "frameon": False, "handlelength": 3.5},
        )


def _draw_worst_case(
    axes: Axes, bound: float, value: float, height: float, words: str, colour: str
) -> None:
    """Draw a worst case below the curves, with a line from its bound.

    Args:
        axes: of the panel.
        bound: in the unit of the panel; NaN if there is none.
        value: of the worst case, likewise.
        height: at which it stands.
        words: that stand above.
        colour: of its curve.
    """
    axes.plot(value, height, marker="X", markersize=7, color=colour)
    if not math.isfinite(bound):
        return
    axes.plot([bound, value], [height, height], color=colour, linewidth=1.0)
    axes.plot(bound, height, marker="|", markersize=8, color=colour)
    middle = 0.5 * (bound + value), height
    above = axes.annotate(words, middle, xytext=(0, 4), textcoords="offset points")
    above.set(fontsize=7, ha="center", va="bottom", color=colour)


def _below(place: float, runs: int) -> float:
    """Return the height of a place below all curves, on their logarithmic scale."""
    return float(0.5 / runs * 10.0 ** (-0.6 * place))
