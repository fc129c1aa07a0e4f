"""Metrics of quantities by their names, against closed forms and in both engines."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runs import made_up_run
from separations import FREE, generic_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.engines.jax.batch_evaluator import BatchEvaluator
from drakesep.analysis.metrics.metric import Functional, Moment, Window
from drakesep.analysis.metrics.objectives import as_objective, highest
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
    for unknown in ("rate_", "rate_at_x", "speed", "rate_max_at_end", "angle_value"):
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
    ],
)
def test_closed_forms(name, expected):
    metrics = metrics_of_run(RUN, NONE, [name])
    assert metrics[name] == pytest.approx(expected, abs=1e-12)


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
        separation = generic_pair(release_times=(0.05, 0.02, 0.09, 0.03), joint=FREE)
        names = ("upper.mass", "spring_1.force_max", "attachment_2.release_time")
        nominal = np.array([parameters(separation)[name] for name in names])
        spread = np.random.default_rng(0).uniform(-0.1, 0.1, size=(2, 3))
        rows = nominal * np.concatenate([np.ones((1, 3)), 1.0 + spread])
        batch = Batch(separation, names, metrics=EVERY_COMPONENT, tolerance=1e-9)
        simulation = Simulation(separation, Integration(accuracy=1e-10))
        flown = [simulation.run(dict(zip(names, row, strict=True))) for row in rows]
        expected = [metrics_of_run(run, NONE, EVERY_COMPONENT) for run in flown]
        yield batch, rows, expected


EVERY_COMPONENT = [find_metric(name)[0].names[0] for name in EVERY]


def test_both_engines_tell_the_same(both):
    batch, rows, expected = both
    told = batch.run(rows).metrics
    assert set(batch.metrics) == set(expected[0])
    for name in told:
        drake = np.array([metrics[name] for metrics in expected])
        # As the registered ones: the engines' errors are at most 1e-9 and 1e-8.
        allowed = np.maximum(1e-9, 1e-8 * np.abs(drake))
        assert (np.abs(told[name] - drake) <= allowed).all(), name


def test_derivatives_of_metrics_at_times_in_seconds(both):
    """Against differences of the batch itself, whose steps move with the releases."""
    batch, rows, _ = both
    names = [
        *("rate_value_at_0.07_s_y", "rate_max_from_0.07_to_0.4_s_x"),
        *("longitudinal_speed_at_0.4_s", "angle_min_until_0.35_s_yaw"),
        *("longitudinal_speed_max_until_0.35_s", "rate_min_from_0.07_s_z"),
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
