"""How long the steps of the lanes are, and by which method.

Every lane has steps of its own: a first guess wherever something has changed what acts,
then what the error estimate admits, at most what its bodies may turn, and so that it
ends at the next known event. Nothing here carries a derivative but the length that this
event leaves.
"""

import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode, pick
from drakesep.systems.batch.tableaus import DOP853, Method
from drakesep.systems.vectors import TINY


_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 6.0
_PHASE = 0.8
"""First guess of a step, rad of the fastest motion, at a tolerance of 1e-8."""
_TURN = 0.4
"""Largest rotation in a step, rad: its nodes resolve rates and angles to 1e-9."""
_SHORT = 0.02
"""Part of the wanted step below which DOPRI5 is as exact."""


class StepControl:
    """The first guess, the largest step and the error of a step, of one separation."""

    def __init__(self, equations: BatchEquations, tolerance: float):
        """Prepare.

        Args:
            equations: of the separation.
            tolerance: of the error estimates of all steps of a run together, in SI.
        """
        self._equations = equations
        self._springs = equations.springs
        self._tolerance = tolerance
        self._share = tolerance / equations.separation.duration

    def wanted(
        self,
        step: Lanes,
        fresh: Lanes,
        x: Lanes,
        params: BatchParameters,
        mode: Mode,
    ) -> Lanes:
        """Return (n,) how long the next step would be, were there no known event, s.

        Args:
            step: (n,) what the error of the step before admits, s.
            fresh: (n,) whether what acts has changed since then: it is guessed anew.
            x: (13, m, n) states.
            params: of the batch.
            mode: what has happened.
        """
        guess = self.first_guess(x, params, mode)
        return jnp.minimum(jnp.where(fresh, guess, step), largest_step(x))

    def first_guess(self, x: Lanes, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (n,) a step that suits what acts now, s.

        Args:
            x: (13, m, n) states.
            params: of the batch.
            mode: what has happened.
        """
        frequency = _fastest(x)
        pushing = self._springs.pushing(mode)
        for k in range(self._springs.count):
            spring = self._springs.frequency(k, params)
            frequency = jnp.maximum(frequency, jnp.where(pushing[k], spring, 0.0))
        if self._equations.holds:
            frequency = jnp.maximum(frequency, self._held_frequency(params, mode))
        scale = (self._tolerance / 1e-8) ** (1.0 / DOP853.order_of_error)
        return _still(_PHASE * scale / (frequency + 1e-3))

    def _held_frequency(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (n,) the fastest motion of bodies in the joints that hold, rad/s."""
        inverse_mass = 1.0 / params.mass
        inverse_inertia = 1.0 / jnp.stack(tuple(params.I_BBcm_B)[:3]).min(axis=0)
        K, D = jnp.zeros_like(inverse_mass[0]), jnp.zeros_like(inverse_mass[0])
        for i, attachment in enumerate(self._equations.separation.attachments):
            gains = np.reshape(attachment.joint.held_gains(), (4, 3)).max(axis=1)
            a, b = self._equations.ends[i]
            turning = inverse_inertia[a] + inverse_inertia[b]
            moving = (
                inverse_mass[a]
                + inverse_mass[b]
                + _squared_arm(params, a, params.p_AoPad_A, i) * inverse_inertia[a]
                + _squared_arm(params, b, params.p_BoPad_B, i) * inverse_inertia[b]
            )
            held = jnp.isinf(mode.released[i])
            K = K + jnp.where(held, gains[0] * moving + gains[2] * turning, 0.0)
            D = D + jnp.where(held, gains[1] * moving + gains[3] * turning, 0.0)
        return jnp.maximum(jnp.sqrt(K + TINY), D)

    def error(self, K: Lanes, method: Method) -> Lanes:
        """Return (n,) the error estimate of a step over its share of the tolerance.

        Args:
            K: (16, 13, m, n) derivatives at its stages.
            method: that took it.
        """
        errors = jnp.tensordot(method.errors, _still(K), 1) / self._share
        square, tempering = (errors**2).sum(axis=(1, 2))
        states = K.shape[1] * K.shape[2]
        # II.10.17; for a method without a tempering error, the norm of its own.
        return square / jnp.sqrt((square + 0.01 * tempering) * states + TINY)


def largest_step(x: Lanes) -> Lanes:
    """Return (n,) the longest step in which no body turns too far, s.

    Args:
        x: (13, m, n) states.
    """
    return _TURN / (_fastest(x) + TINY)


def pieces(left: Lanes, wanted: Lanes) -> Lanes:
    """Return (n,) in how many equal steps the time left is taken.

    Args:
        left: (n,) time until the next known event, s.
        wanted: (n,) longest step, s.
    """
    # Round-off does not add a step.
    return jnp.maximum(jnp.ceil(_still(left / wanted) - 1e-9), 1.0)


def is_short(h: Lanes, wanted: Lanes, flying: Lanes) -> Lanes:
    """Return whether events force steps on all lanes far shorter than they want.

    Args:
        h: (n,) steps, s.
        wanted: (n,) as the error would have them, s.
        flying: (n,) which lanes count.
    """
    return jnp.where(flying, h < _SHORT * wanted, True).all()


def next_step(
    h: Lanes, error: Lanes, order_of_error: Lanes, wanted: Lanes, accepted: Lanes
) -> Lanes:
    """Return (n,) the step that the error of the last one admits, s.

    Args:
        h: (n,) the last step, s.
        error: (n,) its error estimate over its share of the tolerance.
        order_of_error: power of the step with which that falls.
        wanted: (n,) how long it would have been without a known event, s: one that this
            event made short does not make the next short.
        accepted: (n,) whether it was taken.
    """
    factor = jnp.clip(
        _SAFETY * (error + TINY) ** (-1.0 / order_of_error), _SHRINK, _GROW
    )
    factor = jnp.where(jnp.isfinite(error), factor, _SHRINK)
    admitted = _still(h * factor)
    return jnp.where(accepted, jnp.maximum(admitted, wanted), admitted)


def _still(x: Lanes) -> Lanes:
    """Return x without its derivative: what only decides how to go on."""
    return lax.stop_gradient(x)


def _fastest(x: Lanes) -> Lanes:
    """Return (n,) the largest angular velocity of the bodies, rad/s."""
    w = _still(x[7:10])
    return jnp.sqrt((w * w).sum(axis=0)).max(axis=0)


def _squared_arm(
    params: BatchParameters, body: int, pads: tuple[Lanes, ...], i: int
) -> Lanes:
    """Return (n,) the square of the distance of a pad from its body's CG, m^2."""
    cg = pick(params.p_BoBcm_B, body)
    return sum((pad - c) * (pad - c) for pad, c in zip(pick(pads, i), cg, strict=True))
