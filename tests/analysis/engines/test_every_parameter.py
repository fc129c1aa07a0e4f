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
from drakesep.analysis.metrics.registry import METRICS
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
WITHOUT_EFFECT: dict[str, str] = {}
"""Parameters that move no metric of their case, and why."""


CASES = {"staged": staged_pair(), "hinged": hinged_pair()}


@functools.cache
def moved(case: str) -> tuple[tuple[str, ...], np.ndarray, np.ndarray, np.ndarray]:
    """Names, nominal metrics, and what each parameter changes in Drake and batch."""
    separation = CASES[case]
    nominal, declared = parameters(separation), declarations(separation)
    names = tuple(nominal)
    rows = np.array(list(nominal.values())) + np.vstack(
        [np.zeros(len(names)), np.diag([STEP[declared[name].kind] for name in names])]
    )
    simulation = Simulation(separation, Integration(accuracy=3e-8))
    drake = [
        list(metrics_of_run(simulation.run(values), LIMITS).values())
        for values in [
            {},
            *({name: rows[i, i - 1]} for i, name in enumerate(names, 1)),
        ]
    ]
    result = Batch(separation, names, tolerance=1e-8).run(rows)
    assert not result.failures
    batch = result.metrics.to_numpy()
    changes = [np.array(m)[1:] - np.array(m)[0] for m in (drake, batch)]
    return names, batch[0], *changes


@pytest.mark.parametrize(
    ("case", "name"), [(c, name) for c, s in CASES.items() for name in parameters(s)]
)
def test_moves_some_metric_alike_in_both_engines(case, name):
    names, nominal, in_drake, in_batch = moved(case)
    i = names.index(name)
    # What both engines together are wrong by, in SI, of motions of 0.1 rad and 1 m/s:
    # 1e-7 at most, from Drake's steps at this accuracy.
    error = 3e-7 * np.maximum(1.0, np.abs(nominal))
    most = np.argmax(np.abs(in_batch[i]) / error)
    felt = np.abs(in_batch[i, most]) > 20.0 * error[most]
    assert felt == (name not in WITHOUT_EFFECT), (METRICS[most], in_batch[i, most])
    assert (np.abs(in_drake[i] - in_batch[i]) < error).all()


def test_reasons_are_of_parameters_that_exist():
    known = {name for case in CASES.values() for name in parameters(case)}
    assert not set(WITHOUT_EFFECT) - known
