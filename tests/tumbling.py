"""Motions of two bodies that both tumble along curves, by formulae of their own."""

import numpy as np
from scipy.spatial.transform import Rotation

from drakesep.systems.model.run import Trajectory


class Tumbling:
    """B moves on a curve in A and tumbles; A moves and turns too.

    B's attitude in A is a turn about an axis that itself turns about another.
    """

    def __init__(self, seed, *, distance=1.0, tumbles=True):
        rng = np.random.default_rng(seed)
        self._start = distance * unit(rng)
        # Toward A and back, and to and fro.
        toward = -rng.uniform(0.4, 0.9) * self._start
        self._swing = np.array([toward, 0.2 * distance * rng.normal(size=3)])
        self._rates = rng.uniform(2.0, 5.0, size=2)
        self._axes = np.array([unit(rng), unit(rng)])
        self._spins = tumbles * rng.uniform(-5.0, 5.0, size=2)
        self._axis_A, self._spin_A = unit(rng), rng.uniform(0.2, 1.0)
        self._v_A = rng.normal(size=3)

    def place(self, t):
        """(n, 3) p_AoBo_A at (n,) times."""
        waves = zip(self._rates, self._swing, strict=True)
        return self._start + sum(np.sin(w * t)[:, None] * a for w, a in waves)

    def velocity(self, t):
        waves = zip(self._rates, self._swing, strict=True)
        return sum(w * np.cos(w * t)[:, None] * a for w, a in waves)

    def turn(self, t):
        """R_AB at (n,) times, by scipy."""
        outer, inner = (
            Rotation.from_rotvec((spin * t)[:, None] * axis)
            for spin, axis in zip(self._spins, self._axes, strict=True)
        )
        return outer * inner

    def points(self, t, p_B):
        """(n, 3) places in A, at (n,) times, of a point (3,) of B."""
        return self.turn(t).apply(p_B) + self.place(t)

    def trajectory(self, t):
        """The states of both at (n,) times, as a simulation would give them."""
        (s1, s2), (n1, n2) = self._spins, self._axes
        q_AB = times(quaternion(s1 * t, n1), quaternion(s2 * t, n2))
        outer = Rotation.from_rotvec((s1 * t)[:, None] * n1)
        w_AB_A = s1 * n1 + outer.apply(s2 * n2)
        R_WA = Rotation.from_rotvec((self._spin_A * t)[:, None] * self._axis_A)
        q_WA, w_WA = (
            quaternion(self._spin_A * t, self._axis_A),
            self._spin_A * self._axis_A,
        )
        p_WA, arm = t[:, None] * self._v_A, R_WA.apply(self.place(t))
        states = np.zeros((len(t), 2, 13))
        states[:, 0] = np.concatenate(
            [q_WA, p_WA, np.tile([*w_WA, *self._v_A], (len(t), 1))], axis=1
        )
        v_WB = self._v_A + np.cross(w_WA, arm) + R_WA.apply(self.velocity(t))
        states[:, 1] = np.concatenate(
            [times(q_WA, q_AB), p_WA + arm, w_WA + R_WA.apply(w_AB_A), v_WB], axis=1
        )
        return Trajectory(names=("lower", "upper"), time=t, states=states)


def unit(rng):
    n = rng.normal(size=3)
    return n / np.linalg.norm(n)


def quaternion(angle, axis):
    """(n, 4), which do not jump from q to -q as (n,) angles grow."""
    half = 0.5 * angle[:, None]
    return np.concatenate([np.cos(half), np.sin(half) * axis], axis=1)


def times(a, b):
    w, v = (
        a[:, 0] * b[:, 0] - (a[:, 1:] * b[:, 1:]).sum(axis=1),
        np.cross(a[:, 1:], b[:, 1:]),
    )
    return np.column_stack([w, a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + v])
