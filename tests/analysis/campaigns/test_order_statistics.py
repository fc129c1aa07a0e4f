"""How many runs show a share, against published sizes and exact binomial sums."""

from fractions import Fraction
from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta, binomtest

from drakesep.analysis.campaigns.order_statistics import (
    CampaignSize,
    consumers_risk,
    failures_allowed,
    producers_risk,
    runs_needed,
    share_at_most,
    share_shown,
)
from drakesep.systems.checks import InputError


PUBLISHED = [
    # share, confidence, runs for 0, 1, 2, 3 failures
    (0.99865, 0.90, (1705, 2880, 3941, 4947)),
    (0.9973, 0.90, (852, 1440, 1970, 2473)),
    (0.95, 0.95, (59, 93, 124)),  # Wilks
    (0.99, 0.95, (299, 473)),
]


@pytest.mark.parametrize(("share", "confidence", "sizes"), PUBLISHED)
def test_published_sizes(share, confidence, sizes):
    """Tables of Hanson and Beard, NASA/TP-2010-216447, and of Wilks."""
    assert tuple(runs_needed(share, confidence, k) for k in range(len(sizes))) == sizes
    for k, runs in enumerate(sizes):
        assert failures_allowed(runs, share, confidence) == k
        assert failures_allowed(runs - 1, share, confidence) == (k - 1 if k else None)


@pytest.mark.parametrize(
    ("runs", "share", "allowed"),
    [(2000, 0.9973, 2), (2000, 0.99865, 0), (10_000, 0.9973, 19), (10_000, 0.99865, 8)],
)
def test_published_numbers_of_failures(runs, share, allowed):
    """From the same report."""
    assert failures_allowed(runs, share, 0.90) == allowed


def exact_risk(runs: int, failures: int, share: Fraction) -> Fraction:
    """The binomial sum itself."""
    return sum(
        comb(runs, k) * (1 - share) ** k * share ** (runs - k)
        for k in range(failures + 1)
    )


@given(
    share=st.integers(1, 99).map(lambda n: Fraction(n, 100)),
    confidence=st.integers(1, 99).map(lambda n: Fraction(n, 100)),
    failures=st.integers(0, 6),
)
def test_no_run_more_and_none_less(share, confidence, failures):
    """Of the fewest runs, by exact arithmetic, where risks that are equal pass, too."""
    runs = runs_needed(float(share), float(confidence), failures)
    if runs > 400:  # the sums become slow
        return
    allowed = 1 - confidence
    assert exact_risk(runs, failures, share) <= allowed
    assert runs == failures + 1 or exact_risk(runs - 1, failures, share) > allowed
    assert failures_allowed(runs, float(share), float(confidence)) >= failures


@given(
    runs=st.integers(1, 60),
    failures=st.integers(0, 60),
    share=st.integers(1, 99).map(lambda n: Fraction(n, 100)),
)
def test_risks_are_binomial_sums(runs, failures, share):
    """Of both parties, which are each other's complement."""
    exact = exact_risk(runs, min(failures, runs), share)
    # Of incomplete beta functions, relative to 1.
    assert consumers_risk(runs, failures, float(share)) == pytest.approx(
        float(exact), abs=1e-13
    )
    assert producers_risk(runs, failures, float(share)) == pytest.approx(
        float(1 - exact), abs=1e-13
    )


@given(runs=st.integers(1, 10_000), failures=st.integers(0, 10_000))
def test_shares_are_those_of_clopper_and_pearson(runs, failures):
    """Held against scipy's, whose two-sided interval has both at half the risk."""
    failures = min(failures, runs)
    within = binomtest(runs - failures, runs).proportion_ci(0.8)
    # Where a share is of round-off's size, its complement is what has digits.
    assert share_shown(runs, failures, 0.9) == pytest.approx(within.low, abs=1e-12)
    assert share_at_most(runs, failures, 0.9) == pytest.approx(within.high, abs=1e-12)


@given(
    runs=st.integers(1, 20_000),
    failures=st.integers(0, 40),
    share=st.sampled_from([0.9, 0.99, 0.9973, 0.99865]),
    confidence=st.sampled_from([0.5, 0.9, 0.95]),
)
def test_three_ways_to_say_it_agree(runs, failures, share, confidence):
    """Failures that are allowed, the share that is shown, and the order statistic."""
    size = CampaignSize(share=share, confidence=confidence, runs=runs)
    shown = size.allowed is not None and failures <= size.allowed
    assert shown == (share_shown(runs, min(failures, runs), confidence) >= share)
    if size.rank is not None:
        # The share beyond the r-th worst of N draws has the beta distribution of r and
        # N + 1 - r; the next draw would not be worse than the share at the confidence.
        risk = [
            1.0 - beta.cdf(1.0 - share, r, runs + 1 - r)
            for r in (size.rank, size.rank + 1)
        ]
        assert risk[0] <= (1.0 - confidence) * (1.0 + 1e-9)  # of scipy's cdf
        assert risk[1] > (1.0 - confidence) * (1.0 - 1e-9) or size.rank == runs


def test_a_bound_covers_its_quantile_as_often_as_it_says():
    """In 4000 campaigns on draws of which every quantile is known."""
    size = CampaignSize(share=0.99, confidence=0.9, runs=500)
    assert size.allowed == 1
    draws = np.random.default_rng(1).random((4000, size.runs))
    bound = np.sort(draws, axis=1)[:, -size.rank]
    misses = int((bound < size.share).sum())
    interval = binomtest(misses, 4000).proportion_ci(0.999)
    assert interval.low <= size.consumers_risk <= interval.high
    assert size.consumers_risk <= 0.1


def test_who_is_good_enough_passes():
    """The producer's risk of the share that passes with a chance is 1 less that."""
    size = CampaignSize(share=0.99865, confidence=0.9, runs=1705)
    share = size.share_that_passes(0.9)
    assert share > size.share
    # Of inverse beta functions.
    assert size.producers_risk(share) == pytest.approx(0.1, rel=1e-9)
    # With none allowed, it is the share whose power of 1705 is the chance.
    assert share == pytest.approx(0.9 ** (1 / 1705), rel=1e-12)


def test_too_few_runs_pass_nobody():
    """Whatever the design."""
    size = CampaignSize(share=0.99865, confidence=0.9, runs=1704)
    assert (size.allowed, size.rank, size.consumers_risk) == (None, None, 0.0)
    assert (size.producers_risk(1.0), size.share_that_passes(0.5)) == (1.0, 1.0)


def test_what_disproves_a_share():
    """As many failures as are improbable where it is met: by the binomial sum."""
    size = CampaignSize(share=0.99, confidence=0.9, runs=1000)
    disproving = next(k for k in range(1000) if size.disproved_by(k))
    at_least = [1 - exact_risk(1000, k - 1, Fraction(99, 100)) for k in (14, 15)]
    assert at_least[0] > Fraction(1, 10) >= at_least[1]
    assert disproving == 15
    assert not any(size.disproved_by(k) for k in range(size.allowed + 1))


def test_large_campaigns():
    """A billion runs: the normal limit of the binomial, and no overflow."""
    allowed = failures_allowed(10**9, 0.99865, 0.9)
    # 1.35e6 less 1.2816 deviations of sqrt(N p q); the rest is of the limit.
    assert allowed == pytest.approx(1.35e6 - 1.2816 * (1.35e6 * 0.99865) ** 0.5, abs=5)
    assert failures_allowed(runs_needed(1 - 1e-9, 0.9), 1 - 1e-9, 0.9) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"share": 1.0}, "share must be > 0 and < 1, got 1.0"),
        ({"share": float("nan")}, "share must be finite, got nan"),
        ({"confidence": 90.0}, "confidence must be > 0 and < 1, got 90.0"),
        ({"runs": 0}, "runs must be >= 1, got 0"),
        ({"runs": 1.5}, "runs must be a whole number"),
    ],
)
def test_sizes_that_make_no_sense(arguments, said):
    """Each is refused by name."""
    with pytest.raises(InputError, match=said):
        CampaignSize(**{"share": 0.9, "confidence": 0.9, "runs": 100} | arguments)


def test_failures_that_make_no_sense():
    """Fewer than none; or more runs than can be counted."""
    with pytest.raises(InputError, match="failures must be >= 0, got -1"):
        runs_needed(0.9, 0.9, -1)
    with pytest.raises(InputError, match=r"takes more than 10+ runs"):
        runs_needed(1 - 1e-16, 0.9)
