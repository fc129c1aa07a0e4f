"""Gravity in the falling world: Clohessy and Wiltshire, and two bodies on ellipses."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from separations import generic_pair
from two_bodies import two_bodies

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.separation import InitialMotion
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


@pytest.mark.parametrize(
    "engine", ["drake", pytest.param("batch", marks=pytest.mark.slow)]
)
def test_relative_motion_on_an_ellipse_against_two_bodies(engine):
    """A body that drifts 27 m from the reference, on its way down to the perigee.

    Both fall about the Earth in an inertial frame, each integrated by itself.
    """
    T, rate = 1200.0, np.array([1e-3, 2e-3, -1.5e-3])
    orbit = Orbit(radius=8.6e6, horizontal_speed=7300.0, climb_rate=-1900.0)
    separation = generic_pair(
        initial=InitialMotion(w_WA_A=tuple(rate)),
        springs=False,
        orbit=orbit,
        duration=T,
    )
    lower, upper = separation.bodies
    lower = dataclasses.replace(lower, p_BoBcm_B=(0.0, 0.0, 0.0))
    separation = dataclasses.replace(separation, bodies=(lower, upper))
    if engine == "batch":
        names = ["upper.mass"]
        [run] = Batch(separation, names).runs(np.array([[upper.mass]]))
    else:
        run = Simulation(separation, Integration(accuracy=1e-9)).run()
    state = run.completed_trajectory.of("upper")
    R_WB = Rotation.from_quat(state[:, :4], scalar_first=True)
    p_WBcm = state[:, 4:7] + R_WB.apply(upper.p_BoBcm_B)

    time = run.completed_trajectory.time
    r = np.array([0.0, 0.0, -orbit.radius])
    v = np.array([orbit.horizontal_speed, 0.0, -orbit.climb_rate])
    p = np.array(upper.p_BoBcm_B)
    reference, body = (
        two_bodies(np.concatenate(start), time)[:, :3]
        for start in ((r, v), (r + p, v + np.cross(rate, p)))
    )
    # Round-off of two radii of 8e6 m over some hundred steps, and the run's accuracy.
    assert np.abs(p_WBcm - (body - reference)).max() <= 3e-5
    straight = p + np.outer(time, np.cross(rate, p))
    assert np.abs(p_WBcm - straight).max() > 1.0  # gravity does matter here


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
