"""Designs: of the wanted distributions, spread evenly, and not independent."""

import dataclasses
import math
import re

import numpy as np
import pytest
from scipy import stats
from trade import symmetric_design

from drakesep.analysis.campaigns.designs import design_points, designed
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.distributions import Normal
from drakesep.systems.checks import InputError


DESIGNS = ("sobol", "lhs")
CASE = dataclasses.replace(
    symmetric_design().in_si(),
    tolerances={"sc.mass": Normal(sigma=5.0), "s1.force_max": 8.0, "s2.force_max": 8.0},
    correlations=(RankCorrelation(names=("s1.force_max", "s2.force_max"), rank=0.6),),
    failure_cases=(FailureCase(name="out", values={"s1.force_max": 0.0}),),
    failure_probabilities={"out": 0.5},
)


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("count", [1, 64, 100])
def test_one_point_in_each_layer(design, count):
    """Of a hypercube of any number of points; of Sobol' points of powers of 2."""
    points = design_points(design, count, 5, 3)
    assert points.shape == (count, 5)
    assert 0.0 < points.min() and points.max() < 1.0
    if design == "lhs" or count != 100:
        layers = np.sort(np.floor(points * count), axis=0)
        assert (layers == np.arange(count)[:, None]).all()


def test_sobol_points_fill_boxes():
    """Each of 64 boxes of two dimensions has one: a (0, 6, 2)-net, and scrambled so."""
    points = design_points("sobol", 64, 2, 8)
    for i in range(7):
        cells = np.floor(points * [2**i, 64 // 2**i])
        assert len(np.unique(cells, axis=0)) == 64


@pytest.mark.parametrize("design", DESIGNS)
def test_the_seed_tells_points(design):
    of = [design_points(design, 32, 4, seed) for seed in (1, 1, 2)]
    assert (of[0] == of[1]).all()
    assert not (of[0] == of[2]).any()


@pytest.mark.parametrize("design", DESIGNS)
def test_marginals_and_correlations(design):
    drawn = designed(CASE, design, 4096, 1)
    assert not drawn.independent
    assert (drawn.failure == -1).all()
    assert drawn.indices.tolist() == list(range(4096))
    # Even layers: no further from the distribution than one of them.
    for column, of in zip(
        drawn.values.T,
        (stats.norm(500.0, 5.0), stats.uniform(492.0, 16.0)),
        strict=False,
    ):
        assert stats.kstest(column, of.cdf).statistic <= 1.0 / 4096 + 1e-12
    ranks = stats.spearmanr(drawn.values[:, 1], drawn.values[:, 2]).statistic
    # Of a hypercube only layers are even: 4 standard errors of independent ones.
    assert ranks == pytest.approx(0.6, abs=4 * (1 - 0.6**2) / math.sqrt(4096))


@pytest.mark.parametrize("design", DESIGNS)
def test_what_cannot_be_is_left_out(design):
    """Of I_xy and I_xz over a square, those in a disk: see test_draws."""
    reach = math.sqrt(30.0 * 90.0)
    t = 0.9 * reach
    case = dataclasses.replace(
        CASE,
        tolerances={"sc.inertia_xy": t, "sc.inertia_xz": t},
        correlations=(),
    )
    drawn = designed(case, design, 8192, 2)
    assert np.hypot(*drawn.values.T).max() < reach
    beyond = reach**2 * math.acos(0.9) - t * math.sqrt(reach**2 - t**2)
    share = (math.pi * reach**2 - 4.0 * beyond) / (2.0 * t) ** 2
    assert len(drawn) / 8192 == pytest.approx(share, abs=0.01)
    assert len(np.unique(drawn.indices)) == len(drawn) == len(drawn.values)


def test_means_converge_faster_than_of_draws():
    """Of the product of two forces, whose mean is known."""
    case = dataclasses.replace(CASE, correlations=())
    values = designed(case, "sobol", 1024, 1).values
    mean = float((values[:, 1] * values[:, 2]).mean())
    # Independent draws would have a standard error of 500 sqrt(2 / 3) 8 / 32 = 102.
    assert mean == pytest.approx(500.0**2, abs=1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("halton", 4, 2, 1), "design must be one of sobol, lhs, got 'halton'"),
        (("sobol", 0, 2, 1), "count must be >= 1, got 0"),
        (("lhs", 4, 2, -1), "seed must be >= 0, got -1"),
        (("sobol", 4, 30_000, 1), "sobol: needs at most 21201 parameters, got 30000"),
        (("lhs", 4.5, 2, 1), "count must be a whole number, got 4.5"),
    ],
)
def test_what_is_no_design_is_refused(arguments, message):
    with pytest.raises(InputError, match=re.escape(message)):
        design_points(*arguments)
