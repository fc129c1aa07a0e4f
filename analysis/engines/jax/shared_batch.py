"""Batches that calls share which fly the same: their programs are made once.

In a process that studies a case again and again each would take seconds to be traced
and loaded. No result depends on what a batch has flown before.
"""

import functools
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metric_named
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.systems.equations.springs import PUSHERS
from drakesep.systems.model.separation import Separation


_MOST = 4
"""That are kept; of those that are not, the longest unused goes."""


def shared_batch(
    separation: Separation,
    names: Iterable[str],
    limits: Mapping[str, tuple[float, ...]],
    *,
    metrics: Iterable[str],
    without: Collection[str],
) -> Batch:
    """Return what flies a separation, made unless one has been that flies the same.

    Args:
        separation: to be flown and varied.
        names: (n_p,) parameters that vary.
        limits: (3,) limits of roll, pitch and yaw, rad, of each pair by its body B.
        metrics: names of those to tell beside those that are registered.
        without: stems of registered ones that are not to be told.

    Raises:
        ValueError: as `Batch` does.
    """
    registered = registered_metrics()
    usual = {m for m in registered if m.stem not in without}
    # One name of each metric that is told beside these: which axis does not matter.
    more = {metric_named(name): name for name in metrics}
    others = tuple(name for metric, name in more.items() if metric not in usual)
    asked = tuple(names), tuple(limits.items()), others, frozenset(without)
    return _made(separation, *asked, (registered, tuple(PUSHERS.items())))


@functools.lru_cache(maxsize=_MOST)
def _made(
    separation: Separation,
    names: tuple[str, ...],
    limits: tuple[tuple[str, tuple[float, ...]], ...],
    metrics: tuple[str, ...],
    without: frozenset[str],
    registered: tuple[Any, ...],
) -> Batch:
    """Return a batch; what is registered is not read, but tells it from others."""
    return Batch(
        separation,
        names,
        deviation_limits=dict(limits),
        metrics=metrics,
        without=without,
    )
