"""Whole runs: against an independent integration, converged, repeatable."""

import dataclasses
import math
import resource

import numpy as np
import oracle
import pytest
from separations import FREE, GENERIC, by_displacement, coaxial, generic_pair, vega

from drakesep.systems.diagram.wrenches import Forces
from drakesep.systems.model.integration import SCHEMES, Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.run import Motion, RunStatus
from drakesep.systems.simulation.simulation import Simulation
from drakesep.systems.simulation.state_notice import StateNotice


def same(a: Motion, b: Motion) -> bool:
    return all(
        np.array_equal(getattr(a, field.name), getattr(b, field.name))
        for field in dataclasses.fields(Motion)
    )


@pytest.mark.parametrize(
    "separation",
    [
        vega(),
        generic_pair(orbit=Orbit(radius=7.0e6)),
        generic_pair(
            initial=dataclasses.replace(GENERIC, w_WA_A=(0.9, -1.1, 0.8)), duration=3.0
        ),
    ],
    ids=["vega", "generic", "large rates"],
)
def test_against_an_independent_integration(separation):
    run = Simulation(separation, Integration(accuracy=1e-10)).run()
    flight = oracle.fly(separation, run.motion.time)
    # 1e-10 a step; momenta are per mass and per inertia of about a thousand.
    for name, tolerance in {
        "rate": 5e-10,
        "relative_rate": 5e-10,
        "angle": 1e-9,
        "relative_velocity": 1e-8,
        "linear_momentum_change": 1e-6,
        "angular_momentum_change": 1e-6,
    }.items():
        expected = getattr(flight, name)
        assert getattr(run.motion, name) == pytest.approx(expected, abs=tolerance)


@pytest.mark.parametrize("worst", [False, True], ids=["nominal", "corner"])
def test_default_accuracy_is_enough(worst):
    """Within 1e-6 deg/s and 1e-6 m of a run 100 times tighter."""
    separation = vega()
    tight = Integration(accuracy=0.01 * Integration().accuracy)
    values = {"payload.mass": 1840.0, "spring_1.force_max": 1500.0} if worst else {}
    a = Simulation(separation).run(values).motion
    b = Simulation(separation, tight).run(values).motion
    assert np.degrees(a.rate[-1]) == pytest.approx(np.degrees(b.rate[-1]), abs=1e-6)
    assert a.relative_position == pytest.approx(b.relative_position, abs=1e-6)


def test_error_falls_with_the_accuracy():
    separation = by_displacement(vega())
    reference = Simulation(separation, Integration(accuracy=1e-11)).run().motion
    errors = []
    for accuracy in (1e-5, 1e-7, 1e-9):
        motion = Simulation(separation, Integration(accuracy=accuracy)).run().motion
        difference = motion.relative_position - reference.relative_position
        errors.append(np.abs(difference).max())
    assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_forces_are_of_the_state_that_is_integrated(monkeypatch, scheme):
    """At every evaluation, those after rejected steps, too."""
    contexts, seen = [], []
    watch, wrenches = StateNotice.watch, Forces.wrenches_at

    def watched_one(notice, context):
        contexts.append(context)
        watch(notice, context)

    def watched(self, acting, t, x, given):
        state = contexts[-1].get_continuous_state_vector().CopyToVector()
        seen.append(x == state.tolist() and t == contexts[-1].get_time())
        return wrenches(self, acting, t, x, given)

    monkeypatch.setattr(StateNotice, "watch", watched_one)
    monkeypatch.setattr(Forces, "wrenches_at", watched)
    separation = by_displacement(generic_pair(release_times=(0.05,) * 4, duration=0.3))
    run = Simulation(separation, Integration(scheme=scheme, accuracy=1e-5)).run()
    stages = {"runge_kutta3": 3, "runge_kutta5": 7}.get(scheme, 4)
    assert run.evaluations > stages * run.steps  # some are rejected
    assert len(seen) > 0.5 * run.evaluations and all(seen)


LAWS = {
    "linear": {},
    "table": {"profile": ((0.0, 0.7), (0.1, 1.0), (0.6, 0.4), (1.0, 0.0))},
    "lifting": {"damping": 300.0},
}


@pytest.mark.parametrize("law", LAWS)
def test_steps_end_at_kinks_that_are_foreseen(law):
    """No step is rejected for a kink, and none hides from the error estimate."""
    separation = by_displacement(generic_pair(), **LAWS[law])
    run = Simulation(separation).run()
    # Seven a step; one may be rejected after a corner, where its force steepens.
    assert run.evaluations <= 7 * (run.steps + 1)
    tight = Simulation(separation, Integration(accuracy=1e-11)).run()
    apart = run.trajectory.states[-1] - tight.trajectory.states[-1]
    # Some 50 steps of 1e-7 each; a kink within one step would leave 1e-5.
    assert np.abs(apart).max() < 5e-7


def test_steps_end_where_a_force_that_curves_lifts_off():
    """One step that straddled the lift-off would err by 6e-6."""
    profile = ((0.0, 0.73), (0.07, 1.0), (0.48, 0.01), (0.68, 0.63), (1.0, 0.5))
    separation = by_displacement(
        generic_pair(release_times=(0.0, 0.0), joint=FREE, duration=3.0),
        profile=profile,
        damping=50.0,
    )
    run = Simulation(separation).run()
    tight = Simulation(separation, Integration(accuracy=1e-11)).run()
    apart = run.trajectory.states[-1] - tight.trajectory.states[-1]
    # A hundred steps of 1e-7, errors of either sign.
    assert np.abs(apart).max() < 1e-6


def test_kinks_at_the_same_time_as_a_jump():
    """Pads side by side: two springs end as they are spent, two with force left.

    Drake ends the process where what it searches lies at the end of a step.
    """
    pair = coaxial(by_displacement(generic_pair()))
    attachments = [
        dataclasses.replace(
            a, spring=dataclasses.replace(a.spring, profile=((0.0, 1.0), (1.0, left)))
        )
        for a, left in zip(pair.attachments, (0.0, 0.3, 0.0, 0.3), strict=True)
    ]
    run = Simulation(dataclasses.replace(pair, attachments=tuple(attachments))).run()
    energy = sum((1.0 + k) * 0.5 * 1200.0 * 0.1 for k in (0.0, 0.3, 0.0, 0.3))
    lightness = sum(1.0 / body.mass for body in pair.bodies)
    speed = run.motion.relative_velocity[-1, 0]
    # The jump is found within 1e-8 s, of 720 N on half a ton.
    assert speed == pytest.approx(math.sqrt(2.0 * energy * lightness), abs=1e-7)


@pytest.mark.parametrize("apart", [1e-15, 9e-10])
def test_releases_within_a_nanosecond_are_as_if_at_once(apart):
    """No step straddles the second: it would be told as if all of it came after."""
    separation = generic_pair(release_times=(0.1, 0.1), joint=Joint(rigid=True))
    at_once = Simulation(separation).run().trajectory
    second = Simulation(separation).run({"attachment_2.release_time": 0.1 + apart})
    assert second.releases["attachment_2"] == 0.1 + apart
    states = second.trajectory.states
    assert second.trajectory.time == pytest.approx(at_once.time, abs=1e-9)
    # Samples a nanosecond apart, at 2 m/s or less; steps err by 1e-7.
    assert states == pytest.approx(at_once.states, abs=1e-6)


@pytest.mark.parametrize("law", ["time", "displacement"])
def test_between_steps_as_by_hand(law):
    """Springs of both laws push as X (1 - cos w t), then bodies go straight on.

    At samples, of which there are several a step.
    """
    separation = coaxial(generic_pair())
    spring, count = separation.springs[0], len(separation.springs)
    mu = 1.0 / sum(1.0 / body.mass for body in separation.bodies)
    if law == "time":
        w = math.sqrt(spring.force_max / (spring.design_mass * spring.stroke))  # Eq. 5
    else:
        separation = by_displacement(separation)
        w = math.sqrt(count * spring.force_max / spring.stroke / mu)
    amplitude = count * spring.force_max / (mu * w * w)
    run = Simulation(separation).run()
    t = run.motion.time
    end = 0.5 * math.pi / w
    assert len(t) > 5 * run.steps
    pushed, after = w * np.minimum(t, end), np.maximum(t - end, 0.0)
    travel = amplitude * (1.0 - np.cos(pushed) + w * after)
    speed = amplitude * w * np.sin(pushed)
    gained = count * spring.force_max / separation.body("upper").mass * np.cos(pushed)
    # 1e-6: the default accuracy; of accelerations, w as much.
    assert run.motion.relative_position[:, 0] == pytest.approx(travel, abs=1e-6)
    assert run.motion.relative_velocity[:, 0] == pytest.approx(speed, abs=1e-6)
    along = np.linalg.norm(run.motion.acceleration, axis=1)
    assert along == pytest.approx(gained, abs=1e-5)
    assert list(run.stroke_ends.values()) == pytest.approx([end] * count, abs=1e-7)


def test_every_setting_of_an_integration_has_an_effect():
    """No step is longer than the longest; a finer accuracy and another scheme show."""

    def effort(**settings):
        run = Simulation(vega(), Integration(**settings)).run()
        return run.steps, run.evaluations

    steps, evaluations = effort()
    assert effort(max_step=0.01)[0] >= 3.0 / 0.01 > 2 * steps
    assert effort(accuracy=1e-11)[0] > 2 * steps
    told = {scheme: effort(scheme=scheme) for scheme in SCHEMES}
    assert told["runge_kutta5"] == (steps, evaluations)
    assert len(set(told.values())) == len(SCHEMES)
    settings = {field.name for field in dataclasses.fields(Integration)}
    assert settings == {"scheme", "accuracy", "max_step", "time_limit"}


def test_same_run_bit_for_bit_whatever_ran_before():
    simulation = Simulation(generic_pair(release_times=(0.0, 0.05, 0.1, 0.101)))
    first = simulation.run().motion
    simulation.run({"upper.mass": 1300.0, "attachment_1.release_time": 0.3})
    simulation.run({"lower.cg_y": 0.2, "spring_2.stroke": 0.2})
    assert same(simulation.run().motion, first)
    assert same(Simulation(simulation.separation).run().motion, first)


def test_samples():
    """At least 300 rows, start, end and every kink among them, in order."""
    separation = generic_pair(release_times=(0.0, 0.0, 0.1, 0.2))
    run = Simulation(separation).run()
    time = run.motion.time
    assert len(time) > 300
    assert (time[0], time[-1]) == (0.0, separation.duration)
    assert (np.diff(time) > 0.0).all()
    ends = separation.timed_stroke_ends(separation.scheduled_releases).values()
    kinks = {0.1, 0.2, *ends}
    assert kinks <= set(run.breaks) <= set(time)
    assert run.separation_end == max(ends)


def test_releases_of_a_run_are_exact():
    """Steps end at the releases: nothing happens early or late, by a bit."""
    run = Simulation(generic_pair(release_times=(0.1, 0.1, 0.1, 0.1))).run()
    momentum = np.linalg.norm(run.motion.linear_momentum_change, axis=1)
    assert momentum[run.motion.time <= 0.1].max() == 0.0
    at_release = run.motion.acceleration[run.motion.time == 0.1]
    force = sum(s.force_max for s in run.separation.springs)
    assert np.linalg.norm(at_release) == pytest.approx(force / 1200.0, rel=1e-12)


def test_runs_of_a_case_share_their_times():
    """300 intervals of the run, whatever the springs do; more between them."""
    simulation = Simulation(generic_pair())
    grid = set(np.linspace(0.0, 1.0, 301))
    for values in ({}, {"spring_1.stroke": 0.11, "spring_2.force_max": 1000.0}):
        assert grid <= set(simulation.run(values).motion.time)


def test_short_stroke_does_not_multiply_the_samples():
    run = Simulation(generic_pair()).run({"spring_1.stroke": 1e-9})
    assert len(run.motion.time) < 700


def test_separation_ends_with_the_last_release():
    """An attachment without a spring may hold longest."""
    separation = generic_pair(release_times=(0.0, 0.0, 0.0, 0.5))
    *others, last = separation.attachments
    last = dataclasses.replace(last, spring=None)
    separation = dataclasses.replace(separation, attachments=(*others, last))
    assert Simulation(separation).run().separation_end == 0.5


def test_values_are_those_flown():
    run = Simulation(generic_pair()).run({"upper.mass": 1300.0})
    assert run.separation.body("upper").mass == 1300.0


def test_failed_run_says_why(monkeypatch):
    """Gains that only steps of nanoseconds can follow stop the run, not the program."""
    monkeypatch.setattr("drakesep.systems.simulation.simulation._MOST_STEPS", 1000)
    stiff = Joint(K_F=1e15, D_F=0.0, K_T=1e15, D_T=0.0)
    separation = generic_pair(release_times=(0.5,), joint=stiff)
    run = Simulation(separation).run()
    assert run.status is RunStatus.FAILED
    assert run.motion is None
    assert run.message.startswith("it takes more than 1000 steps (at t = 0.0")
    with pytest.raises(RuntimeError, match="the run failed"):
        _ = run.completed_motion


def test_evaluations_are_limited(monkeypatch):
    """As steps are: one of an implicit scheme may take hundreds."""
    module = "drakesep.systems.simulation.simulation"
    needed = Simulation(generic_pair()).run().evaluations
    monkeypatch.setattr(f"{module}._MOST_EVALUATIONS", needed)
    assert Simulation(generic_pair()).run().status is RunStatus.COMPLETED
    monkeypatch.setattr(f"{module}._MOST_EVALUATIONS", needed // 2)
    run = Simulation(generic_pair()).run()
    assert run.status is RunStatus.FAILED
    wanted = f"it takes more than {needed // 2} evaluations of its forces (at t = "
    assert run.message.startswith(wanted)


def test_time_is_limited():
    """A microsecond is over by the first step."""
    short = Integration(time_limit=1e-6)
    run = Simulation(generic_pair(), short).run()
    assert run.status is RunStatus.FAILED
    wanted = "it takes more than its time limit on this machine, 1e-06 s (at t = 0"
    assert run.message.startswith(wanted)


def test_runs_do_not_pile_up_memory():
    """A hundred runs in one diagram; a rebuilt one would keep 170 KiB each."""
    simulation = Simulation(generic_pair(duration=0.3))
    for _ in range(20):
        simulation.run()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(100):
        simulation.run()
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert after - before < 5000  # KiB: a third of what rebuilding would leave
