"""Motions of two bodies that are written down, not simulated, and runs of them."""

import dataclasses

import numpy as np
from separations import generic_pair

from drakesep.systems.model.run import Run, RunStatus, Trajectory


def trajectory(time, p_AoBo, v_ABo, *, angle=None, rate=None, axis=(1.0, 0.0, 0.0)):
    """B moves in A, which stands still; it turns about an axis that is fixed.

    Args:
        time: (n,).
        p_AoBo: (n, 3).
        v_ABo: (n, 3).
        angle: (n,) by which B has turned; not at all if None.
        rate: (n,) of the angle.
        axis: (3,).
    """
    n = len(time)
    angle = np.zeros(n) if angle is None else angle
    rate = np.zeros(n) if rate is None else rate
    states = np.zeros((n, 2, 13))
    states[:, 0, 0] = 1.0
    states[:, 1, 0] = np.cos(0.5 * angle)
    states[:, 1, 1:4] = np.sin(0.5 * angle)[:, None] * np.array(axis)
    states[:, 1, 4:7] = p_AoBo
    states[:, 1, 7:10] = rate[:, None] * np.array(axis)
    states[:, 1, 10:13] = v_ABo
    return Trajectory(names=("lower", "upper"), time=time, states=states)


def straight(time, start, velocity, **turning):
    """B moves along a straight line."""
    time, velocity = np.asarray(time), np.asarray(velocity)
    places = np.asarray(start) + time[:, None] * velocity
    return trajectory(time, places, np.tile(velocity, (len(time), 1)), **turning)


def run_of(motion, on_lower, on_upper):
    """A completed run of two bodies with parts."""
    pair = generic_pair()
    lower, upper = pair.bodies
    separation = dataclasses.replace(
        pair,
        bodies=(
            dataclasses.replace(lower, parts=tuple(on_lower)),
            dataclasses.replace(upper, parts=tuple(on_upper)),
        ),
        duration=float(motion.time[-1]),
    )
    return Run(separation=separation, status=RunStatus.COMPLETED, trajectory=motion)
