"""The worst cases in the form of the paper's Table 4."""

import itertools
from collections.abc import Mapping, Sequence

import pandas as pd

from drakesep.analysis.metrics.registry import WITHIN
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.model.parameter_table import XYZ
from drakesep.systems.model.parameters import ParameterName, parameters
from drakesep.tables.labelled_run import LabelledRun
from drakesep.units import unit_of


MARK = 5e-3
"""How near to a bound or to the nominal a value is marked as M, m or Nom, as a part
of its tolerance."""
MARKS = {1: "M", -1: "m"}
"""Of the upper bound, and of the lower."""


def table_4(runs: Sequence[LabelledRun], box: ToleranceBox) -> pd.DataFrame:
    """Return the worst cases in the form of the paper's Table 4.

    Conditions after separation, then M (maximum), m (minimum), Nom (nominal) or the
    value of each property. A published run has what was printed in parentheses.

    Args:
        runs: the nominal run, then the worst cases.
        box: the tolerances.
    """
    groups = _groups(box)
    columns = {}
    for one in runs:
        printed = one.published and one.published.printed
        cells = _conditions(one)
        if printed:
            in_si = (
                *printed.rate,
                printed.deviation_within_limits_until,
                printed.longitudinal_speed,
            )
            numbers = [
                unit_of(name).from_si(value)
                for name, value in zip(_CONDITIONS, in_si, strict=True)
            ]
            cells = [
                f"{cell} ({number:g})"
                for cell, number in zip(cells, numbers, strict=True)
            ]
        values = parameters(one.run.separation)
        for names in groups.values():
            cells.append(_marks({name: values[name] for name in names}, box))
        if printed:
            cells.append(f"({printed.iterations})")
        else:
            cells.append("-" if one.iterations is None else str(one.iterations))
        columns[one.label] = cells
    labels = [
        *(f"rate {axis} (deg/s)" for axis in XYZ),
        "deviation within limits until (s)",
        "longitudinal speed, max (m/s)",
        *groups,
        "solver iterations",
    ]
    return pd.DataFrame({"condition or property": labels, **columns})


_CONDITIONS = (
    *(f"final_rate_{axis}" for axis in XYZ),
    WITHIN,
    "longitudinal_speed_max",
)
"""Metrics after separation, in the order of the table."""


def _conditions(one: LabelledRun) -> list[str]:
    metrics = one.metrics
    return [
        f"{unit_of(name).from_si(metrics[name]):.2f}" if metrics else "failed"
        for name in _CONDITIONS
    ]


def _groups(box: ToleranceBox) -> dict[str, list[str]]:
    def key(name: str) -> tuple[str, str]:
        owner, stem, axis = ParameterName.of(name)
        if stem == "inertia":
            stem += " moments" if axis[0] == axis[1] else " products"
        # Axes of one owner stand together, and so do owners without axes.
        return stem, owner if axis else ""

    def label(stem: str, names: list[str]) -> str:
        parts = [ParameterName.of(name) for name in names]
        owners = list(dict.fromkeys(part.owner for part in parts))
        axes = [part.axis for part in parts]
        first, last = owners[0], owners[-1]
        owner = first if first == last else f"{first} ... {last}"
        return " ".join(
            filter(None, [owner, stem, *axes, f"({unit_of(names[0]).symbol})"])
        ).replace("_", " ")

    groups = {}
    for (stem, _), group in itertools.groupby(box.names, key):
        names = list(group)
        groups[label(stem, names)] = names
    return groups


def _marks(values: Mapping[str, float], box: ToleranceBox) -> str:
    u = box.scaled(values)
    sides = box.sides_of(u, MARK)
    marks = []
    for name, value in values.items():
        i = box.names.index(name)
        if abs(u[i]) <= MARK:
            marks.append("Nom")
        else:
            shown = f"{unit_of(name).from_si(value):.6g}"
            marks.append(MARKS.get(int(sides[i])) or shown)
    return " ".join(marks)
