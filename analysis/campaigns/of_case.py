"""Sobol' indices and far probabilities of a case, over the distributions it states."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.campaigns.sensitivity import (
    Metrics,
    SobolIndices,
    sobol_indices,
)
from drakesep.analysis.campaigns.subset_simulation import (
    RareProbability,
    Values,
    subset_simulation,
)
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array


_LOOKED_AT = 10_000
"""Draws among which one that cannot be is looked for."""


def dependences(case: AnalysisCase) -> list[str]:
    """Return what makes the dispersed parameters of a case depend on each other.

    In words; none, if nothing does.

    Args:
        case: with distributions.
    """
    of_ranks = [f"the rank {one.label}" for one in case.correlations]
    together = [f"the ellipsoid of {', '.join(e.names)}" for e in case.ellipsoids]
    again = Draws(case, 0).at(np.arange(_LOOKED_AT)).share_impossible
    if again:
        together.append(f"values that cannot be, {again:.2%}, which are drawn again")
    return of_ranks + together


@typed
def sobol_indices_of(
    case: AnalysisCase, metrics: Metrics, **settings: Any
) -> SobolIndices:
    """Return Sobol' indices of the dispersed parameters of a case.

    Of launches in which nothing fails.

    Args:
        case: whose parameters are independent.
        metrics: (N, m) of values (N, n) of the dispersed parameters, in SI.
        settings: of `sobol_indices`.

    Raises:
        ValueError: parameters depend on each other, and how; or as of `sobol_indices`.
    """
    joint = case.joint_distribution
    depends = dependences(case)
    return sobol_indices(
        metrics, joint.values, len(joint.names), dependences=depends, **settings
    )


@typed
def probability_beyond(
    case: AnalysisCase, values: Values, limit: float, **settings: Any
) -> RareProbability:
    """Return the probability that a value is beyond a limit, by subset simulation.

    Of launches in which nothing fails.

    Args:
        case: with distributions, correlated or not.
        values: (N,) of values (N, n) of the dispersed parameters, in SI; the larger the
            worse.
        limit: beyond which a value is.
        settings: of `subset_simulation`.

    Raises:
        ValueError: as of `subset_simulation`.
    """
    joint, draws = case.joint_distribution, Draws(case, 0)

    def of_normals(points: Array) -> Array:
        return values(joint.of_normals(points))

    def admits(points: Array) -> NDArray[np.bool_]:
        return draws.can_be(joint.of_normals(points))

    return subset_simulation(
        of_normals, len(joint.names), limit, admits=admits, **settings
    )
