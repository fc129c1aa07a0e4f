"""Pictures of the motion, after the paper's Figs. 6 and 7, and of requirements on it.

Each signal has two panels beside each other: the push, and the whole run. The run that
decides a requirement is drawn against its limit and named above, and so that it can be
followed it is drawn for all signals along the same axis.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.requirements import Verdict
from drakesep.plots.layout import Entry, Layout
from drakesep.plots.limits import LIMIT, limit_words
from drakesep.plots.panels import ROTATION, TRANSLATION, Panel, Topic, panels_of
from drakesep.plots.shown_runs import Decided, ShownRuns
from drakesep.plots.style import DASHES, save_plot
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair
from drakesep.systems.sampling import NANOSECOND
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Published


_REFERENCE = "#000000"
_PUBLISHED = ("#757575", "#A6A6A6", "#CCCCCC")
_COMPARED = ("#0072B2", "#009E73", "#56B4E9", "#E69F00")
_DECIDING = ("#D55E00", "#A0417F", "#0072B2", "#009E73", "#E69F00", "#56B4E9")
_MARKED: dict[str, Any] = {"lw": 2.0, "marker": "o", "ms": 5, "mec": "white"}
_END: dict[str, Any] = {"color": "#555555", "ls": ":", "lw": 1.0}
_SHADE = "#F3F3F3"
"""Of the push."""
_ROOM = 0.06
"""Of the height of curves and limits, that is left above and below them."""
_NOTHING = 1e-7
"""In the units that are shown: runs are no better than that, and what moves less is
drawn as what does not move."""
_AROUND = 0.15
"""Of the push, that is shown before and after it."""
_LEAST = 0.001
"""Of the run, that is shown there if nothing pushes."""


def save_motion(runs: Sequence[LabelledRun], case: AnalysisCase, folder: Path) -> None:
    """Write translation.png and rotation.png of a study's runs into a folder.

    Those of other bodies that leave end with their names.

    Args:
        runs: of the study; those that failed are left out.
        case: with the requirements.
        folder: that receives them.
    """
    shown = ShownRuns.of(runs, case)
    for pair in shown.run.separation.pairs:
        end = "" if pair == shown.run.separation.pairs[0] else f"_{pair.B}"
        for name, topic in (("translation", TRANSLATION), ("rotation", ROTATION)):
            save_plot(motion_figure(topic, shown, pair), folder / f"{name}{end}.png")


class _Drawn(NamedTuple):
    """A run as it is drawn."""

    one: LabelledRun
    colour: str
    dashes: tuple[float, tuple[float, ...]]
    width: float
    level: int


def motion_figure(topic: Topic, shown: ShownRuns, pair: Pair) -> Figure:
    """Return signals of a body that leaves over time, with what is required of them.

    Args:
        topic: what it is about.
        shown: runs of the study.
        pair: whose B leaves.
    """
    run = shown.run
    panels = panels_of(topic, run.separation, pair, shown.decided)
    compared = [o for o in shown.compared if topic.concerns(o, run.separation, pair.B)]
    everywhere = _everywhere(shown.reference, compared)
    drawn_in = [_with_deciding(everywhere, _deciding(p, panels)) for p in panels]
    layout = Layout(
        topic.title.format(A=pair.A, B=pair.B).replace("_", " "),
        [[_sentence(panel, decided) for decided in panel.decided] for panel in panels],
        _legend(everywhere, panels, drawn_in),
    )
    for k, (panel, drawn) in enumerate(zip(panels, drawn_in, strict=True)):
        both = push, whole = layout.panels(k, panel.title, panel.unit.symbol)
        _zoom(push, whole, run, pair)
        for axes in both:
            _draw(axes, panel, drawn, pair)
            fit(axes)
            if math.isfinite(end := run.end_of(pair.B)):
                axes.axvline(end, **_END)
        layout.write(k, [drawn[decided.run.label].colour for decided in panel.decided])
    return layout.figure


def _everywhere(
    reference: LabelledRun, compared: Sequence[LabelledRun]
) -> list[_Drawn]:
    """Return the runs that all panels show, as they are drawn."""
    drawn = [_Drawn(reference, _REFERENCE, DASHES[0], 1.5, 3)]
    published = [one for one in compared if isinstance(one.role, Published)]
    if len(published) <= len(_PUBLISHED):  # more would hide the others
        drawn += [
            _Drawn(one, colour, DASHES[0], 2.6, 1)
            for one, colour in zip(published, _PUBLISHED, strict=False)
        ]
    others = [one for one in compared if not isinstance(one.role, Published)]
    for k, one in enumerate(others):
        dashes = DASHES[1 + k % (len(DASHES) - 1)]
        drawn.append(_Drawn(one, _COMPARED[k % len(_COMPARED)], dashes, 1.4, 2))
    return drawn


def _deciding(panel: Panel, panels: Sequence[Panel]) -> list[LabelledRun]:
    """Return the runs that decide requirements along the same axis, or along none."""
    along = [other for other in panels if other.column is None]
    if panel.column is not None:
        along += [other for other in panels if other.column == panel.column]
    return [decided.run for other in along for decided in other.decided]


def _with_deciding(
    everywhere: Sequence[_Drawn], deciding: Sequence[LabelledRun]
) -> dict[str, _Drawn]:
    """Return runs as they are drawn, by their labels, with those that decide."""
    drawn = {each.one.label: each for each in everywhere}
    new = {one.label: one for one in deciding if one.label not in drawn}
    for k, (label, one) in enumerate(new.items()):
        colour = _DECIDING[k % len(_DECIDING)]
        drawn[label] = _Drawn(one, colour, DASHES[0], 2.0, 4)
    return drawn


def _draw(axes: Axes, panel: Panel, drawn: Mapping[str, _Drawn], pair: Pair) -> None:
    """Draw the curves of runs, the limits, and where runs decide."""
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
        draw_limit(axes, panel, decided)
        mark(axes, panel, decided, curves[label])


def draw_limit(axes: Axes, panel: Panel, decided: Decided) -> None:
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


def mark(axes: Axes, panel: Panel, decided: Decided, curve: Line2D) -> None:
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


def _sentence(panel: Panel, decided: Decided) -> str:
    """Return what is said above a panel of a requirement on it."""
    finding = decided.finding
    limit, unit = limit_words(finding.requirement), panel.unit
    verdict = finding.verdict_on_runs
    if verdict is Verdict.NOT_LOOKED_AT:
        return f"{limit}: {verdict.value}"
    worst = unit.from_si(finding.worst) + 0.0  # of -0, 0
    # Of a share of launches, one that is beyond the limit is no verdict.
    beyond = "beyond it" if finding.requirement.statistical else verdict.value
    broken = "" if verdict is Verdict.MET else f", {beyond}"
    return f"{limit}: {worst:.4g} in {finding.run}{broken}"


def _zoom(push: Axes, whole: Axes, run: Run, pair: Pair) -> None:
    """Show the push in the one panel, and where it is in the other."""
    start, end = run.push_of(pair)
    duration = run.separation.duration
    around = max(_AROUND * (end - start), _LEAST * duration)
    push.set_xlim(max(start - around, 0.0), min(end + around, duration))
    whole.set_xlim(0.0, duration)
    whole.axvspan(*push.get_xlim(), color=_SHADE, zorder=0)
    push.set_facecolor(_SHADE)


def _legend(
    everywhere: Sequence[_Drawn],
    panels: Sequence[Panel],
    drawn_in: Sequence[Mapping[str, _Drawn]],
) -> list[Entry]:
    """Return the entries of the legend: those that decide stand together."""
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
    return [*entries, ("end of separation", [Line2D([], [], **_END)])]
