"""Points that are spread more evenly than draws: for means and sensitivities alone.

They are not independent of each other, as the order statistics behind a verdict need
it.
"""

from typing import Literal, TypeAlias, get_args

import numpy as np
from scipy.stats import qmc

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.draws import DESIGN, Drawn, Draws
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


DesignName: TypeAlias = Literal["sobol", "lhs"]
"""Scrambled Sobol' points (Owen), or a Latin hypercube."""

_BITS = 52
"""Of a Sobol' point."""
_EDGE = 2.0**-53
"""How near to 0 and 1 a point may come."""


@typed
def design_points(design: DesignName, count: int, dimensions: int, seed: int) -> Array:
    """Return points (count, dimensions) of the unit cube, 0 and 1 left out.

    Args:
        design: by which they are spread.
        count: of the points; of Sobol' points best a power of 2.
        dimensions: of the cube.
        seed: of the scrambling, or of the hypercube; 0 or more.

    Raises:
        ValueError: the design is unknown, or a number is too small or too large.
    """
    if design not in get_args(DesignName):
        raise InputError(
            f"design must be one of {', '.join(get_args(DesignName))}, got {design!r}"
        )
    for name, value, least in (("count", count, 1), ("seed", seed, 0)):
        if value < least:
            raise InputError(f"{name} must be >= {least}, got {value}")
    if dimensions == 0:
        return np.zeros((count, 0))
    if design == "lhs":
        points = qmc.LatinHypercube(dimensions, rng=seed).random(count)
    else:
        most = qmc.Sobol.MAXDIM
        if dimensions > most:
            raise InputError(
                f"sobol: needs at most {most} parameters, got {dimensions}"
            )
        sobol = qmc.Sobol(dimensions, scramble=True, bits=_BITS, rng=seed)
        points = sobol.random_base2((count - 1).bit_length())[:count]
    return np.asarray(np.clip(points, _EDGE, 1.0 - _EDGE))


@typed
def designed(case: AnalysisCase, design: DesignName, count: int, seed: int) -> Drawn:
    """Return points of a design as a campaign's rows, in which nothing fails.

    Those that cannot be are left out: there may be fewer than were asked for.

    Args:
        case: with distributions and correlations.
        design: by which the points are spread.
        count: of the points; of Sobol' points best a power of 2.
        seed: 0 or more.

    Returns:
        Rows that are not independent, with their places in the design.

    Raises:
        ValueError: the design is unknown, or a number is too small or too large.
    """
    names = case.tolerance_set.names
    points = design_points(design, count, len(names), seed)
    rows = case.joint_distribution.values(points)
    kept = np.flatnonzero(Draws(case, seed).can_be(rows))
    return Drawn(
        indices=kept,
        values=rows[kept],
        failure=np.full(len(kept), DESIGN),
        attempts=np.zeros(len(kept), dtype=np.int64),
        independent=False,
    )
