"""Parameters that go together, against closed forms."""

import re

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtr

from drakesep.analysis.tolerances.box import Dispersion, ToleranceBox
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Lognormal,
    Normal,
    Table,
    Triangular,
    Uniform,
)
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.joint_distribution import JointDistribution
from drakesep.systems.checks import InputError


TOLERANCES = {
    "a": Normal(sigma=2.0),
    "b": Lognormal(sigma=3.0),
    "c": 0.5,
    "d": Triangular(extent=1.0),
    "e": Table(values=(9.0, 10.0, 14.0)),
    "f": Discrete(values=(9.0, 11.0), probabilities=(0.5, 0.5)),
    "g": Normal(sigma=1.0),
}
BOX = ToleranceBox(
    [Dispersion(name=n, nominal=10.0, tolerance=t) for n, t in TOLERANCES.items()]
)
NAMES = list(TOLERANCES)
COUNT = 100_000
UNIT = np.random.default_rng(11).random((COUNT, len(NAMES)))
LEVEL = 1e-3
"""Of tests at fixed seeds, which have been looked at once."""


def joint(correlations=(), ellipsoids=(), box=BOX):
    return JointDistribution(
        box,
        [
            RankCorrelation(names=tuple(names), rank=rank)
            for names, rank in correlations
        ],
        ellipsoids,
    )


def test_apart_each_has_its_own():
    values = joint().values(UNIT)
    for i, name in enumerate(NAMES):
        one = BOX.dispersions[i].tolerance
        one = one if not isinstance(one, float) else Uniform(extent=one)
        assert values[:, i].tolist() == one.ppf(UNIT[:, i].copy(), 10.0).tolist(), name


RANKS = [("abc", 0.8), ("de", -0.6), ("ga", 0.3)]
GOT = joint(RANKS).values(UNIT)


@pytest.mark.parametrize(
    ("pair", "rank"),
    [
        *(("ab", 0.8), ("ac", 0.8), ("bc", 0.8), ("de", -0.6), ("ga", 0.3)),
        *(("ad", 0.0), ("fa", 0.0), ("gb", 0.0), ("gc", 0.0)),
    ],
)
def test_rank_correlations(pair, rank):
    x, y = (GOT[:, NAMES.index(name)] for name in pair)
    # Of 1e5 draws the standard error is at most 1 / sqrt(1e5), 0.003.
    assert stats.spearmanr(x, y).statistic == pytest.approx(rank, abs=0.01)


def test_correlated_parameters_keep_their_distributions():
    s = Lognormal(sigma=3.0).spread(10.0)
    for name, of in {
        "a": stats.norm(10.0, 2.0),
        "b": stats.lognorm(s, scale=10.0),
        "c": stats.uniform(9.5, 1.0),
        "d": stats.triang(0.5, 9.0, 2.0),
        "g": stats.norm(10.0, 1.0),
    }.items():
        assert stats.kstest(GOT[:, NAMES.index(name)], of.cdf).pvalue > LEVEL, name


@pytest.mark.parametrize("dependent", [False, True])
def test_by_normal_numbers(dependent):
    """The same by either: a normal number stands for its share."""
    one = joint(RANKS) if dependent else joint()
    z = np.random.default_rng(4).standard_normal((1000, len(NAMES)))
    # Shares in the upper tail have 1e-16 / 1e-4 left.
    assert one.of_normals(z) == pytest.approx(one.values(ndtr(z)), rel=1e-10)


CORRELATION = ((1.0, 0.6, 0.2), (0.6, 1.0, -0.3), (0.2, -0.3, 1.0))


def of_three(tolerances):
    box = ToleranceBox(
        [
            Dispersion(name=n, nominal=5.0, tolerance=t)
            for n, t in zip("xyz", tolerances, strict=True)
        ]
    )
    ellipsoid = Ellipsoid(names=("x", "y", "z"), correlation=CORRELATION)
    return box, JointDistribution(box, (), [ellipsoid]).values(UNIT[:, :3])


def mahalanobis(u):
    return np.einsum("ij,ij->i", u, np.linalg.solve(np.array(CORRELATION), u.T).T)


def test_uniform_in_an_ellipsoid():
    """By volumes of concentric ellipsoids, and by slices."""
    box, values = of_three((0.5, Uniform(extent=2.0), 3.0))
    u = (values - box.nominal) / box.tolerance
    share = mahalanobis(u) ** 1.5
    assert share.max() <= 1.0 + 1e-12  # round-off
    assert stats.kstest(share, "uniform").pvalue > LEVEL
    # Along each axis, of a ball: of density 3/4 (1 - x^2), and so for all directions.
    for direction in (*np.eye(3), np.ones(3) / 3.0):
        x = u @ direction / np.sqrt(direction @ np.array(CORRELATION) @ direction)
        assert stats.kstest(x, stats.beta(2, 2, -1, 2).cdf).pvalue > LEVEL


def test_the_middle_of_an_ellipsoid():
    """All shares may be one half."""
    box = ToleranceBox([Dispersion(name=n, nominal=5.0, tolerance=1.0) for n in "xy"])
    one = JointDistribution(box, (), [Ellipsoid(names=("x", "y"))])
    assert one.values(np.full((1, 2), 0.5)).tolist() == [[5.0, 5.0]]


def test_normal_in_an_ellipsoid():
    """Its correlations are theirs, and some are beyond: of three sigma, 2.9 %."""
    box, values = of_three([Normal(sigma=s) for s in (0.5, 1.0, 4.0)])
    assert np.corrcoef(values.T) == pytest.approx(np.array(CORRELATION), abs=0.01)
    u = (values - box.nominal) / box.tolerance
    assert stats.kstest(9.0 * mahalanobis(u), stats.chi2(3).cdf).pvalue > LEVEL


@pytest.mark.parametrize(
    ("correlations", "message"),
    [
        ([("ax", 0.5)], "correlation of a, x: unknown dispersed parameter 'x'"),
        (
            [("af", 0.5)],
            "correlation of a, f: must be of continuous distributions, got",
        ),
        (
            [("a", 0.5)],
            "correlation: must have two different parameters or more, got a",
        ),
        ([("aa", 0.5)], "correlation: must have two different parameters or more"),
        ([("ab", 1.0)], "correlation of a, b: rank must be between -1 and 1, got 1"),
        (
            [("ab", -1.5)],
            "correlation of a, b: rank must be between -1 and 1, got -1.5",
        ),
        ([("ab", np.nan)], "correlation of a, b: rank must be finite, got nan"),
        (
            [("abc", 0.5), ("cab"[:2], 0.1)],
            "correlation of c, a: a and c must stand in one correlation, got two",
        ),
        # Three that all oppose each other: r of normals at least -1/2.
        (
            [("de", 0.1), ("abc", -0.5)],
            "correlation of a, b, c: must be one that values can have",
        ),
        (
            [("ab", 0.9), ("bc", 0.9), ("ca", -0.5)],
            "must be one that values can have, whose matrix is positive definite, got",
        ),
    ],
)
def test_what_cannot_be_correlated_is_refused(correlations, message):
    with pytest.raises(InputError, match=re.escape(message)):
        joint(correlations)


def test_ellipsoids_say_how_their_parameters_go():
    ellipsoid = Ellipsoid(names=("a", "g"))
    with pytest.raises(InputError, match="of a, b: a must stand in no ellipsoid"):
        joint([("ab", 0.5)], [ellipsoid])
    message = "ellipsoids: ellipsoid: its parameters must be all normal, or all uniform"
    with pytest.raises(InputError, match=message):
        joint((), [Ellipsoid(names=("a", "c"))])


def test_less_of_a_correlation():
    one = RankCorrelation(names=("a", "b", "c"), rank=0.5)
    assert one.without(["b"]) == RankCorrelation(names=("a", "c"), rank=0.5)
    assert one.without(["b", "c"]) is None
