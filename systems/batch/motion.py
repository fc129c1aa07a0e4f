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
from drakesep.systems.equations.motion_of_run import relative_motion_of
from drakesep.systems.model.run import Motion, Trajectory
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


_WINDOW = 32
"""Times that are looked at together."""


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
        return Samples(_put(samples.signals, c, xi, inside), momentum[-1])

    def _at_nodes(self, params: BatchParameters, step: Step) -> tuple[Lanes, Lanes]:
        """Return (8, 3 p, n) accelerations, (8, 6 p, n) rates of momenta, at nodes."""
        equations, bodies = self._equations, step.bodies
        times = step.start + lobatto.THETA[:, None] * step.length
        timed = equations.at_times(times, params, step.mode)
        # Of the motion as it is between nodes: the equations again would cost as much
        # to compile as all else.
        half = jnp.where(step.length > 0.0, 0.5 * step.length, jnp.inf)
        slopes = jnp.einsum("ij,kjmn->kimn", lobatto.SLOPES, step.x) / half
        springs = equations.spring_wrenches(timed, bodies, params, step.mode)
        accelerations: list[Vector] = []
        rates: list[Vector] = []
        for pair in self._pairs:
            _, b = equations.bodies_of(pair)
            B = pick(bodies, b)
            p_BoBcm_B, _ = equations.mated_place(pair, params)
            alpha, a_Bo = _vector(slopes[7:10, :, b]), _vector(slopes[10:, :, b])
            accelerations.append(motion_laws.cg_acceleration(B, p_BoBcm_B, alpha, a_Bo))
            rates += motion_laws.momentum_rate(B, p_BoBcm_B, pick(springs, b))
        return _stack(accelerations), _stack(rates)


def _put(signals: Lanes, c: Lanes, xi: Lanes, inside: Lanes) -> Lanes:
    """Return signals (T, s, n) with those of a step where it has some.

    Of the few times that a step has, a window after the other is looked at: all of them
    at every step would take several times as long as the flight.

    Args:
        signals: as far as they are known.
        c: (8, s, n) coefficients of the step's.
        xi: (T, n) where times are in it.
        inside: (T, n) whether they are.
    """
    count, some = len(xi), inside.any(axis=1)
    width = min(_WINDOW, count)
    end = jnp.where(some.any(), count - jnp.argmax(some[::-1]), 0)

    def put(on: tuple[Lanes, Lanes]) -> tuple[Lanes, Lanes]:
        first, signals = on
        mine, within, before = (
            lax.dynamic_slice_in_dim(x, first, width) for x in (xi, inside, signals)
        )
        told = jnp.where(within[:, None], polynomial(c[:, None], mine[:, None]), before)
        put = lax.dynamic_update_slice_in_dim(signals, told, first, 0)
        return first + width, put

    _, told = lax.while_loop(lambda on: on[0] < end, put, (jnp.argmax(some), signals))
    return told


def _vector(x: Lanes) -> Vector:
    return x[0], x[1], x[2]


def _stack(vectors: list[tuple[Lanes, ...]]) -> Lanes:
    return jnp.stack([x for vector in vectors for x in vector], axis=1)


def sampled(
    separation: Separation, times: Array, signals: NDArray[np.float64]
) -> tuple[Trajectory, dict[str, Motion]]:
    """Return the motion of all bodies of a row, and of those that leave by name.

    Args:
        separation: as it was flown.
        times: (T,) of the samples, s.
        signals: (T, 13 m + 9 p) of the row, see `Samples`.
    """
    m, p = len(separation.bodies), len(separation.pairs)
    states, acceleration, momenta = np.split(
        signals, [STATES * m, STATES * m + 3 * p], axis=1
    )
    trajectory = Trajectory(
        names=tuple(body.name for body in separation.bodies),
        time=times,
        states=states.reshape(len(times), m, STATES),
    )
    motions = {}
    for k, pair in enumerate(separation.pairs):
        linear, angular = np.split(momenta[:, 6 * k : 6 * k + 6], 2, axis=1)
        motions[pair.B] = Motion(
            time=times,
            **relative_motion_of(separation, pair, trajectory),
            acceleration=acceleration[:, 3 * k : 3 * k + 3],
            linear_momentum_change=linear,
            angular_momentum_change=angular,
        )
    return trajectory, motions
