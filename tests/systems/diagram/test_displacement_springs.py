"""Springs driven by displacement: energy, speed, stroke."""

import dataclasses
import math

import numpy as np
import pytest
from flying import start
from separations import FREE, GENERIC, by_displacement, coaxial, generic_pair

from drakesep.systems.model.integration import Integration
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.run import RunStatus
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


def linear_pair(damping=0.0, **options):
    return by_displacement(generic_pair(**options), damping=damping)


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


def test_a_stuck_spring_ends_a_step_and_those_beside_it_do_not():
    """Only a jump is searched for: it takes Drake some twenty tries of some steps each.

    Until then four equal springs push: s = L / 2, when cos w t = 1 / 2.
    """
    separation = coaxial(linear_pair())
    first = separation.springs[0].name
    stuck = with_values(separation, {f"{first}.lost_stroke": 0.5})
    whole, lost = (
        Simulation(one, Integration(accuracy=1e-8)).run() for one in (separation, stuck)
    )
    w = math.sqrt(4 * 1200.0 / (reduced_mass(separation) * 0.1))
    # a hundredth of the accuracy, and what that of the motion makes of it
    assert lost.stroke_ends[first] == pytest.approx(math.pi / 3.0 / w, abs=1e-8)
    # Other ends are foreseen, with a few steps each; four searches take four times all.
    assert lost.steps < 2.0 * whole.steps


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


MEASURED = {
    "displacements": (0.0, 0.02, 0.05, 0.12),
    "forces": (900.0, 1200.0, 500.0, 200.0),  # pushes to the end of its stroke
}


def measured_pair(**options):
    separation = generic_pair(**options)
    attachments = tuple(
        dataclasses.replace(
            a, spring=DisplacementSpring.from_table(name=a.spring.name, **MEASURED)
        )
        for a in separation.attachments
    )
    return dataclasses.replace(separation, attachments=attachments)


def test_force_stroke_table():
    """v_rel = sqrt(2 E / mu), with E the area under the table."""
    pair = dataclasses.replace(coaxial(generic_pair()), duration=1.0)
    bodies, initial = pair.bodies, pair.initial
    separation = dataclasses.replace(measured_pair(), bodies=bodies, initial=initial)
    area = np.trapezoid(MEASURED["forces"], MEASURED["displacements"])
    assert separation.springs[0].energy == pytest.approx(area, rel=1e-15)
    run = Simulation(separation, Integration(accuracy=1e-10)).run()
    speed = math.sqrt(2.0 * 4.0 * area / reduced_mass(separation))
    final = run.motion.relative_velocity[-1, 0]
    # The step that ends the stroke ends within a hundredth of the accuracy, in s.
    assert final == pytest.approx(speed, rel=1e-8)


def test_energy_balance_of_tables_in_generic_motion():
    separation = dataclasses.replace(measured_pair(joint=FREE), initial=GENERIC)
    rows = energies(separation, np.linspace(0.0, 0.3, 13), 1e-11)
    assert rows[0, 1] == pytest.approx(4 * separation.springs[0].energy, rel=1e-12)
    assert rows[-1, 1] == 0.0
    # the stroke's end is found to 1e-13 s; kinks of the table cost a step's accuracy
    assert rows.sum(axis=1) == pytest.approx([rows[0].sum()] * 13, rel=1e-9)


def test_spring_that_has_let_go_does_not_push_again():
    """A body that is pushed back meets no spring: its plunger is out of place."""
    separation = coaxial(linear_pair(duration=4.0))
    back = Load(
        name="back",
        body="upper",
        p_BoQ_B=separation.body("upper").p_BoBcm_B,
        times=(0.5, 4.0),
        forces=((-900.0, 0.0, 0.0),) * 2,
    )
    run = Simulation(dataclasses.replace(separation, loads=(back,))).run()
    motion = run.motion
    late = motion.time > 0.3
    assert motion.relative_position[late, 0].min() < 0.05  # within the stroke again
    pushed = np.linalg.norm(motion.linear_momentum_change, axis=1)
    assert np.ptp(pushed[late]) == 0.0


@pytest.mark.parametrize(
    ("displacements", "forces", "message"),
    [
        ((0.0, 0.1), (5.0,), "got 2 displacements and 1 forces"),
        ((0.0,), (5.0,), "two rows or more"),
        (
            (0.01, 0.1),
            (5.0, 0.0),
            "must increase from 0, got 0.01, 0.1 m",
        ),
        ((0.0, 0.2, 0.1), (5.0, 4.0, 0.0), "increase from 0, got 0, 0.2, 0.1 m"),
        ((0.0, 0.1), (0.0, 0.0), "forces must not be 0 all, got 0, 0 N"),
        ((0.0, 0.0), (1.0, 0.0), "displacements must increase from 0, got 0, 0 m"),
        ((0.0, math.nan), (1.0, 0.0), "displacement must be finite"),
    ],
)
def test_bad_tables(displacements, forces, message):
    with pytest.raises(ValueError, match=f"spring_1: .*{message}"):
        DisplacementSpring.from_table(
            name="spring_1", displacements=displacements, forces=forces
        )


def test_spring_that_is_past_its_stroke_when_it_is_let_go():
    """Its body has slid away on a joint that lets it: it does not push."""
    separation = coaxial(linear_pair(release_times=(0.0, 0.0, 0.0, 0.8)))
    first, *rest = separation.attachments
    slide = dataclasses.replace(
        FREE, type="prismatic", K_F=1e4, D_F=1e2, K_T=1e4, D_T=1e2
    )
    last = dataclasses.replace(rest[-1], joint=slide)
    separation = dataclasses.replace(
        separation, attachments=(first, *rest[:-1], last), duration=1.5
    )
    run = Simulation(separation).run()
    assert run.status is RunStatus.COMPLETED, run.message
    assert run.stroke_ends[last.spring.name] == 0.8
    late = run.motion.time > 0.5
    pushed = np.linalg.norm(run.motion.linear_momentum_change, axis=1)
    assert np.ptp(pushed[late]) < 1e-9 * pushed[-1]


@pytest.mark.parametrize("profile", [(), ((0.0, 1.0),), ((0.0, 1.0, 2.0), (1.0, 0.0))])
def test_bad_profiles(profile):
    with pytest.raises(ValueError, match="must have two rows of two or more"):
        DisplacementSpring(name="s", force_max=1.0, stroke=0.1, profile=profile)


@pytest.mark.parametrize("damping", [0.0, 300.0])
def test_a_spring_of_no_force_is_out(damping):
    """It need not travel its stroke, of 5 m here: the run is that without it.

    Unless it damps: then it has not let go of its pad.
    """
    pair = by_displacement(generic_pair(duration=0.3))
    first, *others = pair.attachments
    none = dataclasses.replace(first.spring, force_max=0.0, stroke=5.0, damping=damping)
    flown = dataclasses.replace(
        pair, attachments=(dataclasses.replace(first, spring=none), *others)
    )
    run = Simulation(flown).run()
    if damping:
        assert run.message.startswith("spring_1 has not reached its stroke")
        return
    assert run.status is RunStatus.COMPLETED and not run.not_separated
    assert run.stroke_ends["spring_1"] == run.releases["attachment_1"]
    bare = dataclasses.replace(
        pair, attachments=(dataclasses.replace(first, spring=None), *others)
    )
    expected = Simulation(bare).run()
    # Its steps are the same but for its events.
    got, wanted = (one.motion.relative_velocity[-1] for one in (run, expected))
    assert got == pytest.approx(wanted, rel=1e-6)
