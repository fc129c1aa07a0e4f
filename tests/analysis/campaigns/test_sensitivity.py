"""Rank correlations and Sobol' indices, against closed forms and scipy's."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtri
from scipy.stats import binomtest, spearmanr

from drakesep.analysis.campaigns.sensitivity import rank_correlations, sobol_indices
from drakesep.systems.checks import InputError


def normal_pairs(rho: float, draws: int, seed: int) -> np.ndarray:
    """Draws (N, 2) of a bivariate normal distribution."""
    x, y = np.random.default_rng(seed).standard_normal((2, draws))
    return np.column_stack([x, rho * x + math.sqrt(1.0 - rho**2) * y])


@pytest.mark.parametrize("rho", [-0.95, -0.3, 0.0, 0.5, 0.9])
def test_rank_correlation_of_normal_pairs(rho):
    """Its closed form is 6 / pi asin(rho / 2) (Pearson, 1907)."""
    x, y = normal_pairs(rho, 100_000, 1).T
    found = rank_correlations(x[:, None], y[:, None]).value
    # Three deviations of the estimate, 1 / sqrt(N) at most.
    assert found[0, 0] == pytest.approx(6.0 / math.pi * math.asin(rho / 2.0), abs=0.01)


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_intervals_hold_it_as_often_as_they_say(rho):
    true, hits = 6.0 / math.pi * math.asin(rho / 2.0), 0
    for seed in range(600):
        x, y = normal_pairs(rho, 200, seed).T
        found = rank_correlations(x[:, None], y[:, None], 0.9)
        assert found.low < found.value < found.high
        hits += bool(found.low[0, 0] <= true <= found.high[0, 0])
    # The variance is that of a limit; 1 % of it is seen in no 600.
    assert binomtest(hits, 600, 0.9).pvalue > 1e-3


@given(seed=st.integers(0, 10_000), ties=st.booleans(), missing=st.booleans())
def test_they_are_scipys(seed, ties, missing):
    """With ties, and draws that do not tell."""
    rng = np.random.default_rng(seed)
    values, metrics = rng.random((30, 3)), rng.random((30, 2))
    if ties:
        values, metrics = np.round(4.0 * values), np.round(3.0 * metrics)
    if missing:
        metrics[rng.integers(0, 30, 5), 0] = math.nan
    found = rank_correlations(values, metrics)
    for i in range(3):
        for j in range(2):
            told = ~np.isnan(metrics[:, j])
            theirs = spearmanr(values[told, i], metrics[told, j]).statistic
            # Of sums of thirty products.
            assert found.value[i, j] == pytest.approx(theirs, abs=1e-14, nan_ok=True)


def test_what_does_not_vary_has_no_rank_correlation():
    values = np.column_stack([np.arange(10.0), np.ones(10)])
    metrics = np.column_stack([np.arange(10.0) ** 3, -np.arange(10.0), np.ones(10)])
    found = rank_correlations(values, metrics)
    assert np.array_equal(
        np.isnan(found.value), [[False, False, True], [True, True, True]]
    )
    assert found.value[0, :2] == pytest.approx([1.0, -1.0], abs=1e-15)
    few = rank_correlations(values[:3], metrics[:3])
    assert (few.low[0, 0], few.high[0, 0]) == pytest.approx((-1.0, 1.0))
    untold = rank_correlations(values, np.full((10, 1), math.nan))
    assert np.isnan(untold.value).all()
    with pytest.raises(InputError, match=r"must be \(N, n\) and \(N, m\), got \(10, 2"):
        rank_correlations(values, metrics[:9])


def ishigami(x: np.ndarray) -> np.ndarray:
    """Of Ishigami and Homma (1990), with a = 7, b = 0.1; and twice it less 5."""
    one = np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2
    one += 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    return np.column_stack([one, 2.0 * one - 5.0])


def in_one_turn(probabilities: np.ndarray) -> np.ndarray:
    return math.pi * (2.0 * probabilities - 1.0)


def test_ishigamis_function():
    """Against its closed form (Sobol' and Levitan, 1999)."""
    a, b = 7.0, 0.1
    v1 = 0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2
    v2, v13 = a**2 / 8.0, b**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = v1 + v2 + v13
    found = sobol_indices(ishigami, in_one_turn, 3, confidence=0.999)
    first = np.array([v1, v2, 0.0]) / variance
    total = np.array([v1 + v13, v2, v13]) / variance
    for metric in (0, 1):
        for wanted, got, error in (
            (first, found.first[:, metric], found.first_error[:, metric]),
            (total, found.total[:, metric], found.total_error[:, metric]),
        ):
            assert (np.abs(got - wanted) <= error).all()
            assert (error < 0.1).all()
    assert found.runs == 10 * 512 * 5


@pytest.mark.parametrize("sizes", [(3.0, 2.0), (1.0, 2.0, 0.0, 4.0)])
def test_sums_of_normal_parameters(sizes):
    """Shares of the variance are those of squares, alone and in all."""
    weights = np.array(sizes)
    found = sobol_indices(lambda x: (x @ weights)[:, None], ndtri, len(sizes), base=256)
    wanted = weights**2 / (weights**2).sum()
    # Of 2560 points: a quarter of a per cent and less, by the intervals' widths.
    assert found.first[:, 0] == pytest.approx(wanted, abs=0.02)
    assert found.total[:, 0] == pytest.approx(wanted, abs=0.02)
    assert found.first.shape == found.total_error.shape == (len(sizes), 1)


def test_a_metric_that_does_not_vary_has_no_shares():
    found = sobol_indices(lambda x: np.ones((len(x), 1)), in_one_turn, 2, base=16)
    for each in (found.first, found.first_error, found.total, found.total_error):
        assert np.array_equal(each, np.zeros((2, 1)))


def test_the_same_seed_gives_the_same():
    one, same = (sobol_indices(ishigami, in_one_turn, 3, base=32) for _ in range(2))
    assert np.array_equal(one.first, same.first)
    other = sobol_indices(ishigami, in_one_turn, 3, base=32, seed=1)
    assert not np.array_equal(one.first, other.first)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            {
                "dependences": [
                    "the rank correlation of a and b",
                    "inertias drawn again",
                ]
            },
            "Sobol' indices must be of independent parameters, so that shares of the "
            "variance add up, got the rank correlation of a and b; inertias drawn agai",
        ),
        ({"base": 100}, "base must be a power of two, got 100"),
        ({"replicates": 1}, "replicates must be >= 2, got 1"),
        ({"confidence": 95.0}, "confidence must be > 0 and < 1, got 95.0"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments, said):
    with pytest.raises(InputError, match=said):
        sobol_indices(ishigami, in_one_turn, 3, **arguments)


def test_runs_that_do_not_tell_are_refused():
    def metrics(x):
        return np.where(x[:, :1] > 3.0, math.nan, x[:, :1])

    with pytest.raises(
        InputError, match=r"metrics must be finite, got .* runs that are"
    ):
        sobol_indices(metrics, in_one_turn, 3)
