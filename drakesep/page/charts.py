"""Charts of a run over time, as ECharts draws them: its options, and what changes.

Greys are such that they are read on a light and on a dark ground. The nominal is drawn
dashed, limits in red while they hold.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:  # imports Drake
    from drakesep.page.flown import Flown, Limit, Signal


COLOURS = ("#2b8cd6", "#e08a00", "#1fa67a", "#b06ad4")
"""Of the axes x, y and z, and of what has more."""
_FIRST = (("rate", "deg/s"), ("angle", "deg"), ("relative velocity", "m/s"))
GREY, LINE, LIMIT = "#7d8892", "rgba(127,136,146,0.25)", "#d33c3c"
"""Of words and axes, of lines of the ground, of limits."""
_SEEN = 0.2
"""Of a limit, from which on a curve goes to its side."""
_MOST_POINTS = 400
"""Of a curve: more are not seen."""


@dataclass(frozen=True)
class Chart:
    """What one chart shows: a quantity of a body, by its axes."""

    body: str
    quantity: str
    unit: str
    axes: tuple[str, ...]

    @property
    def title(self) -> str:
        """What it shows, with the unit."""
        return f"{self.quantity} ({self.unit})"


def charts_of(flown: "Flown", body: str) -> list[Chart]:
    """Return the charts of a body that leaves.

    Args:
        flown: a run that has been flown.
        body: whose.
    """
    axes: dict[tuple[str, str], list[str]] = {(q, u): [] for q, u in _FIRST}
    for signal in flown.signals:
        if signal.body == body:
            axes.setdefault((signal.quantity, signal.unit), []).append(signal.axis)
    return [Chart(body, q, unit, tuple(a)) for (q, unit), a in axes.items() if a]


def options(chart: Chart, flown: "Flown") -> dict[str, Any]:
    """Return the options of a chart.

    Args:
        chart: what it shows.
        flown: the nominal run, which stands for the first that is shown, too.
    """
    axis = {
        "nameTextStyle": {"color": GREY, "fontSize": 11},
        "axisLabel": {"color": GREY, "fontSize": 11, "hideOverlap": True},
        "axisLine": {"lineStyle": {"color": GREY}},
        "splitLine": {"lineStyle": {"color": LINE}},
    }
    x = {
        "type": "value",
        "min": 0.0,
        "max": float(flown.times[chart.body][-1]),
        "name": "s",
        "nameGap": 6,
    }
    return {
        "animation": False,
        "grid": {"left": 48, "right": 22, "top": 34, "bottom": 24},
        "title": {
            "text": chart.title,
            "textStyle": {"color": GREY, "fontSize": 12, "fontWeight": 500},
            "left": 4,
            "top": 4,
        },
        "legend": {
            "data": [_named(axis) for axis in chart.axes]
            if len(chart.axes) > 1
            else [],
            "textStyle": {"color": GREY, "fontSize": 11},
            "right": 16,
            "top": 2,
            "itemWidth": 14,
            "itemHeight": 8,
            "icon": "roundRect",
        },
        "tooltip": {"trigger": "axis", "confine": True, "textStyle": {"fontSize": 11}},
        "xAxis": {**axis, **x},
        "yAxis": {**axis, "type": "value", "scale": True, "splitNumber": 4},
        "series": [*_series(chart, flown)],
    }


def nominal_data(chart: Chart, flown: "Flown") -> list[dict[str, Any]]:
    """Return what changes in a chart with the nominal run."""
    return [
        {"id": f"nominal {s.axis}", "data": _points(flown, s)}
        for s in _signals(chart, flown)
    ]


def run_data(chart: Chart, flown: "Flown") -> list[dict[str, Any]]:
    """Return what changes in a chart with each run: its curves, and limits."""
    changes: list[dict[str, Any]] = []
    for s in _signals(chart, flown):
        changes.append({"id": f"run {s.axis}", "data": _points(flown, s)})
        for i, limit in enumerate(s.limits):
            changes.append({"id": f"limit {s.axis} {i}", "data": _line(limit, s)})
    return changes


def _series(chart: Chart, flown: "Flown") -> Iterator[dict[str, Any]]:
    """Yield the curves of a chart, and its limits, with the nominal run's data."""
    for i, s in enumerate(_signals(chart, flown)):
        curve = {"type": "line", "showSymbol": False, "data": _points(flown, s)}
        quiet = {"silent": True, "tooltip": {"show": False}}
        yield {
            **curve,
            **quiet,
            "id": f"nominal {s.axis}",
            "lineStyle": {"width": 1.3, "type": [5, 4], "opacity": 0.8},
            "color": GREY,
        }
        yield {
            **curve,
            "id": f"run {s.axis}",
            "name": _named(s.axis),
            "lineStyle": {"width": 1.8},
            "color": COLOURS[i % len(COLOURS)],
        }
        for k, limit in enumerate(s.limits):
            yield {
                **curve,
                **quiet,
                "id": f"limit {s.axis} {k}",
                "data": _line(limit, s),
                "lineStyle": {"width": 1.4, "type": [7, 4]},
                "color": LIMIT,
                "z": 1,
            }


def _line(limit: "Limit", signal: "Signal") -> list[list[float] | None]:
    """Return the line of a limit while it holds.

    That of a magnitude has two sides: the other is drawn where the curve is there.
    """
    first, *other = limit.values
    line: list[list[float] | None] = [[limit.start, first], [limit.end, first]]
    if other and float(signal.values.min()) < _SEEN * other[0]:
        line += [None, [limit.start, other[0]], [limit.end, other[0]]]
    return line


def _signals(chart: Chart, flown: "Flown") -> Iterable["Signal"]:
    return (
        s
        for s in flown.signals
        if (s.body, s.quantity, s.unit) == (chart.body, chart.quantity, chart.unit)
    )


def _named(axis: str) -> str:
    return axis or "this run"


def _points(flown: "Flown", signal: "Signal") -> list[list[float]]:
    times = flown.times[signal.body]
    every = max(1, len(times) // _MOST_POINTS)
    kept = [*range(0, len(times), every)]
    if kept and kept[-1] != len(times) - 1:
        kept.append(len(times) - 1)
    return [
        [round(t, 5), float(f"{y:.6g}")]
        for t, y in zip(times[kept].tolist(), signal.values[kept].tolist(), strict=True)
    ]
