"""How long the steps of the lanes are, and by which method.

Every lane has steps of its own: a first guess wherever something has changed what acts,
then what the error estimate admits, at most what its bodies may turn, and so that it
ends at the next known event, or just beyond the next that is foreseen. Nothing here
carries a derivative but the length that a known event leaves.
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
_DRIVEN = 0.45
"""Largest step while springs push by displacement, rad of their motion, at 1e-8: the
error estimate lets pass what is larger than it promises where forces follow motion."""
_TURN = 0.4
"""Largest rotation in a step, rad: its nodes resolve rates and angles to 1e-9."""
_SHORT = 0.03
"""Part of the wanted step below which DOPRI5 is as exact."""
_LEAST = 0.01
"""Part of the wanted step below which none is taken towards a foreseen event."""
_BEYOND = 1.1
"""How far a step goes of the way to an event that a parabola foresees."""
_SLIGHTLY_BEYOND = 1.0001
"""The same, where a step that went beyond it has told where it is."""
_CUT_SHARE = 0.1
"""Of the tolerance, for what is read off within a step where it is cut."""


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
        self._scale = (tolerance / 1e-8) ** (1.0 / DOP853.order_of_error)

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
        largest = jnp.minimum(largest_step(x), self._largest_push(params, mode))
        return jnp.minimum(jnp.where(fresh, guess, step), largest)

    def first_guess(self, x: Lanes, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (n,) a step that suits what acts now, s.

        Args:
            x: (13, m, n) states.
            params: of the batch.
            mode: what has happened.
        """
        frequency = _fastest(x)
        for by_time in (True, False):
            springs = self._springs_drive(params, mode, by_time)
            frequency = jnp.maximum(frequency, springs)
        if self._equations.holds:
            frequency = jnp.maximum(frequency, self._held_frequency(params, mode))
        return _still(_PHASE * self._scale / (frequency + 1e-3))

    def _largest_push(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (n,) the longest step while springs push by displacement, s."""
        frequency = self._springs_drive(params, mode, by_time=False)
        return _still(_DRIVEN * self._scale / (frequency + TINY))

    def _springs_drive(
        self, params: BatchParameters, mode: Mode, by_time: bool
    ) -> Lanes:
        """Return (n,) how fast the motion is that springs drive, rad/s."""
        mass = params.mass
        welded: dict[tuple[int, int], list[int]] = {}
        for i, attachment in enumerate(self._equations.separation.attachments):
            if attachment.joint.rigid and attachment.joint.type == "fixed":
                a, b = sorted(self._equations.ends[i])
                welded.setdefault((a, b), []).append(i)
        for (a, b), pads in welded.items():
            held = jnp.isinf(mode.released[np.array(pads)]).any(axis=0)
            for body, other in ((a, b), (b, a)):
                with_it = jnp.where(held, params.mass[other], 0.0)
                mass = mass.at[body].add(with_it)
        return self._springs.fastest(params, mass, mode, by_time=by_time)

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

    def cut_error(self, K: Lanes, method: Method, h: Lanes, fraction: Lanes) -> Lanes:
        """Return (n,) the error of a state within a step over its share.

        It is that of the continuous extension without its last term: of the order below
        its own, as estimates are.

        Args:
            K: (16, 13, m, n) derivatives at the step's stages.
            method: that took it.
            h: (n,) its length, s.
            fraction: (n,) of it, where the state is.
        """
        last = jnp.tensordot(method.powers[-1], _still(K), 1)
        size = jnp.sqrt((last * last).mean(axis=(0, 1)))
        theta = _still(fraction)
        part = theta**4 * (1.0 - theta) ** 3  # II.6.30
        return part * _still(h) * size / (_CUT_SHARE * self._tolerance)


def towards(foreseen: Lanes, left: Lanes, wanted: Lanes) -> Lanes:
    """Return (n,) a step towards a foreseen event, s; the time left if that is sooner.

    Args:
        foreseen: (n,) time until a little beyond it, s.
        left: (n,) time until the next known event, s.
        wanted: (n,) longest step, s.
    """
    # A shorter one would be cut where it is as exact, and might not get there.
    way = jnp.maximum(_still(foreseen), _LEAST * _still(wanted))
    way = jnp.minimum(way, _still(left))
    return way / pieces(way, wanted)


def beyond_foreseen(
    h: Lanes,
    ahead: Lanes,
    fraction: Lanes,
    accepted: Lanes,
    admitted: Lanes,
    before: Lanes,
) -> Lanes:
    """Return (n,) time until a little beyond the next event, s; infinite without one.

    Args:
        h: (n,) length of the step that was tried, s.
        ahead: (n,) after which part of it an event follows its end.
        fraction: (n,) the part of it until an event within.
        accepted: (n,) whether it was taken, until there.
        admitted: (n,) whether its error was small enough: if it was not taken, what is
            known of the event within is not exact enough to go on from there.
        before: (n,) the same before the step, s.
    """
    next_one = jnp.where(jnp.isfinite(ahead), _BEYOND * _still(h) * ahead, jnp.inf)
    within = _SLIGHTLY_BEYOND * _still(fraction * h)
    return jnp.where(accepted, next_one, jnp.where(admitted, within, before))


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
