"""Gravity in the falling world against Clohessy and Wiltshire's relative motion."""

import dataclasses

import numpy as np
import pytest
from separations import generic_pair

from drakesep.systems.model.integration import Integration
from drakesep.systems.model.separation import InitialMotion, Orbit
from drakesep.systems.simulation.simulation import Simulation


ORBIT = Orbit(radius=7.078137e6)


def test_relative_motion_against_clohessy_wiltshire():
    """A body that drifts 30 m from the origin within a quarter of an orbit."""
    T = 1500.0
    rate = (1e-3, 2e-3, -1.5e-3)
    separation = generic_pair(
        initial=InitialMotion(w_WA_A=rate), springs=False, orbit=ORBIT, duration=T
    )
    lower, upper = separation.bodies
    lower = dataclasses.replace(lower, p_BoBcm_B=(0.0, 0.0, 0.0))
    separation = dataclasses.replace(separation, bodies=(lower, upper))
    run = Simulation(separation, Integration(accuracy=1e-9)).run()

    p0 = np.array(upper.p_BoBcm_B)
    v0 = np.cross(rate, p0)
    motion = run.motion
    # A's CG stays at the origin: seen from it without its rotation, B is where
    # Clohessy and Wiltshire put it.
    distance = np.linalg.norm(motion.relative_position + p0, axis=1)
    n = ORBIT.mean_motion
    expected = clohessy_wiltshire(n, p0, v0, motion.time)
    # CW is linear: off by 3/2 d / r of the tidal displacement, 3 n^2 d t^2 / 2
    d = distance.max()
    neglected = 1.5 * d / ORBIT.radius * 1.5 * (n * T) ** 2 * d
    assert distance == pytest.approx(
        np.linalg.norm(expected, axis=1), abs=neglected + 1e-6
    )
    free = np.linalg.norm(p0 + v0 * motion.time[:, None], axis=1)
    assert np.abs(distance - free).max() > 1.0  # gravity does matter here


def clohessy_wiltshire(n, p_W, v_W, t):
    """Positions (n, 3) in a frame that turns with the orbit, from W's at t = 0."""
    # Radial x (up), along-track y, cross-track z, from W's axes at t = 0.
    x0, y0, z0 = -p_W[2], p_W[0], -p_W[1]
    # Seen from the turning frame, whose rate is n about z.
    u0, v0, w0 = -v_W[2] + n * y0, v_W[0] - n * x0, -v_W[1]
    s, c = np.sin(n * t), np.cos(n * t)
    x = (4 - 3 * c) * x0 + s / n * u0 + 2 / n * (1 - c) * v0
    y = 6 * (s - n * t) * x0 + y0 - 2 / n * (1 - c) * u0 + (4 * s - 3 * n * t) / n * v0
    z = z0 * c + w0 / n * s
    return np.stack([x, y, z], axis=1)


def test_a_body_at_rest_at_the_origin_stays():
    """W falls along the orbit: nothing moves at its origin."""
    separation = generic_pair(
        initial=InitialMotion(), springs=False, orbit=ORBIT, duration=100.0
    )
    lower, upper = separation.bodies
    upper = dataclasses.replace(upper, p_BoBcm_B=(0.0, 0.0, 0.0))
    lower = dataclasses.replace(lower, p_BoBcm_B=(0.0, 0.0, 0.0))
    separation = dataclasses.replace(separation, bodies=(lower, upper))
    run = Simulation(separation).run()
    # 100 s of round-off in W's place, 1e-9 m of 7e6 m, as a tidal force
    assert np.abs(run.motion.acceleration).max() < 1e-12
