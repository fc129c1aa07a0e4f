"""Charts of a study, as ECharts draws them: iterates, parameters in bounds, draws."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.page.charts import COLOURS, GREY, LIMIT, LINE
from drakesep.tables.table_4 import MARK, MARKS
from drakesep.units import unit_of, with_unit


_OTHERS = "rgba(127,136,146,0.55)"
_TEXT = {"color": GREY, "fontSize": 11}
_AXIS = {
    "type": "value",
    "nameTextStyle": _TEXT,
    "axisLabel": {**_TEXT, "hideOverlap": True},
    "axisLine": {"lineStyle": {"color": GREY}},
    "splitLine": {"lineStyle": {"color": LINE}},
}
_TOOLTIP = {"confine": True, "textStyle": {"fontSize": 11}}

Row = Mapping[str, Any]
"""Of `iterates.csv`."""


def _title(text: str) -> dict[str, Any]:
    style = {"color": GREY, "fontSize": 12, "fontWeight": 500}
    return {"text": text, "textStyle": style, "left": 4, "top": 4}


def iterates_options(rows: Sequence[Row], chosen: Row | None) -> dict[str, Any]:
    """Return the chart of one objective's iterates over the runs that they took.

    Args:
        rows: of the objective.
        chosen: the one that is looked at, ringed if it is one of them.
    """
    ascents: dict[str, list[Row]] = {}
    for row in rows:
        ascents.setdefault(f"{row['search']} {row['start']}", []).append(row)
    unit = rows[0]["unit"] if rows else ""
    series = [
        {
            "id": name,
            "name": name,
            "type": "line",
            "symbol": "circle",
            "symbolSize": 8,
            "data": [[r["evaluations"], r["value"]] for r in each],
            "color": COLOURS[0] if each[0]["search"] == "sqp" else _OTHERS,
            "lineStyle": {"width": 1.5},
        }
        for name, each in ascents.items()
    ]
    ring = [[r["evaluations"], r["value"]] for r in rows if r is chosen]
    series.append(
        {
            "id": "chosen",
            "name": "shown",
            "type": "scatter",
            "symbol": "circle",
            "symbolSize": 15,
            "silent": True,
            "z": 5,
            "itemStyle": {
                "color": "transparent",
                "borderColor": COLOURS[1],
                "borderWidth": 2.5,
            },
            "data": ring,
        }
    )
    return {
        "animation": False,
        "title": _title(f"value ({unit})" if unit else "value"),
        "grid": {"left": 58, "right": 30, "top": 34, "bottom": 40},
        "tooltip": {"trigger": "item", **_TOOLTIP},
        "xAxis": {
            **_AXIS,
            "name": "runs of the ascent",
            "nameLocation": "middle",
            "nameGap": 24,
        },
        "yAxis": {**_AXIS, "scale": True, "splitNumber": 4},
        "series": series,
    }


@dataclass(frozen=True)
class Bounds:
    """Where parameters may be, in their units, by names that carry these."""

    nominal: Mapping[str, float]
    tolerance: Mapping[str, float]
    lower: Mapping[str, float]
    """Scaled, as a point of the box is."""
    upper: Mapping[str, float]

    @classmethod
    def of(cls, case: AnalysisCase) -> "Bounds":
        """Return those of a case."""
        box = case.box
        names = [with_unit(name) for name in box.names]

        def by_name(values: Any, *, in_units: bool = False) -> dict[str, float]:
            each = zip(box.names, values.tolist(), strict=True)
            told = [unit_of(n).from_si(x) if in_units else x for n, x in each]
            return dict(zip(names, told, strict=True))

        return cls(
            nominal=by_name(box.nominal, in_units=True),
            tolerance=by_name(box.tolerance, in_units=True),
            lower=by_name(box.lower),
            upper=by_name(box.upper),
        )

    def scaled(self, name: str, value: float) -> float:
        """Return where a value is, from -1 to 1."""
        return (value - self.nominal[name]) / self.tolerance[name]

    def mark(self, name: str, value: float) -> str:
        """Return M at the upper bound, m at the lower, and else nothing."""
        u = self.scaled(name, value)
        if abs(u - self.upper[name]) <= MARK:
            return MARKS[1]
        return MARKS[-1] if abs(u - self.lower[name]) <= MARK else ""


def bounds_options(bounds: Bounds, row: Row | None) -> dict[str, Any]:
    """Return the chart of an iterate's parameters in their bounds.

    Args:
        bounds: of the parameters.
        row: the iterate; None: there is none yet.
    """
    names = [*bounds.nominal]
    values = [float(bounds.nominal[n] if row is None else row[n]) for n in names]
    data = [
        {
            "value": round(bounds.scaled(n, x), 6),
            "label": {
                "show": True,
                "position": "right" if bounds.scaled(n, x) >= 0.0 else "left",
                "formatter": f"{bounds.mark(n, x)}  {x:.6g}".strip(),
                "color": GREY,
                "fontSize": 10,
            },
            "itemStyle": {"color": COLOURS[1] if bounds.mark(n, x) else COLOURS[0]},
        }
        for n, x in zip(names, values, strict=True)
    ]
    return {
        "animation": False,
        "title": _title("parameters in their tolerances: m, nominal, M"),
        "grid": {"left": 190, "right": 66, "top": 32, "bottom": 22},
        "tooltip": {"trigger": "axis", **_TOOLTIP},
        "xAxis": {
            **_AXIS,
            "min": -2.0,
            "max": 1.6,
            "interval": 10,
            "axisLabel": {"show": False},
            "splitLine": {"show": False},
        },
        "yAxis": {
            **_AXIS,
            "type": "category",
            "inverse": True,
            "data": names,
            "axisTick": {"show": False},
            "axisLabel": {**_TEXT, "interval": 0, "fontSize": 10.5},
            "splitLine": {"show": False},
        },
        "series": [
            {
                "id": "u",
                "type": "bar",
                "barWidth": "60%",
                "data": data,
                "markLine": {
                    "silent": True,
                    "symbol": "none",
                    "label": {"show": False},
                    "lineStyle": {"color": LINE, "type": "solid"},
                    "data": [{"xAxis": x} for x in (-1, 0, 1)],
                },
            }
        ],
    }


def histogram_options(told: Row) -> dict[str, Any]:
    """Return the histogram of what a requirement limits, with its limit.

    Args:
        told: what the draws show of it so far.
    """
    edges, counts = told["edges"], told["counts"]
    middles = [(a + b) / 2.0 for a, b in itertools.pairwise(edges)]
    bars = [[x, n] for x, n in zip(middles, counts, strict=True)]
    name = " ".join(filter(None, (told["requirement"], told["axis"])))
    return {
        "animation": False,
        "title": _title(f"{name} ({told['unit']})"),
        "grid": {"left": 48, "right": 24, "top": 34, "bottom": 26},
        "tooltip": {"trigger": "axis", **_TOOLTIP},
        "xAxis": {
            **_AXIS,
            "scale": True,
            "min": min([*edges[:1], told["limit"]]),
            "max": max([*edges[-1:], told["limit"]]),
        },
        "yAxis": {**_AXIS, "splitNumber": 3},
        "series": [
            {
                "type": "bar",
                "data": bars,
                "barWidth": "96%" if len(bars) < 2 else None,
                "barMinWidth": 2,
                "color": COLOURS[0],
                "markLine": {
                    "silent": True,
                    "symbol": "none",
                    "label": {"show": False},
                    "lineStyle": {"color": LIMIT, "type": "dashed", "width": 1.6},
                    "data": [{"xAxis": told["limit"]}],
                },
            }
        ],
    }


def shares_options(draws: Sequence[Row]) -> dict[str, Any]:
    """Return what share of launches is shown of each requirement, over draws.

    As the share beyond the limit at most, of which less is better, on logarithmic axes.

    Args:
        draws: what was told each time.
    """
    names: dict[str, list[list[float]]] = {}
    required: dict[float, None] = {}
    for each in draws:
        for told in each["requirements"]:
            key = ("requirement", "axis", "sense")
            name = " ".join(filter(None, (str(told[k]) for k in key)))
            at = [each["draws"], max(1.0 - told["share_shown"], 1e-12)]
            names.setdefault(name, []).append(at)
            required[1.0 - told["share"]] = None
    series: list[dict[str, Any]] = [
        {
            "name": name,
            "type": "line",
            "showSymbol": len(data) < 3,
            "data": data,
            "color": COLOURS[i % len(COLOURS)],
        }
        for i, (name, data) in enumerate(names.items())
    ]
    if series:
        series[0]["markLine"] = {
            "silent": True,
            "symbol": "none",
            "label": {"formatter": "required", "position": "insideEndTop", **_TEXT},
            "lineStyle": {"color": LIMIT, "type": "dashed", "width": 1.6},
            "data": [{"yAxis": y} for y in required],
        }
    return {
        "animation": False,
        "title": _title("share of launches beyond the limit, at most"),
        "grid": {"left": 64, "right": 30, "top": 34, "bottom": 40},
        "tooltip": {"trigger": "axis", **_TOOLTIP},
        "xAxis": {
            **_AXIS,
            "type": "log",
            "name": "draws",
            "nameLocation": "middle",
            "nameGap": 24,
        },
        "yAxis": {**_AXIS, "type": "log"},
        "series": series,
    }
