"""Sobol' indices and a far probability of VEGA, against brute force."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import binomtest

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.campaigns.of_case import probability_beyond, sobol_indices_of
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.case_file.reader import load_case
from drakesep.systems.checks import InputError


pytestmark = pytest.mark.slow

RATES = [f"rate_after_separation_{axis}" for axis in "xyz"]
BEYOND = 0.00726
"""Of the rate about y, rad/s: of some 1e-4 of launches."""


@pytest.fixture(scope="module")
def vega() -> AnalysisCase:
    return load_case("vega").in_si()


def flown_by(case: AnalysisCase):
    """The largest rates (N, 3) after separation of values of what is dispersed."""
    paper = {metric.stem for metric in registered_metrics() if metric.objective}
    batch = Batch(case.separation, case.tolerance_set.names, without=paper)

    def rates(values: np.ndarray) -> np.ndarray:
        found = batch.run(values)
        assert not found.failures
        return found.metrics[RATES].to_numpy()

    return rates


def test_indices_without_inertias(vega):
    """First: the variance of conditional means, in thirty parts of each parameter.

    Total: the variance that is left where all others are held, of pairs of runs.
    """
    without = {k: t for k, t in vega.tolerances.items() if "inertia" not in k}
    case = dataclasses.replace(vega, tolerances=without, ellipsoids=())
    rates, n, parts = flown_by(case), len(without), 30
    found = sobol_indices_of(case, rates)

    rng, joint = np.random.default_rng(1), case.joint_distribution
    q = rng.random((300_000, n))
    flown = rates(joint.values(q))
    variance = flown.var(axis=0)
    place = (q * parts).astype(int)
    first = np.empty((n, 3))
    for i in range(n):
        counts = np.bincount(place[:, i], minlength=parts)
        for j in range(3):
            sums = np.bincount(place[:, i], flown[:, j], parts)
            first[i, j] = np.average(
                (sums / counts - flown[:, j].mean()) ** 2, weights=counts
            )
    # Means of ten thousand differ by chance, too; parts leave out 1 / 900 of a line.
    first = (first / variance - (parts - 1) / len(q)) / (1.0 - parts**-2)

    pairs, total = 40_000, np.empty((n, 3))
    for i in range(n):
        other = q[:pairs].copy()
        other[:, i] = rng.random(pairs)
        apart = rates(joint.values(other)) - flown[:pairs]
        total[i] = (apart**2).mean(axis=0) / 2.0 / variance  # Jansen (1999)

    # Each of 72 intervals of 95 %, twice as wide; beside them the error of brute force.
    assert (np.abs(found.first - first) < 2.0 * found.first_error + 0.003).all()
    assert (np.abs(found.total - total) < 2.0 * found.total_error + 0.02 * total).all()
    assert found.first_error.max() < 0.05
    # Across the direction parameters add up; the roll needs two of them together.
    roll, *across = found.first.sum(axis=0)
    assert across == pytest.approx([1.0, 1.0], abs=0.02) and roll < 0.6


def test_indices_with_inertias_are_refused(vega):
    """Those that no body can have are drawn again."""
    with pytest.raises(InputError, match=r"values that cannot be, 2\.\d+%, which are "):
        sobol_indices_of(vega, lambda values: values)


def test_a_far_probability(vega):
    """With its inertias, which depend on each other."""
    rates = flown_by(vega)
    draws, beyond, count = Draws(vega, 7), 0, 0
    for first in range(0, 1_000_000, 200_000):
        flown = rates(draws.at(range(first, first + 200_000)).values)
        beyond += int((flown[:, 1] > BEYOND).sum())
        count += len(flown)
    found = probability_beyond(vega, lambda values: rates(values)[:, 1], BEYOND)
    assert found.runs <= 100_000 and found.unreached == found.untold == 0
    brute = binomtest(beyond, count).proportion_ci(0.99)
    mine = found.within(0.99)
    assert mine.low <= brute.high and brute.low <= mine.high
    assert found.probability == pytest.approx(beyond / count, rel=0.35)
