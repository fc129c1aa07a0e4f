"""The bodies' motion from step to step, as polynomials.

Positions are of fifth degree within each step, as its ends have them with velocities
and accelerations (Hermite): their error is of sixth order. Velocities and accelerations
are their derivatives. So what is told between steps costs no evaluation, and is as good
as a scheme of fifth order.
"""

import numpy as np
from scipy.interpolate import PPoly

from drakesep.systems.arrays import Array
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.vectors import conjugate, multiply


_SHORT = 1e-4
"""Of a step, s, over which rates and accelerations at its ends say more of its way than
its positions, which round-off takes from each other."""


class StepPolynomials:
    """The motion over steps, none of which has a kink within."""

    def __init__(self, layout: StateLayout, times: Array, states: Array, slopes: Array):
        """Fit.

        Args:
            layout: where states hold the motion of each body.
            times: (n,) of the steps' ends, s; a kink stands there twice.
            states: (s, n) of the plant.
            slopes: (s, n) their derivatives; at a kink, before it and after it.
        """
        self._size = layout.size
        starts = np.array(layout.starts)
        self._q = starts[:, :1] + np.arange(7)
        self._v = starts[:, 1:] + np.arange(6)
        # From (m, k, n), of n steps' ends, to the polynomials' (n, m, k).
        q, v = states[self._q], states[self._v]
        q_dot, v_dot = slopes[self._q], slopes[self._v]
        bend = _times(v_dot[:, :3], q[:, :4]) + _times(v[:, :3], q_dot[:, :4])
        # q_dot = (0, w) q / 2
        q_ddot = np.concatenate([0.5 * bend, v_dot[:, 3:]], axis=1)
        ways = (np.moveaxis(x, -1, 0) for x in (q, q_dot, q_ddot))
        self._positions = quintics(times, *ways)

    def states(self, times: Array) -> Array:
        """Return (s, n) states of the plant at n times; at a kink, after it."""
        q, q_dot = self._positions_at(times, 0), self._positions_at(times, 1)
        x = np.empty((self._size, len(times)))
        x[self._q] = q
        x[self._v] = _velocities(q, q_dot)
        return x

    def accelerations(self, times: Array) -> Array:
        """Return (m, 6, n) of each body at n times; at a kink, after it.

        Angular, rad/s^2, and of its origin, m/s^2, in W.
        """
        return _velocities(self._positions_at(times, 0), self._positions_at(times, 2))

    def _positions_at(self, times: Array, derivative: int) -> Array:
        return np.moveaxis(self._positions(times, derivative), 0, -1)


def _times(w: Array, q: Array) -> Array:
    """Return (0, w) q, of (m, 3, n) and (m, 4, n)."""
    x, y, z = w.swapaxes(0, 1)
    turned = multiply((0.0, x, y, z), tuple(q.swapaxes(0, 1)))
    return np.array(turned).swapaxes(0, 1)


def _velocities(q: Array, derivative: Array) -> Array:
    """Return (m, 6, n) velocities, or accelerations, of such derivatives of q.

    2 q_dot = (0, w) q; and 2 q_ddot = (0, alpha) q + (0, w) (0, w) q / 2, of which the
    last is along q.
    """
    quaternion, rate = q[:, :4].swapaxes(0, 1), derivative[:, :4].swapaxes(0, 1)
    back = conjugate(tuple(quaternion * (2.0 / (quaternion**2).sum(axis=0))))
    turning = np.array(multiply(tuple(rate), back)[1:])
    return np.concatenate([turning.swapaxes(0, 1), derivative[:, 4:]], axis=1)


def quintics(times: Array, q: Array, v: Array, a: Array) -> PPoly:
    """Return polynomials of fifth degree between points.

    Args:
        times: (n,) of the points, s; where one stands twice, v and a may jump.
        q: (n, ...) values there.
        v: (n, ...) first derivatives.
        a: (n, ...) second derivatives.
    """
    [first] = np.nonzero(np.diff(times) > 0.0)
    h = (times[first + 1] - times[first]).reshape(-1, *[1] * (q.ndim - 1))
    (q0, v0, a0), (q1, v1, a1) = (
        (q[at], v[at], h * a[at]) for at in (first, first + 1)
    )
    dv = v1 - v0
    # The rate is the cubic of its ends, and a bump that makes it lead from q0 to q1.
    missing = (q1 - q0) / h - v0 - 0.5 * dv - (a0 - a1) / 12.0
    bump = 30.0 * np.where(h < _SHORT, 0.0, missing)
    rate = (v0, a0, 3.0 * dv - 2.0 * a0 - a1 + bump, a0 + a1 - 2.0 * (dv + bump), bump)
    # By powers of time from the step's start.
    rising = [q0, *(c / ((k + 1) * h**k) for k, c in enumerate(rate))]
    return PPoly(np.stack(rising[::-1]), np.append(times[first], times[-1]))
