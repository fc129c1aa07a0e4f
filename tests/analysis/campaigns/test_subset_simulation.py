"""Probabilities far out, against closed forms."""

import json
import math

import numpy as np
import pytest
from scipy.special import log_ndtr
from scipy.stats import binomtest, chi2, gamma, norm

from drakesep.analysis.campaigns.subset_simulation import subset_simulation
from drakesep.results.case_json import from_json, to_json
from drakesep.systems.checks import InputError


FAR = 1e-5


def along(points: np.ndarray) -> np.ndarray:
    """Standard normal, whatever the number of parameters: a plane limits it."""
    return points.sum(axis=1) / math.sqrt(points.shape[1])


def exponentials(points: np.ndarray) -> np.ndarray:
    """Of as many exponential numbers the sum, whose distribution is gamma: curved."""
    return -log_ndtr(-points).sum(axis=1)


def squares(points: np.ndarray) -> np.ndarray:
    """Chi square: beyond it lies all around."""
    return (points**2).sum(axis=1)


@pytest.mark.parametrize(
    ("values", "parameters", "limit"),
    [
        (along, 2, norm.isf(FAR)),
        (along, 18, norm.isf(FAR)),
        (exponentials, 6, gamma.isf(FAR, 6)),
        (squares, 3, chi2.isf(FAR, 3)),
    ],
)
def test_1e_5_within_20_per_cent_from_1e5_runs(values, parameters, limit):
    found = subset_simulation(values, parameters, float(limit))
    assert found.runs <= 100_000
    assert abs(found.probability / FAR - 1.0) <= 0.2
    # And it says so: a deviation of less than 20 %, and an interval that has it.
    assert found.variation < 0.15
    low, high = found.within(0.99)[1:]
    assert low <= FAR <= high
    assert (found.untold, found.unreached) == (0, 0)
    for levels in found.levels:
        assert list(levels) == sorted(levels) and 4 <= len(levels) <= 5
        assert levels[-1] <= limit


def test_its_error_is_what_it_says():
    """Of 60 simulations the intervals have it as often as they say, and it is no more
    above than below."""
    limit = float(norm.isf(1e-4))
    found = [
        subset_simulation(along, 3, limit, per_level=400, seed=seed)
        for seed in range(60)
    ]
    hits = sum(one.within(0.9).low <= 1e-4 <= one.within(0.9).high for one in found)
    # A sum of ten numbers that are skewed: some per cent of the interval's confidence.
    assert binomtest(hits, 60, 0.87).pvalue > 0.01
    ratios = np.array([one.probability for one in found]) / 1e-4
    stated = math.sqrt(float(np.mean([one.variation**2 for one in found])))
    # 60 deviations are known to 9 %, two of these twice.
    assert ratios.std(ddof=1) == pytest.approx(stated, rel=0.36)
    # Three deviations of the mean of 60.
    assert ratios.mean() == pytest.approx(1.0, abs=3.0 * stated / math.sqrt(60))


def test_what_is_not_rare_is_counted():
    """By draws alone: no chain is needed."""
    found = subset_simulation(along, 2, 0.5, per_level=1000, replicates=20)
    assert found.runs == 20_000 and found.levels == ((),) * 20
    true = norm.sf(0.5)
    count = round(20_000 * found.probability)
    interval = binomtest(count, 20_000).proportion_ci(0.999)
    assert interval.low <= true <= interval.high
    # That of a binomial share; twenty tell a deviation to a sixth, three of these.
    variation = math.sqrt((1.0 - true) / true / 20_000)
    assert found.variation == pytest.approx(variation, rel=0.5)


def test_of_what_is_admitted():
    """Given that a number is positive, it is beyond a limit twice as often."""
    seen = []

    def values(points):
        seen.append(points)
        return points[:, 0]

    limit = float(norm.isf(1e-3))
    found = subset_simulation(
        values, 2, limit, per_level=1000, admits=lambda points: points[:, 0] > 0.0
    )
    assert found.within(0.999).low <= 2e-3 <= found.within(0.999).high
    points = np.concatenate(seen)
    assert (points[:, 0] > 0.0).all() and len(points) == found.runs


def test_what_does_not_tell_is_beyond():
    """Where runs fail far out, the probability is no less for it."""
    limit = float(norm.isf(1e-3))

    def values(points):
        return np.where(points[:, 0] > limit, math.nan, points[:, 0])

    found = subset_simulation(values, 2, 50.0, per_level=1000)
    assert found.untold > 100
    assert found.within(0.999).low <= 1e-3 <= found.within(0.999).high


@pytest.mark.parametrize("top", [-1.0, 1.5])
def test_a_limit_that_nothing_reaches(top):
    """No less than the least that was looked for, and it says so."""
    found = subset_simulation(
        lambda points: np.minimum(points[:, 0], top),
        2,
        3.0,
        **{"per_level": 200, "replicates": 3, "least": 1e-6},
    )
    assert (found.probability, found.variation, found.unreached) == (1e-6, 0.0, 3)
    far = subset_simulation(along, 2, 30.0, per_level=200, replicates=3, least=1e-6)
    assert (far.probability, far.unreached) == (1e-6, 3)
    assert len(far.levels[0]) == 7


def test_the_same_seed_gives_the_same_whatever_stands_beside():
    """Each simulation draws its own numbers."""
    two, three = (
        subset_simulation(along, 2, 3.0, per_level=200, replicates=count)
        for count in (2, 3)
    )
    assert two.replicates == three.replicates[:2]
    other = subset_simulation(along, 2, 3.0, per_level=200, replicates=2, seed=1)
    assert not {*other.replicates} & {*two.replicates}


def test_it_is_kept_as_json():
    found = subset_simulation(along, 2, 3.0, per_level=200, replicates=2)
    assert from_json(json.loads(json.dumps(to_json(found)))) == found


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"limit": math.nan}, "limit must be finite, got nan"),
        ({"replicates": 1}, "replicates must be >= 2, got 1"),
        ({"per_level": 15}, "must be two or more and divide per_level, got 15 and 0.1"),
        ({"per_level": 10}, "must be two or more and divide per_level, got 10 and 0.1"),
        ({"level_share": 1.0}, "level_share must be > 0 and < 1, got 1.0"),
        ({"least": 0.0}, "least must be > 0 and < 1, got 0.0"),
    ],
)
def test_settings_that_make_no_sense(settings, said):
    with pytest.raises(InputError, match=said):
        subset_simulation(along, 2, **{"limit": 3.0} | settings)
