"""What the draws of a campaign say of a metric: mean, deviation, quantiles, histogram.

A summary of some draws is of fixed size however many they are; summaries of parts of a
campaign make that of the whole, to the bit, in whatever order they are put together.
Quantiles are order statistics, their intervals free of any distribution.
"""

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from scipy.special import ndtri

from drakesep.analysis.campaigns.exact_sums import (
    exact_sum,
    exact_sum_of_squares,
    in_units,
)
from drakesep.analysis.campaigns.order_statistics import failures_allowed
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_finite, check_share


_ROUND_OFF = 1e-15
"""Relative: 7 % of 100 draws are 7, though the product of floats is a little more."""


class Estimate(NamedTuple):
    """A number with the interval that has the true one, at some confidence."""

    value: float
    low: float
    high: float


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Histogram:
    """How many draws lie between edges that were fixed before any was flown.

    Raises:
        ValueError: edges do not rise, or counts do not fit them.
    """

    edges: tuple[float, ...]
    """(B + 1,) in the unit of what is counted."""
    counts: tuple[int, ...]
    """(B + 2,) below the first edge; from each to below the next; from the last on."""

    def __post_init__(self) -> None:
        """Check edges and counts."""
        check_finite("edges", *self.edges)
        if len(self.edges) < 2 or any(
            a >= b for a, b in itertools.pairwise(self.edges)
        ):
            raise InputError(f"edges must rise, two or more, got {self.edges}")
        if len(self.counts) != len(self.edges) + 1 or any(n < 0 for n in self.counts):
            raise InputError(
                f"counts must be {len(self.edges) + 1} and >= 0, got {self.counts}"
            )

    @classmethod
    def of(cls, values: Array, edges: Sequence[float]) -> Self:
        """Count values (N,); those that are NaN are not."""
        ordered = np.sort(values[~np.isnan(values)])
        # Edges are few: to look these up takes less than to look up every value.
        below = np.searchsorted(ordered, np.asarray(edges, float), side="left")
        counts = np.diff([0, *below, len(ordered)])
        return cls(edges=tuple(map(float, edges)), counts=tuple(counts.tolist()))

    @classmethod
    def merged(cls, parts: Iterable[Self]) -> Self:
        """Return the histogram of parts of a campaign together: of the same edges."""
        parts = list(parts)
        if len({part.edges for part in parts}) != 1:
            raise InputError("histograms must have the same edges")
        counts = [sum(each) for each in zip(*(p.counts for p in parts), strict=True)]
        return cls(edges=parts[0].edges, counts=tuple(counts))

    @property
    def total(self) -> int:
        """Of all counts."""
        return sum(self.counts)

    def within(self, rank: int) -> tuple[float, float]:
        """Return the edges between which the draw of a rank lies.

        Args:
            rank: 1 for the smallest; 0 and more than there are: beyond all draws.
        """
        ends = (-math.inf, *self.edges, math.inf)
        if rank < 1:
            return ends[0], ends[0]
        if rank > self.total:
            return ends[-1], ends[-1]
        upto = list(itertools.accumulate(self.counts))
        place = next(i for i, count in enumerate(upto) if count >= rank)
        return ends[place], ends[place + 1]


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """What is kept of the draws of one metric, however many there are."""

    draws: int
    """In all."""
    untold: int
    """Of them, those that have no finite value: they are in nothing below."""
    total: int
    """The exact sum, in units of 2^-1126."""
    squares: int
    """The exact sum of squares, in units of 2^-1126."""
    least: float
    """Infinite, if no draw tells."""
    greatest: float
    """Minus infinity, if no draw tells."""
    histogram: Histogram

    @classmethod
    def of(cls, values: Array, edges: Sequence[float]) -> Self:
        """Summarise draws.

        Args:
            values: (N,) of the metric; NaN, or infinite, if a draw does not tell.
            edges: of the histogram, the same for all parts of a campaign.
        """
        values = np.asarray(values, float)
        told = values[np.isfinite(values)]
        return cls(
            draws=len(values),
            untold=len(values) - len(told),
            total=exact_sum(told),
            squares=exact_sum_of_squares(told),
            least=float(told.min(initial=math.inf)),
            greatest=float(told.max(initial=-math.inf)),
            histogram=Histogram.of(told, edges),
        )

    @classmethod
    def merged(cls, parts: Iterable[Self]) -> Self:
        """Return the summary of parts of a campaign together.

        Args:
            parts: one or more, of different draws, with the same edges.
        """
        parts = list(parts)
        return cls(
            draws=sum(part.draws for part in parts),
            untold=sum(part.untold for part in parts),
            total=sum(part.total for part in parts),
            squares=sum(part.squares for part in parts),
            least=min(part.least for part in parts),
            greatest=max(part.greatest for part in parts),
            histogram=Histogram.merged(part.histogram for part in parts),
        )

    @property
    def told(self) -> int:
        """Draws that have a value."""
        return self.draws - self.untold

    @property
    def mean(self) -> float:
        """Of the draws that tell, rounded once; NaN if none does."""
        return float(in_units(self.total) / self.told) if self.told else math.nan

    @property
    def deviation(self) -> float:
        """The standard deviation of the population, as draws estimate it.

        NaN of fewer than two that tell.
        """
        if self.told < 2:
            return math.nan
        about_mean = in_units(self.squares) - in_units(self.total) ** 2 / self.told
        return math.sqrt(about_mean / (self.told - 1))

    def mean_within(self, confidence: float) -> Estimate:
        """Return the mean, with its interval by the central limit theorem.

        Args:
            confidence: such as 0.95; for some hundred draws or more.
        """
        return _mean_within(self.mean, self.deviation, self.told, confidence)

    def quantile_within(self, share: float, confidence: float) -> Estimate:
        """Return a quantile and its interval, as far as the histogram tells.

        The value is the middle of the bin that has it, cut at the least and greatest
        draw; the interval reaches to the outer edges of bins, so that its confidence
        is no less than what is asked for.

        Args:
            share: of draws that are below it.
            confidence: of the interval.
        """
        low, high = quantile_ranks(self.told, share, confidence)
        rank = _rank(self.told, share)
        inner = [*map(self._cut, self.histogram.within(rank))]
        return Estimate(
            sum(inner) / 2.0,
            self._cut(self.histogram.within(low)[0]) if low else -math.inf,
            self._cut(self.histogram.within(high)[1])
            if high <= self.told
            else math.inf,
        )

    def _cut(self, edge: float) -> float:
        """Return an edge, or where draws end before it."""
        return min(max(edge, self.least), self.greatest)


def quantile_ranks(draws: int, share: float, confidence: float) -> tuple[int, int]:
    """Return which of the sorted draws have a quantile between them.

    Whatever the distribution, at the confidence or more; half of the risk on each side
    (David and Nagaraja, Order Statistics, 3rd ed., 2003, section 7.1).

    Args:
        draws: that are independent.
        share: of the population that is below the quantile.
        confidence: of the interval.

    Returns:
        Ranks, 1 for the smallest; 0, and one more than there are, where the draws are
        too few to have a bound.
    """
    each_side = (1.0 + confidence) / 2.0
    below = failures_allowed(draws, 1.0 - share, each_side)
    above = failures_allowed(draws, share, each_side)
    return (
        0 if below is None else below + 1,
        draws + 1 if above is None else draws - above,
    )


@typed
def quantile_within(values: Array, share: float, confidence: float) -> Estimate:
    """Return a quantile of draws, with its interval between two of them.

    Args:
        values: (N,) of the metric, one or more, all finite.
        share: of the population that is below it.
        confidence: of the interval; see `quantile_ranks`.

    Returns:
        The draw of rank share N, rounded up; infinite bounds where draws are too few.
    """
    check_share("confidence", confidence)
    ranks = quantile_ranks(len(values), share, confidence)
    ordered = np.concatenate([[-math.inf], np.sort(values), [math.inf]])
    low, high = ordered[[*ranks]].tolist()
    return Estimate(float(ordered[_rank(len(values), share)]), low, high)


def _rank(draws: int, share: float) -> int:
    """Return the rank of a quantile: the first draw that has the share at or below."""
    return max(1, math.ceil(share * draws * (1.0 - _ROUND_OFF)))


def _mean_within(
    mean: float, deviation: float, draws: int, confidence: float
) -> Estimate:
    """Return a mean, with its interval by the central limit theorem."""
    check_share("confidence", confidence)
    half = float(ndtri((1.0 + confidence) / 2.0)) * deviation / math.sqrt(draws or 1)
    return Estimate(mean, mean - half, mean + half)


class Convergence(NamedTuple):
    """What the first draws of a campaign say."""

    draws: int
    """How many."""
    mean: Estimate
    deviation: float
    quantile: Estimate


@typed
def convergence(
    values: Array, share: float, confidence: float, points: int = 20
) -> list[Convergence]:
    """Return what more and more of the draws say of a metric.

    It shows whether a campaign is large enough; to stop it as soon as an interval is
    narrow voids the confidence.

    Args:
        values: (N,) in the order of the draws; those that do not tell are left out.
        share: of the quantile.
        confidence: of the intervals.
        points: how many, each some times as many draws as the one before, from ten.
    """
    least = min(10, len(values))
    counts = np.unique(np.geomspace(max(least, 1), len(values), points).round())
    rows = []
    for count in counts.astype(int).tolist():
        told = values[:count][np.isfinite(values[:count])]
        if len(told) < 2:
            continue
        deviation = float(told.std(ddof=1))
        mean = _mean_within(float(told.mean()), deviation, len(told), confidence)
        quantile = quantile_within(told, share, confidence)
        rows.append(Convergence(count, mean, deviation, quantile))
    return rows
