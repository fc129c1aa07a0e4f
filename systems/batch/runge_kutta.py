"""A Runge-Kutta step of every lane: its stages, and the states between its ends."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.batch import lobatto
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode
from drakesep.systems.batch.tableaus import DOP853, DOPRI5, Method


class Weights(NamedTuple):
    """What makes a step of the stages' derivatives: arrays, or their traces."""

    method: Method
    at_nodes: Lanes
    """(8, 16) weights of the stages for the states at the nodes of `lobatto`."""

    @classmethod
    def of(cls, method: Method) -> "Weights":
        """Return the weights of a method."""
        # At the ends exactly: nothing, and the step's own.
        inner = method.weights_at(lobatto.THETA[1:-1])
        return cls(method, np.vstack([0.0 * method.B, inner, method.B]))


LONG, SHORT = Weights.of(DOP853), Weights.of(DOPRI5)
"""The methods for long steps, and for far shorter ones."""


def weights_for(short: Lanes) -> Weights:
    """Return the weights of the method for short steps, or for long ones.

    Args:
        short: a single boolean: all lanes take their stages together.
    """
    chosen: Weights = jax.tree.map(
        lambda long, brief: jnp.where(short, brief, long), LONG, SHORT
    )
    return chosen


def stages(
    equations: BatchEquations,
    method: Method,
    t: Lanes,
    h: Lanes,
    x: Lanes,
    params: BatchParameters,
    mode: Mode,
) -> Lanes:
    """Return (16, 13, m, n) the derivatives at the stages of a step.

    Args:
        equations: of the separation.
        method: that takes the step.
        t: (n,) where it starts, s.
        h: (n,) its length, s.
        x: (13, m, n) states at its start.
        params: of the batch.
        mode: what has happened by its start.
    """
    times = t + method.C[:, None] * h
    timed = equations.at_times(times, params, mode)

    def run(phase: int) -> Callable[[None], Lanes]:
        def stage(i: int, K: Lanes) -> Lanes:
            y = x + h * jnp.tensordot(method.A[i], K, 1)
            now = jax.tree.map(lambda lanes: lanes[i], timed)
            k = equations.derivative(phase, now, y, params, mode)
            return K.at[i].set(k)

        K = jnp.zeros((len(method.A), *x.shape))
        return lambda _: lax.fori_loop(0, method.stages, stage, K)

    programs = [run(phase) for phase in range(len(equations.phases))]
    if len(programs) == 1:
        return programs[0](None)
    return lax.switch(equations.phase(mode), programs, None)


def at_nodes(x: Lanes, change: Lanes, moved: Lanes, accepted: Lanes) -> Lanes:
    """Return (13, 8, m, n) the states at the nodes of a step.

    Args:
        x: (13, m, n) states at its start.
        change: (8, 13, m, n) of the states by the nodes, over the step's length.
        moved: (n,) that length, s.
        accepted: (n,) whether the step is taken: elsewhere nothing changes, whatever
            its stages are.
    """
    nodes = x + jnp.where(accepted, moved * change, 0.0)
    return jnp.moveaxis(nodes, 0, 1)


def change_until(weights: Weights, K: Lanes, fraction: Lanes) -> Lanes:
    """Return (8, 13, m, n) the change of the states by the nodes of a step cut short.

    Args:
        weights: of the method that took the step.
        K: (16, 13, m, n) derivatives at its stages.
        fraction: (n,) of it that is left.

    Returns:
        Changes over the length of the whole step.
    """
    powers = jnp.tensordot(weights.method.powers, K, 1)
    theta = lobatto.THETA[:, None] * fraction
    total = jnp.zeros((lobatto.COUNT, *K.shape[1:]))
    for coefficient in powers[::-1]:
        total = total * theta[:, None, None, :] + coefficient
    return total
