"""Attachments let go when they are told to."""

import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from separations import generic_pair

from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.simulation.simulation import Simulation


ACCURACY = 1e-6
# Drake isolates an event to a hundredth of the accuracy, in seconds.
LATENESS = 0.01 * ACCURACY


def released_after(release_times, times):
    """Release times that the diagram has recorded after each of the given times."""
    separation = generic_pair(release_times=release_times)
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    context.SetAccuracy(ACCURACY)
    simulator = Simulator(system, context)
    simulator.Initialize()
    port = system.GetOutputPort("released")
    recorded = []
    for t in times:
        simulator.AdvanceTo(t)
        recorded.append(port.Eval(context).tolist())
    return recorded


def test_release_at_the_start():
    [at_start] = released_after((0.0, 0.0), [0.0])
    assert at_start == [0.0, 0.0]


def test_release_scheduled_before_the_start_happens_at_the_start():
    separation = generic_pair(release_times=(0.1, 0.3))
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    context.SetAccuracy(ACCURACY)
    context.SetTime(0.2)
    Simulator(system, context).Initialize()
    released = system.GetOutputPort("released").Eval(context)
    assert released.tolist() == [0.2, math.inf]


def test_release_is_neither_early_nor_late_and_records_the_scheduled_time():
    before, after = released_after((0.2, 0.5), [0.2 - 1e-9, 0.2 + LATENESS])
    assert before == [math.inf, math.inf]
    assert after == [0.2, math.inf]


def test_simulation_may_stop_at_the_release():
    """Drake ends the process if it must find a crossing at the end of AdvanceTo."""
    at, after = released_after((0.2, 0.2), [0.2, 0.2 + 1e-12])
    assert at == [math.inf, math.inf]  # Drake leaves it to the next step
    assert after == [0.2, 0.2]


def test_releases_that_fall_together_and_a_millisecond_apart():
    times = (0.1, 0.1, 0.101, 0.102)
    steps = [0.1 + LATENESS, 0.101 + LATENESS, 0.102 + LATENESS]
    recorded = released_after(times, steps)
    assert recorded == [
        [0.1, 0.1, math.inf, math.inf],
        [0.1, 0.1, 0.101, math.inf],
        [0.1, 0.1, 0.101, 0.102],
    ]


def test_release_times_are_a_parameter_of_the_context():
    """One diagram, several schedules; the springs push from the scheduled time on."""
    simulation = Simulation(generic_pair(release_times=(0.0, 0.0)))
    for time in (0.0, 0.25):
        values = {f"attachment_{i}.release_time": time for i in (1, 2)}
        motion = simulation.run(values).motion
        moving = np.linalg.norm(motion.linear_momentum_change, axis=1) > 0.0
        start = motion.time[moving][0]
        assert time < start <= time + 0.01  # the next sample after it


def test_joints_hold_until_their_release():
    """Springs wait; the joint's deviation stays far below a millimetre."""
    run = Simulation(generic_pair(release_times=(0.3, 0.3, 0.3, 0.3))).run()
    mated = run.motion.time <= 0.3
    assert np.abs(run.motion.relative_position[mated]).max() < 1e-5
    assert np.abs(run.motion.relative_position[~mated]).max() > 0.1
    assert run.motion.linear_momentum_change[mated] == pytest.approx(0.0, abs=0.0)
