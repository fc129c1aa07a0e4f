"""How values stand in columns: in units that the names carry."""

import gzip
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from drakesep.analysis.metrics.objectives import Objective
from drakesep.analysis.tolerances.box import Dispersion
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Lognormal,
    Normal,
    Table,
    Triangular,
    TruncatedNormal,
    Uniform,
    distribution_of,
)
from drakesep.analysis.tolerances.sides import Sides
from drakesep.files import written
from drakesep.units import SI, Unit, unit_of, with_unit


if TYPE_CHECKING:  # half a second, and case files are read without it
    import pandas as pd


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
    return _extent_text(dispersion.sides, unit_of(dispersion.name))


def distribution_text(dispersion: Dispersion) -> str:
    """Return how a parameter is distributed: ``uniform``, ``normal, sigma 2``.

    Of one whose tolerance is not all that there is, also over what.
    """
    one, unit = distribution_of(dispersion.tolerance), unit_of(dispersion.name)
    text = [one.kind.replace("_", " ")]
    if isinstance(one, Normal | TruncatedNormal | Lognormal):
        text.append(f"sigma {unit.from_si(one.sigma):g}")
    if isinstance(one, Uniform | Triangular | TruncatedNormal) and one.within:
        text.append(f"over {_extent_text(Sides.of(one.extent), unit)}")
    if isinstance(one, Table | Discrete):
        text.append(f"{len(one.values)} values")
    return ", ".join(text)


def values_text(dispersion: Dispersion) -> str:
    """Return the values of a table or a discrete distribution, with their weights.

    Empty of others, which have none: ``388 (1), 395 (2)``, by weight or probability.
    """
    one, unit = distribution_of(dispersion.tolerance), unit_of(dispersion.name)
    if not isinstance(one, Table | Discrete):
        return ""
    values = [f"{unit.from_si(x):.10g}" for x in one.values]
    weights = one.weights if isinstance(one, Table) else one.probabilities
    if weights is None:
        return ", ".join(values)
    pairs = zip(values, weights, strict=True)
    return ", ".join(f"{value} ({weight:.6g})" for value, weight in pairs)


def _extent_text(sides: Sides, unit: Unit) -> str:
    if sides.symmetric:
        return f"± {unit.from_si(sides.plus):g}"
    return f"{-unit.from_si(sides.minus):g} {unit.from_si(sides.plus):+g}"


def write_csv(frame: "pd.DataFrame", path: Path) -> None:
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


def read_table(file: str | Path) -> "pd.DataFrame":
    """Return a table that `write_csv` has written; floats are read back exactly."""
    import pandas as pd

    return pd.read_csv(file)


def in_units(values: Mapping[str, float]) -> dict[str, float]:
    """Return values by the names that carry their units, in those units."""
    return {
        with_unit(name): unit_of(name).from_si(value) for name, value in values.items()
    }
