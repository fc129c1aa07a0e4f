"""Why a worst case may be believed: optimality, local maxima, chance.

None of it proves a global maximum. First-order optimality says that no small change
within the set makes it worse; the other local maxima say how rugged the objective is
and how often the ascent missed; the samples bound what fraction of the set can be
worse.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.special import betaincinv

from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.arrays import Array


_AT_BOUND = 1e-6
"""How near to a bound a parameter is at it, scaled: an ascent ends a little before."""
_AT_EDGE = 1e-6
"""How near to zero a constraint's margin is active."""
SAME = 1e-6
"""Local maxima are one if their values differ by less, as a part of the value; or by no
more than round-off, where the value is zero."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Optimality:
    """First-order conditions (Karush, Kuhn, Tucker) at a point of a set.

    The slope is a sum, with multipliers >= 0, of the outward normals of what is active;
    what is left over, over the slope, is the residual.
    """

    slopes: tuple[float, ...]
    """(n,) of the objective with the scaled parameters: for a whole tolerance each."""
    active: tuple[str, ...]
    """(n,) for each parameter: M at its maximum, m at its minimum, empty between."""
    multipliers: tuple[float, ...]
    """(n,) of the bounds: what the objective would gain for a whole tolerance more."""
    constraints: tuple[tuple[str, float], ...]
    """Active constraints, with their multipliers."""
    residual: float
    """0 at a maximum of first order, 1 where nothing holds the slope; NaN if a run that
    the slope needs failed."""


def optimality(
    tolerances: ToleranceSet, u: Array, slopes: Array, round_off: float = 0.0
) -> Optimality:
    """Return the first-order conditions.

    Args:
        tolerances: the set.
        u: (n,) a scaled point of it.
        slopes: (n,) of the objective with the scaled parameters.
        round_off: of the objective, in SI: a slope no larger is none.
    """
    side = tolerances.box.sides_of(u, _AT_BOUND)
    bounds = np.flatnonzero(side)
    edges = np.flatnonzero(tolerances.margins(u) <= _AT_EDGE)
    outward = np.concatenate([np.diag(side)[bounds], -tolerances.jacobian(u)[edges]]).T
    size = float(np.linalg.norm(slopes))
    unknown = math.isnan(size)
    multipliers = np.full(outward.shape[1], np.nan if unknown else 0.0)
    left = size
    if size > 0.0 and outward.shape[1]:
        multipliers, left = nnls(outward, slopes / size)
        multipliers, left = multipliers * size, left * size
    of_bounds = np.zeros(len(u))
    of_bounds[bounds] = multipliers[: len(bounds)]
    labels = [tolerances.margin_labels[i] for i in edges]
    return Optimality(
        slopes=tuple(slopes.tolist()),
        active=tuple({1: "M", -1: "m", 0: ""}[s] for s in side.tolist()),
        multipliers=tuple(of_bounds.tolist()),
        constraints=tuple(
            zip(labels, multipliers[len(bounds) :].tolist(), strict=True)
        ),
        residual=0.0 if size <= round_off else left / size,
    )


def same(value: float, other: float, round_off: float) -> bool:
    """Return whether a value is another one, which is no smaller, but for errors."""
    return other - value <= max(SAME * abs(other), round_off)


def local_maxima(
    values: Sequence[float], round_off: float = 0.0
) -> tuple[tuple[float, int], ...]:
    """Return the different values that ascents ended at, and how many did.

    Args:
        values: of the ends.
        round_off: of the objective, in SI.

    Returns:
        Each with its count, from the largest.
    """
    found: list[tuple[float, int]] = []
    for value in sorted(values, reverse=True):
        if found and same(value, found[-1][0], round_off):
            found[-1] = found[-1][0], found[-1][1] + 1
        else:
            found.append((value, 1))
    return tuple(found)


def fraction_beyond(beyond: int, samples: int, confidence: float) -> float:
    """Return an upper bound on the fraction of a set that is beyond some value.

    That of Clopper and Pearson, one-sided (doi:10.1093/biomet/26.4.404); with none
    beyond it is 1 - (1 - confidence)^(1 / samples), some 3 / samples at 95 %.

    Args:
        beyond: samples that were.
        samples: drawn uniformly from the set.
        confidence: with which the bound holds.
    """
    if beyond >= samples:
        return 1.0
    return float(betaincinv(beyond + 1, samples - beyond, confidence))
