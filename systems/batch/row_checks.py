"""Which rows of parameter values are not physical, and why."""

import math
from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.arrays import Array
from drakesep.systems.checks import check_finite
from drakesep.systems.equations.pushers import values_of
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.inertia import physical_margin
from drakesep.systems.model.parameters import (
    declarations,
    names_of,
    parameters,
    with_values,
)
from drakesep.systems.model.separation import Separation


_MARGIN = 1e-9
"""Relative: what is nearer to its edge is looked at closely."""


def check_rows(
    separation: Separation, names: Sequence[str], values: Array
) -> dict[int, str]:
    """Return why rows are not physical, by their numbers.

    What a row may hold is said once, in the model: this only finds, at the speed of
    arrays, the rows that may not pass, and lets the model judge them.

    Args:
        separation: whose parameters they are.
        names: (n_p,) of the parameters.
        values: (n, n_p) in SI.
    """
    doubtful = ~np.isfinite(values).all(axis=1)
    declared = declarations(separation)
    for name, column in zip(names, values.T, strict=True):
        doubtful |= ~declared[name].holds(column)
        if declared[name].kind == "time":
            doubtful |= column >= separation.duration - _latest_start(separation)
    doubtful |= _edge_of_inertia(separation, names, values)
    doubtful |= _late_stroke(separation, names, values)
    failures = {}
    for row in np.flatnonzero(doubtful).tolist():
        try:
            with_values(separation, dict(zip(names, values[row].tolist(), strict=True)))
            check_finite(f"row {row} of a batch", *values[row].tolist())
        except ValueError as error:
            failures[row] = str(error)
    return failures


def _latest_start(separation: Separation) -> float:
    return max((load.times[0] for load in separation.loads), default=0.0)


def _late_stroke(
    separation: Separation, names: Sequence[str], values: Array
) -> NDArray[np.bool_]:
    """Return (n,) whether a spring that pushes for a time may do so beyond the run."""
    doubtful = np.full(len(values), False)
    of = {**parameters(separation), **dict(zip(names, values.T, strict=True))}
    for attachment, spring in separation.pushing:
        law = law_of(spring)
        if law.by_time and math.isfinite(attachment.release_time):
            p = SimpleNamespace()
            for field in values_of(law, spring)._fields:
                entries = [of[name] for name in names_of([spring], [field])]
                setattr(p, field, entries if len(entries) > 1 else entries[0])
            [release] = names_of([attachment], ["release_time"])
            # What is out of its range has been found, and makes no number here.
            with np.errstate(all="ignore"):
                end = of[release] + law.end(p, np)
                doubtful |= end >= (1.0 - _MARGIN) * separation.duration
    return doubtful


def _edge_of_inertia(
    separation: Separation, names: Sequence[str], values: Array
) -> NDArray[np.bool_]:
    """Return (n,) whether an inertia is impossible, or nearly so."""
    doubtful = np.full(len(values), False)
    nominal = parameters(separation)
    for body in separation.bodies:
        keys = names_of([body], ["I_BBcm_B"])
        if not any(key in names for key in keys):
            continue
        inertia = np.stack(
            [
                values[:, names.index(key)]
                if key in names
                else np.full(len(values), nominal[key])
                for key in keys
            ],
            axis=1,
        )
        finite = np.isfinite(inertia).all(axis=1)
        trace = 0.5 * inertia[finite, :3].sum(axis=1)
        margin = physical_margin(inertia[finite])
        doubtful[finite] |= ~(margin > _MARGIN * np.abs(trace))
    return doubtful
