"""Springs driven by displacement: energy, speed, stroke."""

import dataclasses
import math

import numpy as np
import pytest
from flying import start
from separations import FREE, GENERIC, coaxial, generic_pair

from drakesep.systems.parameters import parameters, with_values
from drakesep.systems.pushers import DisplacementSpring
from drakesep.systems.run import RunStatus
from drakesep.systems.settings import Integration
from drakesep.systems.simulation import Simulation


def linear_pair(damping=0.0, **options):
    separation = generic_pair(**options)
    attachments = tuple(
        dataclasses.replace(
            a,
            spring=DisplacementSpring(
                name=a.spring.name,
                force_max=a.spring.force_max,
                stroke=a.spring.stroke,
                damping=damping,
            ),
        )
        for a in separation.attachments
    )
    return dataclasses.replace(separation, attachments=attachments)


def reduced_mass(separation):
    lower, upper = separation.bodies
    return lower.mass * upper.mass / (lower.mass + upper.mass)


def energies(separation, times, accuracy):
    """Kinetic, spring and joint energy at the times."""
    system, context, simulator = start(separation, accuracy)
    plant = system.plant.GetMyContextFromRoot(context)
    rows = []
    for t in times:
        simulator.AdvanceTo(t)
        [springs] = system.GetOutputPort("spring_energy").Eval(context)
        [joints] = system.GetOutputPort("joint_energy").Eval(context)
        rows.append((system.plant.CalcKineticEnergy(plant), springs, joints))
    return np.array(rows)


@pytest.mark.parametrize("ratio", [0.01, 0.3, 1.0, 7.0, 100.0])
def test_relative_speed(ratio):
    """v_rel = sqrt(2 E / mu), whatever the masses: both bodies share E by theirs."""
    separation = coaxial(linear_pair(duration=3.0))
    separation = with_values(separation, {"upper.mass": 700.0 * ratio})
    run = Simulation(separation, Integration(accuracy=1e-11)).run()
    energy = sum(spring.energy for spring in separation.springs)
    speed = math.sqrt(2.0 * energy / reduced_mass(separation))
    final = run.motion.relative_velocity[-1]
    assert final[0] == pytest.approx(speed, rel=1e-9)
    assert final[1:] == pytest.approx([0.0, 0.0], abs=1e-9 * speed)


def test_motion_and_end_of_a_stroke():
    """A half pendulum: s = L (1 - cos w t) with w^2 = n F / (mu L)."""
    separation = coaxial(linear_pair())
    run = Simulation(separation, Integration(accuracy=1e-10)).run()
    w = math.sqrt(4 * 1200.0 / (reduced_mass(separation) * 0.1))
    push = run.motion.time < 0.5 * math.pi / w
    s = 0.1 * (1.0 - np.cos(w * run.motion.time[push]))
    assert run.motion.relative_position[push, 0] == pytest.approx(s, abs=1e-8)
    assert run.separation_end == pytest.approx(0.5 * math.pi / w, abs=1e-6)
    # a sample and a break, to the nanosecond to which it is found
    for times in (run.breaks, run.motion.time):
        assert np.abs(np.array(times) - run.separation_end).min() < 1e-9


def test_energy_balance_in_generic_motion():
    """Off-axis, turning, staged: what springs lose is what bodies gain."""
    separation = linear_pair(
        joint=FREE, initial=dataclasses.replace(GENERIC, w_WA_A=(0.3, -0.4, 0.5))
    )
    times = np.linspace(0.0, 0.3, 13)
    rows = energies(separation, times, 1e-12)
    stored = sum(spring.energy for spring in separation.springs)
    assert rows[0, 1] == pytest.approx(stored, rel=1e-14)
    assert rows[-1, 1] == 0.0
    assert rows.sum(axis=1) == pytest.approx([rows[0].sum()] * len(times), rel=1e-9)


def test_damper_takes_energy_and_never_pulls():
    separation = linear_pair(joint=FREE, damping=400.0)
    times = np.linspace(0.0, 0.6, 61)
    rows = energies(separation, times, 1e-9)
    total = rows.sum(axis=1)
    assert (np.diff(total) <= 1e-6).all()
    assert total[-1] < total[0] - 10.0
    undamped = energies(linear_pair(joint=FREE), times[[0, -1]], 1e-9)
    assert rows[-1, 0] < undamped[-1, 0]


def test_both_laws_agree_for_the_design():
    """Eq. 5 with its design mass at mu / n is the same motion, coaxially."""
    timed = coaxial(generic_pair())
    design = reduced_mass(timed) / 4
    timed = with_values(
        timed, {f"spring_{i}.design_mass": design for i in (1, 2, 3, 4)}
    )
    a = Simulation(timed, Integration(accuracy=1e-10)).run()
    b = Simulation(coaxial(linear_pair()), Integration(accuracy=1e-10)).run()
    assert a.separation_end == pytest.approx(b.separation_end, abs=1e-6)
    assert a.motion.relative_velocity[-1] == pytest.approx(
        b.motion.relative_velocity[-1], abs=1e-8
    )


def test_spring_that_does_not_reach_its_stroke_is_told():
    run = Simulation(linear_pair()).run({"spring_2.stroke": 50.0})
    assert run.status is RunStatus.FAILED
    assert "spring_2 has not reached its stroke" in run.message


def test_parameters_of_a_linear_spring():
    separation = linear_pair()
    assert parameters(separation)["spring_1.damping"] == 0.0
    assert "spring_1.design_mass" not in parameters(separation)
    changed = with_values(separation, {"spring_1.damping": 3.0})
    assert changed.springs[0].damping == 3.0
    with pytest.raises(ValueError, match="spring_1: damping must be >= 0, got -1"):
        with_values(separation, {"spring_1.damping": -1.0})
