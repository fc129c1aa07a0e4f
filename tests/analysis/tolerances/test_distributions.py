"""Distributions against those of scipy.stats, and what searches look at of each."""

import dataclasses
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from drakesep.analysis.tolerances.box import Dispersion, ToleranceBox
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Lognormal,
    Normal,
    Table,
    Triangular,
    TruncatedNormal,
    Uniform,
    distribution_of,
    over_tolerance,
)
from drakesep.analysis.tolerances.sides import Sides, ends_of
from drakesep.systems.checks import InputError


NOMINAL = 7.25
# From far below to far above, as a campaign has them.
Q = np.concatenate([[2.0**-53, 1e-9, 1e-4], np.linspace(0.01, 0.99, 99), [1 - 1e-9]])
MEASURED = (7.5, 6.0, 9.25, 6.75, 8.0)
WEIGHTS = (1.0, 3.0, 0.5, 2.0, 4.0)
SKEWED = Sides(minus=1.5, plus=0.5)


def lognormal():
    """With a median of 7.25 and a standard deviation of 2.5: s by bisection."""
    low, high = 0.0, 1.0
    for _ in range(60):
        s = 0.5 * (low + high)
        low, high = (
            (s, high) if stats.lognorm(s, scale=NOMINAL).std() < 2.5 else (low, s)
        )
    return stats.lognorm(0.5 * (low + high), scale=NOMINAL)


def histogram():
    """Whose bins lie between sorted values, with the means of their weights."""
    order = np.argsort(MEASURED)
    w = np.array(WEIGHTS)[order]
    bins = 0.5 * (w[1:] + w[:-1])
    return stats.rv_histogram((bins, np.array(MEASURED)[order]), density=False)


SAME = [
    (Uniform(extent=2.0), stats.uniform(5.25, 4.0)),
    (Uniform(extent=SKEWED), stats.uniform(5.75, 2.0)),
    (Triangular(extent=2.0), stats.triang(0.5, 5.25, 4.0)),
    (Triangular(extent=SKEWED), stats.triang(0.75, 5.75, 2.0)),
    (Triangular(extent=Sides(minus=0.0, plus=3.0)), stats.triang(0.0, 7.25, 3.0)),
    (Normal(sigma=1.5), stats.norm(7.25, 1.5)),
    (TruncatedNormal(sigma=1.5, extent=3.0), stats.truncnorm(-2, 2, 7.25, 1.5)),
    (TruncatedNormal(sigma=2.0, extent=SKEWED), stats.truncnorm(-0.75, 0.25, 7.25, 2)),
    (
        TruncatedNormal(sigma=2.0, extent=Sides(minus=0.0, plus=5.0)),
        stats.truncnorm(0.0, 2.5, 7.25, 2.0),
    ),
    (Lognormal(sigma=2.5), lognormal()),
    (Table(values=MEASURED, weights=WEIGHTS), histogram()),
]


@pytest.mark.parametrize(("ours", "theirs"), SAME, ids=lambda x: getattr(x, "kind", ""))
def test_quantiles(ours, theirs):
    # Of the lognormal, s is bisected to 1e-15; far out, truncnorm has 1e-12 itself.
    assert ours.ppf(Q, NOMINAL) == pytest.approx(theirs.ppf(Q), rel=1e-10)


@pytest.mark.parametrize("ours", [ours for ours, _ in SAME], ids=lambda one: one.kind)
def test_by_normal_numbers(ours):
    z = np.linspace(-6.0, 6.0, 101)
    # ndtr has a relative error of 1e-15, which quantiles in the upper tail magnify.
    assert ours.of_normal(z, NOMINAL) == pytest.approx(
        ours.ppf(stats.norm.cdf(z), NOMINAL), rel=1e-6
    )


def test_quantiles_of_measured_values():
    """As numpy has them between values, if all weigh the same."""
    ours = Table(values=MEASURED)
    assert ours.ppf(Q, NOMINAL) == pytest.approx(np.quantile(MEASURED, Q), rel=1e-14)
    # A value that was measured twice has its share.
    ours = Table(values=(1.0, 2.0, 2.0, 3.0))
    assert ours.ppf(np.array([0.33, 0.34, 0.5, 0.66, 0.7]), 0.0) == pytest.approx(
        np.quantile([1.0, 2.0, 2.0, 3.0], [0.33, 0.34, 0.5, 0.66, 0.7])
    )


def test_quantiles_of_some_values():
    ours = Discrete(values=(3.0, -1.0, 10.0), probabilities=(0.25, 0.7, 0.05))
    theirs = stats.rv_discrete(values=((-1, 3, 10), (0.7, 0.25, 0.05)))
    assert ours.ppf(Q, NOMINAL).tolist() == theirs.ppf(Q).tolist()
    assert ours.ppf(np.array([0.7, 0.701, 0.95, 0.951]), NOMINAL).tolist() == [
        *(-1.0, 3.0, 3.0, 10.0)
    ]
    assert ours.of_normal(np.array([-0.5, 1.0, 2.0]), NOMINAL).tolist() == [-1, 3, 10]


def test_the_nominal_of_a_lognormal_is_its_median():
    ours = Lognormal(sigma=2.5)
    assert ours.ppf(np.array([0.5]), NOMINAL)[0] == pytest.approx(NOMINAL, rel=1e-15)
    # As far below, by a factor, as above.
    low, high = ours.ppf(np.array([0.02, 0.98]), NOMINAL)
    assert low * high == pytest.approx(NOMINAL**2, rel=1e-12)
    # Narrow, it is a normal one.
    ends = Lognormal(sigma=5.0).usual_sides(1485.0)
    assert ends.minus == pytest.approx(15.0, rel=0.01)
    assert ends.plus == pytest.approx(15.0, rel=0.01)


@pytest.mark.parametrize(
    ("distribution", "bounds"),
    [
        (Uniform(extent=2.0), (5.25, 9.25)),
        (Triangular(extent=SKEWED), (5.75, 7.75)),
        (TruncatedNormal(sigma=5.0, extent=SKEWED), (5.75, 7.75)),
        (Normal(sigma=1.5), (2.75, 11.75)),  # three standard deviations
        (Lognormal(sigma=2.5), tuple(lognormal().ppf(stats.norm.cdf([-3.0, 3.0])))),
        (Table(values=MEASURED, weights=WEIGHTS), (6.0, 9.25)),
        (Discrete(values=(3.0, 5.0), probabilities=(0.5, 0.5)), (3.0, 7.25)),
        (Table(values=(8.0, 9.0)), (7.25, 9.0)),  # and the nominal
    ],
    ids=lambda one: getattr(one, "kind", ""),
)
def test_what_searches_look_at(distribution, bounds):
    assert ends_of(NOMINAL, distribution) == pytest.approx(bounds, rel=1e-9)
    box = ToleranceBox([Dispersion(name="a", nominal=7.25, tolerance=distribution)])
    low, high = (box.values(u)["a"] for u in (box.lower, box.upper))
    assert (low, high) == pytest.approx(bounds, rel=1e-9)
    # Unless it is said.
    said = dataclasses.replace(distribution, within=0.5)
    assert ends_of(NOMINAL, said) == (6.75, 7.75)
    assert said.ppf(Q, NOMINAL).tolist() == distribution.ppf(Q, NOMINAL).tolist()
    # Grown, it is what searches look at that grows.
    [grown] = box.grown(2.0).dispersions
    assert grown.bounds == pytest.approx([2 * x - NOMINAL for x in bounds], rel=1e-9)


def test_a_number_is_uniform():
    assert distribution_of(2.0) == Uniform(extent=2.0)
    assert distribution_of(SKEWED) == Uniform(extent=SKEWED)
    assert distribution_of(Normal(sigma=1.0)) == Normal(sigma=1.0)


@given(extent=st.floats(1e-3, 1e3), sigmas=st.floats(0.5, 6.0))
def test_a_tolerance_is_three_standard_deviations(extent, sigmas):
    assert over_tolerance("normal", extent) == Normal(sigma=extent / 3, within=extent)
    for kind in ("normal", "lognormal", "truncated_normal"):
        made = over_tolerance(kind, extent, sigmas)
        assert made.sigma == extent / sigmas
        assert made.sides(NOMINAL) == Sides(minus=extent, plus=extent)
    assert over_tolerance("uniform", extent) == Uniform(extent=extent)
    skewed = Sides(minus=extent, plus=2.0 * extent)
    assert over_tolerance("triangular", skewed) == Triangular(extent=skewed)


def refused(kind, **fields):
    def make():
        made = kind(**fields)
        Dispersion(name="a", nominal=0.0, tolerance=made)

    return make


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (refused(Uniform, extent=0.0), "uniform: extent: tolerance must be > 0, got 0"),
        (refused(Normal, sigma=0.0), "sigma must be > 0, got 0"),
        (refused(Normal, sigma=math.nan), "sigma must be finite, got nan"),
        (refused(Normal, sigma="1"), "sigma must be a number, got '1'"),
        (refused(Normal, sigma=1.0, within=-1.0), "normal: within: tolerance must be"),
        (refused(Triangular, extent=math.inf), "extent: tolerance must be finite"),
        (refused(TruncatedNormal, sigma=-1.0, extent=1.0), "sigma must be > 0, got -1"),
        (refused(Lognormal, sigma=1.0), "a: lognormal: needs a nominal > 0, its"),
        (refused(Lognormal, sigma=1.0, within=1.0), "needs a nominal > 0, its median"),
        (refused(Table, values=(1.0, 1.0)), "table: values must be two different ones"),
        (
            refused(Table, values=(1.0, 2.0), weights=(1.0,)),
            "table: weights must be 2, one for each value, got 1",
        ),
        (
            refused(Table, values=(1.0, 2.0), weights=(1.0, 0.0)),
            "table: weights must be > 0, got 0.0",
        ),
        (refused(Table, values=(1.0, math.nan)), "table: values must be finite"),
        (
            refused(Discrete, values=(1.0, 2.0), probabilities=(0.5, 0.4)),
            "discrete: probabilities must add up to 1, got 0.9",
        ),
        (
            refused(Discrete, values=(1.0, 2.0, 1.0), probabilities=(0.5, 0.4, 0.1)),
            "discrete: each of the values must stand once",
        ),
        (lambda: over_tolerance("normal", SKEWED), "the same to either side, got 1.5"),
        (lambda: over_tolerance("gauss", 1.0), "distribution must be one of uniform,"),
        (lambda: over_tolerance("normal", 1.0, 0.0), "sigmas must be > 0"),
    ],
)
def test_what_is_no_distribution_is_refused(make, message):
    with pytest.raises(InputError, match=re.escape(message)):
        make()
