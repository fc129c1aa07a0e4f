"""The motion of a batch at given times, and the runs made of it."""

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
from drakesep.systems.model.run import Motion, Trajectory
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


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
    """(T, 13 m + 9 p, n): states of all bodies, accelerations of the CGs of those that
    leave, in the order of their p pairs, and momenta given to them."""
    momentum: Lanes
    """(6 p, n) given to them by the springs by the end of the last step, N s and
    N m s."""


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
        self._pairs = equations.separation.pairs

    def start(self, params: BatchParameters) -> Samples:
        """Return what there is before the first step."""
        count, n = self._times.shape
        p = len(self._pairs)
        return Samples(
            jnp.full((count, self._states + 9 * p, n), jnp.nan), jnp.zeros((6 * p, n))
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
        """Return (8, 3 p, n) accelerations, (8, 6 p, n) rates of momenta, at nodes."""
        equations, bodies = self._equations, step.bodies
        times = step.start + lobatto.THETA[:, None] * step.length
        timed = equations.at_times(times, params, step.mode)
        slopes = lax.map(
            lambda node: equations.derivative(
                len(equations.phases) - 1, node[0], node[1], params, step.mode
            ),
            (timed, jnp.moveaxis(step.x, 1, 0)),
        )
        accelerations: list[Vector] = []
        rates: list[Vector] = []
        for pair in self._pairs:
            _, b = equations.bodies_of(pair)
            B = pick(bodies, b)
            p_BoBcm_B, _ = equations.mated_place(pair, params)
            alpha, a_Bo = (
                tuple(slopes[:, k + i, b] for i in range(3)) for k in (7, 10)
            )
            accelerations.append(motion_laws.cg_acceleration(B, p_BoBcm_B, alpha, a_Bo))
            wrench = equations.spring_wrench_on(b, timed, bodies, params, step.mode)
            rates += motion_laws.momentum_rate(B, p_BoBcm_B, wrench)
        return _stack(accelerations), _stack(rates)

    def finish(self, samples: Samples, params: BatchParameters) -> Lanes:
        """Return (T, 24 p + 13 m, n) `COLUMNS` of each pair, and the states."""
        states: Lanes = jnp.moveaxis(samples.signals, 1, 0)[: self._states]
        # (13, T, m, n)
        states = jnp.moveaxis(states.reshape(-1, STATES, *states.shape[1:]), 0, 2)
        bodies = motion_laws.body_state(states, 0, 7)
        accelerations, momenta = jnp.split(
            samples.signals[:, self._states :], [3 * len(self._pairs)], axis=1
        )
        signals = []
        for k, pair in enumerate(self._pairs):
            motion = self._equations.relative_motion(pair, bodies, params)
            signals += [
                _stack([*motion]),
                accelerations[:, 3 * k : 3 * k + 3],
                momenta[:, 6 * k : 6 * k + 6],
            ]
        return jnp.concatenate([*signals, samples.signals[:, : self._states]], axis=1)


def _stack(vectors: list[tuple[Lanes, ...]] | tuple[tuple[Lanes, ...], ...]) -> Lanes:
    return jnp.stack([x for vector in vectors for x in vector], axis=1)


def motions_of(
    separation: Separation, times: Array, signals: NDArray[np.float64]
) -> dict[str, Motion]:
    """Return the motions of the bodies that leave, from a row's signals (T, ...)."""
    motions = {}
    for k, pair in enumerate(separation.pairs):
        mine = signals[:, 3 * len(COLUMNS) * k :]
        columns = {c: mine[:, 3 * i : 3 * i + 3] for i, c in enumerate(COLUMNS)}
        motions[pair.B] = Motion(time=times, **columns)
    return motions


def trajectory_of(separation: Separation, times: Array, signals: Array) -> Trajectory:
    """Return the motion of all bodies of a row from its signals (T, 24 p + 13 m)."""
    states = signals[:, 3 * len(COLUMNS) * len(separation.pairs) :]
    return Trajectory(
        names=tuple(body.name for body in separation.bodies),
        time=times,
        states=states.reshape(len(times), -1, STATES),
    )
