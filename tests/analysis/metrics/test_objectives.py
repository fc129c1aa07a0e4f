"""The paper's objectives on motions whose norms are known."""

import dataclasses
import math

import numpy as np
import pytest
from runs import made_up_run
from separations import generic_pair

from drakesep.analysis.metrics.objectives import (
    OBJECTIVES,
    MetricObjective,
    Needs,
    as_objective,
    highest,
    largest,
    lowest,
    of_run,
    towards,
)
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import METRICS
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.model.run import Run, RunStatus


RUN = made_up_run(
    relative_rate=lambda t: (np.sin(math.pi * t), -2.0 * t, 3.0 + 0.0 * t),
    relative_velocity=lambda t: (1.0 - (t - 1.1) ** 2, 9.0 + 0.0 * t, t),
    rate=lambda t: (0.1 * t, -0.2 * t, 0.3 - 0.2 * t),
    angle=lambda t: (0.1 * t, -0.2 * t, 0.05 * t),
)

# Splines over steps of 0.01 s: 5/384 (pi h)^4 = 1e-8
CLOSE = 5e-8


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("L1", 6.0 / math.pi + 9.0 + 9.0),
        ("L2", math.sqrt(1.5 + 36.0 + 27.0)),
        ("Linf", 1.0 + 6.0 + 3.0),
        ("PM", -1.0),
    ],
)
def test_objective(name, expected):
    assert OBJECTIVES[name](RUN) == pytest.approx(expected, abs=CLOSE)


def test_objectives_begin_at_the_release():
    late = generic_pair(release_times=(1.0, 1.5, 2.0, 2.0), duration=3.0)
    run = made_up_run(late, relative_rate=lambda t: (3.0 - t, 0.0 * t, 0.0 * t))
    assert OBJECTIVES["L1"](run) == pytest.approx(2.0, abs=CLOSE)
    assert OBJECTIVES["Linf"](run) == pytest.approx(2.0, abs=CLOSE)


def test_metrics():
    limits = (1.0, 0.3, math.inf)
    metrics = metrics_of_run(RUN, limits)
    end = RUN.separation_end
    assert metrics["separation_end"] == end
    assert metrics["final_rate_y"] == pytest.approx(-0.6, abs=1e-12)
    assert metrics["rate_after_separation_y"] == pytest.approx(0.6, abs=1e-12)
    # falls through zero after the separation: the larger side counts
    assert metrics["rate_after_separation_z"] == pytest.approx(0.3, abs=1e-12)
    assert metrics["deviation_at_separation_pitch"] == pytest.approx(0.2 * end)
    assert metrics["deviation_within_limits_until"] == pytest.approx(1.5, abs=1e-9)
    assert metrics["longitudinal_speed_max"] == pytest.approx(1.0)
    slowest = 1.0 - 1.9**2
    assert metrics["longitudinal_speed_after_separation"] == pytest.approx(slowest)
    fastest = metrics["longitudinal_speed_max_after_separation"]
    assert fastest == pytest.approx(1.0)  # at 1.1 s
    # From 0.2 end to 0.6, and through zero.
    assert metrics["rate_magnitude_min_after_separation_y"] == pytest.approx(0.2 * end)
    assert metrics["rate_magnitude_min_after_separation_z"] == 0.0
    assert metrics["G_PM"] == OBJECTIVES["PM"](RUN)


def test_failed_run_has_no_value():
    failed = dataclasses.replace(RUN, status=RunStatus.FAILED, motion=None, message="x")
    assert isinstance(failed, Run)
    for objective in OBJECTIVES.values():
        with pytest.raises(RuntimeError, match="the run failed: x"):
            objective(failed)


LIMITS = (1.0, 0.3, math.inf)
MEASURED = metrics_of_run(RUN, LIMITS)


def test_both_directions_of_a_magnitude():
    """The z rate falls through zero after the separation: from 0.3 to -0.3."""
    end = RUN.separation_end
    assert MEASURED["rate_max_after_separation_z"] == pytest.approx(0.3 - 0.2 * end)
    assert MEASURED["rate_min_after_separation_z"] == pytest.approx(-0.3)
    assert MEASURED["angle_at_separation_pitch"] == pytest.approx(-0.2 * end)


def test_sums_multiples_and_the_largest():
    values = {name: np.array([value]) for name, value in MEASURED.items()}
    first, second = highest("G_L1"), lowest("longitudinal_speed_max")
    for objective, expected in (
        (
            first + second,
            MEASURED["G_L1"] - MEASURED["longitudinal_speed_max"],
        ),
        (
            2.0 * first - second,
            2 * MEASURED["G_L1"] + MEASURED["longitudinal_speed_max"],
        ),
        (-first, -MEASURED["G_L1"]),
        (largest(-first, second), -MEASURED["longitudinal_speed_max"]),
        (first + of_run(lambda run: 5.0), MEASURED["G_L1"] + 5.0),
        (sum([first, first]), 2.0 * MEASURED["G_L1"]),
        (first + "L1", 2.0 * MEASURED["G_L1"]),
        (largest("L1", lambda run: 1e6), 1e6),
    ):
        assert objective.of_run(RUN, LIMITS) == pytest.approx(expected)
        if isinstance(objective, MetricObjective):
            assert objective.of_metrics(values) == pytest.approx([expected])
            weights, h = objective.weights(values), 1e-6
            for name in METRICS:
                stepped = values | {name: values[name] + h}
                slope = (objective.of_metrics(stepped) - expected) / h
                # eps / h, of values up to 20
                weight = weights.get(name, 0.0)
                assert weight == pytest.approx(slope, abs=1e-8), name
        else:
            assert objective.needs is Needs.RUN
    assert (2.0 * first - second).name == (
        "2*highest_G_L1-lowest_longitudinal_speed_max"
    )
    assert (first + second).named("mine").name == "mine"


def test_a_window_looks_at_a_part_of_the_run():
    """Linear signals, from 1 s to 2 s."""
    window = (1.0, 2.0)
    assert highest("rate_max_after_separation_x", window=window)(RUN) == pytest.approx(
        0.2
    )
    assert lowest("rate_min_after_separation_y", window=window)(RUN) == pytest.approx(
        0.4
    )
    # |sin(pi t)| over one period's half, 2 t, 3
    expected = 2.0 / math.pi + 3.0 + 3.0
    assert highest("G_L1", window=window)(RUN) == pytest.approx(expected, abs=CLOSE)
    assert highest("G_L1", window=window).name == "highest_G_L1_1_to_2_s"
    # takes the place of "after separation", which ends later than this
    early = (0.0, 0.5 * RUN.separation_end)
    assert lowest("rate_min_after_separation_y", window=early)(RUN) == pytest.approx(
        0.1 * RUN.separation_end
    )
    speed = highest("longitudinal_speed_max", window=(0.0, 0.5))(RUN)
    assert speed == pytest.approx(1.0 - 0.6**2)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: highest("G_L3"), "unknown metric 'G_L3'; did you mean 'G_L"),
        (lambda: highest("final_rate_x", window=(0.0, 1.0)), "window: must be of one"),
        (lambda: highest("G_L1", window=(1.0, 1.0)), "must be from one time to a late"),
        (
            lambda: highest("G_L1", window=(math.nan, 1.0)),
            "must be from one time to a later",
        ),
        (lambda: highest("G_L1", window=(4.0, 5.0))(RUN), "window: must end after 0"),
        (lambda: highest("G_L1", window=(1.0, 2.0, 3.0)), "from one time to a later"),
        (lambda: highest("G_L1", window=1.0), r"window must be \(a number, a numb"),
        (lambda: largest(), "largest: must have an objective or more"),
        (lambda: of_run(3), "function must be a function, got 3"),
        (lambda: math.nan * highest("G_L1"), "factors of a sum must be finite"),
        (lambda: as_objective("L3"), "unknown objective 'L3'; did you mean 'L"),
        (lambda: as_objective("highest_velocity"), "unknown metric 'velocity'"),
    ],
)
def test_bad_objectives(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_objectives_by_name():
    assert as_objective("L1") is OBJECTIVES["L1"]
    assert as_objective("lowest_G_L1")(RUN) == -OBJECTIVES["L1"](RUN)
    assert as_objective(lambda run: 7.0)(RUN) == 7.0


@pytest.mark.parametrize(
    ("metric", "sense", "names"),
    [
        ("rate_after_separation_x", "<=", ["up", "down"]),
        ("deviation_at_separation_yaw", "<=", ["up", "down"]),
        ("longitudinal_speed_after_separation", ">=", None),
    ],
)
def test_ways_out_of_a_requirement(metric, sense, names):
    """The larger of both directions is the magnitude."""
    objectives = towards(Requirement(metric=metric, sense=sense, limit=1.0))
    worst = max(objective(RUN) for objective in objectives)
    metrics = metrics_of_run(RUN, (math.inf,) * 3)
    assert worst == (metrics[metric] if sense == "<=" else -metrics[metric])
    if names:
        assert [o.name for o in objectives] == [f"{metric}_{name}" for name in names]
