"""The motion of a body that leaves at a glance, and what is required over time.

Rates and angles, after the paper's Fig. 7, and the relative velocity of its Fig. 6.
"""

import math

from matplotlib.figure import Figure

from drakesep.plots.layout import draw_legend
from drakesep.plots.limits import limit_words
from drakesep.plots.motion_curves import (
    END,
    draw_curves,
    drawn_everywhere,
    fit,
    legend_entries,
    with_deciding,
)
from drakesep.plots.panels import OVERVIEW, Panel, panels_of
from drakesep.plots.shown_runs import ShownRuns
from drakesep.plots.style import columns_of_legend, wrapped
from drakesep.systems.model.separation import Pair


_ACROSS = 3
_ROW, _FOOT, _ENTRY = 1.75, 0.1, 0.17
"""Height of a panel, below all, and of a line of the legend, in."""
_LETTERS = 7


def overview_figure(shown: ShownRuns, pair: Pair, width: float) -> Figure:
    """Return signals of a body that leaves, with what is required of them.

    A panel shows the nominal, worst cases of objectives, and the runs that decide what
    is required of its signal, or of one along no axis.

    Args:
        shown: the runs of a study, and those that decide requirements.
        pair: whose B leaves.
        width: of the figure, in.
    """
    separation = shown.run.separation
    panels = panels_of(OVERVIEW, separation, pair, shown.decided)
    compared = [o for o in shown.compared if OVERVIEW.concerns(o, separation, pair.B)]
    everywhere = drawn_everywhere(shown.reference, compared)
    along_none = [p for p in panels if p.column is None]
    drawn_in = [
        with_deciding(
            everywhere,
            [d.run for other in (panel, *along_none) for d in other.decided],
        )
        for panel in panels
    ]
    labels, lines = zip(*legend_entries(everywhere, panels, drawn_in), strict=True)
    columns = columns_of_legend(labels, width - 0.5, _LETTERS)
    entries = math.ceil(len(labels) / columns)
    down = math.ceil(len(panels) / _ACROSS)
    height = _ROW * down + _ENTRY * entries + _FOOT
    figure = Figure(figsize=(width, height), layout="constrained")
    grid = figure.subplots(down, _ACROSS, squeeze=False)
    for axes, panel, drawn in zip(grid.flat, panels, drawn_in, strict=False):
        draw_curves(axes, panel, drawn, pair)
        axes.set_xlim(0.0, separation.duration)
        fit(axes)
        if math.isfinite(end := shown.run.end_of(pair.B)):
            axes.axvline(end, **END)
        axes.set_title(wrapped(_title(panel), width / _ACROSS - 0.5, 8), fontsize=8)
        axes.set_ylabel(panel.unit.symbol, fontsize=_LETTERS)
        axes.tick_params(labelsize=_LETTERS)
        axes.grid(alpha=0.3)
    for k in range(len(panels)):
        if k + _ACROSS >= len(panels):  # nothing is below
            grid.flat[k].set_xlabel("time (s)", fontsize=_LETTERS)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    draw_legend(
        figure,
        labels,
        lines,
        loc="outside lower center",
        size=_LETTERS,
        columns=columns,
    )
    return figure


def _title(panel: Panel) -> str:
    limits = [limit_words(decided.finding.requirement) for decided in panel.decided]
    return f"{panel.title} ({'; '.join(limits)})" if limits else panel.title
