"""How values stand in columns: in units that the names carry."""

import gzip
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.tolerances.box import Dispersion
from drakesep.files import written
from drakesep.units import SI, Unit, unit_of, with_unit


def unit_of_objective(objective: Objective) -> Unit:
    """Return the unit of an objective: of its metric, its own, or SI."""
    metric = objective.shown_as
    if metric is None:
        return SI
    return unit_of(metric.name) if metric.unit is None else Unit("", metric.unit)


def shown(objective: Objective, value: float) -> float:
    """Return the value of an objective as tables show it: its metric, in its unit."""
    metric = objective.shown_as
    in_si = value if metric is None else metric.value(value)
    return unit_of_objective(objective).from_si(in_si)


def tolerance_text(dispersion: Dispersion) -> str:
    """Return a parameter's tolerance in its unit: ``± 2``, or ``-1 +3``."""
    sides, from_si = dispersion.sides, unit_of(dispersion.name).from_si
    if sides.symmetric:
        return f"± {from_si(sides.plus):g}"
    return f"{-from_si(sides.minus):g} {from_si(sides.plus):+g}"


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    """Write a table; its floats are written to read back exactly.

    Args:
        frame: the table.
        path: of the file; compressed if it ends in ``.gz``, the same each time.
    """
    with written(path) as beside:
        if path.suffix == ".gz":
            text = frame.to_csv(index=False).encode()
            beside.write_bytes(gzip.compress(text, compresslevel=_LEVEL, mtime=0))
        else:
            frame.to_csv(beside, index=False)


_LEVEL = 1
"""Of compression: 9 takes ten times as long for a tenth less."""


def read_table(file: str | Path) -> pd.DataFrame:
    """Return a table that `write_csv` has written; floats are read back exactly."""
    return pd.read_csv(file)


def in_units(values: Mapping[str, float]) -> dict[str, float]:
    """Return values by the names that carry their units, in those units."""
    return {
        with_unit(name): unit_of(name).from_si(value) for name, value in values.items()
    }
