"""What share of draws is beyond each value of what is required, as curves."""

import math
from dataclasses import dataclass

import numpy as np

from drakesep.analysis.campaigns.statistics import Summary
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.arrays import Array


_POINTS = 2000
"""Of a curve, at most."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """What is drawn of a requirement over the draws of a campaign; in SI."""

    requirement: Requirement
    values: Array
    """(p,) to the worst."""
    shares: Array
    """(p,) of draws that are as bad or worse; runs that failed are."""
    bound_of: float
    """The share of which the bound is told."""
    bound: float
    """NaN: there is none."""
    bound_share: float
    """Of draws that are as bad as the bound or worse."""
    worst_case: float = math.nan
    """That searches have found; NaN, if none was searched."""


def curve_of_rows(values: Array, from_above: bool) -> tuple[Array, Array]:
    """Return values in order, to the worst, and the share of draws as bad or worse.

    Args:
        values: (N,) of all draws; NaN of runs that failed: beyond every value; infinite
            of draws of which no more is known than that they are better than others.
        from_above: whether the larger are the worse.
    """
    told = np.sort(values[~np.isnan(values)])
    told = told if from_above else told[::-1]
    share = (len(values) - np.arange(len(told))) / len(values)
    told, share = told[np.isfinite(told)], share[np.isfinite(told)]
    if len(told) > _POINTS:  # dense where few are left
        steps = np.geomspace(1, len(told), _POINTS).round().astype(int)
        kept = len(told) - np.unique(steps)[::-1]
        told, share = told[kept], share[kept]
    return told, share


def curve_of_summary(summary: Summary, from_above: bool) -> tuple[Array, Array]:
    """Return the same where no rows are kept, at the edges of the histogram.

    Args:
        summary: of all draws.
        from_above: whether the larger are the worse.
    """
    edges, counts = np.array(summary.histogram.edges), summary.histogram.counts
    beyond = np.cumsum(counts[::-1])[-2::-1] if from_above else np.cumsum(counts)[:-1]
    values, told = (edges, beyond) if from_above else (edges[::-1], beyond[::-1])
    first = np.flatnonzero(told == summary.told)[-1:]  # all are beyond it
    start = int(first[0]) if len(first) else 0
    inside = (np.arange(len(told)) >= start) & (told > 0)
    worst = summary.greatest if from_above else summary.least
    last = ([worst], [1]) if summary.told else ([], [])
    shares = (np.append(told[inside], last[1]) + summary.untold) / summary.draws
    return np.append(values[inside], last[0]), shares
