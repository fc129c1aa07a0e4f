"""How a batch is held against Drake, and its derivatives against differences."""

import math

import numpy as np

from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.registry import METRICS
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Separation


RELATIVE, ABSOLUTE = 1e-8, 1e-9
"""Of each metric, in SI: what the engine promises."""
NONE = (math.inf,) * 3


def random_rows(case, count: int, seed: int = 0) -> np.ndarray:
    """Values in the physical part of a case's box, many of them at its edges."""
    tolerances, rng = case.tolerance_set, np.random.default_rng(seed)
    u = rng.uniform(-1.3, 1.3, size=(count, len(tolerances)))
    return tolerances.rows(tolerances.draw_back(u))


def around(separation: Separation, names, spread: float, count: int) -> np.ndarray:
    nominal = np.array([parameters(separation)[name] for name in names])
    rng = np.random.default_rng(0)
    return nominal * (1.0 + spread * rng.uniform(-1, 1, size=(count, len(names))))


def drake_figures(
    separation, names, rows, limits, accuracy=1e-10, workers=None
) -> np.ndarray:
    integration = Integration(accuracy=accuracy)
    with DrakePool(separation, integration, workers=workers) as pool:
        runs = pool.fly([dict(zip(names, row, strict=True)) for row in rows.tolist()])
    return np.array([list(metrics_of_run(run, limits).values()) for run in runs])


def assert_close(got, expected, relative=RELATIVE, absolute=ABSOLUTE):
    allowed = np.maximum(absolute, relative * np.abs(expected))
    excess = np.abs(got - expected) / allowed
    column = np.unravel_index(excess.argmax(), excess.shape)[-1]
    assert excess.max() <= 1.0, (METRICS[column], excess.max())


def central_differences(batch: Batch, row: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Fourth-order differences of the metrics, (n_m, n_p)."""
    offsets = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
    probes = [
        row + k * step * unit
        for step, unit in zip(steps, np.eye(len(row)), strict=True)
        for k in offsets
    ]
    result = batch.run(np.array(probes))
    assert not result.failures
    metrics = result.metrics.to_numpy().reshape(len(row), 4, len(METRICS))
    slopes = np.tensordot(np.array(list(offsets.values())), metrics, ((0,), (1,)))
    return slopes.T / steps


def assert_slopes(jacobian, differences, steps):
    """To 1e-6 of the largest change of a metric over the steps, beside their noise."""
    got, expected = jacobian * steps, differences * steps
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(got - expected) <= 1e-6 * scale + 1e-11).all()


def compiled_once(patch, *modules: str):
    """Let batches of a separation and its names be made once for all that ask.

    Args:
        patch: of pytest, by which it ends.
        modules: that make batches.
    """
    known = {}

    def batch(separation, names, **how):
        key = separation, tuple(names), repr({**how, "workers": None})
        if key not in known:
            known[key] = Batch(separation, names, **how)
        return known[key]

    for module in modules:
        patch.setattr(f"{module}.Batch", batch)
