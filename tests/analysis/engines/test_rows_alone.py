"""Rows of a batch know nothing of each other: n of them are n batches of one.

Of whatever is asked, in chunks of three, with rows that fail for every reason that
there is first, in the middle, last, and one to a chunk.
"""

import numpy as np
import pytest
from separations import hinged_pair

from drakesep.analysis.engines.jax import batch as engine
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.registry import METRICS
from drakesep.systems.batch.integrator import LaneStatus
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.run import RunStatus


pytestmark = pytest.mark.slow  # compiles programs of its own, for minutes


NAMES = (
    "upper.mass",
    "upper.inertia_xx",
    "attachment_1.release_time",
    "attachment_2.release_angle",
    "spring_1.force_max",
    "spring_1.stroke",
    "spring_1.damping",
)
SEPARATION = hinged_pair()
NOMINAL = np.array([parameters(SEPARATION)[name] for name in NAMES])
MAX_STEPS = 150
"""Twice what a row takes that flies."""
CHUNK = 3

# Why a row fails, and what is changed for it.
UNPHYSICAL = {
    "upper: mass must be > 0, got -3": {"upper.mass": -3.0},
    "upper.mass must be finite, got nan": {"upper.mass": np.nan},
    "triangle inequality": {"upper.inertia_xx": 1e5},
    "release time must lie before the end": {"attachment_1.release_time": 0.4},
    "spring_1: stroke must be > 0": {"spring_1.stroke": 0.0},
}
IN_FLIGHT = {
    LaneStatus.STILL_HELD: {"attachment_2.release_angle": 3.0},
    LaneStatus.STROKE_LEFT: {"spring_1.stroke": 50.0},
    LaneStatus.STEP_COLLAPSED: {"spring_1.damping": 1e15},
    LaneStatus.TOO_MANY_STEPS: {"upper.mass": 1e-3},
}
"""By how the row ends."""


def row(changes, number=0):
    """The nominal, a little to the side so that no two are alike, with changes."""
    values = NOMINAL * (1.0 + 1e-3 * number)
    for name, value in changes.items():
        values[NAMES.index(name)] = value
    return values


SAID = {
    LaneStatus.STILL_HELD: "attachment_2 has not let go: its joint has not moved far",
    LaneStatus.STROKE_LEFT: "spring_1 has not reached its stroke",
    LaneStatus.STEP_COLLAPSED: "the step size collapsed (at t = 0 s)",
    LaneStatus.TOO_MANY_STEPS: f"more than {MAX_STEPS} integration steps (at t = ",
}


GOOD = [row({}, i) for i in range(6)]
BAD = [row(c) for c in (*UNPHYSICAL.values(), *IN_FLIGHT.values())]
ORDERS = {
    "first": [*BAD, *GOOD],
    "middle": [*GOOD[:3], *BAD, *GOOD[3:]],
    "last": [*GOOD, *BAD],
    "one to a chunk": [
        r for k, bad in enumerate(BAD) for r in (GOOD[k % 6], bad, GOOD[(k + 1) % 6])
    ],
}


def batch(chunk):
    return Batch(SEPARATION, NAMES, chunk=chunk, max_steps=MAX_STEPS, tolerance=1e-9)


@pytest.fixture(scope="module")
def run():
    return batch(CHUNK).run


@pytest.fixture(scope="module")
def jacobian():
    """A row has as many lanes as parameters, each twice as wide."""
    return batch(2 * len(NAMES) * CHUNK).jacobian


@pytest.fixture(scope="module")
def alone():
    """What comes of a row in a batch of its own, by the function that flies it."""
    known = {}

    def one(fly, values):
        key = fly.__name__, values.tobytes()
        if key not in known:
            known[key] = fly([values])
        return known[key]

    return one


def test_every_reason_is_there(run, alone):
    for wanted, changes in UNPHYSICAL.items():
        result = alone(run, row(changes))
        assert wanted in result.failures[0]
        assert result.steps.tolist() == [0]
    for status, changes in IN_FLIGHT.items():
        result = alone(run, row(changes))
        assert result.failures[0].startswith(SAID[status])
        assert 0 < result.steps[0] <= MAX_STEPS
    for values in GOOD:
        assert not alone(run, values).failures
    # No row is known that completes and has metrics that are not finite.
    others = {LaneStatus.FLYING, LaneStatus.COMPLETED}
    assert set(IN_FLIGHT) == set(LaneStatus) - others


@pytest.mark.parametrize("order", ORDERS)
def test_run(order, run, alone):
    rows = ORDERS[order]
    result = run(np.array(rows))
    each = [alone(run, values) for values in rows]
    assert_alike(result, each)


@pytest.mark.parametrize("order", ORDERS)
def test_jacobian(order, jacobian, alone):
    rows = ORDERS[order]
    result = jacobian(np.array(rows))
    each = [alone(jacobian, values) for values in rows]
    assert_alike(result, each)
    slopes = np.concatenate([one.jacobian for one in each])
    assert (np.isnan(result.jacobian) == np.isnan(slopes)).all()
    failed = list(result.failures)
    assert np.isnan(result.jacobian[failed]).all()
    # Of the largest slope that a metric has with the parameter: neighbours choose
    # between two methods, as below, and slopes have fewer digits than metrics.
    scale = np.nanmax(np.abs(slopes), axis=0, initial=1e-9)
    apart = (result.jacobian - slopes) / scale
    assert np.nanmax(np.abs(apart)) <= 2e-6


def test_slopes_at_events_that_are_found(run, jacobian):
    """Strokes and angles that are met, and times of release, carry derivatives.

    Against differences of fourth order.
    """
    steps = 1e-3 * np.abs(NOMINAL)
    offsets = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
    probes = [
        NOMINAL + k * step * unit
        for step, unit in zip(steps, np.eye(len(NAMES)), strict=True)
        for k in offsets
    ]
    metrics = run(np.array(probes)).metrics.to_numpy()
    metrics = metrics.reshape(len(NAMES), len(offsets), len(METRICS))
    expected = np.tensordot(list(offsets.values()), metrics, ((0,), (1,))).T
    got = jacobian(NOMINAL[None]).jacobian[0] * steps
    # To 1e-6 of a metric's largest change over the steps, beside their noise.
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(got - expected) <= 1e-6 * scale + 1e-11).all()


def why(failure: str) -> str:
    """Without how far it came: its neighbours have a say in how long steps are."""
    return failure.partition(" (at t =")[0]


def assert_alike(result, each):
    expected = {i: why(one.failures[0]) for i, one in enumerate(each) if one.failures}
    assert {i: why(text) for i, text in result.failures.items()} == expected
    assert list(result.metrics.columns) == list(METRICS)
    metrics = np.concatenate([one.metrics.to_numpy() for one in each])
    assert np.isnan(metrics[list(expected)]).all()
    # Neighbours choose between two methods: a hundredth of the tolerance.
    assert result.metrics.to_numpy() == pytest.approx(
        metrics, rel=1e-9, abs=1e-10, nan_ok=True
    )
    unflown = [i for i, one in enumerate(each) if one.steps[0] == 0]
    assert np.flatnonzero(result.steps == 0).tolist() == unflown


def test_runs(monkeypatch, alone):
    monkeypatch.setattr(engine, "_RUNS", CHUNK)
    runs = batch(CHUNK).runs
    rows = ORDERS["one to a chunk"]
    for got, values in zip(runs(np.array(rows)), rows, strict=True):
        [expected] = alone(runs, values)
        assert got.status is expected.status
        assert why(got.message) == why(expected.message)
        assert got.separation == expected.separation
        if got.status is RunStatus.FAILED:
            assert got.motion is None
            continue
        assert got.releases == pytest.approx(dict(expected.releases), abs=1e-9)
        assert got.stroke_ends == pytest.approx(dict(expected.stroke_ends), abs=1e-9)
        for quantity in ("time", "relative_velocity", "angular_momentum_change"):
            ours, theirs = (getattr(r.motion, quantity) for r in (got, expected))
            assert ours == pytest.approx(theirs, rel=1e-8, abs=1e-9)
        # A row's own values are in its run.
        assert parameters(got.separation)["upper.mass"] == values[0]
