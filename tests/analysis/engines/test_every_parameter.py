"""Every parameter of a separation acts, and alike in both engines.

Small cases in which each one can be felt: joints that hold for a while, tilted springs
with a damper, loads, an orbit, a hinge that lets go at its angle.
"""

import functools
import math

import numpy as np
import pytest
from separations import hinged_pair, staged_pair

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import declarations, parameters
from drakesep.systems.simulation.simulation import Simulation


LIMITS = (math.inf,) * 3
STEP = {
    "mass": 5.0,
    "length": 2e-3,
    "angle": 5e-3,
    "angular_rate": 5e-3,
    "inertia": 2.0,
    "force": 10.0,
    "damping": 10.0,
    "time": 2e-3,
    "factor": 0.1,
}
"""By which a parameter is moved, in SI: far from what either engine is wrong by."""


CASES = {"staged": staged_pair(), "hinged": hinged_pair()}


def moved(case: str, chosen: np.ndarray) -> np.ndarray:
    """Return a row of values for each row of choices: those of which are moved."""
    separation = CASES[case]
    nominal, declared = parameters(separation), declarations(separation)
    steps = np.array([STEP[declared[name].kind] for name in nominal])
    return np.array(list(nominal.values())) + chosen * steps


@functools.cache
def batch(case: str) -> Batch:
    return Batch(CASES[case], tuple(parameters(CASES[case])), tolerance=1e-8)


def flown(case: str, rows: np.ndarray) -> np.ndarray:
    """Return the metrics of the rows on the batch engine."""
    result = batch(case).run(rows)
    assert not result.failures
    return result.metrics.to_numpy()


def errors(metrics: np.ndarray) -> np.ndarray:
    """Return what both engines together are wrong by at most, in SI.

    1e-7 at most of motions of 0.1 rad and 1 m/s, from Drake's steps at this accuracy.
    """
    return 3e-7 * np.maximum(1.0, np.abs(metrics))


@pytest.mark.parametrize("case", CASES)
def test_each_moves_some_metric(case):
    names = tuple(parameters(CASES[case]))
    chosen = np.vstack([np.zeros(len(names)), np.eye(len(names))])
    nominal, *each = flown(case, moved(case, chosen))
    felt = (np.abs(each - nominal) > 20.0 * errors(nominal)).any(axis=1)
    assert [n for n, is_felt in zip(names, felt, strict=True) if not is_felt] == []


@pytest.mark.parametrize("case", CASES)
def test_all_act_alike_in_both_engines(case):
    """Row b moves those whose number has bit b: what differs spells which one it is.

    Each is moved in some row, by far more than both engines are wrong by.
    """
    numbers = np.arange(1, len(parameters(CASES[case])) + 1)
    bits = np.arange(numbers[-1].item().bit_length())
    rows = moved(case, (numbers >> bits[:, None]) & 1)
    simulation = Simulation(CASES[case], Integration(accuracy=3e-8))
    names = tuple(parameters(CASES[case]))
    drake = np.array(
        [
            list(metrics_of_run(simulation.run(values), LIMITS).values())
            for values in (dict(zip(names, row, strict=True)) for row in rows)
        ]
    )
    of_batch = flown(case, rows)
    differs = (np.abs(drake - of_batch) > errors(of_batch)).any(axis=1)
    number = int(differs @ (1 << bits))
    assert not number, f"{names[number - 1 : number]} or several that differ together"
