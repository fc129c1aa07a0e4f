"""The registry of metrics: every entry means the same wherever it is read."""

import dataclasses
import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from runs import made_up_run
from separations import FREE, coaxial, generic_pair
from toy_metrics import OTHERS, RELATIVE, RELATIVE_MIN, WHILE_PUSHED, registered

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.engines.jax.batch_evaluator import BatchEvaluator
from drakesep.analysis.metrics.metric import (
    AFTER_SEPARATION,
    ANGLE,
    RATE,
    Functional,
    Kind,
    Metric,
    Moment,
    Window,
)
from drakesep.analysis.metrics.objectives import (
    OBJECTIVES,
    ObjectiveName,
    highest,
    lowest,
)
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import (
    METRICS,
    find_metric,
    forget_metric,
    register_metric,
    registered_metrics,
)
from drakesep.analysis.metrics.requirements import Requirement, assess
from drakesep.systems import sampling
from drakesep.systems.checks import InputError
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.simulation.simulation import Simulation


NONE = (math.inf,) * 3


# Both engines.


def test_every_metric_is_the_same_in_both_engines(monkeypatch):
    """The built-in ones and some made up; springs let go one after the other."""
    # Splines through samples of 3 ms, 64 in a push: as good as the integrations.
    monkeypatch.setattr(sampling, "_ROWS", 1000)
    separation = generic_pair(release_times=(0.05, 0.02, 0.09, 0.03), joint=FREE)
    names = ("upper.mass", "spring_1.force_max", "attachment_2.release_time")
    nominal = np.array([parameters(separation)[name] for name in names])
    spread = np.random.default_rng(0).uniform(-0.1, 0.1, size=(3, 3))
    rows = nominal * np.concatenate([np.ones((1, 3)), 1.0 + spread])
    turned = 0.02 + abs(separation.initial.rpy_WA[1])
    limits = (math.inf, turned, math.inf)
    with registered(RELATIVE, RELATIVE_MIN, *OTHERS):
        batch = Batch(separation, names, deviation_limits=limits, tolerance=1e-9)
        told = batch.run(rows).metrics
        simulation = Simulation(separation, Integration(accuracy=1e-10))
        flown = [simulation.run(dict(zip(names, row, strict=True))) for row in rows]
        expected = [metrics_of_run(run, limits) for run in flown]
        assert tuple(told.columns) == tuple(METRICS)
        until = told["deviation_within_limits_until"]
        assert ((until > 0.0) & (until < separation.duration)).all()  # it is felt
    # What is registered no more is still told by what was made before.
    assert RELATIVE.names[0] in batch.run(rows[:1]).metrics
    for name in told:
        drake = np.array([metrics[name] for metrics in expected])
        # As `test_batch` has it; the engines' errors are at most 1e-9 and 1e-8.
        allowed = np.maximum(1e-9, 1e-8 * np.abs(drake))
        assert (np.abs(told[name] - drake) <= allowed).all(), name


FROM_ROLL = Metric(
    stem="roll_at_end",
    kind=Kind.ANGLE,
    functional=Functional.VALUE,
    signal=ANGLE,
    when=Moment.END,
)
MOST_ROLL, LEAST_ROLL, ROLLED = (
    Metric(
        stem=stem,
        kind=Kind.ANGLE,
        functional=functional,
        signal=ANGLE,
        when=AFTER_SEPARATION,
    )
    for stem, functional in (
        ("most_roll", Functional.LARGEST),
        ("least_roll", Functional.SMALLEST),
        ("roll_over_time", Functional.INTEGRAL_OF_MAGNITUDE),
    )
)


@pytest.mark.parametrize("spin", [2.5, pytest.param(-2.5, marks=pytest.mark.slow)])
def test_angles_go_on_beyond_half_a_turn(spin):
    """A stack that spins about its axis: its roll is 3 rad + spin t, by hand."""
    duration, roll = 4.0, math.copysign(3.0, spin)
    separation = dataclasses.replace(
        coaxial(generic_pair(duration=duration, joint=FREE)),
        initial=InitialMotion(rpy_WA=(roll, 0.0, 0.0), w_WA_A=(spin, 0.0, 0.0)),
    )
    turned = roll + spin * duration
    limits = (4.0, math.inf, math.inf)
    with registered(MOST_ROLL, LEAST_ROLL, ROLLED, FROM_ROLL):
        batch = Batch(separation, ["upper.mass"], deviation_limits=limits)
        told = batch.run([[1200.0]]).metrics.iloc[0]
        flown = Simulation(separation, Integration(accuracy=1e-9)).run()
        end = flown.separation_end
        at_separation = roll + spin * end
        for metrics in (told, metrics_of_run(flown, limits)):
            ends = sorted([at_separation, turned])
            # Both engines' errors of an angle at their tolerances, over 4 s.
            close = {"abs": 1e-6}
            assert metrics["least_roll_roll"] == pytest.approx(ends[0], **close)
            assert metrics["most_roll_roll"] == pytest.approx(ends[1], **close)
            mean = 0.5 * abs(at_separation + turned)
            area = mean * (duration - end)
            assert metrics["roll_over_time_roll"] == pytest.approx(area, abs=4e-6)
            until = (4.0 - 3.0) / 2.5
            assert metrics["deviation_within_limits_until"] == pytest.approx(
                until, **close
            )
            within = math.remainder(turned, math.tau)
            assert metrics["roll_at_end_roll"] == pytest.approx(within, **close)
            within = math.remainder(at_separation, math.tau)
            assert metrics["angle_at_separation_roll"] == pytest.approx(within, **close)


def test_an_objective_finds_its_metric_where_another_was_forgotten():
    """In a batch of before: its columns are those of then."""
    separation = generic_pair(joint=FREE)
    names, other = ["upper.mass"], dataclasses.replace(RELATIVE, at_least="")
    rows = np.array([[1200.0]])
    with registered(RELATIVE_MIN):
        with registered(other):
            batch = Batch(separation, names)
            objective = lowest(RELATIVE_MIN.names[1]) + highest(other.names[0])
            evaluator = BatchEvaluator(batch, [objective], NONE)
        with registered(dataclasses.replace(other, stem="one_more")):
            told = evaluator.all(rows).values[0, 0]
            value, slopes = evaluator.slopes(rows, [0])
    metrics = batch.run(rows).metrics.iloc[0]
    assert told == metrics[other.names[0]] - metrics[RELATIVE_MIN.names[1]]
    jacobian = dict(zip(metrics.index, batch.jacobian(rows).jacobian[0], strict=True))
    slope = jacobian[other.names[0]] - jacobian[RELATIVE_MIN.names[1]]
    # A batch with derivatives goes other steps, within its tolerance of 1e-7.
    assert value.values[0] == pytest.approx(told, abs=1e-7)
    assert slopes[0] == pytest.approx(slope, rel=1e-12)


# The extreme that breaks a limit.


def wave(a, w, phase, offset):
    return lambda t: a * np.sin(w * t + phase) + offset


WAVES = st.builds(
    wave,
    st.floats(0.1, 1.0),
    st.floats(0.5, 4.0),
    st.floats(0.0, 6.0),
    st.floats(-0.6, 0.6),
)


def integral(values, time):
    return float(np.trapezoid(values, time))


def held(stem, t, end, rate, relative, angle, speed, limits):
    """What must keep a limit on a metric, component by component: brute force.

    A metric that names a quantity is limited at all times of its window; one that names
    an extreme, an integral or a time is limited as the number that it is.
    """
    after = t >= end
    at_end = np.searchsorted(t, end)
    peaks = [np.abs(w).max() for w in relative]
    one = {
        "G_L1": [sum(integral(np.abs(w), t) for w in relative)],
        "G_L2": [math.sqrt(sum(integral(w**2, t) for w in relative))],
        "G_Linf": [sum(peaks)],
        "G_PM": [-speed.max()],
        "deviation_within_limits_until": [
            min(
                float(t[np.abs(a) > limit][0]) if (np.abs(a) > limit).any() else t[-1]
                for a, limit in zip(angle, limits, strict=True)
            )
        ],
        "longitudinal_speed_max": [speed.max()],
        "longitudinal_speed_after_separation": [speed[after]],
        "longitudinal_speed_max_after_separation": [speed[after].max()],
        "separation_end": [end],
    }
    each_rate = {
        "final_rate": lambda w: w[-1],
        "rate_after_separation": lambda w: np.abs(w[after]),
        "rate_min_after_separation": lambda w: w[after].min(),
        "rate_max_after_separation": lambda w: w[after].max(),
        "rate_magnitude_min_after_separation": lambda w: np.abs(w[after]).min(),
    }
    each_angle = {
        "deviation_at_separation": lambda a: abs(a[at_end]),
        "angle_at_separation": lambda a: a[at_end],
    }
    if stem in one:
        return one[stem]
    if stem in each_rate:
        return [each_rate[stem](w) for w in rate]
    return [each_angle[stem](a) for a in angle]


EVERY = [metric for metric in registered_metrics() if metric.of_every_run]
DENSE = np.linspace(0.0, 3.0, 6001)


@pytest.mark.parametrize("sense", ["<=", ">="])
@pytest.mark.parametrize("metric", EVERY, ids=lambda metric: metric.stem)
@settings(max_examples=15)
@given(waves=st.lists(WAVES, min_size=10, max_size=10), limit=st.floats(-1.5, 1.5))
def test_met_where_the_signal_keeps_its_limit(metric, sense, waves, limit):
    limit = max(abs(limit), 1e-2) if metric.never_negative else limit
    limits = (0.3, 0.5, math.inf)
    rate, relative, angle = waves[:3], waves[3:6], waves[6:9]

    def columns(functions):
        return lambda t: [function(t) for function in functions]

    run = made_up_run(
        generic_pair(duration=3.0, springs=True, joint=FREE),
        rate=columns(rate),
        relative_rate=columns(relative),
        angle=columns(angle),
        relative_velocity=columns([waves[9], waves[9], waves[9]]),
    )
    signals = [[f(DENSE) for f in functions] for functions in (rate, relative, angle)]
    expected = held(
        metric.stem, DENSE, run.separation_end, *signals, waves[9](DENSE), limits
    )
    metrics = metrics_of_run(run, limits)
    for name, values in zip(metric.names, expected, strict=True):
        slack = np.min(limit - values if sense == "<=" else values - limit)
        # 5e-4 s between points, for times; extremes and integrals are nearer.
        assume(abs(slack) > 1e-3)
        requirement = Requirement(metric=name, sense=sense, limit=limit)
        [finding] = assess([requirement], {"run": metrics}, "run")
        assert finding.met == bool(slack > 0.0), name


def test_partners_look_at_the_same():
    """At the same signal and time; directions and extremes are those they should be."""
    up_and_down = {
        Functional.LARGEST_MAGNITUDE: (Functional.LARGEST, Functional.SMALLEST),
        Functional.MAGNITUDE: (Functional.VALUE, Functional.VALUE),
    }
    other = {
        Functional.LARGEST_MAGNITUDE: {">=": Functional.SMALLEST_MAGNITUDE},
        Functional.SMALLEST: {"<=": Functional.LARGEST},
    }
    checked = 0
    for metric in registered_metrics():
        partners = [
            (metric.judged_by(sense), other.get(metric.functional, {}).get(sense))
            for sense in ("<=", ">=")
            if metric.judged_by(sense) != metric.stem
        ]
        if metric.directions is not None:
            functionals = up_and_down[metric.functional]
            partners += zip(metric.directions, functionals, strict=True)
        for stem, functional in partners:
            partner, _ = find_metric(stem)
            same = dataclasses.replace(
                metric,
                stem=stem,
                functional=functional,
                at_most="",
                at_least="",
                directions=None,
            )
            assert partner == same, metric.stem
            checked += 1
    assert checked == 6


# What is in it.


def test_names_are_those_of_the_entries():
    assert METRICS[:5] == ("G_L1", "G_L2", "G_Linf", "G_PM", "final_rate_x")
    assert "clearance" not in METRICS
    assert find_metric("clearance")[0].kind is Kind.CLEARANCE
    assert find_metric("rate_after_separation_y")[0].axes == ("x", "y", "z")
    assert find_metric("deviation_at_separation_yaw")[1] == "yaw"
    assert find_metric("deviation_at_separation")[0].axes == ("roll", "pitch", "yaw")
    for unknown in ("rate_after_separation_yaw", "G_L1_x", "x", ""):
        assert find_metric(unknown) is None
    before = list(METRICS)
    with registered(RELATIVE):
        assert list(METRICS) == [*before, *RELATIVE.names]
        assert highest(RELATIVE.names[1]).shown_as.name == RELATIVE.names[1]
        with pytest.raises(InputError, match="is registered already"):
            register_metric(RELATIVE)
    assert list(METRICS) == before
    with pytest.raises(InputError, match="unknown metric"):
        highest(RELATIVE.names[1])


def test_the_papers_objectives_are_named_where_types_are():
    assert tuple(OBJECTIVES) == get_args(ObjectiveName)


LARGEST = {"functional": Functional.LARGEST, "signal": RATE}


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"functional": Functional.LARGEST}, "largest value needs a signal"),
        ({"functional": Functional.TIME, "signal": RATE}, "time needs no signal"),
        ({"functional": Functional.VALUE, "signal": RATE}, "value needs a moment"),
        (
            {
                "functional": Functional.LARGEST,
                "signal": RATE,
                "when": Moment.END,
            },
            "largest value needs a window",
        ),
        (
            {
                "functional": Functional.TIME_WITHIN,
                "signal": ANGLE,
                "when": WHILE_PUSHED,
            },
            "limits are those of the angles",
        ),
        (LARGEST | {"sign": math.nan}, "sign must be 1 or -1, got nan"),
        (
            LARGEST | {"when": Window(Moment.END, Moment.RELEASE, "backwards")},
            "window must be from one moment to a later, got from the end to the f",
        ),
        (
            LARGEST | {"signal": RATE._replace(quantity="speed")},
            "signal: unknown field 'speed'",
        ),
        (
            LARGEST | {"signal": RATE._replace(components=(0, 1, 3))},
            "signal: components must be of 0, 1, 2, got",
        ),
        (
            LARGEST | {"signal": RATE._replace(axes=("x", "y"))},
            "signal: each component must have an axis of its own",
        ),
    ],
)
def test_entries_that_make_no_sense(fields, message):
    with pytest.raises(InputError, match=f"(mine|metric): {message}"):
        Metric(**{"stem": "mine", "kind": Kind.RATE, **fields})


def test_a_stem_that_cannot_be_a_name_is_refused():
    spaced = Metric(stem="my toy", kind=Kind.RATE, **LARGEST)
    with pytest.raises(InputError, match="stem must be of letters, digits and _, got"):
        register_metric(spaced)


def test_metrics_of_drakesep_stay():
    for stem in ("final_rate", "no_such_metric"):
        with pytest.raises(InputError, match=f"registered .*, got '{stem}'"):
            forget_metric(stem)


def test_objectives_of_the_paper_are_no_others():
    mine = dataclasses.replace(RELATIVE, objective="mine")
    with pytest.raises(InputError, match=r"objective must be empty.* got 'mine'"):
        register_metric(mine)


def test_a_limit_judged_by_no_metric_is_refused():
    with registered(RELATIVE):
        required = Requirement(metric=RELATIVE.names[0], sense=">=", limit=0.1)
        with pytest.raises(InputError, match=r"is judged by '.*_x', which must be a"):
            _ = required.judged_by
