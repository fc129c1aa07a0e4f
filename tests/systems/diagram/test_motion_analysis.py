"""The ports of the diagram give what the table of a run holds.

What that should hold, poses and Eq. 5 say in `tests/roof/tables/test_run_recomputed`.
"""

import dataclasses

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from separations import generic_pair

from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.run import Motion
from drakesep.systems.simulation.simulation import Simulation


ACCURACY = 1e-8


def test_ports_under_somebody_elses_simulator():
    """Every quantity, at times between the samples' own steps."""
    separation = generic_pair(
        release_times=(0.0, 0.0, 0.1, 0.1), orbit=Orbit(radius=7e6)
    )
    motion = Simulation(separation, Integration(accuracy=ACCURACY)).run().motion

    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    context.SetAccuracy(ACCURACY)
    simulator = Simulator(system, context)
    simulator.get_mutable_integrator().set_target_accuracy(ACCURACY)
    simulator.Initialize()
    scale = {
        # Cubics between steps: velocities to the accuracy, accelerations to what a
        # step of 1 ms leaves of the joints' ringing (100 rad/s) and the springs.
        "acceleration": 5e-3,
        "linear_momentum_change": 1e-6 * 1200.0,
        "angular_momentum_change": 1e-6 * 700.0,
    }
    for i in (0, 20, 90, 200, 330):
        simulator.AdvanceTo(motion.time[i])
        for field in dataclasses.fields(Motion):
            if field.name == "time":
                continue
            port = system.GetOutputPort(field.name).Eval(context)
            table = getattr(motion, field.name)[i]
            tolerance = scale.get(field.name, 1e-6)
            assert port == pytest.approx(table, abs=tolerance), (field.name, i)


def test_acceleration_is_force_over_mass():
    """At release the springs alone act: F_max each, along A's x axis."""
    separation = generic_pair()
    motion = Simulation(separation).run().motion
    mass = separation.body("upper").mass
    # The rotating stack gives B's CG no force: its joints have just let go.
    force = sum(s.force_max for s in separation.springs)
    assert np.linalg.norm(motion.acceleration[0]) == pytest.approx(
        force / mass, rel=1e-12
    )


def test_velocity_is_the_derivative_of_position():
    motion = Simulation(generic_pair(), Integration(accuracy=1e-9)).run().motion
    late = motion.time > 0.3
    t, p = motion.time[late], motion.relative_position[late]
    speed = np.gradient(p, t, axis=0, edge_order=2)[1:-1]
    # central differences over 3 ms of a motion that turns at 0.1 rad/s
    assert speed == pytest.approx(motion.relative_velocity[late][1:-1], abs=1e-6)
