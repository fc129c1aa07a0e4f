"""Runs as curves of a signal over time: which, how they look, limits, what decides."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from drakesep.plots.layout import Entry
from drakesep.plots.limits import LIMIT
from drakesep.plots.panels import Panel
from drakesep.plots.shown_runs import Decided
from drakesep.plots.style import DASHES
from drakesep.systems.model.separation import Pair
from drakesep.systems.sampling import NANOSECOND
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Published


_REFERENCE = "#000000"
_PUBLISHED = ("#757575", "#A6A6A6", "#CCCCCC")
_COMPARED = ("#0072B2", "#009E73", "#56B4E9", "#E69F00")
_DECIDING = ("#D55E00", "#A0417F", "#0072B2", "#009E73", "#E69F00", "#56B4E9")
_MARKED: dict[str, Any] = {"lw": 2.0, "marker": "o", "ms": 5, "mec": "white"}
END: dict[str, Any] = {"color": "#555555", "ls": ":", "lw": 1.0}
"""How the end of separation is drawn."""
_ROOM = 0.06
"""Of the height of curves and limits, that is left above and below them."""
_NOTHING = 1e-7
"""In the units that are shown: runs are no better than that, and what moves less is
drawn as what does not move."""


class Drawn(NamedTuple):
    """A run as it is drawn."""

    one: LabelledRun
    colour: str
    dashes: tuple[float, tuple[float, ...]]
    width: float
    level: int


def drawn_everywhere(
    reference: LabelledRun, compared: Sequence[LabelledRun]
) -> list[Drawn]:
    """Return the runs that all panels show, as they are drawn.

    Args:
        reference: that the others are seen against.
        compared: published runs, and worst cases of objectives.
    """
    drawn = [Drawn(reference, _REFERENCE, DASHES[0], 1.5, 3)]
    published = [one for one in compared if isinstance(one.role, Published)]
    if len(published) <= len(_PUBLISHED):  # more would hide the others
        drawn += [
            Drawn(one, colour, DASHES[0], 2.6, 1)
            for one, colour in zip(published, _PUBLISHED, strict=False)
        ]
    others = [one for one in compared if not isinstance(one.role, Published)]
    for k, one in enumerate(others):
        dashes = DASHES[1 + k % (len(DASHES) - 1)]
        drawn.append(Drawn(one, _COMPARED[k % len(_COMPARED)], dashes, 1.4, 2))
    return drawn


def with_deciding(
    everywhere: Sequence[Drawn], deciding: Sequence[LabelledRun]
) -> dict[str, Drawn]:
    """Return runs as they are drawn, by their labels, with those that decide.

    Args:
        everywhere: that all panels show.
        deciding: that one panel shows beside them.
    """
    drawn = {each.one.label: each for each in everywhere}
    new = {one.label: one for one in deciding if one.label not in drawn}
    for k, (label, one) in enumerate(new.items()):
        colour = _DECIDING[k % len(_DECIDING)]
        drawn[label] = Drawn(one, colour, DASHES[0], 2.0, 4)
    return drawn


def draw_curves(
    axes: Axes, panel: Panel, drawn: Mapping[str, Drawn], pair: Pair
) -> None:
    """Draw the curves of runs, the limits, and where runs decide.

    Args:
        axes: of the panel.
        panel: the signal, with what is required of it.
        drawn: the runs, by their labels.
        pair: whose B leaves.
    """
    for label, (one, colour, dashes, width, level) in drawn.items():
        axes.plot(
            one.run.motion_of(pair.B).time,
            panel.unit.per_si * panel.values(one.run),
            color=colour,
            linestyle=dashes,
            linewidth=width,
            zorder=level,
            label=label,
        )
    curves = {line.get_label(): line for line in axes.get_lines()}
    for decided in panel.decided:
        label = decided.run.label
        _draw_limit(axes, panel, decided)
        _mark(axes, panel, decided, curves[label])


def _draw_limit(axes: Axes, panel: Panel, decided: Decided) -> None:
    """Draw a limit while it holds; on both sides, if curves go to the other."""
    metric = decided.metric
    limit = metric.sign * panel.unit.from_si(decided.finding.requirement.limit)
    sides = [limit]
    if metric.is_magnitude and axes.dataLim.y0 < -0.2 * limit:
        sides.append(-limit)
    start, end = decided.window
    # What holds at a moment is drawn until then.
    span = (start if start < end else 0.0, end)
    for side in sides:
        axes.plot(span, (side, side), **LIMIT)


def _mark(axes: Axes, panel: Panel, decided: Decided, curve: Line2D) -> None:
    """Mark where the run that decides a requirement is nearest its limit, or beyond."""
    worst = decided.metric.sign * panel.unit.from_si(decided.finding.worst)
    if math.isnan(worst):
        return
    time, values = (np.asarray(x, float) for x in curve.get_data())
    start, end = decided.window
    away = np.abs((np.abs(values) if decided.metric.is_magnitude else values) - worst)
    away[(time < start - NANOSECOND) | (time > end + NANOSECOND)] = np.inf
    if np.isinf(away).all():  # a moment between samples
        away = np.abs(time - end)
    k = int(away.argmin())
    side = -1.0 if decided.metric.is_magnitude and values[k] < 0.0 else 1.0
    axes.plot(
        time[k],
        side * worst,
        marker="o",
        markersize=5,
        color=curve.get_color(),
        markeredgecolor="white",
        zorder=6,
        clip_on=not _is_in(axes, time[k]),  # whole, if it is at the edge
    )


def _is_in(axes: Axes, time: float) -> bool:
    start, end = axes.get_xlim()
    return start <= time <= end


def fit(axes: Axes) -> None:
    """Fit the height of a panel to what is seen of its lines, be it flat."""
    start, end = axes.get_xlim()
    seen: list[float] = []
    for line in axes.get_lines():
        time, values = (np.asarray(x, float) for x in line.get_data())
        edges = np.clip((start, end), time[0], time[-1])
        if start <= edges[0] and edges[1] <= end:  # it is within the times, or crosses
            at = np.concatenate([time[(start <= time) & (time <= end)], edges])
            seen += np.interp(at, time, values).tolist()
    low, high = (0.0 if abs(x) < _NOTHING else x for x in (min(seen), max(seen)))
    if high - low < _NOTHING:
        low = high
    room = _ROOM * ((high - low) or abs(high) or 1.0)
    axes.set_ylim(low - room, high + room)


def legend_entries(
    everywhere: Sequence[Drawn],
    panels: Sequence[Panel],
    drawn_in: Sequence[Mapping[str, Drawn]],
) -> list[Entry]:
    """Return the entries of the legend: those that decide stand together.

    Args:
        everywhere: runs that all panels show.
        panels: of the figure.
        drawn_in: the runs that each shows, by their labels.
    """
    entries: list[Entry] = [
        (
            each.one.label,
            [Line2D([], [], color=each.colour, ls=each.dashes, lw=each.width)],
        )
        for each in everywhere
    ]
    shown = {each.one.label for each in everywhere}
    new = [one for drawn in drawn_in for one in drawn.values()]
    colours = dict.fromkeys(x.colour for x in new if x.one.label not in shown)
    if colours:
        lines = [Line2D([], [], color=colour, **_MARKED) for colour in colours]
        entries.append(("worst by a requirement", lines))
    if any(panel.decided for panel in panels):
        entries.append(("limit", [Line2D([], [], **LIMIT)]))
    return [*entries, ("end of separation", [Line2D([], [], **END)])]
