"""What a screen says at least of clearances, against their measure."""

import itertools
import math

import numpy as np
import pytest
from small_case import small_case

from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.campaigns.screens import BatchScreens, measured_in
from drakesep.analysis.clearance.screen import ClearanceScreen, can_be_screened
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.case_file.case import Case
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.vectors import rotation_matrix


def tumbling(**changes):
    """Bodies that turn by tens of degrees, one way in one run, another in the next.

    A ring of staves and a mast that leaves it; and what the small case has.
    """
    data = small_case(published=None, objectives=None, failure_cases=None)
    data["bodies"]["lower"]["geometry"]["ring"] = {
        "cylinder": {"radius_mm": 160.0, "length_mm": 80.0, "thickness_mm": 15.0},
        "position_mm": [100.0, -100.0, 50.0],
    }
    data["bodies"]["upper"]["geometry"]["nozzle"] = {
        "cone": {"radius_aft_mm": 70.0, "radius_fore_mm": 30.0, "length_mm": 200.0},
        "position_mm": [120.0, -100.0, 50.0],
    }
    del data["bodies"]["lower"]["geometry"]["deck"]
    del data["bodies"]["upper"]["geometry"]["mast"]
    data["dispersions"] |= {
        "upper.cg_z_mm": 300.0,
        "upper.cg_y_mm": 300.0,
        "before_separation.rate_x_deg_s": 40.0,
        "before_separation.rate_y_deg_s": 40.0,
    }
    data["requirements"] = [
        {"quantity": "clearance_mm", "at_least": 1.0},
        {"quantity": "clearance_mm", "at_least": 1.0, "until_separation_mm": 150},
    ]
    return Case.model_validate(data | changes).in_si()


MEASURED = 16
"""Draws whose clearances are measured."""


@pytest.fixture(scope="module")
def screened():
    case = tumbling()
    draws = Draws(case, 0)
    batch = Batch(case.separation, draws.names)
    clearances = [case.lowest_clearance(one.metric) for one in case.requirements]
    rows = draws.at(np.arange(300)).values
    screens = BatchScreens(batch, clearances, rows[:4])
    return clearances, batch, rows, screens.at_least(rows)


@pytest.fixture(scope="module")
def measured(screened):
    """NaN where a window does not end."""
    clearances, batch, rows, _ = screened
    runs = batch.runs(rows[:MEASURED])
    return np.array(
        [[measured_in(run, one, -math.inf) for one in clearances] for run in runs]
    )


def test_it_is_no_more_than_what_is_measured(screened, measured):
    *_, at_least = screened
    at_least, untold = at_least[:MEASURED], np.isnan(measured)
    assert (at_least <= measured)[~untold].all()
    assert np.isneginf(at_least[untold]).all()
    assert np.isfinite(at_least).mean() > 0.5


def test_it_is_no_more_than_any_distance_on_the_way(screened):
    clearances, batch, rows, at_least = screened
    worst = np.where(np.isfinite(at_least[:, 1]), at_least[:, 1], 9.0).argsort()[:2]
    for i, run in zip(worst, batch.runs(rows[worst]), strict=True):
        for k, clearance in enumerate(clearances):
            times = np.linspace(0.0, clearance.end(run), 50)
            distances = clearance.analysis.at_times(run, times)
            assert at_least[i, k] <= distances.min()


def test_it_proves_most_and_hardly_less_than_there_is(screened, measured):
    """Within some millimetres, of the half that comes nearest."""
    *_, at_least = screened
    off = (measured - at_least[:MEASURED])[:, 1]
    nearest = measured[:, 1] < np.nanmedian(measured[:, 1])
    assert np.median(off[nearest]) < 5e-3


TIMES = np.array([0.0, 0.05, 0.11, 0.12, 0.3, 0.55, 0.8])


@pytest.fixture(scope="module")
def placed(screened):
    """Where bodies are in some rows, and the same as runs."""
    _, batch, rows, _ = screened
    watching = batch.watching([("lower", "upper"), ("upper", "lower")], TIMES.tolist())
    [(part, places)] = watching.places(rows[:5])
    assert part == slice(0, 5)
    return batch.runs(rows[:5]), places


def test_places_are_those_of_the_runs(placed):
    """To a hundredth of the engine's tolerance, by which neighbours may matter."""
    runs, places = placed
    for i, run in enumerate(runs):
        for k, (A, B) in enumerate((("lower", "upper"), ("upper", "lower"))):
            path = RelativePath(run.completed_trajectory, A, B)
            R, p = path.places(TIMES)
            np.testing.assert_allclose(places.p_AoBo_A[i, :, k], p, atol=1e-8)
            told = rotation_matrix(tuple(places.q_AB[i, :, k].T))
            np.testing.assert_allclose(np.array(told).T.reshape(-1, 3, 3), R, atol=1e-8)


def test_what_curves_is_bounded_and_closely(placed):
    """By integrals of the runs' own second derivatives, across their kinks."""
    runs, places = placed
    for i, run in enumerate(runs):
        path = RelativePath(run.completed_trajectory, "lower", "upper")
        for j, (a, b) in enumerate(itertools.pairwise(TIMES.tolist())):
            t = np.linspace(a, b, 2001)
            second = path._spline(0.5 * (t[1:] + t[:-1]), 2)
            sizes = [np.linalg.norm(x, axis=1) for x in np.split(second, [4], axis=1)]
            turned, moved = (float(size.mean()) * (b - a) for size in sizes)
            bound, bending = places.curved[i, j, 0]
            assert moved * (1.0 - 1e-3) <= bound
            assert 2.0 * turned * (1.0 - 1e-3) <= bending
            # A step's most counts for all of it, and a push dies away within one.
            assert bound <= 5.0 * moved + 0.02


def test_who_watches_nothing_tells_no_places(screened):
    _, batch, rows, _ = screened
    with pytest.raises(ValueError, match=r"^places: a batch must be `watching`"):
        next(batch.places(rows))


class Told:
    """A pair of parts whose bounds are known."""

    def __init__(self, *bounds):
        self._bounds = np.array(bounds)

    def lower_bounds(self, *_):
        return self._bounds


@pytest.mark.parametrize("order", [1, -1])
def test_one_pair_that_does_not_tell_is_not_hidden_by_others(order, monkeypatch):
    pairs = [(("a", "b"), Told(0.2, 0.2)), (("a", "c"), Told(math.nan, 0.3))]
    screen = ClearanceScreen.__new__(ClearanceScreen)
    screen._pairs = pairs[::order]
    monkeypatch.setattr(screen, "_motion", lambda *_: None, raising=False)
    known = None, np.array([True, True])
    monkeypatch.setattr(screen, "_counts", lambda _: known, raising=False)
    first, second = screen.lower_bounds(None)
    assert first == -math.inf
    assert second == pytest.approx(0.2, abs=1e-4)  # but for what a measure may err


def test_what_cannot_be_screened():
    case = tumbling()
    clearance = case.lowest_clearance("clearance")
    varied = [*case.tolerances]
    assert can_be_screened(clearance, case.separation, varied)
    moved = [*varied, "ball.position_y"]
    assert not can_be_screened(clearance, case.separation, moved)
    touching = tumbling(clearance={"pairs": [["ball", "post"]], "touching": []})
    assert can_be_screened(
        touching.lowest_clearance("clearance"), touching.separation, varied
    )
    parts = {"touching": [["ball", "post"]]}
    named = {"quantity": "no_contact", "parts": [["ball", "post"]]}
    apart = tumbling(clearance=parts, requirements=[named])
    of_parts = apart.lowest_clearance("clearance_of_ball+post")
    assert not can_be_screened(of_parts, apart.separation, varied)
