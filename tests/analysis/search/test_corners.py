"""The search by flips of bounds, on functions whose worst corner is known otherwise."""

import numpy as np
import pytest
from separations import generic_pair

from drakesep.analysis.engines.evaluator import Evaluated
from drakesep.analysis.metrics.objectives import of_run
from drakesep.analysis.search.corners import flip_bounds
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import Candidate, Problem
from drakesep.analysis.search.sweeps import sweep_vertices
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.inertia import ENTRIES


PAIR = generic_pair()
FEW = [f"{body}.{entry}" for body in ("upper", "lower") for entry in ("mass", "cg_x")]
MANY = [
    f"{body}.{entry}"
    for body in ("upper", "lower")
    for entry in ("mass", "cg_x", "cg_y", "cg_z")
] + [f"before_separation.{what}_{axis}" for what in ("rate",) for axis in "xyz"]
CLOSE = 1e-9
"""Points are scaled back from values of 1000 with tolerances of 1e-3: 1e-16 of 1e6."""


class OfFunctions:
    """Tells functions of scaled points (r, n), all at once, and what was flown."""

    concurrent = False

    def __init__(self, *functions, tolerances):
        self.objectives = tuple(
            of_run(lambda run: 0.0, f"function_{k}") for k in range(len(functions))
        )
        self.names = tolerances.names
        self.flown = []
        self._functions, self._box = functions, tolerances.box

    def exact(self, k):
        return False

    def one(self, rows, which):
        u = (rows - self._box.nominal) / self._box.tolerance
        self.flown += [
            (k, tuple(np.round(p, 9))) for k, p in zip(which, u, strict=True)
        ]
        values = np.array(
            [self._functions[k](p) for k, p in zip(which, u, strict=True)]
        )
        failures = {i: "it failed" for i in np.flatnonzero(np.isnan(values)).tolist()}
        return Evaluated(values, failures)

    def all(self, rows, on_progress=None, of=None):
        values = np.full((len(rows), len(self.objectives)), np.nan)
        for k in range(len(self.objectives)):
            values[:, k] = self.one(rows, [k] * len(rows)).values
        return Evaluated(values, {})


def set_of(names):
    return ToleranceSet(PAIR, ToleranceBox.around(PAIR, dict.fromkeys(names, 1e-3)))


def searched(*functions, names=MANY, tolerances=None, known=(), **settings):
    tolerances = tolerances or set_of(names)
    evaluator = OfFunctions(*functions, tolerances=tolerances)
    problem = Problem(tolerances=tolerances, evaluator=evaluator)
    settings = SearchSettings(**settings)
    return flip_bounds(problem, settings, known, lambda _: None), evaluator


def corners(n):
    return 2.0 * ((np.arange(2**n)[:, None] >> np.arange(n)) & 1) - 1.0


def pairs(seed, n):
    """Linear terms, and one for each pair, whose signs and sizes leave many maxima."""
    rng = np.random.default_rng(seed)
    b, C = rng.normal(size=n), np.triu(rng.normal(size=(n, n)), 1)
    return lambda u: u @ b + ((u @ C) * u).sum(axis=-1)


@pytest.mark.parametrize("seed", range(5))
def test_pairs_that_act_together(seed):
    """Against every corner of eleven parameters, a tenth of which could be flown."""
    function = pairs(seed, len(MANY))
    found, _ = searched(function)
    expected = function(corners(len(MANY))).max()
    assert found.best(0).value == pytest.approx(expected, abs=CLOSE)


@pytest.mark.parametrize("seed", range(5))
def test_magnitudes_that_add_up(seed):
    """In closed form: of the signs of six terms, those for which it is largest."""
    rng = np.random.default_rng(seed)
    A, b = rng.normal(size=(6, len(MANY))), rng.normal(size=6)
    signs = corners(6)
    expected = (np.abs(signs @ A).sum(axis=1) + signs @ b).max()
    found, _ = searched(lambda u: np.abs(A @ u + b).sum())
    assert found.best(0).value == pytest.approx(expected, abs=CLOSE)


def test_flips_of_two_lead_out_of_what_is_worst_among_its_neighbours():
    """Pairs that must change together: each of 16 starts is such a corner."""

    def alike(u):
        both = np.sign(u).reshape(5, 2).sum(axis=1) / 2.0
        return float((np.abs(both) + 0.1 * both).sum())

    starts = np.repeat(corners(5)[:16], 2, axis=1)
    assert starts.min(axis=1).max() == -1.0  # not the worst itself
    known = [
        Candidate(objective=0, u=tuple(u), value=alike(u), search="samples")
        for u in starts
    ]
    found, _ = searched(alike, names=MANY[:10], known=known, flips=1)
    assert found.best(0).value == pytest.approx(5.5)


def test_no_corner_is_flown_twice_and_few_are_all_flown():
    found, evaluator = searched(lambda u: u[0] * u[1] - u[2], names=FEW)
    assert len(evaluator.flown) == len(set(evaluator.flown)) == found.points
    assert found.points <= 16
    assert found.best(0).value == pytest.approx(2.0)
    assert found.note == "flips of one and two bounds, from 16 corners"


def test_what_others_there_are_changes_nothing():
    one, other = pairs(1, len(MANY)), pairs(2, len(MANY))
    alone, _ = searched(one)
    beside, _ = searched(other, one)
    assert [(c.u, c.value) for c in beside.candidates if c.objective == 1] == [
        (c.u, c.value) for c in alone.candidates
    ]


def test_corners_beyond_the_set_are_drawn_back_as_vertices_are():
    """Inertias that no body can have, in some of the 64 corners."""
    names = [f"upper.inertia_{entry}" for entry in ENTRIES]
    inertia = PAIR.body("upper").I_BBcm_B
    sizes = [
        0.1 * value if i < 3 else 0.1 * inertia[0] for i, value in enumerate(inertia)
    ]
    box = ToleranceBox.around(PAIR, dict(zip(names, sizes, strict=True)))
    tolerances = ToleranceSet(PAIR, box)
    weights = np.random.default_rng(4).normal(size=6)
    found, evaluator = searched(lambda u: weights @ u**3, tolerances=tolerances)
    problem = Problem(tolerances=tolerances, evaluator=evaluator)
    swept = sweep_vertices(problem, SearchSettings(), (), lambda _: None)
    assert "drawn back" in swept.note
    assert found.best(0).value == pytest.approx(swept.best(0).value, abs=CLOSE)
    flown = np.array([u for _, u in evaluator.flown])
    assert tolerances.contains((1.0 - 1e-8) * flown).all()  # noted to 1e-9


def test_failed_runs_are_counted_and_left():
    def failing(u):
        return np.nan if u[0] > 0.0 else u.sum()

    found, evaluator = searched(failing, names=FEW)
    assert found.best(0).value == pytest.approx(2.0)  # -1 + 1 + 1 + 1
    failed = sum(u[0] > 0.0 for _, u in evaluator.flown)
    assert found.failures == {"it failed": failed}
    none, _ = searched(lambda u: np.nan, names=FEW)
    assert none.best(0) is None


def test_what_it_may_cost_bounds_the_starts():
    """A corner among 2^11 that nothing leads to: no other start comes there."""
    function = pairs(0, len(MANY))

    def rugged(u):
        return function(u * np.arange(1, 12)) + 10.0 * np.sin(1e3 * function(u))

    few, _ = searched(rugged, flips=16)
    many, _ = searched(rugged)
    assert few.note.endswith("from 16 corners")
    least, _ = searched(rugged, flips=2)
    assert least.note.endswith("from 2 corners")
    assert few.points < many.points <= 2**11
