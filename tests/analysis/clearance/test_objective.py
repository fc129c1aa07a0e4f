"""The smallest distance as an objective, against motions whose slopes are known."""

import math

import numpy as np
import pytest
from flights import run_of, straight, trajectory

from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.analysis.metrics.objectives import highest, largest, of_run
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.parts import Part, Sphere


TIME = np.linspace(0.0, 1.0, 9)
NO_LIMITS = (math.inf,) * 3
ROCK = Part(name="rock", shape=Sphere(radius=0.2))
BALL = Part(name="payload_ball", shape=Sphere(radius=0.1))
EXACT = 1e-6
"""Spheres are measured to round-off; their smallest distance is found to 1e-6 s, at
which it differs from the true one to second order."""


def fly_by(miss, speed=2.0, when=0.4):
    """B passes A's origin at a distance along y."""
    start, velocity = (-when * speed, miss, 0.0), (speed, 0.0, 0.0)
    return run_of(straight(TIME, start, velocity), [ROCK], [BALL])


def test_its_value_is_the_smallest_distance_and_its_slope_that_of_the_points():
    run = fly_by(0.5)
    about = LowestClearance(run.separation).about(run, NO_LIMITS)
    assert about.value == pytest.approx(-0.2, abs=EXACT)
    assert about.near(run) == pytest.approx(about.value, abs=1e-12)
    for change in (-0.01, 1e-4, 0.02):
        # To the side the distance changes as the miss; to and fro, to second order.
        near = about.near(fly_by(0.5 + change))
        assert near - about.value == pytest.approx(-change, abs=1e-5 * abs(change))
        later = about.near(fly_by(0.5, when=0.4 + 0.1 * change))
        assert abs(later - about.value) < 0.01 * abs(change)


def closing(speed, drop=0.8, more=()):
    """B moves away along x and comes nearer along y, all the time."""
    motion = straight(TIME, (0.0, 2.0, 0.0), (speed, -drop, 0.0))
    return run_of(motion, [ROCK], [*more, BALL])


FAR = Part(name="far_ball", shape=Sphere(radius=0.1), p_BoGo_B=(0.0, 5.0, 0.0))
MID = Part(name="mid_ball", shape=Sphere(radius=0.1), p_BoGo_B=(0.0, 0.3, 0.0))


@pytest.mark.parametrize("more", [(), (FAR,)])
def test_where_it_ends_a_window_its_slope_has_the_windows(more):
    """Nearest at the end of the window, when B has moved 0.3 m: at 0.3 / speed."""

    def distance(speed):
        t = 0.3 / speed
        return math.hypot(0.3, 2.0 - 0.8 * t) - 0.3

    run = closing(1.5, more=more)
    objective = LowestClearance(run.separation, until_separation=0.3)
    about = objective.about(run, NO_LIMITS)
    assert about.value == pytest.approx(-distance(1.5), abs=EXACT)
    h = 1e-4
    slope = (about.near(closing(1.5 + h)) - about.near(closing(1.5 - h))) / (2.0 * h)
    truth = -(distance(1.5 + h) - distance(1.5 - h)) / (2.0 * h)
    assert slope == pytest.approx(truth, rel=1e-5)
    # One that is never reached goes on to the end, and is known not to be over.
    far = LowestClearance(run.separation, until_separation=9.0)
    whole = LowestClearance(run.separation)
    assert far.of_run(run, NO_LIMITS) == whole.of_run(run, NO_LIMITS)
    assert not far.is_window_ended(run)
    assert objective.is_window_ended(run) and whole.is_window_ended(run)


X = (1.0, 0.0, 0.0)


def test_time_apart():
    run = closing(1.5)
    path = RelativePath(run.completed_trajectory, "lower", "upper")
    assert path.time_apart(0.3, X) == pytest.approx(0.2, abs=1e-12)
    assert path.time_apart(2.0, X) == math.inf
    assert path.time_apart(0.3, (-1.0, 0.0, 0.0)) == math.inf
    aslant = path.time_apart(0.3, (0.6, -0.8, 0.0))
    assert aslant == pytest.approx(0.3 / (0.6 * 1.5 + 0.8 * 0.8), abs=1e-12)
    # The first of two: B goes out and comes back.
    t = np.linspace(0.0, 1.0, 41)
    p = np.stack([t - t**2, 0.0 * t, 0.0 * t], axis=1)
    v = np.stack([1.0 - 2.0 * t, 0.0 * t, 0.0 * t], axis=1)
    back = RelativePath(trajectory(t, p, v), "lower", "upper")
    assert back.time_apart(0.16, X) == pytest.approx(0.2, abs=1e-9)


def test_places_are_those_of_the_poses():
    angle = 0.7 * TIME
    motion = straight(
        TIME, (0.1, 0.2, 0.3), (1.0, -2.0, 0.5), angle=angle, rate=0.7 + 0.0 * TIME
    )
    path = RelativePath(motion, "lower", "upper")
    times = np.array([0.0, 0.31, 1.0])
    R, p = path.places(times)
    for t, R_AB, p_AB in zip(times.tolist(), R, p, strict=True):
        np.testing.assert_allclose(R_AB, path.at(t).R_AB, atol=1e-15)
        np.testing.assert_allclose(p_AB, path.at(t).p_AoBo_A, atol=1e-15)


def test_contact_is_the_worst_there_is_and_has_no_slope():
    run = fly_by(0.25)
    about = LowestClearance(run.separation).about(run, NO_LIMITS)
    assert about.value == 0.0
    assert about.near(fly_by(0.26)) == 0.0


def test_parts_that_touch_while_mated_are_left_out_unless_named():
    ring = Part(name="ring", shape=Sphere(radius=0.1), p_BoGo_B=(0.0, 3.0, 0.0))
    motion = straight(TIME, (0.0, 0.3, 0.0), (1.0, 0.0, 0.0))
    run = run_of(motion, [ROCK, ring], [BALL])
    touching = [("rock", "payload_ball")]
    left = LowestClearance(run.separation, touching=touching)
    assert left(run) == pytest.approx(-(2.7 - 0.2), abs=EXACT)
    named = LowestClearance(run.separation, touching, touching=touching)
    # From the first sample at which they have parted, 1/8 s.
    assert named(run) == pytest.approx(-(math.hypot(0.125, 0.3) - 0.3), abs=EXACT)
    with pytest.raises(ValueError, match=r"pairs: must have one .* got none"):
        LowestClearance(fly_by(0.5).separation, touching=touching)


# The second is nearer than the nearest half-way, where the search for it begins.
@pytest.mark.parametrize("place", [(0.0, 0.4, 0.0), (-0.2, 0.03, 0.0)])
def test_the_nearest_of_several_pairs_whichever_is_nearest_half_way(place):
    near = Part(name="near_ball", shape=Sphere(radius=0.1))
    far = Part(name="far_ball", shape=Sphere(radius=0.1), p_BoGo_B=place)
    motion = straight(TIME, (-0.8, 0.5, 0.0), (2.0, 0.0, 0.0))
    run = run_of(motion, [ROCK], [far, near])
    analysis = ClearanceAnalysis(run.separation)
    found = analysis.smallest(run)
    assert (found.first, found.second) == ("rock", "near_ball")
    of_all = min(one.minimum for one in analysis.of(run))
    assert found.minimum == pytest.approx(of_all, abs=ACCURACY)
    assert found.minimum == pytest.approx(0.2, abs=EXACT)


def test_sums_and_maxima_have_slopes_of_their_terms():
    run = fly_by(0.5)
    clearance = LowestClearance(run.separation)

    def along(other):
        return float(other.trajectory.states[-1, 1, 5])  # p_y of B

    mine = of_run(along)
    both = clearance + 2.0 * mine
    about = both.about(run, NO_LIMITS)
    assert both.expensive
    assert about.value == pytest.approx(-0.2 + 1.0, abs=EXACT)
    change = about.near(fly_by(0.51)) - about.value
    assert change == pytest.approx(-0.01 + 0.02, abs=1e-6)
    most = largest(clearance, -mine).about(run, NO_LIMITS)
    assert most.value == pytest.approx(-0.2, abs=EXACT)
    assert most.near(fly_by(0.51)) - most.value == pytest.approx(-0.01, abs=1e-6)


def test_bad_input():
    separation = fly_by(0.5).separation
    with pytest.raises(ValueError, match=r"until_separation must be .*> 0.*got -1"):
        LowestClearance(separation, until_separation=-1.0)
    with pytest.raises(ValueError, match="part"):
        LowestClearance(separation, [("rock", "payload_bal")])
    with pytest.raises(ValueError, match=r"unknown metric"):
        highest("clearance")


@pytest.mark.parametrize("likely", [math.inf, 0.5, 0.2, 0.1, 0.0, -1.0])
def test_what_is_likely_changes_how_soon_it_is_told_alone(likely):
    run = fly_by(0.5)
    found = LowestClearance(run.separation).nearest(run, likely)
    assert found.minimum == pytest.approx(0.2, abs=EXACT)


@pytest.mark.parametrize("miss", [0.35, 0.49, 0.7])
def test_two_points_of_the_parts_are_a_bound_in_any_run(miss):
    run = fly_by(0.5)
    objective = LowestClearance(run.separation)
    other = fly_by(miss, when=0.45)
    bound = objective.about(run, NO_LIMITS).at_least(other)
    value = objective.of_run(other, NO_LIMITS)
    assert bound <= value + EXACT
    assert objective.about(other, NO_LIMITS, bound).value == value


def test_parts_that_cannot_become_the_nearest_are_left_out():
    """What is told is as without; what is not could not reach what is nearest."""
    run = closing(0.5, more=(FAR, MID))
    objective = LowestClearance(run.separation)
    around = [closing(0.5 + 0.01, more=(FAR, MID)), closing(0.5, 0.8 + 0.1, (FAR, MID))]
    reach = np.array([10.0, 3.0])
    values, changes = objective.linearised_parts(run, around)
    told, told_changes = objective.linearised_parts(run, around, reach)
    known = np.isfinite(told)
    assert known.any() and not known.all()
    assert told[known] == pytest.approx(values[known], abs=1e-12)
    assert told_changes[known] == pytest.approx(changes[known], abs=1e-12)
    rises = np.abs(changes) @ reach
    assert (values + rises)[~known].max() < values.max()
    assert told.max() == values.max()
