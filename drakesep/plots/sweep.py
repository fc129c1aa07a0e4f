"""What is required of variants over the one parameter that varies."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.plots.limits import LIMIT, limit_words
from drakesep.plots.style import COLOURS, save_plot, wrapped
from drakesep.systems.model.parameters import parameters
from drakesep.tables.variants import Variant
from drakesep.units import unit_of, with_unit


_ACROSS = 3
_CELL = 4.6
"""Width of a panel, in."""
_COUNTS = {"<=": "largest", ">=": "smallest", ">": "smallest"}
"""What counts to each side of a limit."""


def save_sweep(variants: Sequence[Variant], case: AnalysisCase, folder: Path) -> None:
    """Write sweep.png into a folder."""
    save_plot(sweep_figure(variants, case), folder / "sweep.png")


def sweep_figure(variants: Sequence[Variant], case: AnalysisCase) -> Figure:
    """Return what is required over the parameter that varies, with its limits.

    A panel for each quantity, with a curve for each axis; variants that failed leave
    gaps.

    Args:
        variants: that differ in one parameter.
        case: with the requirements.
    """
    [name] = variants[0].values
    ordered = sorted(variants, key=lambda variant: variant.values[name])
    panels: dict[tuple[str, str], list[Requirement]] = {}
    for required in case.requirements:
        key = required.pair, required.quantity[0]
        panels.setdefault(key, []).append(required)
    across = min(len(panels), _ACROSS)
    down = math.ceil(len(panels) / across)
    figure = Figure(figsize=(_CELL * across, 3.6 * down + 0.6), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    for axes, ((pair, quantity), mine) in zip(grid.flat, panels.items(), strict=False):
        _draw(axes, name, ordered, mine)
        nominal = unit_of(name).from_si(parameters(case.separation)[name])
        axes.axvline(nominal, color="#555555", linestyle=":", linewidth=1.0)
        of = f", {pair}" if pair else ""
        title = f"{quantity}{of}".replace("_", " ")
        axes.set_title(wrapped(title, _CELL - 1.0, 9), fontsize=9)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    title = f"{case.name} over {with_unit(name)}; dotted: nominal, dashed: limit"
    figure.suptitle(wrapped(title, _CELL * across - 0.2, 12))
    return figure


def _draw(
    axes: Axes,
    name: str,
    variants: Sequence[Variant],
    requirements: Sequence[Requirement],
) -> None:
    """Draw the requirements on one quantity."""
    unit = unit_of(requirements[0].metric)
    x = [unit_of(name).from_si(variant.values[name]) for variant in variants]
    judges = {r.judged_by: r for r in requirements}
    both = len(judges) > len({r.quantity for r in requirements})
    for k, (judge, required) in enumerate(judges.items()):
        y = [unit.from_si(v.metrics.get(judge, math.nan)) for v in variants]
        axis = required.quantity[1]
        axes.plot(
            x,
            np.array(y),
            marker=".",
            color=COLOURS[k % len(COLOURS)],
            label=f"{axis} {_COUNTS[required.sense]}".strip() if both else axis,
        )
    several = len({r.limit for r in requirements}) > 1 and len(judges) > 1
    limits: dict[tuple[float, str, str], None] = {}
    for required in requirements:
        k = [*judges].index(required.judged_by)
        colour = COLOURS[k % len(COLOURS)] if several else LIMIT["color"]
        limit = unit.from_si(required.limit)
        limits[limit, limit_words(required), colour] = None
    for limit, words, colour in limits:
        axes.axhline(limit, **LIMIT | {"color": colour}, label=words)
    axes.legend(
        **{"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "ncols": 2},
        **{"fontsize": 7, "frameon": False, "handlelength": 3.5},
    )
    axes.set_xlabel(with_unit(name), fontsize=8)
    axes.set_ylabel(unit.symbol)
    axes.grid(alpha=0.3)
