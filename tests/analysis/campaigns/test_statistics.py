"""Means, quantiles, histograms: of known distributions, and of parts put together."""

import itertools
import json
import math
import statistics
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest, expon, norm

from drakesep.analysis.campaigns.statistics import (
    Histogram,
    Summary,
    convergence,
    quantile_ranks,
    quantile_within,
)
from drakesep.results.case_json import from_json, to_json
from drakesep.systems.checks import InputError


EDGES = (-2.0, -1.0, 0.0, 0.5, 3.0)
VALUES = st.floats(-4.0, 4.0) | st.sampled_from([*EDGES, math.nan, math.inf, -math.inf])


@given(values=st.lists(VALUES, min_size=1, max_size=40), seed=st.integers(0, 999))
def test_parts_make_the_whole_in_whatever_order(values, seed):
    """To the bit: sums and squares are exact."""
    rng = np.random.default_rng(seed)
    cuts = np.sort(rng.integers(0, len(values) + 1, 3))
    parts = [Summary.of(part, EDGES) for part in np.split(np.array(values), cuts)]
    whole = Summary.merged(parts)
    shuffled = [parts[i] for i in rng.permutation(len(parts))]
    assert Summary.merged(shuffled) == whole == Summary.of(np.array(values), EDGES)
    two = [Summary.merged(shuffled[:1]), Summary.merged(shuffled[1:])]
    assert Summary.merged(two) == whole
    told = [x for x in values if math.isfinite(x)]
    assert (whole.draws, whole.untold) == (len(values), len(values) - len(told))
    if told:
        assert (whole.least, whole.greatest) == (min(told), max(told))
        exact = sum(map(Fraction, told)) / len(told)
        assert whole.mean == float(exact)
    else:
        assert math.isnan(whole.mean)
    counts = [sum(x < EDGES[0] for x in told)]
    counts += [sum(a <= x < b for x in told) for a, b in itertools.pairwise(EDGES)]
    assert whole.histogram.counts == (*counts, sum(x >= EDGES[-1] for x in told))


def test_a_small_deviation_of_large_values():
    """Where the difference of sums of squares has no digits left in floats."""
    values = 1e9 + np.array([0.0, 1e-3, 2e-3])
    summary = Summary.of(values, (0.0, 2e9))
    exact = statistics.pstdev(map(Fraction, values.tolist())) * math.sqrt(3 / 2)
    assert summary.deviation == pytest.approx(float(exact), rel=1e-15)
    assert math.isnan(Summary.of(values[:1], (0.0, 2e9)).deviation)


def test_a_mean_is_within_its_interval_as_often_as_it_says():
    draws = np.random.default_rng(1).exponential(size=(1000, 400))
    means = [Summary.of(row, (0.0, 10.0)).mean_within(0.9) for row in draws]
    hits = sum(one.low <= 1.0 <= one.high for one in means)
    # The limit theorem's error of a skew of 2 at 400 draws is below 1 %.
    assert binomtest(hits, 1000, 0.9).pvalue > 1e-3
    one = means[0]
    half = norm.ppf(0.95) * draws[0].std(ddof=1) / 20.0
    assert (one.low, one.high) == pytest.approx((one.value - half, one.value + half))


@pytest.mark.parametrize("share", [0.01, 0.5, 0.99])
@pytest.mark.parametrize("law", [norm, expon])
def test_a_quantile_is_within_its_interval_as_often_as_it_says(share, law):
    """Whatever the distribution; and ranks do no more than they must."""
    draws = law.ppf(np.random.default_rng(7).random((2000, 500)))
    found = [quantile_within(row, share, 0.9) for row in draws]
    true = law.ppf(share)
    below = sum(one.low > true for one in found)
    above = sum(one.high < true for one in found)
    low, high = quantile_ranks(500, share, 0.9)
    # By the binomial sums of draws below the quantile, exactly.
    risks = binom.cdf(low - 1, 500, share), binom.sf(high - 1, 500, share)
    for missed, risk in zip((below, above), risks, strict=True):
        assert risk <= 0.05
        interval = binomtest(missed, 2000).proportion_ci(0.9999)
        assert interval.low <= risk <= interval.high
    assert binom.cdf(low, 500, share) > 0.05 and binom.sf(high - 2, 500, share) > 0.05


def test_too_few_draws_have_no_bound():
    one = quantile_within(np.arange(10.0), 0.99, 0.9)
    assert (one.value, one.high) == (9.0, math.inf)
    assert math.isfinite(one.low)
    assert quantile_within(np.arange(10.0), 0.01, 0.9).low == -math.inf
    assert quantile_within(np.arange(1.0, 101.0), 0.07, 0.9).value == 7.0
    with pytest.raises(InputError, match="runs must be >= 1, got 0"):
        quantile_within(np.array([]), 0.5, 0.9)


@pytest.mark.parametrize("share", [0.001, 0.3, 0.5, 0.99])
def test_quantiles_of_a_histogram_enclose_those_of_the_draws(share):
    """Within a bin of them, and never narrower."""
    values = np.random.default_rng(3).standard_normal(5000)
    for edges in (np.linspace(-5.0, 5.0, 201), np.linspace(-0.5, 0.5, 21)):
        rough = Summary.of(values, edges).quantile_within(share, 0.95)
        exact = quantile_within(values, share, 0.95)
        assert rough.low <= exact.low <= exact.value <= exact.high <= rough.high
        inside = edges[0] <= exact.low and exact.high <= edges[-1]
        if inside:
            width = edges[1] - edges[0]
            assert abs(rough.value - exact.value) <= width / 2.0
            assert rough.high - exact.high <= width >= exact.low - rough.low
    few = Summary.of(values[:5], edges).quantile_within(share, 0.95)
    exact = quantile_within(values[:5], share, 0.95)
    for bound, wanted in ((few.low, exact.low), (few.high, exact.high)):
        assert math.isinf(bound) == math.isinf(wanted)


def test_convergence_is_that_of_the_first_draws():
    values = np.random.default_rng(5).standard_normal(2000)
    values[3] = math.nan
    rows = convergence(values, 0.9, 0.95, points=7)
    assert rows[0].draws == 10 and rows[-1].draws == 2000
    assert [row.draws for row in rows] == sorted({row.draws for row in rows})
    for row in rows:
        told = np.delete(values[: row.draws], 3)
        assert row.mean.value == told.mean()
        assert row.deviation == told.std(ddof=1)
        assert row.quantile == quantile_within(told, 0.9, 0.95)
    widths = [row.mean.high - row.mean.low for row in rows]
    # The square root of 2000 / 10 is 14; the deviation of ten draws misses by a third.
    assert 9.0 < widths[0] / widths[-1] < 22.0
    assert convergence(np.array([1.0]), 0.9, 0.95) == []


def test_a_summary_is_kept_as_json():
    """Whole numbers of hundreds of digits among them."""
    one = Summary.of(np.array([1e100, 3.5, math.nan]), EDGES)
    assert one.squares > 10**400
    assert from_json(json.loads(json.dumps(to_json(one)))) == one


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"edges": (1.0, 1.0), "counts": (0, 0, 0)}, "edges must rise, two or more"),
        ({"edges": (1.0,), "counts": (0, 0)}, "edges must rise, two or more"),
        ({"edges": (1.0, math.inf), "counts": (0, 0, 0)}, "edges must be finite"),
        ({"edges": (1.0, 2.0), "counts": (0, 0)}, "counts must be 3 and >= 0, got"),
        ({"edges": (1.0, 2.0), "counts": (0, -1, 0)}, "counts must be 3 and >= 0, got"),
    ],
)
def test_histograms_that_make_no_sense(arguments, said):
    with pytest.raises(InputError, match=said):
        Histogram(**arguments)


def test_histograms_of_other_edges_are_not_put_together():
    parts = [Histogram.of(np.array([1.0]), edges) for edges in ((0, 2), (0, 3))]
    with pytest.raises(InputError, match="must have the same edges"):
        Histogram.merged(parts)
