"""Draws: by their numbers alone, of the wanted distributions, and only what can be."""

import dataclasses
import functools
import itertools
import math
import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from trade import symmetric_design

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.failure_cases import FailureCase
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Lognormal,
    Normal,
    Table,
    Triangular,
    TruncatedNormal,
    Uniform,
)
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.sides import Sides
from drakesep.systems.checks import InputError


LEVEL = 1e-3
"""Of tests at fixed seeds, which have been looked at once."""
COUNT = 100_000


def case(**changes) -> AnalysisCase:
    return dataclasses.replace(symmetric_design().in_si(), **changes)


OUT = FailureCase(name="out", values={"s3.force_max": 0.0})
LATE = FailureCase(name="late", values={"a2.release_time": math.inf})
HEAVY = FailureCase(name="heavy", values={"sc.inertia_xx": 40.0, "lv.mass": 2100.0})
# With everything at once: ellipsoids, correlations, inertias that cannot be, failures.
CASE = case(
    tolerances={
        "sc.mass": Normal(sigma=5.0),
        "sc.cg_y": 0.01,
        "sc.cg_z": 0.02,
        "s1.force_max": Lognormal(sigma=10.0),
        "s2.force_max": Lognormal(sigma=10.0),
        "s3.force_max": Normal(sigma=8.0),
        "sc.inertia_xy": Normal(sigma=20.0, within=40.0),
        "sc.inertia_xx": Sides(minus=10.0, plus=5.0),
        "lv.mass": Discrete(values=(2000.0, 2050.0), probabilities=(0.75, 0.25)),
        "lv.cg_x": Table(values=(-1.21, -1.205, -1.19), weights=(1.0, 3.0, 2.0)),
        "lv.cg_y": TruncatedNormal(sigma=0.002, extent=0.003),
        "lv.cg_z": Triangular(extent=0.004),
    },
    ellipsoids=(Ellipsoid(names=("sc.cg_y", "sc.cg_z")),),
    correlations=(RankCorrelation(names=("s1.force_max", "s2.force_max"), rank=0.8),),
    failure_cases=(OUT, LATE, HEAVY),
    failure_probabilities={"heavy": 0.125, "out": 0.25},
)


@functools.cache
def draws(seed: int = 3) -> Draws:
    return Draws(CASE, seed)


@functools.cache
def many():
    return draws().at(range(COUNT))


@pytest.mark.parametrize("number", [0, 1, 77, 2**32 + 5, 2**63 - 1])
@pytest.mark.parametrize("attempt", [0, 3])
@pytest.mark.parametrize("seed", [0, 3, 2**63 - 1])
def test_bits_are_those_of_numpy(seed, number, attempt):
    """By the words of the module's page."""
    got = draws(seed).shares([number], attempt)[0]
    for d, share in enumerate(got, 1):
        counter = [d // 4, attempt, number, 0]
        word = np.random.Philox(counter=counter, key=seed).random_raw(4)[d % 4]
        assert share == (int(word) >> 11) / 2**53
        assert 0.0 < share < 1.0


def test_shares_end_before_0_and_1(monkeypatch):
    """The least and the greatest words that there are."""
    for word, wanted in ((0, 2.0**-53), (2**64 - 1, 1.0 - 2.0**-53)):
        words = (np.array([word], np.uint64),) * 4
        monkeypatch.setattr(
            "drakesep.analysis.campaigns.draws.philox", lambda *_, words=words: words
        )
        assert (draws().shares([5]) == wanted).all()


numbers = st.integers(0, COUNT - 1) | st.integers(0, 2**63 - 1)


@given(chosen=st.lists(numbers, max_size=8), data=st.data())
def test_the_same_alone_and_among_many_in_any_order(chosen, data):
    among = draws().at(chosen)
    assert among.indices.tolist() == chosen
    for i, number in enumerate(chosen):
        of = [draws().at([number])] + ([many()] if number < COUNT else [])
        for other in of:
            k = number if other is many() else 0
            assert among.values[i].tolist() == other.values[k].tolist()
            assert among.failure[i] == other.failure[k]
            assert among.attempts[i] == other.attempts[k]
    mixed = data.draw(st.permutations(range(len(chosen))))
    again = draws().at([chosen[i] for i in mixed])
    assert again.values.tobytes() == among.values[list(mixed)].tobytes()


def test_chunks_are_parts_of_the_whole():
    ends = [0, 1, 17, 4096, 16383, 16385, 50_001, COUNT]
    chunks = [draws().at(np.arange(*of)) for of in itertools.pairwise(ends)]
    assert np.concatenate([c.values for c in chunks]).tobytes() == (
        many().values.tobytes()
    )
    assert np.concatenate([c.attempts for c in chunks]).tolist() == (
        many().attempts.tolist()
    )


def test_another_seed_draws_others():
    other = draws(4).at(range(1000))
    assert not (other.values == many().values[:1000]).all(axis=1).any()
    # Seeds and numbers do not go over into each other.
    rows = np.concatenate([draws(s).shares(range(500)) for s in range(5)])
    assert len(np.unique(rows)) == rows.size


def test_distributions():
    names, values = draws().names, many().values
    design = values[many().failure == -1]
    for name, of in {
        "sc.mass": stats.norm(500.0, 5.0),
        "s1.force_max": stats.lognorm(Lognormal(sigma=10.0).spread(500.0), 0.0, 500.0),
        "s2.force_max": stats.lognorm(Lognormal(sigma=10.0).spread(500.0), 0.0, 500.0),
        "s3.force_max": stats.norm(500.0, 8.0),
        # Of a disk: 2/pi sqrt(1 - y^2)
        "sc.cg_y": stats.beta(1.5, 1.5, -0.01, 0.02),
        "sc.cg_z": stats.beta(1.5, 1.5, -0.02, 0.04),
    }.items():
        column = design[:, names.index(name)]
        assert stats.kstest(column, of.cdf).pvalue > LEVEL, name
    s1, s2 = (names.index(f"s{i}.force_max") for i in (1, 2))
    ranks = stats.spearmanr(values[:, s1], values[:, s2]).statistic
    assert ranks == pytest.approx(0.8, abs=0.01)
    heavy = design[:, names.index("lv.mass")] == 2050.0
    assert stats.binomtest(int(heavy.sum()), len(heavy), 0.25).pvalue > LEVEL


def test_what_fails():
    drawn, names = many(), draws().names
    assert [one.name for one in draws().failures] == ["out", "heavy"]
    counts = np.bincount(drawn.failure + 1, minlength=3)
    assert (
        stats.chisquare(counts, COUNT * np.array([0.625, 0.25, 0.125])).pvalue > LEVEL
    )
    out, heavy = drawn.values[drawn.failure == 0], drawn.values[drawn.failure == 1]
    assert (out[:, names.index("s3.force_max")] == 0.0).all()
    assert (heavy[:, names.index("lv.mass")] == 2100.0).all()
    assert (heavy[:, names.index("sc.inertia_xx")] == 40.0).all()
    # What has not failed varies as it does in the design.
    assert stats.kstest(out[:, 0], stats.norm(500.0, 5.0).cdf).pvalue > LEVEL
    # Nothing else changes: a draw in which nothing fails is that of the case without.
    plain = Draws(dataclasses.replace(CASE, failure_probabilities={}), 3)
    nothing = np.flatnonzero(drawn.failure == -1)[:1000]
    assert plain.at(nothing).values.tobytes() == drawn.values[nothing].tobytes()


# Of sc, with moments 180, 120 and 120: the second moments of mass are 30, 90 and 90.
REACH = math.sqrt(30.0 * 90.0)
"""Up to which I_xy is possible: |I_xy|^2 <= 30 x 90."""


def test_impossible_inertias_are_drawn_again():
    """Of I_xy alone: what is left is the truncated distribution, in closed form."""
    for tolerance, share, left in (
        (
            Uniform(extent=100.0, within=50.0),
            1.0 - REACH / 100.0,
            stats.uniform(-REACH, 2.0 * REACH),
        ),
        (
            Normal(sigma=40.0, within=50.0),
            2.0 * stats.norm.cdf(-REACH / 40.0),
            stats.truncnorm(-REACH / 40.0, REACH / 40.0, 0.0, 40.0),
        ),
    ):
        drawn = Draws(case(tolerances={"sc.inertia_xy": tolerance}), 1).at(range(COUNT))
        assert np.abs(drawn.values).max() < REACH
        assert stats.kstest(drawn.values[:, 0], left.cdf).pvalue > LEVEL
        again = int(drawn.attempts.sum())
        assert stats.binomtest(again, again + COUNT, share).pvalue > LEVEL
        assert drawn.share_impossible == again / (again + COUNT)
        # How often: geometric.
        first = int((drawn.attempts == 0).sum())
        assert stats.binomtest(first, COUNT, 1.0 - share).pvalue > LEVEL


def test_impossible_inertias_of_tolerances():
    """Each alone reaches possible inertias; I_xy and I_xz together those of a disk."""
    t = 0.9 * REACH
    beyond = REACH**2 * math.acos(0.9) - t * math.sqrt(REACH**2 - t**2)
    share = 1.0 - (math.pi * REACH**2 - 4.0 * beyond) / (2.0 * t) ** 2
    of = case(tolerances={"sc.inertia_xy": t, "sc.inertia_xz": t})
    drawn = Draws(of, 1).at(range(COUNT))
    again = int(drawn.attempts.sum())
    assert stats.binomtest(again, again + COUNT, share).pvalue > LEVEL
    assert np.hypot(*drawn.values.T).max() < REACH
    # The set of the searches has the same share.
    assert of.share_unphysical == pytest.approx(share, abs=0.005)  # of 1e5 samples


def test_of_vega(vega):
    """The share of inertias that cannot be, by the eigenvalues of other samples."""
    record = vega.in_si()
    drawn = Draws(record, 2).at(range(COUNT))
    entries = [f"payload.inertia_{e}" for e in ("xx", "yy", "zz", "xy", "xz", "yz")]
    box, rng = record.box, np.random.default_rng(5)
    at = [box.names.index(name) for name in entries]
    low = (box.nominal - box.tolerance)[at]
    xx, yy, zz, xy, xz, yz = (low + 2 * box.tolerance[at] * rng.random((COUNT, 6))).T
    matrices = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    least, middle, most = np.linalg.eigvalsh(matrices).T
    share = float((most > least + middle).mean())
    # Two shares of 1e5 samples each, of 2.3 %: 4 standard errors.
    assert drawn.share_impossible == pytest.approx(share, abs=4 * 0.0007)
    assert drawn.independent


def test_impossible_under_a_failure():
    """A failure changes an inertia that does not vary, and so what else can be."""
    failure = FailureCase(name="slim", values={"sc.inertia_xx": 220.0})
    failing = case(
        tolerances={"sc.inertia_xy": Normal(sigma=60.0, within=30.0)},
        failure_cases=(failure,),
        failure_probabilities={"slim": 0.5},
    )
    drawn = Draws(failing, 1).at(range(20_000))
    # The second moments are 10, 110, 110 then.
    for which, reach in ((-1, REACH), (0, math.sqrt(10.0 * 110.0))):
        most = np.abs(drawn.values[drawn.failure == which]).max()
        assert 0.99 * reach < most < reach


def test_other_values_that_cannot_be():
    """Half of these times of release are before t = 0."""
    early = Normal(sigma=0.01, within=Sides(minus=0.0, plus=0.03))
    drawn = Draws(case(tolerances={"a1.release_time": early}), 1).at(range(20_000))
    of = stats.halfnorm(0.0, 0.01)
    assert stats.kstest(drawn.values[:, 0], of.cdf).pvalue > LEVEL
    assert drawn.share_impossible == pytest.approx(0.5, abs=0.01)


def test_hardly_anything_possible_is_refused(monkeypatch):
    hardly = case(tolerances={"sc.inertia_xy": Normal(sigma=1e6, within=1.0)})
    with pytest.raises(InputError, match="values of which a thousandth can be, got"):
        Draws(hardly, 1).at(range(20_000))
    monkeypatch.setattr("drakesep.analysis.campaigns.draws._ENOUGH", 1000)  # of 10 000
    with pytest.raises(InputError, match="can be, got 0 of 1000; narrow the tolerance"):
        Draws(hardly, 1).at([5])
    monkeypatch.setattr("drakesep.analysis.campaigns.draws._MOST", 50)
    with pytest.raises(InputError, match="can be, got 0 of 51; narrow the tolerance"):
        Draws(hardly, 1).at([5])


def test_sent_to_another_process():
    sent = pickle.loads(pickle.dumps(draws()))
    assert sent.at([77]).values.tobytes() == draws().at([77]).values.tobytes()


def test_nothing_dispersed():
    drawn = Draws(case(), 0).at([3, 1])
    assert drawn.values.shape == (2, 0)
    assert drawn.share_impossible == 0.0
    assert Draws(CASE, 0).at([]).values.shape == (0, len(draws().names))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: Draws(CASE, -1), "seed must be >= 0, got -1"),
        (lambda: Draws(CASE, 0.5), "seed must be a whole number, got 0.5"),
        (lambda: draws().at([-1]), "indices must be >= 0, got -1"),
        (lambda: draws().at(np.array([0.5])), "indices must be whole numbers (N,)"),
        (lambda: draws().at(np.zeros((2, 2), int)), "indices must be whole numbers"),
    ],
)
def test_what_is_no_draw_is_refused(wrong, message):
    with pytest.raises(InputError, match=re.escape(message)):
        wrong()


@pytest.mark.parametrize(
    ("probabilities", "message"),
    [
        ({"outt": 0.1}, "failures: unknown failure case 'outt'; did you mean 'out'?"),
        ({"out": 0.0}, "failures: out must be > 0, got 0"),
        ({"out": math.nan}, "failures: out must be finite, got nan"),
        ({"out": 0.5, "late": 0.5}, "probabilities must add up to less than 1, got 1"),
    ],
)
def test_what_is_no_probability_is_refused(probabilities, message):
    with pytest.raises(InputError, match=re.escape(message)):
        dataclasses.replace(CASE, failure_probabilities=probabilities)


def test_in_failure_nothing_else_fails():
    failed = CASE.in_failure(FailureCase(name="a", values={"s1.force_max": 0.0}))
    assert failed.correlations == ()
    assert failed.failure_probabilities == {}
