"""Connectors: pins and seals that resist once over their travel, and dissipate."""

import dataclasses
import math

import numpy as np
import pytest
from conserved import of_all_bodies
from separations import FREE, by_displacement, coaxial, generic_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.equations.forces_of_run import spring_force_over, spring_work
from drakesep.systems.equations.springs import CREEP
from drakesep.systems.model.connectors import Connector
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.loads import Load
from drakesep.systems.model.separation import Attachment, InitialMotion
from drakesep.systems.simulation.simulation import Simulation


ACCURATE = Integration(accuracy=1e-9)
PIN = Connector(name="pin", force_max=800.0, travel=0.03)
SEAL = Connector.from_table(
    name="seal", displacements=(0.0, 0.01, 0.04), forces=(900.0, 300.0, 0.0)
)
TAKEN = {"pin": 800.0 * 0.03, "seal": 0.5 * (1200.0 * 0.01 + 300.0 * 0.03)}
"""Areas of their tables, J."""
STORED = 4.0 * 0.5 * 1200.0 * 0.1


def connected(pair, connector, place=(0.0, 0.0, 0.0)):
    """A pair with a connector beside its springs."""
    plug = Attachment(
        name="plug", A="lower", B="upper", p_AoPad_A=place, joint=FREE, spring=connector
    )
    return dataclasses.replace(pair, attachments=(*pair.attachments, plug))


def springs():
    pair = coaxial(generic_pair(duration=0.6))
    return by_displacement(dataclasses.replace(pair, initial=InitialMotion()))


def reduced_mass(pair):
    return 1.0 / sum(1.0 / body.mass for body in pair.bodies)


@pytest.mark.parametrize("connector", [PIN, SEAL], ids=["pin", "seal"])
def test_its_energy_is_taken_from_the_speed(connector):
    """v = sqrt(2 (E - W) / mu), with W the area of its table."""
    pair = connected(springs(), connector)
    run = Simulation(pair, ACCURATE).run()
    speed = math.sqrt(2.0 * (STORED - TAKEN[connector.name]) / reduced_mass(pair))
    metrics = metrics_of_run(run, (math.inf,) * 3)
    # It rubs with less at first: where speeds are below some CREEP, within 0.1 mm.
    assert metrics["longitudinal_speed_max"] == pytest.approx(speed, rel=1e-4)
    assert metrics["longitudinal_speed_max"] >= speed
    [plug] = (a for a in pair.attachments if a.name == "plug")
    work = spring_work(run, plug)
    assert work == pytest.approx(-TAKEN[connector.name], rel=1e-3)
    force = spring_force_over(run, plug)
    assert force.max() == 0.0 and force.min() > -connector.force_max
    place = np.interp(
        run.stroke_ends[connector.name],
        run.motion.time,
        run.motion.relative_position[:, 0],
    )
    assert place == pytest.approx(connector.travel, abs=1e-6)
    assert (force[run.motion.time >= run.stroke_ends[connector.name]] == 0.0).all()


def test_what_it_loses_at_rest_is_of_its_creep():
    """Along s = a t^2 / 2: the share is the mean of 1 - v / sqrt(v^2 + c^2) over s."""
    pair = connected(springs(), PIN)
    run = Simulation(pair, ACCURATE).run()
    speed = metrics_of_run(run, (math.inf,) * 3)["longitudinal_speed_max"]
    mu = reduced_mass(pair)
    given = STORED - 0.5 * mu * speed**2
    v = np.linspace(0.0, 0.5, 1_000_001)
    a = (4.0 * 1200.0 - 800.0) / mu  # at first, where it matters
    less = np.trapezoid((1.0 - v / np.hypot(v, CREEP)) * v / a, v)
    # Some tenths of it: the springs weaken, and it takes its force little by little.
    assert TAKEN["pin"] - given == pytest.approx(800.0 * less, rel=0.3)


def test_beside_the_axis_it_turns_and_only_dissipates():
    pair = connected(springs(), PIN, place=(0.0, 0.3, -0.4))
    run = Simulation(pair, ACCURATE).run()
    whole = of_all_bodies(run)
    assert abs(whole.momentum).max() < 1e-6 and abs(whole.angular).max() < 1e-6
    assert whole.kinetic[-1] == pytest.approx(STORED - TAKEN["pin"], rel=1e-4)
    # About z by its y, and about y by its z: M = r x J, of one impulse J against x.
    rate = run.motion.rate[-1] * pair.body("upper").I_BBcm_B[:3]
    assert rate[1] / rate[2] == pytest.approx(0.4 / 0.3, rel=0.05)
    mirrored = [
        dataclasses.replace(a, p_AoPad_A=tuple(np.multiply(a.p_AoPad_A, (1, -1, 1))))
        for a in pair.attachments
    ]
    pair = dataclasses.replace(pair, attachments=tuple(mirrored))
    other = Simulation(pair, ACCURATE).run().motion.rate[-1]
    same = run.motion.rate[-1] * [-1.0, 1.0, -1.0]
    assert other == pytest.approx(same, abs=1e-8)


def test_it_does_not_resist_what_comes_back():
    """Pressed back at once, it slides in freely; drawn out, it takes its work."""
    pair = springs()
    attachments = [dataclasses.replace(a, spring=None) for a in pair.attachments]
    pair = dataclasses.replace(pair, attachments=tuple(attachments))
    back = Load(
        name="back",
        body="upper",
        p_BoQ_B=(1.1, 0.0, 0.0),
        times=(0.0, 0.1, 0.1001, 0.6),
        forces=((-500.0, 0.0, 0.0),) * 2 + ((4000.0, 0.0, 0.0),) * 2,
    )
    pair = dataclasses.replace(connected(pair, PIN), loads=(back,))
    run = Simulation(pair, ACCURATE).run()
    [plug] = (a for a in pair.attachments if a.name == "plug")
    force, time = spring_force_over(run, plug), run.motion.time
    speed = run.motion.relative_velocity[:, 0]
    assert speed.min() < -0.03
    assert (force[speed <= 0.0] == 0.0).all() and force.min() < -0.99 * PIN.force_max
    # It is drawn over the way that it went in, too.
    deep = -run.motion.relative_position[:, 0].min()
    assert spring_work(run, plug) == pytest.approx(-800.0 * (0.03 + deep), rel=2e-3)
    assert (time[force < 0.0] > 0.1).all()


def test_out_it_resists_nothing():
    pair = connected(springs(), PIN)
    run = Simulation(pair, ACCURATE).run({"pin.force_max": 0.0})
    speed = metrics_of_run(run, (math.inf,) * 3)["longitudinal_speed_max"]
    expected = math.sqrt(2.0 * STORED / reduced_mass(pair))
    assert speed == pytest.approx(expected, rel=1e-7)


@pytest.mark.slow
def test_both_engines():
    pair = by_displacement(generic_pair(duration=0.6))
    for connector, place in ((PIN, (0.0, 0.3, -0.4)), (SEAL, (0.0, -0.2, 0.1))):
        pair = connected(pair, connector, place)
        *others, plug = pair.attachments
        plug = dataclasses.replace(plug, name=f"plug_{connector.name}")
        pair = dataclasses.replace(pair, attachments=(*others, plug))
    names = ["pin.force_max", "pin.travel", "seal.force_max", "seal.tilt_y"]
    rows = np.array([[800.0, 0.03, 900.0, 0.0], [500.0, 0.04, 1100.0, 0.2]])
    result = Batch(pair, names).run(rows)
    assert not result.failures
    for row, told in zip(rows, result.metrics.to_dict("records"), strict=True):
        run = Simulation(pair, ACCURATE).run(dict(zip(names, row, strict=True)))
        metrics = metrics_of_run(run, (math.inf,) * 3)
        for name, value in told.items():
            # Both engines promise 1e-8 of states; an integral of magnitudes is told
            # by splines through samples in Drake.
            within = 1e-7 if name == "G_L1" else 3e-8
            assert metrics[name] == pytest.approx(value, abs=within), name


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"force_max": -1.0}, "pin: maximum force must be >= 0, got -1"),
        ({"travel": 0.0}, "pin: travel must be > 0, got 0"),
        ({"profile": ((0.0, 0.5), (1.0, 0.7))}, "pin: profile must have forces"),
    ],
)
def test_impossible_connectors(changes, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(PIN, **changes)
