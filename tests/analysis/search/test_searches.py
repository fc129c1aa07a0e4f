"""The searches, on functions of the parameters whose maxima are known."""

import dataclasses
import math

import numpy as np
import pytest
from runs import evaluator_of
from separations import generic_pair

from drakesep.analysis.metrics.objectives import of_run
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.judge import find_worst_cases
from drakesep.analysis.search.problem import Candidate, Problem
from drakesep.analysis.search.registry import SEARCHES
from drakesep.analysis.search.sweeps import sweep_vertices
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.model.inertia import ENTRIES
from drakesep.systems.model.parameters import with_values


PAIR = generic_pair()
NAMES = ("upper.cg_x", "upper.cg_y", "upper.cg_z", "upper.mass")
BOX = ToleranceBox.around(PAIR, dict(zip(NAMES, (0.02, 0.01, 0.005, 1.0), strict=True)))
SET = ToleranceSet(PAIR, BOX)
QUICK = SearchSettings(starts=6, samples=300, generations=30)
ALL = ("samples", "vertices", "corners", "sqp", "multistart", "best", "evolution")


def problem(*functions, tolerances=SET):
    return Problem(
        tolerances=tolerances, evaluator=evaluator_of(*functions, tolerances=tolerances)
    )


def run(name, *functions, settings=QUICK, tolerances=SET, known=()):
    asked = problem(*functions, tolerances=tolerances)
    return SEARCHES[name](asked, settings, known, lambda _: None)


def bump(u):
    """1 at a place inside the box, and only there."""
    return 1.0 - ((u - [0.3, -0.6, 0.1, 0.5]) ** 2).sum()


def saddle(u):
    """Largest in two of the corners; flat at the nominal."""
    return u[0] * u[1] - 0.1 * u[2] + 0.2 * u[3]


@pytest.mark.parametrize(
    ("name", "close"), [("sqp", 1e-5), ("multistart", 1e-5), ("evolution", 1e-3)]
)
def test_maximum_inside_the_box(name, close):
    found = run(name, bump).best(0)
    assert found.value == pytest.approx(1.0, abs=close)


@pytest.mark.parametrize(
    ("name", "close"),
    [
        *(("vertices", 1e-9), ("corners", 1e-9)),
        *(("multistart", 1e-9), ("evolution", 0.05)),
    ],
)
def test_maximum_in_a_corner_that_the_nominal_does_not_see(name, close):
    found = run(name, saddle).best(0)
    assert found.value == pytest.approx(1.3, abs=close)


def test_vertices_are_all_flown_once():
    flown = []

    def function(u):
        flown.append(tuple(np.round(u, 12)))
        return u[0]

    searched = run("vertices", function)
    corners = {tuple(2.0 * ((np.arange(4) >> 0) * 0 + bits) - 1.0) for bits in _bits()}
    assert set(flown) == corners
    assert len(flown) == searched.points == 16
    assert searched.note == "all 16 vertices"


def _bits():
    return [np.array([(k >> i) & 1 for i in range(4)]) for k in range(16)]


def test_vertices_hold_what_has_a_worse_bound():
    """Where 16 are too many: two slopes have one sign, two parameters are left."""
    settings = dataclasses.replace(QUICK, vertices=4)
    searched = run("vertices", saddle, settings=settings)
    assert searched.best(0).value == pytest.approx(1.3)
    assert searched.points == 4
    assert "2 to 2 parameters whose slopes changed sign at 64 points" in searched.note


def test_vertices_leave_out_what_does_not_matter():
    settings = dataclasses.replace(QUICK, vertices=2)
    searched = run("vertices", lambda u: u[0], settings=settings)
    assert searched.points == 1
    assert searched.best(0).value == pytest.approx(1.0)


def test_vertices_beyond_what_is_affordable_are_refused():
    """A box of 40 parameters, with nothing that tells the worse bounds."""
    rng = np.random.default_rng(0)
    A = rng.standard_normal((40, 40))

    class FortyOfThem:
        objectives = (of_run(lambda run: 0.0),)
        names = tuple(f"p{i}" for i in range(40))

        def exact(self, k):
            return True

        def slopes(self, rows, which):
            from drakesep.analysis.engines.evaluator import Evaluated

            return Evaluated(np.zeros(len(rows)), {}), rows @ A

    tolerances = ToleranceSet(PAIR, BOX)
    tolerances.box = ToleranceBox(
        [dataclasses.replace(BOX.dispersions[0], nominal=0.0)] * 40
    )
    with pytest.raises(ValueError, match=r"2\^40, and 1.1e\+12 .*'multistart'"):
        sweep_vertices(
            Problem(tolerances=tolerances, evaluator=FortyOfThem()),
            QUICK,
            (),
            lambda _: None,
        )


def test_corners_of_an_ellipsoid_are_drawn_back_and_said_to_be():
    ellipsoid = Ellipsoid(names=NAMES[:2])
    tolerances = ToleranceSet(PAIR, BOX, [ellipsoid])
    searched = run("vertices", lambda u: u[0] + u[1], tolerances=tolerances)
    assert searched.best(0).value == pytest.approx(math.sqrt(2.0))
    assert "16 of them drawn back" in searched.note


@pytest.mark.slow
def test_samples_find_about_as_much_as_they_should():
    """The largest of n values of u_x lies 2 / (n + 1) below 1, in the mean."""
    values = [
        run("samples", lambda u: u[0], settings=SearchSettings(samples=500, seed=seed))
        .best(0)
        .value
        for seed in range(20)
    ]
    assert 1.0 - np.mean(values) == pytest.approx(2.0 / 501, rel=0.7)


@pytest.mark.parametrize("name", ALL)
def test_same_answer_for_the_same_seed(name):
    twice = [run(name, bump, saddle).candidates for _ in range(2)]
    assert [(c.u, c.value) for c in twice[0]] == [(c.u, c.value) for c in twice[1]]


@pytest.mark.parametrize("name", ALL)
def test_objectives_do_not_disturb_each_other(name):
    together = run(name, bump, saddle)
    alone = run(name, bump)
    assert together.best(0).u == alone.best(0).u
    assert together.best(0).value == alone.best(0).value


@pytest.mark.parametrize("name", ALL)
def test_progress_is_told(name):
    seen = []
    SEARCHES[name](problem(bump), QUICK, (), seen.append)
    assert {progress.search for progress in seen} == {name}
    counts = [progress.done for progress in seen]
    assert counts == sorted(counts)
    assert counts[-1] > 0


def test_half_of_the_box_is_not_physical():
    """Slender body: products beyond what its least moment allows, half of the time."""
    inertia = (10.0, 50.0, 50.0, 0.0, 0.0, 0.0)
    names = [f"upper.inertia_{entry}" for entry in ENTRIES]
    slender = with_values(PAIR, dict(zip(names, inertia, strict=True)))
    # Sigma is [[45, 0, 0], [0, 5, -yz], [0, -yz, 5]]: physical while |yz| <= 5
    box = ToleranceBox.around(slender, {"upper.inertia_yz": 4.9, "upper.mass": 1.0})
    tolerances = ToleranceSet(slender, box).grown(np.array([10.0 / 4.9, 1.0]))
    assert tolerances.share_unphysical() == pytest.approx(0.5, abs=0.01)
    found = find_worst_cases(
        problem(lambda u: u[0] + 0.1 * u[1], tolerances=tolerances), ALL, QUICK
    )
    assert found[0].value == pytest.approx(0.6, abs=1e-5)
    assert found[0].values["upper.inertia_yz"] == pytest.approx(5.0, rel=1e-5)
    [(label, multiplier), *_] = found[0].evidence.optimality.constraints
    assert label == "upper.inertia"
    assert multiplier > 0.0
    assert found[0].evidence.optimality.residual < 1e-6


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"starts": 0}, "starts: must be a whole number >= 1, got 0"),
        ({"samples": 2.5}, "samples must be a whole number, got 2.5"),
        ({"seed": -1}, "seed: must be a whole number >= 0, got -1"),
    ],
)
def test_bad_settings(settings, message):
    with pytest.raises(ValueError, match=message):
        SearchSettings(**settings)


def test_unknown_search():
    with pytest.raises(ValueError, match="unknown search 'vertex'; did you mean 'vert"):
        find_worst_cases(problem(bump), ["vertex"])
    with pytest.raises(ValueError, match="searches: must be one or more"):
        find_worst_cases(problem(bump), [])


HIGH = (0.3, 0.8, 0.8, 0.8)


@pytest.mark.parametrize("likely", [HIGH, (-0.9,) * 4])
def test_the_best_goes_up_from_each_search_and_from_what_is_likely(likely):
    """But from no likely point that is no better than all that is known."""
    of_searches = {"samples": (0.9,) * 4, "corners": (0.8,) * 4}
    known = [
        Candidate(objective=0, u=u, value=bump(np.array(u)), search=search)
        for search, best in of_searches.items()
        for u in (best, (-1.0,) * 4)
    ]
    asked = dataclasses.replace(problem(bump), likely={0: likely})
    found = SEARCHES["best"](asked, QUICK, known, lambda _: None)
    starts = {one.ascent.history[0].u for one in found.candidates}
    assert starts == {*of_searches.values()} | ({likely} if likely == HIGH else set())
    assert found.best(0).value == pytest.approx(1.0, abs=1e-5)


def test_few_flips_begin_where_it_is_likely():
    """To the one corner of 2^4 that counts nothing leads."""

    def traps(u):
        corner = np.sign(u)
        return float((corner == np.sign(HIGH)).all()) + 0.1 * float(corner.prod() > 0.0)

    few = dataclasses.replace(QUICK, flips=1, samples=1, seed=2)
    asked = dataclasses.replace(problem(traps), likely={0: HIGH})
    found = SEARCHES["corners"](asked, few, (), lambda _: None)
    assert found.best(0).value == pytest.approx(1.1)
    astray = SEARCHES["corners"](problem(traps), few, (), lambda _: None)
    assert astray.best(0).value < 1.0
