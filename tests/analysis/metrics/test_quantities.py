"""Metrics of quantities by their names, against closed forms and in both engines."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runs import made_up_run
from separations import FREE, generic_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.engines.jax.batch_evaluator import BatchEvaluator
from drakesep.analysis.metrics.metric import Functional, Moment, Outer, Window
from drakesep.analysis.metrics.objectives import Needs, as_objective, highest
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.quantities import (
    QUANTITIES,
    at_time,
    between_times,
    metric_of_quantity,
    time_named,
)
from drakesep.analysis.metrics.registry import find_metric
from drakesep.systems import sampling
from drakesep.systems.checks import InputError
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import parameters
from drakesep.systems.simulation.simulation import Simulation


NONE = (math.inf,) * 3
WHEN = (
    *("", "since_release", "after_separation", "until_separation"),
    *("at_release", "at_separation", "at_end"),
    *("at_0.07_s", "at_0.4_s", "from_0.07_s", "from_0.07_to_0.4_s", "until_0.35_s"),
)
EXTREMES = ("", "max", "min", "magnitude_min", "value")


def named(quantity: str, extreme: str, when: str) -> str:
    return "_".join(filter(None, (quantity, extreme, when)))


EVERY = [
    name
    for quantity in QUANTITIES
    for when in WHEN
    for extreme in EXTREMES
    if find_metric(name := named(quantity, extreme, when)) is not None
]


def test_names_say_what_metrics_are():
    for name in EVERY:
        metric, axis = find_metric(name)
        assert (metric.stem, axis) == (name, "")
        for component, axis in zip(metric.names, metric.axes, strict=True):
            assert find_metric(component) == (metric, axis)
        for sense in ("<=", ">="):  # judged by one that there is
            assert find_metric(metric.judged_by(sense)) is not None
        for stem in metric.directions or ():
            assert find_metric(stem) is not None
    for unknown in ("rate_", "rate_at_x", "velocity", "rate_max_at_end", "angle_value"):
        assert metric_of_quantity(unknown) is None


SECONDS = st.floats(0.0, 1e6)


@given(start=SECONDS, end=SECONDS)
def test_times_in_names_are_read_back(start, end):
    """To the ten digits that are written."""
    assert time_named(at_time(start)) == pytest.approx(start, rel=1e-9)
    window = time_named(between_times(start, end))
    assert window[:2] == pytest.approx((start, end), rel=1e-9)
    assert time_named(between_times(start, None))[1] is Moment.END
    assert time_named(between_times(None, end))[0] is Moment.START


RUN = made_up_run(
    rate=lambda t: (0.1 * t, -0.2 * t, 0.3 - 0.2 * t),
    relative_velocity=lambda t: (1.0 - (t - 1.1) ** 2, 9.0 + 0.0 * t, t),
    angle=lambda t: (3.0 + 0.1 * t, -0.2 * t, 0.05 * t),
)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("rate_at_2_s_y", 0.4),
        ("rate_value_at_2_s_y", -0.4),
        ("rate_from_1_to_2_s_z", 0.1),
        ("rate_max_from_1_to_2_s_z", 0.1),
        ("rate_min_from_1_to_2_s_z", -0.1),
        ("rate_magnitude_min_from_1_to_1.25_s_z", 0.05),
        ("rate_magnitude_min_from_1_to_2_s_z", 0.0),
        ("longitudinal_speed_from_2_s", 1.0 - 1.9**2),
        ("longitudinal_speed_max_from_2_s", 1.0 - 0.9**2),
        ("longitudinal_speed_max_until_0.6_s", 0.75),
        ("longitudinal_speed_at_end", 1.0 - 1.9**2),
        # Beyond half a turn over time, and within at a moment.
        ("deviation_from_1_to_2_s_roll", 3.2),
        ("deviation_at_2_s_roll", 2.0 * math.pi - 3.2),
        ("angle_at_2_s_roll", 3.2 - 2.0 * math.pi),
        # All turns are counted from the start, to either side.
        ("rotation_at_2_s_y", 0.4),
        ("rotation_value_at_2_s_y", -0.4),
        ("rotation_max_z", 0.225),
        ("rotation_min_z", 0.0),
        ("rotation_value_at_end_z", 0.0),
        ("rotation_max_from_2_s_z", 0.2),
    ],
)
def test_closed_forms(name, expected):
    metrics = metrics_of_run(RUN, NONE, [name])
    assert metrics[name] == pytest.approx(expected, abs=1e-12)


TURNING = made_up_run(
    dataclasses.replace(generic_pair(duration=3.0), direction=(0.0, 0.6, 0.8)),
    rate=lambda t: (3.0 + 0.0 * t, 0.0 * t, 4.0 * t),
    relative_rate=lambda t: (0.0 * t, 5.0 * t, 0.0 * t),
    angle=lambda t: (0.0 * t, 0.0 * t, 0.3 * t),
    relative_velocity=lambda t: (2.0 * t, 0.0 * t, 1.0 + 0.0 * t),
    relative_position=lambda t: (t**2, 0.0 * t, t),
    acceleration=lambda t: (0.0 * t, 3.0 * t, 4.0 * t),
    linear_momentum_change=lambda t: (6.0 * t, 0.0 * t, 8.0 * t),
    angular_momentum_change=lambda t: (0.0 * t, 12.0 * t, 5.0 * t),
)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("rate_modulus_at_1_s", 5.0),
        ("rate_modulus_until_1_s", 5.0),
        ("rate_modulus_min_until_1_s", 3.0),
        # Along (0, 0.6, 0.8): 0.8 by 4 t; across it 3, 0.48 by 4 t and -0.36 by 4 t.
        ("spin_rate_value_at_1_s", 3.2),
        ("spin_rate_until_1_s", 3.2),
        ("transverse_rate_at_1_s", math.hypot(3.0, 2.4)),
        ("relative_rate_modulus_at_2_s", 10.0),
        ("rotation_at_end_x", 9.0),
        ("relative_total_rotation_at_2_s", 10.0),
        # The integral of sqrt(9 + 16 t^2), from 1 s on that of the start too.
        ("total_rotation_min_from_1_s", 2.5 + 9.0 / 8.0 * math.asinh(4.0 / 3.0)),
        ("relative_spin_rate_value_at_2_s", 6.0),
        ("relative_transverse_rate_from_1_to_2_s", 8.0),
        ("speed_at_1_s", math.sqrt(5.0)),
        ("longitudinal_speed_at_1_s", 0.8),
        ("lateral_speed_at_1_s", math.hypot(2.0, 0.6)),
        ("displacement_at_2_s", math.hypot(4.0, 2.0)),
        ("longitudinal_displacement_at_2_s", 1.6),
        ("lateral_displacement_max_from_1_to_2_s", math.hypot(4.0, 1.2)),
        # Turned about z by a, (0, 0.6, 0.8) is (-0.6 sin a, 0.6 cos a, 0.8).
        ("tip_off_angle_at_2_s", math.acos(0.36 * math.cos(0.6) + 0.64)),
        ("acceleration_at_2_s", 10.0),
        ("acceleration_from_1_to_2_s", 10.0),
        ("momentum_given_at_1_s", 10.0),
        ("angular_momentum_given_at_end", 39.0),
    ],
)
def test_closed_forms_of_the_trade(name, expected):
    # Squares of splines are splines of squares but for 5/384 h^4 times some units.
    told = metrics_of_run(TURNING, NONE, [name])[name]
    assert told == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("spin", [2.0, -2.0])
def test_nutation_of_a_symmetric_body(spin):
    """tan = I_t w_t / (I_s w_s), to either side that it spins."""
    pair = generic_pair(duration=3.0)
    lower, upper = pair.bodies
    upper = dataclasses.replace(upper, I_BBcm_B=(300.0, 400.0, 400.0, 0.0, 0.0, 0.0))
    run = made_up_run(
        dataclasses.replace(pair, bodies=(lower, upper)),
        rate=lambda t: (spin + 0.0 * t, 0.3 * np.cos(t), 0.3 * np.sin(t)),
    )
    expected = math.atan2(400.0 * 0.3, 300.0 * abs(spin))
    names = ["nutation_at_1_s", "nutation_after_separation", "nutation_min_from_1_s"]
    told = metrics_of_run(run, NONE, names)
    for name in names:  # splines of cosines, as above
        assert told[name] == pytest.approx(expected, abs=1e-7)
    still = made_up_run()  # without a rate there is no such angle
    assert metrics_of_run(still, NONE, ["nutation"])["nutation"] == 0.0


def test_force_of_a_spring_is_that_of_equation_5():
    separation = generic_pair(release_times=(0.05, 0.02, 0.09, 0.03), joint=FREE)
    run, spring = Simulation(separation).run(), separation.springs[0]
    w = math.sqrt(spring.force_max / (spring.design_mass * spring.stroke))
    names = ["spring_1.spring_force_at_0.1_s", "spring_1.spring_force"]
    told = metrics_of_run(run, NONE, names)
    # Straight lines between samples of a 64th of the push: w^2 h^2 / 8 of the force.
    expected = spring.force_max * math.cos(w * 0.05)
    assert told[names[0]] == pytest.approx(expected, rel=1e-4)
    assert told[names[1]] == pytest.approx(spring.force_max, rel=1e-12)
    with pytest.raises(InputError, match="unknown spring 'spring_9'; did you mean"):
        metrics_of_run(run, NONE, ["spring_9.spring_force"])


def test_what_the_batch_cannot_tell_is_told_of_whole_runs():
    objective = highest("acceleration_until_separation")
    assert objective.needs is Needs.RUN
    separation = generic_pair(joint=FREE)
    batch = Batch(separation, ["upper.mass"], metrics=["acceleration_at_end"])
    assert "acceleration_at_end" not in batch.metrics
    told = BatchEvaluator(batch, [objective], NONE).all(np.array([[1200.0]]))
    # At release all springs push at once, along one axis, at the lower's gains only.
    expected = sum(spring.force_max for spring in separation.springs) / 1200.0
    assert told.values[0, 0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    "name", ["rate_at_3.1_s_x", "rate_from_1_to_4_s_x", "rate_until_3.5_s_x"]
)
def test_a_time_beyond_the_run_tells_nothing(name):
    assert math.isnan(metrics_of_run(RUN, NONE, [name])[name])
    reached = name.replace("3.1", "3").replace("4", "3").replace("3.5", "3")
    assert not math.isnan(metrics_of_run(RUN, NONE, [reached])[reached])


@pytest.fixture(scope="module")
def both():
    """A batch that tells all, its rows, and the same from Drake's runs."""
    # Splines through samples of 3 ms, 64 in a push: as good as the integrations.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sampling, "_ROWS", 1000)
        separation = aslant(
            generic_pair(release_times=(0.05, 0.02, 0.09, 0.03), joint=FREE)
        )
        names = ("upper.mass", "spring_1.force_max", "attachment_2.release_time")
        nominal = np.array([parameters(separation)[name] for name in names])
        spread = np.random.default_rng(0).uniform(-0.1, 0.1, size=(2, 3))
        rows = nominal * np.concatenate([np.ones((1, 3)), 1.0 + spread])
        batch = Batch(separation, names, metrics=EVERY_COMPONENT, tolerance=1e-9)
        simulation = Simulation(separation, Integration(accuracy=1e-10))
        flown = [simulation.run(dict(zip(names, row, strict=True))) for row in rows]
        expected = [metrics_of_run(run, NONE, EVERY_COMPONENT) for run in flown]
        yield batch, rows, expected


PLAIN = ("rate", "relative_rate", "deviation", "angle", "longitudinal_speed")
FEW = ("after_separation", "at_0.4_s", "from_0.07_to_0.4_s")
ROTATIONS = (
    *("rotation_value_at_release", "total_rotation_at_separation", "rotation"),
    *("total_rotation_at_0.4_s", "relative_rotation_min_from_0.07_to_0.4_s"),
)
TOLD = [
    metric
    for name in EVERY
    if (metric := find_metric(name)[0]).of_steps
    and (
        name in ROTATIONS
        if "rotation" in name
        else name.startswith(PLAIN) or name.endswith(FEW)
    )
]
EVERY_COMPONENT = [metric.names[0] for metric in TOLD]


def aslant(separation):
    """B is mated at an angle, and leaves along no axis."""
    lower, upper = separation.bodies
    upper = dataclasses.replace(upper, rpy_AB=(0.3, -0.2, 0.5))
    return dataclasses.replace(
        separation, bodies=(lower, upper), direction=(0.6, 0.48, 0.64)
    )


def test_both_engines_tell_the_same(both):
    batch, rows, expected = both
    told = batch.run(rows).metrics
    assert set(batch.metrics) == set(expected[0])
    for name in told:
        drake = np.array([metrics[name] for metrics in expected])
        # As the registered ones: the engines' errors are at most 1e-9 and 1e-8. Of
        # roots the squares are told, which splines through samples miss by 1e-10.
        allowed = np.maximum(1e-9, 1e-8 * np.abs(drake))
        signal = find_metric(name)[0].signal
        if signal is not None and signal.outer is not Outer.ITSELF:
            allowed = np.maximum(allowed, 1e-10 / (np.abs(drake) + 1e-9))
        assert (np.abs(told[name] - drake) <= allowed).all(), name


@pytest.mark.slow
def test_derivatives_of_metrics_at_times_in_seconds(both):
    """Against differences of the batch itself, whose steps move with the releases."""
    batch, rows, _ = both
    names = [
        *("rate_value_at_0.07_s_y", "rate_max_from_0.07_to_0.4_s_x"),
        *("longitudinal_speed_at_0.4_s", "angle_min_until_0.35_s_yaw"),
        *("longitudinal_speed_max_until_0.35_s", "rate_min_from_0.07_s_z"),
        *("total_rotation_at_0.4_s", "total_rotation_at_separation"),
    ]
    row, columns = rows[1], [list(batch.metrics).index(name) for name in names]
    jacobian = batch.jacobian(row[None]).jacobian[0][columns]
    for i, h in enumerate((1e-2, 1e-2, 1e-5)):
        steps = np.array([row, row])
        steps[:, i] += [h, -h]
        high, low = batch.run(steps).metrics[names].to_numpy()
        # Curvature and errors of 1e-9 over the step.
        assert jacobian[:, i] == pytest.approx(
            (high - low) / (2.0 * h), rel=1e-4, abs=2e-9 / h
        )


def test_an_objective_says_which_metrics_its_batch_must_tell(both):
    separation = generic_pair(joint=FREE)
    objective = highest("rate_max_from_0.5_s_x") + as_objective("L1")
    with pytest.raises(InputError, match="make it with metrics="):
        BatchEvaluator(Batch(separation, ["upper.mass"]), [objective], NONE)
    batch = Batch(separation, ["upper.mass"], metrics=objective.reads)
    told = BatchEvaluator(batch, [objective], NONE).all(np.array([[1200.0]]))
    metrics = batch.run([[1200.0]]).metrics.iloc[0]
    assert told.values[0, 0] == metrics["rate_max_from_0.5_s_x"] + metrics["G_L1"]


def test_extremes_of_a_window_are_those_of_the_quantity():
    assert metric_of_quantity("rate_after_separation")[0].functional is (
        Functional.LARGEST_MAGNITUDE
    )
    window = metric_of_quantity("rate_from_0.5_to_2_s")[0].when
    assert isinstance(window, Window) and window[:2] == (0.5, 2.0)
