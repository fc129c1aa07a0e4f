"""The motion of a batch at given times, and the runs made of it."""

from collections.abc import Mapping
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import lax
from numpy.typing import NDArray

from drakesep.systems.arrays import Array
from drakesep.systems.batch import lobatto
from drakesep.systems.batch.equations import STATES, BatchEquations
from drakesep.systems.batch.integrator import Step
from drakesep.systems.batch.lanes import BatchParameters, Lanes, pick
from drakesep.systems.batch.polynomials import polynomial
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.relative_motion import RelativeMotion
from drakesep.systems.model.run import Trajectory
from drakesep.systems.model.separation import Separation


COLUMNS = (
    *RelativeMotion._fields,
    "acceleration",
    "linear_momentum_change",
    "angular_momentum_change",
)
"""Of `drakesep.systems.model.run.Motion`, three signals each."""


class Samples(NamedTuple):
    """What has been sampled so far."""

    signals: Lanes
    """(T, 13 m + 9, n): states of all bodies, acceleration of B's CG, momentum given
    to B."""
    momentum: Lanes
    """(6, n) given to B by the springs by the end of the last step, N s and N m s."""


class MotionFold:
    """Samples the motion of every row at its own times."""

    def __init__(self, equations: BatchEquations, times: Lanes):
        """Prepare.

        Args:
            equations: of the separation.
            times: (T, n), s; those beyond the run are not sampled.
        """
        self._equations = equations
        self._times = times
        # Of the bodies, of which the rest is made: angles jump between samples.
        self._states = STATES * len(equations.separation.bodies)

    def start(self, params: BatchParameters) -> Samples:
        """Return what there is before the first step."""
        count, n = self._times.shape
        return Samples(
            jnp.full((count, self._states + 9, n), jnp.nan), jnp.zeros((6, n))
        )

    def add(self, samples: Samples, params: BatchParameters, step: Step) -> Samples:
        """Return the samples after a step: those at a kink are those after it."""
        acceleration, momentum_rate = self._at_nodes(params, step)
        gained = 0.5 * step.length * jnp.tensordot(lobatto.INTEGRALS, momentum_rate, 1)
        momentum = samples.momentum + gained
        # (13, 8, m, n) to (8, 13 m, n)
        states = jnp.transpose(step.x, (1, 2, 0, 3))
        states = states.reshape(len(states), self._states, -1)
        values = jnp.concatenate([states, acceleration, momentum], axis=1)
        length = jnp.where(step.length > 0.0, step.length, 1.0)
        xi = 2.0 * (self._times - step.start) / length - 1.0
        # Round-off of the step's end is within it.
        inside = (step.length > 0.0) & (xi >= -1.0) & (xi <= 1.0 + 1e-9)
        c = jnp.tensordot(lobatto.COEFFICIENTS, values, 1)
        at_times = polynomial(c[:, None], xi[:, None])
        signals = jnp.where(inside[:, None], at_times, samples.signals)
        return Samples(signals, momentum[-1])

    def _at_nodes(self, params: BatchParameters, step: Step) -> tuple[Lanes, Lanes]:
        """Return (8, 3, n) acceleration and (8, 6, n) rates of momentum, at nodes."""
        equations = self._equations
        _, b = equations.pair
        bodies = step.bodies
        B = pick(bodies, b)
        p_BoBcm_B, _ = equations.mated_place(params)
        times = step.start + lobatto.THETA[:, None] * step.length
        timed = equations.at_times(times, params, step.mode)
        slopes = lax.map(
            lambda node: equations.derivative(
                equations.holds, node[0], node[1], params, step.mode
            ),
            (timed, jnp.moveaxis(step.x, 1, 0)),
        )[:, :, b]
        alpha, a_Bo = (tuple(slopes[:, k + i] for i in range(3)) for k in (7, 10))
        acceleration = motion_laws.cg_acceleration(B, p_BoBcm_B, alpha, a_Bo)
        wrench = equations.spring_wrench_on(b, timed, bodies, params, step.mode)
        rates = motion_laws.momentum_rate(B, p_BoBcm_B, wrench)
        return _stack([acceleration]), _stack(rates)

    def finish(self, samples: Samples, params: BatchParameters) -> Lanes:
        """Return (T, 24 + 13 m, n) the signals of `COLUMNS`, and the states."""
        states: Lanes = jnp.moveaxis(samples.signals, 1, 0)
        A, B = (
            motion_laws.body_state(states, STATES * body, STATES * body + 7)
            for body in self._equations.pair
        )
        place = self._equations.mated_place(params)
        motion = motion_laws.relative_motion(A, B, *place, jnp)
        return jnp.concatenate(
            [
                _stack([*motion]),
                samples.signals[:, self._states :],
                samples.signals[:, : self._states],
            ],
            axis=1,
        )


def _stack(vectors: list[tuple[Lanes, ...]] | tuple[tuple[Lanes, ...], ...]) -> Lanes:
    return jnp.stack([x for vector in vectors for x in vector], axis=1)


def columns_of(signals: NDArray[np.float64]) -> Mapping[str, NDArray[np.float64]]:
    """Return the columns (T, 3) of a row's motion from its signals (T, ...)."""
    return {name: signals[:, 3 * i : 3 * i + 3] for i, name in enumerate(COLUMNS)}


def trajectory_of(separation: Separation, times: Array, signals: Array) -> Trajectory:
    """Return the motion of all bodies of a row from its signals (T, 24 + 13 m)."""
    return Trajectory(
        names=tuple(body.name for body in separation.bodies),
        time=times,
        states=signals[:, 3 * len(COLUMNS) :].reshape(len(times), -1, STATES),
    )
