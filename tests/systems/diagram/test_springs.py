"""Springs push as Eq. 5 says, and as hard on one body as on the other."""

import math

import pytest
from pydrake.systems.analysis import Simulator
from separations import coaxial, generic_pair

from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.integration import Integration
from drakesep.systems.simulation.simulation import Simulation


def test_relative_speed_of_coaxial_springs():
    """Four impulses F_max / w on the reduced mass, Eq. 5's integral."""
    separation = coaxial(generic_pair())
    run = Simulation(separation, Integration(accuracy=1e-10)).run()
    lower, upper = separation.bodies
    reduced_mass = lower.mass * upper.mass / (lower.mass + upper.mass)
    spring = separation.springs[0]
    # F / w with w^2 = F / (m L).
    impulse = 4.0 * math.sqrt(spring.force_max * spring.design_mass * spring.stroke)
    final = run.motion.relative_velocity[-1]
    # global error of many steps of 1e-10
    assert final == pytest.approx((impulse / reduced_mass, 0.0, 0.0), abs=1e-9)
    assert run.motion.rate[-1] == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_force_port_is_equation_5():
    separation = generic_pair()
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    context.SetAccuracy(1e-6)
    Simulator(system, context).Initialize()
    for t in (0.0, 0.05, 0.12, 0.2):
        context.SetTime(t)
        forces = system.GetOutputPort("spring_forces").Eval(context)
        expected = []
        for s in separation.springs:
            w = math.sqrt(s.force_max / (s.design_mass * s.stroke))
            push = s.force_max * math.cos(w * t)
            expected.append(push if w * t < 0.5 * math.pi else 0.0)
        assert forces == pytest.approx(expected, rel=1e-14)
