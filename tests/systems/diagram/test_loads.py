"""Thrusters, retro-rockets and disturbances: what they give, and when."""

import dataclasses
import math

import numpy as np
import pytest
from flying import start
from separations import FREE, GENERIC, generic_pair

from drakesep.systems.model.loads import Load, thruster
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.simulation.simulation import Simulation


PULSE = {"times": (0.0, 0.1, 0.3), "forces": ((0, 0, 0), (60, -20, 30), (0, 0, 0))}


def with_loads(*loads, **options):
    options = {"springs": False, "joint": FREE} | options
    return dataclasses.replace(generic_pair(**options), loads=loads)


def momenta(separation, times):
    """Linear and angular momentum of all, (n, 6), about W's origin."""
    system, context, simulator = start(separation, 1e-8)
    plant_context = system.plant.GetMyContextFromRoot(context)
    rows = []
    for t in times:
        simulator.AdvanceTo(t)
        total = system.plant.CalcSpatialMomentumInWorldAboutPoint(
            plant_context, np.zeros(3)
        )
        rows.append(np.append(total.translational(), total.rotational()))
    return np.array(rows)


def test_impulse_in_world_axes():
    """What a table of forces gives is its area, in generic motion."""
    load = Load(name="gust", body="upper", axes="world", **PULSE)
    rows = momenta(with_loads(load, initial=GENERIC), [0.0, 0.2, 0.5])
    given = (rows - rows[0])[:, :3]
    peak = np.array(PULSE["forces"][1])
    # 0.05 + 0.075 at 0.2 s; 0.15 in all
    assert given[1] == pytest.approx(0.125 * peak, abs=1e-5)
    assert given[2] == pytest.approx(0.15 * peak, abs=1e-5)


def test_torque_in_world_axes():
    load = Load(
        name="torque",
        body="lower",
        axes="world",
        times=(0.1, 0.2),
        torques=((5.0, -3.0, 8.0),) * 2,
    )
    rows = momenta(with_loads(load, initial=GENERIC), [0.0, 0.5])
    given = (rows - rows[0])[1]
    assert given[3:] == pytest.approx([0.5, -0.3, 0.8], abs=1e-5)
    assert given[:3] == pytest.approx(np.zeros(3), abs=1e-5)


def test_steps_that_end_at_rows_of_a_table_are_not_searched():
    """Times of rows are met to round-off: a load of nearly nothing costs few steps."""
    times = (0.07, 0.1, 0.3)
    whiff = [
        Load(
            name=name,
            body="upper",
            after=after,
            start=0.02,
            times=times,
            forces=((1e-9, 0, 0),) * 3,
        )
        for name, after in (("from the start", None), ("after", "attachment_1"))
    ]
    plain = with_loads(initial=GENERIC, release_times=(0.03,) * 4)
    loaded = dataclasses.replace(plain, loads=tuple(whiff))
    without, with_them = (Simulation(each).run() for each in (plain, loaded))
    # Each of the six rows cuts a step in two, and the tries of the first are shorter.
    assert with_them.steps <= without.steps + 2 * 6


def test_thruster_turns_with_its_body():
    """A thrust through the CG of a spinning body: the impulse of a turning force."""
    separation = with_loads(initial=InitialMotion(w_WA_A=(0.0, 0.0, 2.0)))
    upper = dataclasses.replace(
        separation.body("upper"), I_BBcm_B=(900.0, 900.0, 900.0, 0.0, 0.0, 0.0)
    )
    jet = thruster(
        name="jet",
        body="upper",
        p_BoQ_B=upper.p_BoBcm_B,
        direction_B=(0.6, 0.8, 0.0),
        times=(0.0, 0.4),
        thrusts=(50.0, 50.0),
    )
    separation = dataclasses.replace(
        separation, bodies=(separation.body("lower"), upper), loads=(jet,)
    )
    rows = momenta(separation, [0.0, 0.6])
    angle = math.atan2(0.8, 0.6)
    along = 25.0 * (math.sin(0.8 + angle) - math.sin(angle))
    across = 25.0 * (math.cos(angle) - math.cos(0.8 + angle))
    given = (rows - rows[0])[1, :3]
    assert given == pytest.approx([along, across, 0.0], abs=1e-5)


def test_a_short_pulse_is_not_stepped_over():
    """A millisecond, in a coast whose steps are a second long."""
    load = Load(
        name="kick",
        body="lower",
        axes="world",
        times=(0.8, 0.801),
        forces=((1000.0, 0.0, 0.0),) * 2,
    )
    rows = momenta(with_loads(load, initial=InitialMotion()), [0.0, 0.99])
    # begin and end are found to 1e-10 s; 1e-8 m/s a step of nearly two tons
    assert (rows - rows[0])[1, 0] == pytest.approx(1.0, abs=2e-5)


def test_load_after_a_release():
    """A retro-rocket that is lit by a release, whenever that is."""
    retro = thruster(
        name="retro",
        body="lower",
        p_BoQ_B=(-1.0, 0.0, 0.0),
        direction_B=(-1.0, 0.0, 0.0),
        times=(0.0, 0.1),
        thrusts=(500.0, 500.0),
        start=0.05,
        after="attachment_1",
    )
    separation = with_loads(retro, release_times=(0.2,), initial=InitialMotion())
    simulation = Simulation(separation)
    for release in (0.2, 0.4):
        run = simulation.run({"attachment_1.release_time": release})
        assert {round(t, 12) for t in run.breaks} == {
            0.0,
            release,
            round(release + 0.05, 12),
            round(release + 0.15, 12),
            1.0,
        }
        speed = run.motion.relative_velocity
        before = run.motion.time <= release + 0.05
        # at rest but for round-off
        assert np.abs(speed[before]).max() < 1e-12
        assert speed[-1, 0] > 0.05


def test_parameters_of_a_load():
    load = Load(name="gust", body="upper", axes="world", **PULSE)
    simulation = Simulation(with_loads(load, initial=InitialMotion()))
    once, twice, later = (
        simulation.run(values).motion
        for values in ({}, {"gust.factor": 2.0}, {"gust.start": 0.5})
    )
    # as seen from the other body, which the gust does not turn
    assert twice.relative_velocity[-1] == pytest.approx(
        2.0 * once.relative_velocity[-1], abs=1e-6
    )
    assert np.abs(later.acceleration[later.time <= 0.5]).max() < 1e-12


def test_kinks_are_the_rows_at_which_a_load_acts():
    quiet = Load(
        name="two pulses",
        body="upper",
        times=(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
        torques=((0, 0, 0), (0, 1, 0), *((0, 0, 0),) * 3, (0, 0, 2), (0, 0, 2)),
    )
    assert quiet.kinks == (0.0, 1.0, 2.0, 4.0, 5.0, 6.0)


def test_a_pulse_on_top_of_a_load_is_not_stepped_over():
    """Two milliseconds of 10 kN, in a second of 10 N."""
    load = Load(
        name="kick",
        body="lower",
        axes="world",
        times=(0.0, 0.5, 0.501, 0.502, 0.95),
        forces=tuple((f, 0.0, 0.0) for f in (10.0, 10.0, 1e4, 10.0, 10.0)),
    )
    rows = momenta(with_loads(load, initial=InitialMotion()), [0.0, 0.99])
    given = (rows - rows[0])[1, 0]
    assert given == pytest.approx(9.5 + 9990.0 * 1e-3, abs=1e-4)


@pytest.mark.parametrize("start", [0.0, 1e-9, 1e-3])
def test_load_that_follows_a_release_at_once(start):
    """Under a plain Simulator, whose steps the release does not end exactly."""
    load = Load(
        name="retro",
        body="lower",
        axes="world",
        times=(0.0, 0.05),
        forces=((1000.0, 0.0, 0.0),) * 2,
        start=start,
        after="attachment_1",
    )
    separation = with_loads(load, release_times=(0.237,), initial=InitialMotion())
    rows = momenta(separation, [0.0, 0.5])
    # begins up to 1e-9 s late, and then within event isolation
    assert (rows - rows[0])[1, 0] == pytest.approx(50.0, abs=1e-4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"times": (0.0,)}, "times must be two or more and increase, got 0"),
        ({"times": (0.0, 0.2, 0.1)}, "times must be two or more and increase"),
        ({"times": (-1.0, 0.0, 1.0)}, "first time must be >= 0, got -1"),
        (
            {"times": (0.0, 1.0)},
            "forces must have a row for each of the 2 times",
        ),
        ({"forces": ((0, 0),) * 3}, "forces must have 3 entries, got 2"),
        ({"forces": ((0, 0, math.nan),) * 3}, "forces must be finite, got nan"),
        ({"axes": "orbit"}, "unknown axes 'orbit'"),
        ({"start": -1.0}, "start must be >= 0, got -1"),
        ({"factor": math.inf}, "factor must be finite"),
        ({"forces": ()}, "must have forces or torques, got none"),
    ],
)
def test_bad_loads(change, message):
    with pytest.raises(ValueError, match=f"gust: {message}"):
        Load(**({"name": "gust", "body": "upper"} | PULSE | change))


def test_loads_that_name_nothing():
    load = Load(name="gust", body="uper", **PULSE)
    with pytest.raises(ValueError, match="gust: unknown body 'uper'; did you mean"):
        with_loads(load)
    with pytest.raises(ValueError, match="gust: must begin before the end of the run"):
        with_loads(dataclasses.replace(load, body="upper", start=3.0))
    load = dataclasses.replace(load, body="upper", after="attachment_9")
    with pytest.raises(ValueError, match="gust: unknown attachment 'attachment_9'"):
        with_loads(load)
    with pytest.raises(ValueError, match="jet: direction must be of length 1"):
        thruster(
            name="jet",
            body="upper",
            p_BoQ_B=(0, 0, 0),
            direction_B=(1.0, 1.0, 0.0),
            times=(0.0, 1.0),
            thrusts=(1.0, 1.0),
        )
    with pytest.raises(ValueError, match="jet: thrusts must be as many as the 2 times"):
        thruster(
            name="jet",
            body="upper",
            p_BoQ_B=(0, 0, 0),
            direction_B=(1.0, 0.0, 0.0),
            times=(0.0, 1.0),
            thrusts=(1.0,),
        )
