"""Tables of force over stroke that are negative somewhere: captive springs, say."""

import dataclasses
import math

import numpy as np
import pandas as pd
import pytest
from conserved import of_all_bodies
from separations import FREE, coaxial, generic_pair

import drakesep
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.engines.run_evaluator import RunEvaluator
from drakesep.analysis.metrics.objectives import highest
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.studies.remarks import remarks
from drakesep.systems.equations.forces_of_run import spring_forces
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


LIMITS = (math.inf,) * 3
ACCURATE = Integration(accuracy=1e-9)
KEPT = {"displacements": (0.0, 0.04, 0.085), "forces": (200.0, 0.0, -225.0)}
"""What it gives over 40 mm, 4 J, it takes again over 40 more: 85 mm are not reached."""
LEFT = {"displacements": (0.0, 0.04, 0.06), "forces": (200.0, 0.0, -100.0)}
"""It gives 4 J, and takes 1 J."""


def on_one_spring(table, **changes):
    pair = coaxial(generic_pair(release_times=(0.0,), duration=5.0))
    spring = DisplacementSpring.from_table(name="spring_1", **table)
    [pad] = pair.attachments
    pad = dataclasses.replace(pad, p_AoPad_A=(0.0, 0.0, 0.0), joint=FREE, spring=spring)
    pair = dataclasses.replace(pair, attachments=(pad,), initial=InitialMotion())
    return dataclasses.replace(pair, **changes)


def reduced_mass(pair):
    return 1.0 / sum(1.0 / body.mass for body in pair.bodies)


def test_bodies_that_it_keeps_together():
    """-200 N / 40 mm all along: x = 40 mm (1 - cos w t), for good."""
    pair = on_one_spring(KEPT)
    run = Simulation(pair, ACCURATE).run()
    w = math.sqrt(5000.0 / reduced_mass(pair))
    expected = 0.04 * (1.0 - np.cos(w * run.motion.time))
    # A hundred times the accuracy, over some periods.
    assert run.motion.relative_position[:, 0] == pytest.approx(expected, abs=1e-7)
    force = spring_forces(run)["spring_1"]
    assert force == pytest.approx(200.0 - 5000.0 * expected, abs=1e-3)
    assert run.held_back == ("spring_1",) and run.held == ()
    assert run.stroke_ends == {"spring_1": math.inf}
    metrics = metrics_of_run(run, LIMITS)
    assert math.isnan(metrics["separation_end"])
    assert math.isnan(metrics["rate_after_separation_x"])
    assert metrics["longitudinal_speed_max"] == pytest.approx(0.04 * w, rel=1e-6)
    [remark] = [r for r in remarks({"": run}) if r.about == ("spring_1",)]
    assert "do not separate" in remark.text


def test_one_run_of_it_is_a_result(tmp_path):
    """It comes twice as far as where the force is zero, and back: with all tables."""
    case = drakesep.AnalysisCase(separation=on_one_spring(KEPT))
    study = drakesep.simulate(case, output=tmp_path)
    assert study.completed and study.summary["status"].tolist() == ["completed"]
    places = study.motion["relative_position_x_m"]
    # A cosine whose top lies between samples of 20 ms.
    assert places.max() == pytest.approx(0.08, rel=1e-3)
    assert len(pd.read_csv(tmp_path / "motion.csv")) == len(places)
    assert drakesep.read_results(tmp_path).record.ended.value == "completed"


def test_its_net_work_is_in_the_speed():
    pair = on_one_spring(LEFT)
    run = Simulation(pair, ACCURATE).run()
    speed = math.sqrt(2.0 * 3.0 / reduced_mass(pair))
    assert pair.springs[0].energy == pytest.approx(3.0)
    assert run.motion.relative_velocity[-1, 0] == pytest.approx(speed, rel=1e-7)
    # The last sample before its end is a 64th of its push away.
    assert spring_forces(run)["spring_1"].min() == pytest.approx(-100.0, abs=5.0)
    assert run.held_back == ()


def test_momentum_and_energy_where_it_pulls_beside_the_axis():
    pair = on_one_spring(LEFT)
    [pad] = pair.attachments
    pad = dataclasses.replace(pad, p_AoPad_A=(0.0, 0.2, 0.1))
    run = Simulation(dataclasses.replace(pair, attachments=(pad,)), ACCURATE).run()
    whole = of_all_bodies(run)
    assert abs(whole.momentum).max() < 1e-6 and abs(whole.angular).max() < 1e-6
    assert whole.kinetic[-1] == pytest.approx(3.0, rel=1e-6)


def test_it_is_pulled_back_past_its_place():
    """With a damper it comes to rest where the force is zero, whichever way it goes."""
    pair = on_one_spring(KEPT | {"damping": 900.0}, duration=20.0)
    run = Simulation(pair, ACCURATE).run()
    assert run.motion.relative_position[-1, 0] == pytest.approx(0.04, abs=1e-6)


def test_a_search_run_by_run_says_why_it_tells_nothing():
    pair = on_one_spring(KEPT)
    simulation = Simulation(pair)
    evaluator = RunEvaluator(
        lambda rows: [simulation.run({"upper.mass": m}) for [m] in rows],
        ["upper.mass"],
        [highest("longitudinal_speed_after_separation")],
    )
    found = evaluator.all(np.array([[1200.0]]))
    assert found.failures == {0: "spring_1 has not reached its stroke"}


@pytest.mark.slow
def test_both_engines():
    pair = on_one_spring(LEFT | {"damping": 5.0}, duration=1.5)
    [pad] = pair.attachments
    pad = dataclasses.replace(pad, p_AoPad_A=(0.0, 0.2, 0.1))
    pair = dataclasses.replace(pair, attachments=(pad,))
    names = ["spring_1.force_max", "spring_1.damping", "upper.mass"]
    rows = np.array([[200.0, 5.0, 1200.0], [260.0, 0.0, 1100.0]])
    batch = Batch(pair, names)
    result = batch.run(rows)
    assert not result.failures
    for row, told in zip(rows, result.metrics.to_dict("records"), strict=True):
        run = Simulation(pair, ACCURATE).run(dict(zip(names, row, strict=True)))
        metrics = metrics_of_run(run, LIMITS)
        for name, value in told.items():
            # Both engines promise 1e-8 of states; integrals and norms add some up.
            assert metrics[name] == pytest.approx(value, abs=3e-8), name


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        ((0.0, 0.0, 0.0), "s: forces must not be 0 all, got 0, 0, 0 N"),
        ((1.0, math.nan, 0.0), "s: force must be finite, got nan"),
    ],
)
def test_impossible_tables(forces, message):
    with pytest.raises(ValueError, match=message):
        DisplacementSpring.from_table(
            name="s", displacements=(0.0, 0.1, 0.2), forces=forces
        )
