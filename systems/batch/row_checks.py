"""Which rows of parameter values are not physical, and why."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.arrays import Array
from drakesep.systems.model.inertia import ENTRIES, physical_margin
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.separation import Separation
from drakesep.systems.model.springs import Spring


_POSITIVE = ("mass", "force_max", "stroke", "design_mass", "release_angle")
_NOT_NEGATIVE = ("damping", "release_time", "start")
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
    for name, column in zip(names, values.T, strict=True):
        quantity = name.rpartition(".")[2]
        if quantity in _POSITIVE:
            doubtful |= column <= 0.0
        if quantity in _NOT_NEGATIVE:
            doubtful |= column < 0.0
        if quantity in ("release_time", "start"):
            doubtful |= column >= separation.duration - _latest_start(separation)
        if quantity in ("tilt_y", "tilt_z"):
            doubtful |= np.abs(column) >= 0.5 * math.pi
        if quantity == "release_angle":
            doubtful |= column >= math.pi
    doubtful |= _edge_of_inertia(separation, names, values)
    doubtful |= _late_stroke(separation, names, values)
    failures = {}
    for row in np.flatnonzero(doubtful).tolist():
        try:
            with_values(separation, dict(zip(names, values[row].tolist(), strict=True)))
        except ValueError as error:
            failures[row] = str(error)
    return failures


def _latest_start(separation: Separation) -> float:
    return max((load.times[0] for load in separation.loads), default=0.0)


def _late_stroke(
    separation: Separation, names: Sequence[str], values: Array
) -> NDArray[np.bool_]:
    """Return (n,) whether a spring driven by time may push beyond the run."""
    doubtful = np.full(len(values), False)
    columns = dict(zip(names, values.T, strict=True))
    of = {**parameters(separation), **columns}
    for a in separation.attachments:
        if isinstance(a.spring, Spring) and math.isfinite(a.release_time):
            name = a.spring.name
            force = np.asarray(of[f"{name}.force_max"])
            inertia = of[f"{name}.design_mass"] * np.asarray(of[f"{name}.stroke"])
            ratio = np.divide(
                inertia, force, out=np.zeros(len(values)), where=force > 0
            )
            push = 0.5 * math.pi * np.sqrt(np.maximum(ratio, 0.0))  # Eq. 5
            end = of[f"{a.name}.release_time"] + push
            doubtful |= end >= (1.0 - _MARGIN) * separation.duration
    return doubtful


def _edge_of_inertia(
    separation: Separation, names: Sequence[str], values: Array
) -> NDArray[np.bool_]:
    """Return (n,) whether an inertia is impossible, or nearly so."""
    doubtful = np.full(len(values), False)
    nominal = parameters(separation)
    for body in separation.bodies:
        keys = [f"{body.name}.inertia_{entry}" for entry in ENTRIES]
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
