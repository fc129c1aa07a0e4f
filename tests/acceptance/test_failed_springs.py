"""Springs that are out, and springs that are stuck at a part of their stroke."""

import dataclasses
import math

import numpy as np
import pytest
from conserved import of_all_bodies
from separations import by_displacement, coaxial, generic_pair, on_axis
from trade import symmetric_design

import drakesep
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.studies.remarks import remarks
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.simulation.simulation import Simulation


LIMITS = (math.inf,) * 3
ACCURATE = Integration(accuracy=1e-9)
KINKED = ((0.0, 0.8), (0.3, 1.0), (0.7, 0.9), (1.0, 0.4))


def both_laws():
    """Springs by time and by displacement, with dampers and corners."""
    by_time = generic_pair(duration=0.6)
    wound = by_displacement(by_time, KINKED, damping=40.0).attachments
    attachments = (*by_time.attachments[:2], *wound[2:])
    return dataclasses.replace(by_time, attachments=attachments)


def upper_stage():
    """A stage of 1.8 t on one of 6 t, on four springs of 800 N over 100 mm."""
    design = symmetric_design()
    pad = 1000.0 * 0.55 / math.sqrt(2.0)
    attachments = design.model_dump()["attachments"]
    for attachment in attachments.values():
        y, z = attachment["position_mm"][1:]
        attachment["position_mm"] = 0.0, math.copysign(pad, y), math.copysign(pad, z)
        attachment["spring"] |= {"force_max_N": 800.0, "stroke_mm": 100.0}
    lower = {"xx": 3000.0, "yy": 9000.0, "zz": 9000.0}
    upper = {"xx": 900.0, "yy": 2653.0, "zz": 2653.0}
    return symmetric_design(
        attachments=attachments,
        bodies={
            "lv": {
                "mass_kg": 6000.0,
                "cg_mm": [-1500.0, 0.0, 0.0],
                "inertia_kg_m2": lower,
            },
            "sc": {
                "mass_kg": 1800.0,
                "cg_mm": [1200.0, 0.0, 0.0],
                "inertia_kg_m2": upper,
            },
        },
        run={"duration_s": 3.0, "accuracy": 1e-8},
        dispersions={"s1.force_max_N": 800.0},
    )


def test_one_of_four_springs_out():
    """As an independent tool has it: 0.410118 m/s and 1.583751 deg/s.

    Of 120 J on 1 / (1/1800 + 1/6000) kg, less what turns: 0.4163 m/s at most.
    """
    study = drakesep.simulate(upper_stage(), {"s1.force_max_N": 0.0})
    metrics = study.labelled.metrics
    speed = metrics["longitudinal_speed_after_separation"]
    # To the last digit that is given.
    assert speed == pytest.approx(0.410118, abs=6e-7)
    rates = [metrics[f"final_rate_{axis}"] for axis in "xyz"]
    degrees = np.degrees(np.abs(rates))
    assert degrees == pytest.approx([0.0, 1.583751, 1.583751], abs=6e-7)


def test_a_tolerance_may_end_at_a_spring_that_is_out():
    [dispersion] = upper_stage().in_si().box.dispersions
    assert dispersion.bounds == (0.0, 1600.0)


@pytest.mark.parametrize("lost", [0.0, 0.35])
def test_tip_off_of_a_failed_spring_by_time(lost):
    """Its impulse is missing: M w = sum of pad x J, about each CG.

    By Eq. 5 a spring gives F / omega sin(omega t) until cos(omega t) is the part of its
    stroke that is lost, whatever is moved.
    """
    pair = coaxial(generic_pair())
    pair = dataclasses.replace(pair, initial=InitialMotion())
    stroke = 0.005
    values = {f"{spring.name}.stroke": stroke for spring in pair.springs}
    values |= {"spring_1.force_max": 0.0}
    values |= {f"spring_{i}.lost_stroke": lost for i in (2, 3, 4)}
    run = Simulation(pair, ACCURATE).run(values)
    impulse = math.sqrt(1200.0 * stroke * 110.0) * math.sqrt(1.0 - lost**2)
    pads = np.array([a.p_AoPad_A for a in pair.attachments[1:]])
    moment = np.cross(pads, [impulse, 0.0, 0.0]).sum(axis=0)
    expected = moment / np.array(pair.body("upper").I_BBcm_B[:3])
    assert run.stroke_ends["spring_1"] == run.releases["attachment_1"] == 0.0
    frequency = math.sqrt(1200.0 / (110.0 * stroke))
    assert run.stroke_ends["spring_2"] == pytest.approx(math.acos(lost) / frequency)
    # The pushes turn with A, by 3e-4 rad, 1.1 m from the CG and 0.17 m beside it.
    assert run.motion.rate[-1] == pytest.approx(expected, rel=2e-3, abs=3e-5)
    momentum = 3.0 * impulse * np.array([1.0, 0.0, 0.0])
    given = run.motion.linear_momentum_change[-1]
    assert np.linalg.norm(given) == pytest.approx(np.linalg.norm(momentum), rel=1e-3)


@pytest.mark.parametrize("law", ["by time", "by displacement"])
def test_a_spring_that_is_stuck_gives_a_part_of_its_energy(law):
    """All stuck where a third is lost: E (1 - 1/9), and v = sqrt(2 E / mu).

    The design mass of Eq. 5 is a quarter of mu: the spring that it stands for.
    """
    pair = coaxial(generic_pair())
    lower, upper = (body.mass for body in pair.bodies)
    mu = lower * upper / (lower + upper)
    names = [spring.name for spring in pair.springs]
    values = {f"{name}.lost_stroke": 1.0 / 3.0 for name in names}
    if law == "by time":
        values |= {f"{name}.design_mass": mu / 4.0 for name in names}
    else:
        pair = by_displacement(pair)
    run = Simulation(pair, ACCURATE).run(values)
    energy = 4.0 * 0.5 * 1200.0 * 0.1 * (1.0 - 1.0 / 9.0)
    assert sum(s.energy for s in run.separation.springs) == pytest.approx(energy)
    speed = math.sqrt(2.0 * energy / mu)
    metrics = metrics_of_run(run, LIMITS)
    # Hundred times the accuracy.
    assert metrics["longitudinal_speed_max"] == pytest.approx(speed, rel=1e-7)
    places = np.interp(
        list(run.stroke_ends.values()),
        run.motion.time,
        run.motion.relative_position[:, 0],
    )
    assert places == pytest.approx([0.1 * 2.0 / 3.0] * 4, abs=1e-6)


NAMES = (
    *("spring_1.force_max", "spring_2.lost_stroke"),
    *("spring_3.force_max", "spring_4.lost_stroke"),
)
ROWS = np.array(
    [
        [1200.0, 0.0, 1280.0, 0.0],
        [0.0, 0.0, 1280.0, 0.0],
        [1200.0, 0.0, 0.0, 0.0],
        [1200.0, 0.45, 1280.0, 0.45],
        [0.0, 0.9, 0.0, 0.2],
    ]
)


@pytest.mark.slow
def test_out_and_stuck_in_both_engines():
    pair = both_laws()
    result = Batch(pair, NAMES).run(ROWS)
    assert not result.failures
    simulation = Simulation(pair, ACCURATE)
    for row, told in zip(ROWS, result.metrics.to_dict("records"), strict=True):
        run = simulation.run(dict(zip(NAMES, row.tolist(), strict=True)))
        metrics = metrics_of_run(run, LIMITS)
        for name, value in told.items():
            # Both engines promise 1e-8 of states; integrals and norms add some up.
            assert metrics[name] == pytest.approx(value, abs=3e-8), name
        whole = of_all_bodies(run)
        for total in (whole.momentum, whole.angular):
            same = np.broadcast_to(total[0], total.shape)
            assert total == pytest.approx(same, abs=1e-7)


@pytest.mark.slow
def test_derivatives_where_springs_are_out_are_finite():
    result = Batch(both_laws(), NAMES).jacobian(ROWS)
    assert not result.failures
    assert np.isfinite(result.jacobian).all()


def test_energy_of_a_law_is_what_it_gives_until_it_is_stuck():
    pair = by_displacement(generic_pair(), KINKED)
    spring = dataclasses.replace(pair.springs[0], lost_stroke=0.45)
    law = law_of(spring)
    end = law.end(spring, math)
    assert end == pytest.approx(0.55 * spring.stroke)
    for begin in (-0.01, 0.0, 0.02, 0.03, 0.05):
        x = np.linspace(begin, end, 100_001)
        force = law.force(spring, x, 0.0, law.passed(spring, x, np), np)
        # Straight lines: exact but for the step at a corner.
        work = np.trapezoid(force, x)
        assert law.energy(spring, begin) == pytest.approx(work, abs=1e-8)
    assert law.energy(spring, 0.0) == pytest.approx(spring.energy, rel=1e-14)


def test_nothing_is_remarked_of_a_spring_that_is_out():
    pair = dataclasses.replace(generic_pair(), bodies=on_axis(generic_pair()))
    run = Simulation(pair).run({"spring_1.force_max": 0.0})
    assert not any("spring_1" in remark.about for remark in remarks({"": run}))
