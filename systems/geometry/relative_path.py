"""The motion of one body as seen from another, at any time of a run.

Between samples it is the cubic through places and velocities: of fourth order, and for
a run that is sampled as these are (see `drakesep.systems.sampling`) far finer than any
clearance.
"""

import functools
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

from drakesep.systems.arrays import Array
from drakesep.systems.checks import Vector3
from drakesep.systems.equations.relative_motion import (
    BodyState,
    body_state,
    velocity_at,
)
from drakesep.systems.geometry.moved_parts import Displacement
from drakesep.systems.model.run import Trajectory
from drakesep.systems.vectors import (
    add,
    conjugate,
    cross,
    multiply,
    rotate,
    rotation_matrix,
    subtract,
    unrotate,
)


class Pose(NamedTuple):
    """Pose and velocity of B in A."""

    q_AB: Array
    """(4,)."""
    R_AB: Array
    """(3, 3)."""
    p_AoBo_A: Array
    """m."""
    w_AB_A: Array
    """rad/s."""
    v_ABo_A: Array
    """As seen from A, m/s."""


class MotionBounds(NamedTuple):
    """How fast B moves in A in a stretch of time, at most."""

    angular_speed: float
    """rad/s."""
    acceleration: float
    """Of B's origin as seen from A, m/s^2."""
    bending: float
    """Acceleration of a point of B about the origin, over its distance, 1/s^2."""


class RelativePath:
    """The motion of body B as seen from body A; or of parts of them that are moved.

    Attributes:
        time: (n,) at which it was sampled, s.
    """

    def __init__(
        self,
        trajectory: Trajectory,
        A: str,
        B: str,
        moved: tuple[Displacement, Displacement] = (None, None),
    ):
        """Take the motion of two bodies from that of all.

        Args:
            trajectory: of all bodies.
            A: name of the body from which the other is seen.
            B: name of the other.
            moved: how a part of A and one of B are displaced in them: frames that are
                moved with the parts then take the place of the bodies'.
        """
        self.time = trajectory.time
        a, b = (
            _moved(body_state(trajectory.of(name).T, 0, 7), X)
            for name, X in zip((A, B), moved, strict=True)
        )
        arm = subtract(b.p_WBo, a.p_WBo)
        p = unrotate(a.R_WB, arm)
        v = unrotate(a.R_WB, subtract(subtract(b.v_WBo, a.v_WBo), cross(a.w_WB, arm)))
        w = unrotate(a.R_WB, subtract(b.w_WB, a.w_WB))
        q = multiply(conjugate(a.q_WB), b.q_WB)
        q_dot = [0.5 * x for x in multiply((np.zeros_like(w[0]), *w), q)]
        self._spline = CubicHermiteSpline(
            self.time, np.stack([*q, *p], axis=1), np.stack([*q_dot, *v], axis=1)
        )
        self._derivative = self._spline.derivative()
        self._speeds = np.linalg.norm(np.stack(q_dot), axis=0)

    def at(self, t: float) -> Pose:
        """Return pose and velocity of B in A at a time, s."""
        x, x_dot = self._spline(t), self._derivative(t)
        # Between samples its length misses one by the error of the cubic.
        length = np.linalg.norm(x[:4])
        q, q_dot = x[:4] / length, x_dot[:4] / length
        R = np.array(rotation_matrix(tuple(q.tolist()))).reshape(3, 3)
        _, *w = multiply(tuple(q_dot), conjugate(tuple(q)))
        return Pose(q, R, x[4:], 2.0 * np.array(w), x_dot[4:])

    def places(self, times: Array) -> tuple[Array, Array]:
        """Return (n, 3, 3) orientations R_AB and (n, 3) places p_AoBo_A, m, of B in A.

        Args:
            times: (n,) s.
        """
        x = self._spline(times)
        q = x[:, :4] / np.linalg.norm(x[:, :4], axis=1)[:, None]
        R = np.stack(rotation_matrix(tuple(q.T)), axis=1)
        return R.reshape(-1, 3, 3), x[:, 4:]

    def moved(self, times: Array, direction_A: Vector3) -> Array:
        """Return (n,) how far B's origin has moved in a direction since the start, m.

        Args:
            times: (n,) s.
            direction_A: unit vector fixed in A.
        """
        along = self._along(direction_A)
        moved: Array = along(times) - along(self.time[0])
        return moved

    def time_apart(self, distance: float, direction_A: Vector3) -> float:
        """Return when B's origin has first moved so far in a direction, s.

        Infinite if it never does.

        Args:
            distance: from where it is at first, m.
            direction_A: unit vector fixed in A.
        """
        along = self._along(direction_A)
        reached = along.solve(float(along(self.time[0])) + distance, extrapolate=False)
        return float(np.nanmin(reached, initial=np.inf))

    def _along(self, direction_A: Vector3) -> PPoly:
        return PPoly(self._spline.c[:, :, 4:] @ np.array(direction_A), self.time)

    def bounds(self, start: float, end: float) -> MotionBounds:
        """Return bounds on the motion between two times, s."""
        i = int(np.searchsorted(self.time, start, side="right")) - 1
        j = int(np.searchsorted(self.time, end, side="left"))
        i = min(max(i, 0), len(self.time) - 2)
        mine = slice(i, max(j, i + 1))
        turning, bending, acceleration = (x[mine].max() for x in self._fastest)
        return MotionBounds(
            float(2.0 * turning),
            float(acceleration),
            # R is of second degree in the quaternion.
            float(2.0 * (bending + turning**2)),
        )

    @functools.cached_property
    def _fastest(self) -> tuple[Array, Array, Array]:
        """(n - 1,) on each interval: how fast q turns, bends, and p accelerates."""
        # Second derivatives are linear on an interval: they peak at its ends.
        second = self._spline.derivative(2)
        steps = np.diff(self.time)
        ends = np.stack([second.c[-1], second.c[-1] + second.c[0] * steps[:, None]])
        bending = np.linalg.norm(ends[..., :4], axis=2).max(axis=0)
        acceleration = np.linalg.norm(ends[..., 4:], axis=2).max(axis=0)
        speeds = np.maximum(self._speeds[:-1], self._speeds[1:])
        return speeds + 0.5 * steps * bending, bending, acceleration


def _moved(body: BodyState, X: Displacement) -> BodyState:
    """Return the motion of a frame that is fixed to a body, displaced from its own."""
    if X is None:
        return body
    q_WF = multiply(body.q_WB, tuple(X.rotation().ToQuaternion().wxyz().tolist()))
    arm = rotate(body.R_WB, tuple(X.translation().tolist()))
    return BodyState(
        q_WF,
        rotation_matrix(q_WF),
        add(body.p_WBo, arm),
        body.w_WB,
        velocity_at(body, arm),
    )
