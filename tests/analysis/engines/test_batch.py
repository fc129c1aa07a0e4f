"""The batch engine against Drake, against itself, and against bad input."""

import dataclasses
import math
import os
import signal
import subprocess
import sys
import threading
import time

import jax
import numpy as np
import pandas as pd
import pytest
from batches import (
    NONE,
    around,
    assert_close,
    assert_slopes,
    central_differences,
    drake_figures,
    random_rows,
)
from separations import generic_pair, on_axis

from drakesep.analysis.engines.jax import compiled
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import METRICS, registered_metrics
from drakesep.analysis.metrics.requirements import deviation_limits
from drakesep.case_file.reader import load_case
from drakesep.systems import sampling
from drakesep.systems.checks import InputError
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.run import RunStatus
from drakesep.systems.model.separation import InitialMotion, Separation
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation


LIMITS = (0.02, 0.02, math.inf)


@pytest.fixture
def closely_sampled(monkeypatch):
    """Drake's runs every millisecond: joints that swing between samples of ten."""
    monkeypatch.setattr(sampling, "_ROWS", 3000)
    return {"workers": 1}  # in this process, where the patch is


@pytest.fixture(scope="module")
def fine_batch(vega):
    """A hundredth of the tolerance."""
    limits = deviation_limits(vega.limits)
    return Batch(
        vega.separation, vega.box.names, deviation_limits=limits, tolerance=1e-9
    )


# Parameters that are held.


def test_what_is_held_flies_as_rows_that_have_it(vega, vega_batch):
    values = {"payload.mass": 70.0, "spring_2.force_max": 0.0}
    cg = vega_batch.nominal[vega_batch.names.index("payload.cg_x")]
    values["payload.cg_x"] = cg
    held = vega_batch.holding({**values, "payload.cg_x": 2.0 * cg})
    held = held.holding({"payload.cg_x": cg})  # it is held already
    free = [i for i, name in enumerate(vega_batch.names) if name in held.names]
    assert len(free) == len(vega_batch.names) - 3
    rows = random_rows(vega, 3)
    full = rows.copy()
    for name, value in values.items():
        full[:, vega_batch.names.index(name)] = value
    got, expected = held.run(rows[:, free]), vega_batch.run(full)
    # To round-off: programs take what all lanes have in common, the idle ones too.
    np.testing.assert_allclose(got.metrics, expected.metrics, rtol=1e-12, atol=1e-13)
    # Of slopes some are quotients of small differences.
    slopes = vega_batch.jacobian(full[:1]).jacobian[..., free]
    mine = held.jacobian(rows[:1, free]).jacobian
    np.testing.assert_allclose(mine, slopes, rtol=1e-9, atol=1e-10)
    first, *_ = held.runs(rows[:1, free])
    assert parameters(first.separation)["spring_2.force_max"] == 0.0
    assert held.nominal == pytest.approx(
        [parameters(vega.separation)[n] for n in held.names]
    )


def test_only_what_varies_may_be_held(vega_batch):
    with pytest.raises(InputError, match=r"launch_vehicle\.mass"):
        vega_batch.holding({"launch_vehicle.mass": 1.0})
    with pytest.raises(InputError, match="mass"):
        vega_batch.holding({"payload.mass": -1.0})
    with pytest.raises(InputError, match="finite"):
        vega_batch.holding({"payload.mass": math.inf})


# Against Drake.


def test_vega_against_drake_over_the_whole_box(vega, vega_batch):
    rows = random_rows(vega, 40)
    result = vega_batch.run(rows)
    assert not result.failures
    limits = deviation_limits(vega.limits)
    expected = drake_figures(vega.separation, vega.box.names, rows, limits)
    assert_close(result.metrics.to_numpy(), expected)


@pytest.mark.slow
def test_three_bodies_against_drake(closely_sampled):
    """Staged releases, joints that hold on, springs by displacement, gravity.

    Of the payload, and of the carrier that leaves after it.
    """
    case = load_case("dual_launch")
    rows = random_rows(case, 4)
    every = [metric for metric in registered_metrics() if metric.of_every_run]
    carriers = [f"carrier.{metric.names[0]}" for metric in every]
    result = Batch(case.separation, case.box.names, metrics=carriers).run(rows)
    assert len(result.metrics.columns) == 2 * len(METRICS)
    expected = drake_figures(
        case.separation, case.box.names, rows, NONE, **closely_sampled
    )
    got, payloads = result.metrics.to_numpy(), len(METRICS)
    assert_close(got[:, :payloads], expected[:, :payloads])
    # Until it leaves it swings on its joints, faster than samples of 1 ms follow; the
    # batch at its own tolerance is 1.8e-8 rad from itself at a hundredth of that.
    assert_close(
        got[:, payloads:], expected[:, payloads:], relative=1e-6, absolute=3e-8
    )


def staged() -> Separation:
    """Two bodies that let go one attachment after the other, in orbit, under loads."""
    pair = generic_pair(
        release_times=(0.0, 0.03, 0.05, 0.02),
        joint=Joint(type="revolute", K_F=3e6, D_F=8e3, K_T=2e5, D_T=5e2),
        orbit=load_case("vega").separation.orbit,
    )
    springs = list(pair.springs)
    springs[1] = DisplacementSpring(
        name="spring_2",
        force_max=1500.0,
        stroke=0.08,
        damping=300.0,
        profile=((0.0, 0.8), (0.3, 1.0), (1.0, 0.4)),
    )
    attachments = tuple(
        dataclasses.replace(a, spring=spring)
        for a, spring in zip(pair.attachments, springs, strict=True)
    )
    loads = (
        Load(
            name="jet",
            body="lower",
            p_BoQ_B=(0.1, 0.2, 0.0),
            times=(0.0, 0.2, 0.25, 0.6),
            forces=((0, 0, 0), (50, 10, 0), (0, 30, 20), (0, 0, 0)),
            start=0.05,
        ),
        Load(
            name="retro",
            body="lower",
            axes="world",
            times=(0.1, 0.4),
            forces=((-80, 0, 5), (-80, 0, 5)),
            torques=((0, 3, 0), (0, 0, 2)),
            after="attachment_3",
        ),
    )
    return dataclasses.replace(pair, attachments=attachments, loads=loads)


@pytest.mark.slow
def test_staged_release_under_loads_against_drake(closely_sampled):
    """Release times, starts of loads, a spring's damping and tilts vary too."""
    tilts = {"spring_2.tilt_y": 0.05, "spring_3.tilt_z": -0.03}
    separation = with_values(staged(), tilts)
    names = (
        "upper.mass",
        "attachment_2.release_time",
        "attachment_3.position_y",
        "spring_2.damping",
        "spring_2.stroke",
        "spring_2.tilt_y",
        "spring_3.tilt_z",
        "jet.start",
        "retro.factor",
        "before_separation.rate_y",
        "before_separation.attitude_yaw",
    )
    rows = around(separation, names, 0.1, 6)
    # By default one row in twenty is off by more than 1e-8, and all within 1e-7.
    batch = Batch(separation, names, deviation_limits=LIMITS, tolerance=1e-9)
    result = batch.run(rows)
    expected = drake_figures(separation, names, rows, LIMITS, **closely_sampled)
    assert_close(result.metrics.to_numpy(), expected)


def hinged(angle: float = 0.3) -> Separation:
    """Two bodies on one hinge, which lets go at an angle; a spring turns them."""
    pair = generic_pair(release_times=(0.0, math.inf), duration=1.5)
    hinge = Joint(type="revolute", K_F=2e5, D_F=2e3, K_T=2e5, D_T=2e3)
    pushed, hung = pair.attachments
    pushed = dataclasses.replace(
        pushed,
        p_AoPad_A=(0.0, 0.0, 0.6),
        spring=DisplacementSpring(name="spring_1", force_max=9e3, stroke=0.15),
    )
    hung = dataclasses.replace(
        hung,
        joint=dataclasses.replace(
            hinge, x_axis_A=(0.0, 1.0, 0.0), y_axis_A=(0.0, 0.0, 1.0)
        ),
        p_AoPad_A=(0.0, 0.0, -0.6),
        release_angle=angle,
        spring=None,
    )
    return dataclasses.replace(pair, attachments=(pushed, hung))


def pressed_back() -> Load:
    """A torque that turns the hinge the other way before its spring wins."""
    return Load(
        name="back",
        body="upper",
        times=(0.0, 0.05),
        torques=((0.0, 9e3, 0.0), (0.0, 9e3, 0.0)),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "loads",
    [pytest.param((), id="free"), pytest.param((pressed_back(),), id="back")],
)
def test_release_at_an_angle_against_drake(closely_sampled, loads):
    separation = dataclasses.replace(hinged(), loads=loads)
    names = ("spring_1.force_max", "attachment_2.release_angle", "lower.mass")
    rows = around(separation, names, 0.05, 2)
    batch = Batch(separation, names)
    result = batch.run(rows)
    expected = drake_figures(separation, names, rows, NONE, **closely_sampled)
    # Drake's release is exact to event isolation, here 1e-12 s.
    assert_close(result.metrics.to_numpy(), expected)


def test_runs_are_like_drakes(vega, vega_batch):
    rows = random_rows(vega, 3)
    drake = Simulation(vega.separation, Integration(accuracy=1e-10))
    for row, run in zip(rows, vega_batch.runs(rows), strict=True):
        values = dict(zip(vega.box.names, row.tolist(), strict=True))
        expected = drake.run(values)
        assert run.separation == expected.separation
        assert run.releases == expected.releases
        assert run.stroke_ends == pytest.approx(expected.stroke_ends, abs=1e-15)
        assert run.breaks == pytest.approx(expected.breaks, abs=1e-15)
        for field in dataclasses.fields(run.motion):
            got = getattr(run.motion, field.name)
            reference = getattr(expected.motion, field.name)
            # Within a step the continuous extension has order seven; momentum is
            # hundreds of N s, acceleration a derivative of Drake's steps.
            size = max(1.0, np.abs(reference).max())
            scale = 1e-7 if field.name == "acceleration" else 1e-8
            assert got == pytest.approx(reference, abs=scale * size), field.name


def spinning() -> Separation:
    """Bodies that turn by more than a turn: angles jump from pi to -pi."""
    initial = InitialMotion(rpy_WA=(0.2, 0.1, 2.5), w_WA_A=(2.0, 0.1, 0.9))
    return generic_pair(initial=initial, duration=4.0)


@pytest.mark.slow
def test_angles_that_jump(closely_sampled):
    separation = spinning()
    limits = (2.0, math.inf, math.inf)
    row = np.array([[parameters(separation)["upper.mass"]]])
    # Tumbling bodies make a hundred errors of one.
    batch = Batch(separation, ["upper.mass"], deviation_limits=limits, tolerance=1e-10)
    expected = drake_figures(separation, batch.names, row, limits, **closely_sampled)
    until = METRICS.index("deviation_within_limits_until")
    assert 0.0 < expected[0, until] < separation.duration
    assert_close(batch.run(row).metrics.to_numpy(), expected)
    [run] = batch.runs(row)
    drake = Simulation(separation, Integration(accuracy=1e-10)).run()
    assert np.ptp(run.motion.angle[:, 0]) > 6.0  # it has jumped
    apart = np.exp(1j * run.motion.angle) - np.exp(1j * drake.motion.angle)
    assert np.abs(apart).max() < 1e-8  # as above


def test_figures_are_those_of_the_sampled_runs(vega, vega_batch):
    """Two ways to the metrics: polynomials of the steps, splines of the samples."""
    rows = random_rows(vega, 20, seed=5)
    result = vega_batch.run(rows)
    limits = deviation_limits(vega.limits)
    sampled = [
        list(metrics_of_run(run, limits).values()) for run in vega_batch.runs(rows)
    ]
    # Splines through samples every 10 ms, and 64 in a push, are good to some 1e-9.
    assert_close(result.metrics.to_numpy(), np.array(sampled), absolute=5e-9)


@pytest.mark.slow
@pytest.mark.parametrize("left", [[], ["separation_end"]])
def test_what_is_not_asked_for_is_left_out(vega, vega_batch, left):
    """What is left is told as before; nothing may be left."""
    without = {metric.stem for metric in registered_metrics()}.difference(left)
    batch = Batch(vega.separation, vega.box.names, without=without)
    rows = vega.box.nominal[None] * [[1.0], [1.0 + 1e-4]]
    got = batch.run(rows).metrics
    assert list(got) == list(batch.metrics) == left
    assert len(got) == len(rows)
    if left:
        assert_close(got.to_numpy(), vega_batch.run(rows).metrics[left].to_numpy())


@pytest.mark.slow
def test_convergence_over_the_whole_box(vega, vega_batch, fine_batch):
    """Ten thousand points against a hundredth of the tolerance."""
    rows = random_rows(vega, 10_000, seed=2)
    expected = fine_batch.run(rows).metrics.to_numpy()
    assert_close(vega_batch.run(rows).metrics.to_numpy(), expected)


# Derivatives.


@pytest.mark.slow
def test_jacobian_of_vega(vega, fine_batch):
    batch = fine_batch
    rows = random_rows(vega, 4, seed=3)
    centre = vega.box.nominal
    rows = centre + 0.9 * (rows - centre)  # room for the differences
    result = batch.jacobian(rows)
    assert result.metrics.to_numpy() == pytest.approx(
        batch.run(rows).metrics.to_numpy(), rel=1e-12
    )
    steps = 1e-3 * vega.box.tolerance  # too short to meet a kink of these rows
    for row, jacobian in zip(rows, result.jacobian, strict=True):
        assert_slopes(jacobian, central_differences(batch, row, steps), steps)


def test_jacobian_against_drake(vega, fine_batch):
    """Central differences of Drake runs, of the metrics that have no kink nearby."""
    row = vega.box.nominal
    jacobian = fine_batch.jacobian(row[None]).jacobian[0]
    names = vega.box.names
    chosen = ["payload.cg_y", "payload.inertia_xy", "spring_2.force_max"]
    steps = {name: 0.05 * vega.box.tolerance[names.index(name)] for name in chosen}
    offsets = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
    nominal = dict(zip(names, row.tolist(), strict=True))
    variations = np.array(
        [
            list((nominal | {name: nominal[name] + k * steps[name]}).values())
            for name in chosen
            for k in offsets
        ]
    )
    limits = deviation_limits(vega.limits)
    metrics = drake_figures(vega.separation, names, variations, limits)
    smooth = [i for i, name in enumerate(METRICS) if name.startswith("final_rate")]
    for j, name in enumerate(chosen):
        slope = np.array(list(offsets.values())) @ metrics[4 * j : 4 * j + 4]
        expected = slope[smooth] / steps[name]
        got = jacobian[smooth, names.index(name)]
        # Of the largest of the three rates; Drake's noise over the step is 1e-8.
        assert got == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.slow
def test_jacobian_of_staged_release():
    separation = staged()
    names = ("attachment_3.release_time", "jet.start", "spring_2.damping", "upper.cg_x")
    batch = Batch(separation, names, deviation_limits=LIMITS, tolerance=1e-9)
    row = np.array([parameters(separation)[name] for name in names])
    steps = 1e-3 * np.abs(row)
    jacobian = batch.jacobian(row[None]).jacobian[0]
    assert_slopes(jacobian, central_differences(batch, row, steps), steps)


def coaxial_vega() -> Separation:
    """VEGA that does not rotate at all."""
    separation = load_case("vega").separation
    initial = dataclasses.replace(separation.initial, w_WA_A=(0.0, 0.0, 0.0))
    return dataclasses.replace(
        separation, bodies=on_axis(separation), orbit=None, initial=initial
    )


def test_derivative_at_a_kink_is_between_those_of_both_sides():
    """Rates that stay zero: integrals and peaks of magnitudes grow to either side."""
    batch = Batch(coaxial_vega(), ["payload.cg_y"])
    step = 1e-5
    result = batch.jacobian([[-step], [0.0], [step]])
    assert not result.failures
    for name in ("G_L1", "G_L2", "G_Linf"):
        g = result.metrics[name].to_numpy()
        slopes = result.jacobian[:, METRICS.index(name), 0]
        assert g[1] == pytest.approx(0.0, abs=1e-13)
        side = g[2] / step
        # Linear beside the kink, to the square of what the step turns.
        assert slopes[[0, 2]] == pytest.approx([-side, side], rel=1e-6)
        assert abs(slopes[1]) <= side * (1.0 + 1e-6)


@pytest.mark.slow
def test_jacobian_of_springs_that_end_together():
    """Each of four equal springs, found at the same time, has its own derivative."""
    pair = generic_pair()
    free = Joint(K_F=0.0, D_F=0.0, K_T=0.0, D_T=0.0)
    angles = [0.5 + 0.5 * math.pi * i for i in range(4)]
    attachments = tuple(
        dataclasses.replace(
            a,
            joint=free,
            p_AoPad_A=(0.0, 0.5 * math.cos(angle), 0.5 * math.sin(angle)),
            spring=DisplacementSpring(
                name=a.spring.name,
                force_max=1500.0,
                stroke=0.08,
                profile=((0.0, 1.0), (1.0, 0.6)),
            ),
        )
        for a, angle in zip(pair.attachments, angles, strict=True)
    )
    together = dataclasses.replace(
        pair,
        attachments=attachments,
        bodies=on_axis(pair),
        initial=InitialMotion(),
    )
    batch = Batch(together, ["spring_1.stroke"], tolerance=1e-10)
    row, steps = np.array([0.08]), np.array([8e-6])
    jacobian = batch.jacobian(row[None]).jacobian[0]
    differences = central_differences(batch, row, steps)
    smooth = [METRICS.index(f"final_rate_{axis}") for axis in "yz"]
    assert np.abs(differences[smooth]).min() > 0.1
    # The springs change places within the differences: first order in the step.
    assert jacobian[smooth] == pytest.approx(differences[smooth], rel=1e-5)


# Rows do not know of each other.


def test_workers_and_order_do_not_matter(vega):
    rows = random_rows(vega, 150)
    results = [
        Batch(vega.separation, vega.box.names, workers=workers).run(rows)
        for workers in (1, 2)
    ]
    first, second = (result.metrics.to_numpy() for result in results)
    assert np.array_equal(first, second)
    order = np.random.default_rng(1).permutation(len(rows))
    batch = Batch(vega.separation, vega.box.names)
    shuffled = batch.run(rows[order]).metrics.to_numpy()
    # round-off
    assert shuffled == pytest.approx(first[order], rel=1e-11, abs=1e-14)


@pytest.mark.slow
def test_neighbours_hardly_matter():
    """Where steps are short for some rows only, another method takes them."""
    names = ("upper.mass", "attachment_2.release_time", "spring_2.stroke")
    rows = around(staged(), names, 0.1, 8)
    results = [Batch(staged(), names, chunk=chunk).run(rows) for chunk in (1, 8)]
    alone, together = (result.metrics.to_numpy() for result in results)
    assert len(np.unique(results[0].steps)) > 1
    # a hundredth of what is promised
    assert alone == pytest.approx(together, rel=1e-10, abs=1e-11)


def test_progress_and_chunks(vega):
    rows = random_rows(vega, 40)
    seen = []
    batch = Batch(vega.separation, vega.box.names, chunk=16)
    result = batch.run(rows, on_progress=lambda done, n: seen.append((done, n)))
    assert seen == [(16, 40), (32, 40), (40, 40)]
    assert len(result.metrics) == len(result.steps) == 40


def test_calls_that_are_cut_after_each_step(vega, vega_batch, monkeypatch):
    """What comes of rows is the same to the last bit."""
    rows = random_rows(vega, 20)
    ways = (vega_batch.run, vega_batch.jacobian)
    whole = [fly(rows) for fly in ways]
    monkeypatch.setattr(compiled, "_CALL", 0.0)
    for fly, expected in zip(ways, whole, strict=True):
        got = fly(rows)
        assert got.metrics.equals(expected.metrics)
        assert np.array_equal(got.steps, expected.steps)
        if expected.jacobian is not None:
            assert np.array_equal(got.jacobian, expected.jacobian)


@pytest.mark.parametrize("way", ["run", "jacobian"])
def test_an_interrupt_waits_for_no_row(way, vega, vega_batch):
    """Rows that take a minute, to the last of 20 000 steps; 2 s are promised."""
    rows = np.tile(vega.box.nominal, (128, 1))
    rows[:, vega.box.names.index("spring_1.force_max")] = np.geomspace(1e7, 1e12, 128)
    getattr(vega_batch, way)(rows[:1] * 0.0 + vega.box.nominal)  # compiled
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    sent = []

    def interrupt():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, interrupt)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            getattr(vega_batch, way)(rows)
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - sent[0] < 2.0


def test_no_rows(vega_batch):
    result = vega_batch.jacobian(np.zeros((0, len(vega_batch.names))))
    assert result.metrics.shape == (0, len(METRICS))
    assert result.jacobian.shape == (0, len(METRICS), len(vega_batch.names))


# Bad input.


def test_rows_that_cannot_be_flown_say_why(vega, vega_batch):
    rows = np.tile(vega.box.nominal, (6, 1))
    names = vega.box.names
    rows[1, names.index("payload.mass")] = -3.0
    rows[2, names.index("spring_2.stroke")] = math.nan
    rows[3, names.index("payload.inertia_xx")] = 1e5
    rows[4, names.index("spring_1.force_max")] = 1e-3  # a stroke longer than the run
    result = vega_batch.run(rows)
    assert list(result.failures) == [1, 2, 3, 4]
    assert "payload: mass must be > 0, got -3" in result.failures[1]
    assert "spring_2.stroke must be finite" in result.failures[2]
    assert "triangle inequality" in result.failures[3]
    assert "duration must be longer" in result.failures[4]
    failed = list(result.failures)
    assert result.metrics.iloc[failed].isna().all(axis=None)
    good = result.metrics.drop(index=failed)
    assert np.isfinite(good).all(axis=None)
    assert np.array_equal(good.iloc[0], good.iloc[1])
    runs = vega_batch.runs(rows)
    assert [run.status is RunStatus.FAILED for run in runs] == [
        i in failed for i in range(6)
    ]
    assert runs[4].message == result.failures[4]
    assert (result.steps[failed] == 0).all()


def test_a_hinge_that_does_not_turn_far_enough():
    batch = Batch(hinged(angle=3.0), ["lower.mass"])
    result = batch.run([[700.0]])
    assert "attachment_2 has not let go" in result.failures[0]
    [run] = batch.runs([[701.0]])
    assert run.message == result.failures[0]
    assert run.separation.body("lower").mass == 701.0  # as it was flown


def test_too_many_steps(vega):
    batch = Batch(vega.separation, ["payload.mass"], max_steps=2)
    result = batch.run([[1000.0]])
    assert "more than 2 integration steps" in result.failures[0]


@pytest.mark.parametrize("roll", [0.0, 0.01])
def test_a_deviation_limit_of_zero(roll):
    """Whatever turns is beyond it at once, in both engines."""
    initial = InitialMotion(rpy_WA=(roll, 0.0, 0.0), w_WA_A=(0.1, 0.0, 0.0))
    separation, limits = generic_pair(initial=initial), (0.0, math.inf, math.inf)
    batch = Batch(separation, ["upper.mass"], deviation_limits=limits)
    told = batch.run([[1200.0]]).metrics["deviation_within_limits_until"]
    flown = metrics_of_run(Simulation(separation).run(), limits)
    # Where a crossing is found, by round-off of a step of 1 s.
    assert told.tolist() == pytest.approx([0.0], abs=1e-15)
    assert flown["deviation_within_limits_until"] == 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"names": ["payload.mas"]}, "unknown parameter 'payload.mas'"),
        ({"names": ["payload.mass"] * 2}, "parameters must differ"),
        ({"names": "payload.mass"}, "names must be a sequence, each text"),
        ({"names": []}, "must be a list of parameters"),
        ({"deviation_limits": (0.1,)}, "deviation limits must be three"),
        ({"deviation_limits": (0.1, math.nan, 0.1)}, "deviation limits must be three"),
        ({"deviation_limits": (0.1, -0.1, 0.1)}, "limits must be three, >= 0, in rad"),
        ({"metrics": ["rate_x_at_1_s"] * 2}, "metrics: rate_x_at_1_s must stand once"),
        ({"tolerance": 0.0}, "tolerance must be > 0"),
        ({"deviation_limits": 0.1}, "deviation_limits must be a sequence"),
        ({"chunk": 0}, "chunk must be a whole number >= 1"),
        ({"max_steps": 2.5}, "max_steps must be a whole number"),
        ({"workers": 0}, "workers must be a whole number >= 1"),
    ],
)
def test_bad_settings(vega, arguments, message):
    with pytest.raises(InputError, match=message):
        Batch(vega.separation, **{"names": ["payload.mass"], **arguments})


def test_values_need_a_column_for_each_parameter(vega_batch):
    with pytest.raises(InputError, match="a column for each of the 18 parameters"):
        vega_batch.run(np.zeros((3, 17)))


def test_a_frame_is_read_by_its_names(vega):
    batch = Batch(vega.separation, ["payload.mass", "payload.cg_y"])
    frame = pd.DataFrame(
        {"payload.cg_y": [0.0, 0.01], "payload.mass": [1800.0, 1850.0]}, index=[7, 9]
    )
    result = batch.run(frame)
    assert list(result.metrics.index) == [7, 9]
    expected = batch.run([[1800.0, 0.0], [1850.0, 0.01]]).metrics.to_numpy()
    assert np.array_equal(result.metrics.to_numpy(), expected)
    with pytest.raises(InputError, match="columns must be the parameters"):
        batch.run(frame.rename(columns={"payload.cg_y": "payload.cg_z"}))


def test_what_a_batch_cannot_fly_is_refused_by_name(vega):
    with pytest.raises(InputError, match=r"it has one: \.separation"):
        Batch(vega, ["payload.mass"])


def test_what_does_not_come_about_is_not_told(vega):
    """Nothing lets go: neither release nor separation has metrics."""
    held = dataclasses.replace(
        vega.separation,
        attachments=tuple(
            dataclasses.replace(a, release_time=math.inf)
            for a in vega.separation.attachments
        ),
    )
    told = Batch(held, ["payload.mass"]).metrics
    assert not any("separation" in name or name.startswith("G_") for name in told)
    assert "final_rate_x" in told


# JAX is the engine's own business.


def test_jax_is_not_imported_until_used():
    code = (
        "import sys, drakesep, drakesep.analysis, drakesep.systems, drakesep.cli.app;"
        "assert 'jax' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_users_precision_is_left_alone(vega, vega_batch):
    vega_batch.run(vega.box.nominal[None])
    assert not jax.config.jax_enable_x64
    assert jax.numpy.ones(1).dtype == np.float32
