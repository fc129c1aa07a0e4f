"""Pictures of how near bodies come: distances, and the space that parts sweep."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.approach import Approach, Curve
from drakesep.plots.limits import LIMIT, limit_words
from drakesep.plots.style import (
    COLOURS,
    DASHES,
    columns_of_legend,
    save_plot,
    wrapped,
)
from drakesep.systems.arrays import Array
from drakesep.units import unit_of


def save_clearance(time: Array, curves: Mapping[str, Curve], folder: Path) -> None:
    """Write clearance.png into a folder."""
    figure = clearance_figure(time, curves)
    save_plot(figure, folder / "clearance.png")


def clearance_figure(time: Array, curves: Mapping[str, Curve]) -> Figure:
    """Return how near pairs are, over time and over the distance of separation.

    Args:
        time: (n,) s.
        curves: by the name of the pair of parts.
    """
    mm = unit_of("clearance").per_si
    figure = Figure(figsize=(12, 5.2), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    # Contact has no place on a scale of powers: it is drawn at the lower edge.
    least = min(_positive(curve.distance).min() for curve in curves.values())
    floor = 0.5 * mm * float(least)
    for i, (name, curve) in enumerate(curves.items()):
        one = curve.smallest
        for axes, x in zip(panels, (time, mm * curve.separation), strict=True):
            colour = COLOURS[i % len(COLOURS)]
            dashes = DASHES[i // len(COLOURS) % len(DASHES)]
            shown = np.maximum(mm * curve.distance, floor)
            axes.plot(x, shown, color=colour, linestyle=dashes, label=name)
            axes.plot(
                np.interp(one.time, time, x),
                max(mm * one.minimum, floor),
                marker="o" if one.contact is None else "X",
                color=colour,
                markersize=6 if one.contact is None else 10,
            )
    for axes in panels:
        axes.set_yscale("log")
        axes.grid(alpha=0.3, which="both")
    panels[0].set_xlabel("time (s)")
    panels[1].set_xlabel("separation (mm)")
    panels[0].set_ylabel("distance (mm)")
    handles, labels = panels[0].get_legend_handles_labels()
    labels = [wrapped(label, 10.5, 10) for label in labels]
    columns = columns_of_legend(labels, 11.5)
    figure.legend(
        handles, labels, loc="outside lower center", ncols=columns, frameon=False
    )
    figure.suptitle("Distances between parts; dots: smallest, crosses: contact")
    return figure


def distances_figure(distances: pd.DataFrame, summary: pd.DataFrame) -> Figure:
    """Return how near the nearest pairs are over the distance of separation.

    Args:
        distances: as clearance.csv has them.
        summary: as clearance_summary.csv has it, the nearest first.
    """
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.subplots()
    shown = summary[summary["status"] != "parted"].head(len(DASHES))
    named = zip(shown["first"], shown["second"], shown.to_dict("records"), strict=True)
    for k, (first, second, row) in enumerate(named):
        style: dict[str, Any] = {"color": COLOURS[k], "ls": DASHES[k]}
        y = distances[f"{first}_to_{second}_mm"]
        label = f"{first} to {second}".replace("_", " ")
        axes.plot(distances["separation_mm"], y, label=label, **style)
        marker = "o" if row["status"] == "clear" else "X"
        nearest = row["separation_mm"], row["clearance_mm"]
        axes.plot(*nearest, marker=marker, color=COLOURS[k], markersize=6)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("separation (mm)", fontsize=8)
    axes.set_ylabel("distance (mm)", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize=8, handlelength=3.5)
    return figure


def _positive(distances: Array) -> Array:
    return distances[distances > 0.0] if (distances > 0.0).any() else np.ones(1)


def save_approaches(
    approaches: Sequence[Approach], limits: Sequence[Requirement], folder: Path
) -> None:
    """Write worst_clearance.png into a folder."""
    figure = approaches_figure(approaches, limits)
    save_plot(figure, folder / "worst_clearance.png")


def approaches_figure(
    approaches: Sequence[Approach], limits: Sequence[Requirement]
) -> Figure:
    """Return how near the pair that comes nearest in each run is, as its bodies part.

    Args:
        approaches: of each run; a panel for each clearance.
        limits: requirements, some of which are on these clearances.
    """
    clearances = list(dict.fromkeys(one.clearance for one in approaches))
    figure = Figure(figsize=(8, 1 + 4 * len(clearances)), layout="constrained")
    panels = figure.subplots(len(clearances), squeeze=False)[:, 0]
    for axes, name in zip(panels, clearances, strict=True):
        mine = [one for one in approaches if one.clearance == name]
        _draw_approaches(axes, mine)
        for limit in limits:
            if limit.metric == name:
                at = unit_of(name).from_si(limit.limit)
                axes.axhline(at, **LIMIT, label=limit_words(limit))
        axes.legend(frameon=False)
        axes.set_title(
            "Distance of the pair that comes nearest in each run; dots: smallest"
            if len(clearances) == 1
            else wrapped(name.replace("_", " "), 7.0, 12)
        )
    return figure


def _draw_approaches(axes: Axes, approaches: Sequence[Approach]) -> None:
    mm = unit_of("clearance").per_si
    for i, one in enumerate(approaches):
        colour = COLOURS[i % len(COLOURS)]
        least = int(one.distance.argmin())
        axes.plot(
            mm * one.separation,
            mm * one.distance,
            color=colour,
            linestyle=DASHES[i % len(DASHES)],
            label=f"{one.label}: {one.pair}, {mm * one.distance[least]:.2f} mm",
        )
        axes.plot(
            mm * one.separation[least], mm * one.distance[least], "o", color=colour
        )
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("separation (mm)")
    axes.set_ylabel("distance (mm)")
    axes.grid(alpha=0.3)
