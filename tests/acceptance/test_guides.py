"""Guides that rub: dry friction over a travel, either way."""

import dataclasses
import math

import numpy as np
import pytest
from conserved import of_all_bodies
from separations import FREE, generic_pair, on_axis

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.equations.forces_of_run import spring_force_over, spring_work
from drakesep.systems.equations.springs import CREEP
from drakesep.systems.model.connectors import Guide
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


LIMITS = (math.inf,) * 3
ACCURATE = Integration(accuracy=1e-9)
RUBS = Guide(name="friction", force_max=60.0, travel=0.25)
SPRING = DisplacementSpring(name="spring", force_max=900.0, stroke=0.12)
SLIDES = Joint(type="prismatic", K_F=1e6, D_F=5e3, K_T=1e6, D_T=5e3)


def on_rails(*, joint=None, coaxial=True, spring=SPRING, **changes):
    """A door with a spring, a rail, and its friction."""
    pair = generic_pair(release_times=(0.0,) * 3, initial=InitialMotion())
    door, rail, rubs = pair.attachments
    joint = joint or Joint(type="prismatic", rigid=True)
    door = dataclasses.replace(
        door, name="door", p_AoPad_A=(0.0, 0.0, 0.0), joint=FREE, spring=spring
    )
    rail = dataclasses.replace(
        rail,
        name="rail",
        p_AoPad_A=(0.1, 0.2, 0.1),
        joint=joint,
        spring=None,
        release_time=math.inf,
        release_travel=RUBS.travel,
    )
    rubs = dataclasses.replace(
        rubs, name="rubs", p_AoPad_A=(0.1, 0.2, 0.1), joint=FREE, spring=RUBS
    )
    pair = dataclasses.replace(pair, attachments=(door, rail, rubs), **changes)
    return dataclasses.replace(pair, bodies=on_axis(pair)) if coaxial else pair


def reduced_mass(pair):
    return 1.0 / sum(1.0 / body.mass for body in pair.bodies)


def test_its_work_is_force_times_travel():
    """v = sqrt(2 (E - F s) / mu), and the rest of the energy is in the motion."""
    pair = on_rails()
    run = Simulation(pair, ACCURATE).run()
    energy = 0.5 * 900.0 * 0.12 - 60.0 * 0.25
    speed = math.sqrt(2.0 * energy / reduced_mass(pair))
    # It rubs with less at first: where speeds are below some CREEP.
    assert run.motion.relative_velocity[-1, 0] == pytest.approx(speed, rel=1e-4)
    assert of_all_bodies(run).kinetic[-1] == pytest.approx(energy, rel=1e-4)
    assert run.stroke_ends["friction"] == pytest.approx(run.releases["rail"], abs=1e-8)
    *_, rubs = pair.attachments
    assert spring_work(run, rubs) == pytest.approx(-15.0, rel=1e-3)


def test_momentum_stays_where_it_rubs_beside_the_axis():
    run = Simulation(on_rails(coaxial=False), ACCURATE).run()
    whole = of_all_bodies(run)
    assert abs(whole.momentum).max() < 1e-6 and abs(whole.angular).max() < 1e-6


def pushed_by(*rows):
    times, forces = zip(*rows, strict=True)
    return Load(
        name="push",
        body="upper",
        p_BoQ_B=(1.1, 0.0, 0.0),
        times=times,
        forces=tuple((f, 0.0, 0.0) for f in forces),
    )


def test_it_rubs_either_way():
    """In and out again: F times the path."""
    push = pushed_by((0.0, -500.0), (0.2, -500.0), (0.2001, 900.0), (2.0, 900.0))
    pair = on_rails(spring=None, loads=(push,), duration=2.0)
    run = Simulation(pair, ACCURATE).run()
    *_, rubs = pair.attachments
    place = run.motion.relative_position[:, 0]
    assert place.min() < -0.005
    path = 0.25 + 2.0 * -place.min()
    # At rest it turns about, and rubs with less for a moment.
    assert spring_work(run, rubs) == pytest.approx(-60.0 * path, rel=2e-3)
    force, speed = spring_force_over(run, rubs), run.motion.relative_velocity[:, 0]
    slides = (abs(speed) > 0.02) & (run.motion.time < run.stroke_ends["friction"])
    against = -60.0 * np.sign(speed[slides])
    assert force[slides] == pytest.approx(against, rel=2e-3)


@pytest.mark.parametrize("share", [0.3, 0.6, -0.6])
def test_what_it_should_hold_creeps(share):
    """x F against dry friction F: c x / sqrt(1 - x^2), of some tenths of a mm/s."""
    x = share * 60.0
    push = pushed_by((0.0, x), (1.0, x))
    pair = on_rails(spring=None, loads=(push,))
    # Heavy, so that the launcher stays: the guide feels all of the push.
    lower, upper = pair.bodies
    inertia = tuple(1e6 * m for m in lower.I_BBcm_B)
    lower = dataclasses.replace(lower, mass=7e8, I_BBcm_B=inertia)
    rail = dataclasses.replace(pair.attachments[1], release_travel=math.inf)
    attachments = pair.attachments[0], rail, pair.attachments[2]
    pair = dataclasses.replace(pair, bodies=(lower, upper), attachments=attachments)
    run = Simulation(pair, ACCURATE).run()
    creeps = CREEP * share / math.sqrt(1.0 - share**2)
    assert run.motion.relative_velocity[-1, 0] == pytest.approx(creeps, rel=1e-4)
    assert run.held == ("rail",)


@pytest.mark.slow
def test_both_engines():
    pair = on_rails(joint=SLIDES, coaxial=False)
    names = ["friction.force_max", "friction.travel", "upper.mass"]
    rows = np.array([[60.0, 0.25, 1200.0], [100.0, 0.2, 1100.0]])
    result = Batch(pair, names).run(rows)
    assert not result.failures
    for row, told in zip(rows, result.metrics.to_dict("records"), strict=True):
        run = Simulation(pair, ACCURATE).run(dict(zip(names, row, strict=True)))
        metrics = metrics_of_run(run, LIMITS)
        for name, value in told.items():
            # 1e-8 of states that ring, of which integrals add up some.
            assert metrics[name] == pytest.approx(value, abs=1e-7), name
