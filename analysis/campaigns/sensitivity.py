"""What parameters a metric depends on: rank correlations, and Sobol' indices."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from scipy.special import ndtri, stdtrit
from scipy.stats import rankdata, uniform
from scipy.stats import sobol_indices as indices_of_scipy

from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_share


Metrics: TypeAlias = Callable[[Array], Array]
"""Of values (N, n) of n parameters, m metrics (N, m) of each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RankCorrelations:
    """Spearman's rank correlations of parameters with metrics.

    1 where a metric grows whenever the parameter does, -1 where it falls; NaN where one
    of them does not vary among the draws that tell.
    """

    value: Array
    """(n, m) of n parameters with m metrics."""
    low: Array
    """(n, m) where the interval begins."""
    high: Array
    """(n, m) where it ends."""


@typed
def rank_correlations(
    values: Array, metrics: Array, confidence: float = 0.95
) -> RankCorrelations:
    """Return the rank correlation of each parameter with each metric.

    The interval is Fisher's, with the variance of Bonett and Wright, Psychometrika 65,
    2000, doi:10.1007/BF02294183.

    Args:
        values: (N, n) of parameters, of each draw.
        metrics: (N, m) of each draw; those that do not tell a metric, NaN, are left out
            of it.
        confidence: of the intervals.

    Raises:
        ValueError: there is not a row of each for every draw.
    """
    check_share("confidence", confidence)
    values, metrics = np.asarray(values, float), np.asarray(metrics, float)
    if values.ndim != 2 or metrics.ndim != 2 or len(values) != len(metrics):
        raise InputError(
            "values and metrics must be (N, n) and (N, m), got "
            f"{values.shape} and {metrics.shape}"
        )
    rho = np.full((values.shape[1], metrics.shape[1]), math.nan)
    half = np.full(rho.shape, math.inf)
    of_all = _standard_ranks(values)
    for j, metric in enumerate(metrics.T):
        told = ~np.isnan(metric)
        ranks = of_all if told.all() else _standard_ranks(values[told])
        count = int(told.sum())
        if count:
            rho[:, j] = ranks.T @ _standard_ranks(metric[told, None])[:, 0]
        if count > 3:
            variance = (1.0 + rho[:, j] ** 2 / 2.0) / (count - 3)
            half[:, j] = ndtri((1.0 + confidence) / 2.0) * np.sqrt(variance)
    rho = np.clip(rho, -1.0, 1.0)
    with np.errstate(divide="ignore"):  # of a perfect correlation: infinite
        z = np.arctanh(rho)
    return RankCorrelations(value=rho, low=np.tanh(z - half), high=np.tanh(z + half))


def _standard_ranks(columns: Array) -> Array:
    """Return ranks of columns (N, n), about their mean and of length 1.

    NaN of a column that does not vary.
    """
    ranks = rankdata(columns, axis=0) - (len(columns) + 1) / 2.0
    lengths = np.linalg.norm(ranks, axis=0)
    standard: Array = np.full(ranks.shape, math.nan)
    np.divide(ranks, lengths, out=standard, where=lengths > 0.0)
    return standard


@dataclass(frozen=True, slots=True, kw_only=True)
class SobolIndices:
    """What shares of the variance of metrics come from parameters.

    0 of a metric that does not vary.
    """

    first: Array
    """(n, m) of each of n parameters alone, of each of m metrics."""
    first_error: Array
    """(n, m) half the width of its interval."""
    total: Array
    """(n, m) with all in which it has a part together with others."""
    total_error: Array
    """(n, m) half the width of its interval."""
    runs: int
    """That it took."""


@typed
def sobol_indices(
    metrics: Metrics,
    quantiles: Metrics,
    parameters: int,
    *,
    base: int = 2**9,
    replicates: int = 10,
    confidence: float = 0.95,
    seed: int = 0,
    dependences: Sequence[str] = (),
) -> SobolIndices:
    """Return Sobol' indices of independent parameters.

    By scipy's `sobol_indices`, after Saltelli et al. (2010),
    doi:10.1016/j.cpc.2009.09.018, with points of Sobol' that are scrambled anew for
    each replicate; intervals are Student's, of what replicates differ by.

    Args:
        metrics: (N, m) of parameter values (N, n).
        quantiles: (N, n) parameter values of probabilities (N, n): each parameter's
            inverse distribution, of its own column alone.
        parameters: n, two or more: all comes from one alone.
        base: points of a replicate, a power of two.
        replicates: how many, two or more: it takes replicates base (n + 2) runs.
        confidence: of the intervals.
        seed: of the points.
        dependences: what makes parameters depend on each other, in words, such as
            ``the rank correlation of a and b``.

    Raises:
        ValueError: parameters depend on each other, so that the variance has no shares;
            a metric is not finite; the base is no power of two, or there is but one
            parameter or replicate.
    """
    check_sobol(
        parameters,
        base=base,
        replicates=replicates,
        confidence=confidence,
        dependences=dependences,
    )
    found = [
        indices_of_scipy(
            func=partial(_of_columns, metrics, quantiles),
            n=base,
            dists=[uniform()] * parameters,
            rng=np.random.Generator(np.random.Philox(each)),
        )
        for each in np.random.SeedSequence(seed).spawn(replicates)
    ]
    times = stdtrit(replicates - 1, (1.0 + confidence) / 2.0) / math.sqrt(replicates)

    def together(each: list[Array]) -> tuple[Array, Array]:
        # scipy leaves out an axis of length 1.
        of_replicates = np.array(each).reshape(replicates, -1, parameters)
        mean, deviation = of_replicates.mean(axis=0), of_replicates.std(axis=0, ddof=1)
        return mean.T, times * deviation.T

    first, first_error = together([one.first_order for one in found])
    total, total_error = together([one.total_order for one in found])
    return SobolIndices(
        first=first,
        first_error=first_error,
        total=total,
        total_error=total_error,
        runs=runs_of_sobol(parameters, base, replicates),
    )


def runs_of_sobol(parameters: int, base: int, replicates: int) -> int:
    """Return how many runs indices take; arguments as of `sobol_indices`."""
    return replicates * base * (parameters + 2)


def check_sobol(
    parameters: int,
    *,
    base: int,
    replicates: int,
    confidence: float,
    dependences: Sequence[str],
) -> None:
    """Raise InputError unless `sobol_indices` can tell something of its arguments."""
    check_share("confidence", confidence)
    if dependences:
        raise InputError(
            "Sobol' indices must be of independent parameters, so that shares of the "
            f"variance add up, got {'; '.join(dependences)}: see rank correlations"
        )
    if parameters < 2:
        raise InputError(f"parameters must be >= 2, got {parameters}")
    if base < 2 or base & (base - 1):
        raise InputError(f"base must be a power of two, got {base}")
    if replicates < 2:
        raise InputError(f"replicates must be >= 2, got {replicates}")


def _of_columns(metrics: Metrics, quantiles: Metrics, probabilities: Array) -> Array:
    """Return metrics (m, N) of probabilities (n, N), as scipy has them."""
    found = np.asarray(metrics(quantiles(probabilities.T)), float)
    wrong = int((~np.isfinite(found)).any(axis=1).sum())
    if wrong:
        raise InputError(
            f"metrics must be finite, got {wrong} of {len(found)} runs that are not"
        )
    return np.array(found.T)
