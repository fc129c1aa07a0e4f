"""Kepler's orbits against an independent integration of two bodies."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from two_bodies import two_bodies

from drakesep.systems.equations.kepler import (
    eccentric_turn,
    ellipse,
    ellipse_of,
    orbit_position,
    orbit_velocity,
)
from drakesep.systems.model.orbit import EARTH_MU, Orbit, axes_of_plane


CIRCLE = 7546.0
"""Speed of a circle of 7000 km, m/s, near enough."""
ORBITS = {
    "circle": Orbit(radius=7e6),
    "nearly": Orbit(radius=7e6, horizontal_speed=CIRCLE, climb_rate=0.01),
    "at the perigee": Orbit(radius=6.6e6, horizontal_speed=10_200.0),
    "climbing": Orbit(radius=1.2e7, horizontal_speed=6100.0, climb_rate=2500.0),
    "falling": Orbit(radius=1.2e7, horizontal_speed=5000.0, climb_rate=-3100.0),
    "of an ascent": Orbit(radius=6.5e6, horizontal_speed=4000.0, climb_rate=1500.0),
}
TIMES = np.array([0.0, 1.0, 30.0, 300.0, 900.0])


@pytest.mark.parametrize("name", ORBITS)
def test_the_reference_falls_as_two_bodies_do(name):
    orbit = ORBITS[name]
    reference = ellipse_of(orbit)
    _, radius, across, climb = orbit.start
    wanted = two_bodies([0.0, 0.0, -radius, across, 0.0, -climb], TIMES)
    position = np.stack(orbit_position(TIMES, reference, np), axis=1)
    velocity = np.stack(orbit_velocity(TIMES, reference, np), axis=1)
    # The integration's own error, of some hundred steps to 3e-14.
    assert np.abs(position - wanted[:, :3]).max() <= 1e-12 * radius
    assert np.abs(velocity - wanted[:, 3:]).max() <= 1e-12 * orbit.speed
    assert position[0].tolist() == [0.0, 0.0, -radius]
    assert velocity[0] == pytest.approx([across, 0.0, -climb], rel=4e-16, abs=0.0)


@given(
    st.floats(0.0, 0.9989),
    st.floats(-math.pi, math.pi),
    st.floats(-1e4, 1e6),
)
@example(e=0.9989, anomaly=0.0, t=1776.0)
def test_keplers_equation_is_solved_on_any_ellipse(e, anomaly, t):
    """Wherever it begins, and whenever."""
    a = 2e7
    # Near a parabola, 1 - e keeps its digits if it is taken first.
    r = a * ((1.0 - e) + 2.0 * e * math.sin(0.5 * anomaly) ** 2)
    e_sin = e * math.sin(anomaly)
    climb = e_sin * math.sqrt(EARTH_MU * a) / r
    across = math.sqrt(EARTH_MU * a * (1.0 - e) * (1.0 + e)) / r
    orbit = ellipse(EARTH_MU, r, across, climb)
    x = eccentric_turn(t, orbit, math)
    ends = [y - e * math.sin(y) for y in (anomaly, anomaly + x)]
    mean = math.sqrt(EARTH_MU / a**3) * t
    # That of the anomalies, and of an axis that comes of a difference near a parabola.
    off = 1e-14 * (1.0 + abs(mean)) / (1.0 - e)
    assert ends[1] - ends[0] == pytest.approx(mean, abs=off)


@given(
    st.floats(0.1, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.0, 0.9)
)
def test_state_in_and_out(inclination, node, latitude, e):
    """To 1e-12 of radius and speed, as a trajectory simulation has it."""
    axes = np.array(axes_of_plane(inclination, node, latitude)).T
    speed = math.sqrt(EARTH_MU * (1.0 + e) / 7e6)
    r, v = axes @ [0.0, 0.0, -7e6], axes @ [speed, 0.0, 0.0]
    orbit = Orbit.of_state(tuple(r), tuple(v), frame="EME2000", epoch="")
    R_FW = np.array(orbit.axes).T
    reference = ellipse_of(orbit)
    out = R_FW @ orbit_position(0.0, reference, math)
    assert np.linalg.norm(out - r) <= 1e-12 * 7e6
    out = R_FW @ orbit_velocity(0.0, reference, math)
    assert np.linalg.norm(out - v) <= 1e-12 * speed
    assert np.linalg.norm(R_FW - axes) <= 1e-12


def test_planes():
    """A polar orbit over its node, and one in the equator, by hand."""
    ahead, right, down = axes_of_plane(math.pi / 2, 0.0, 0.0)
    assert np.allclose([ahead, right, down], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    ahead, right, down = axes_of_plane(0.0, 0.0, math.pi / 2)
    assert np.allclose([ahead, right, down], [[-1, 0, 0], [0, 0, -1], [0, -1, 0]])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"horizontal_speed": 0.0}, "orbit: horizontal speed must be > 0"),
        (
            {"horizontal_speed": 10_700.0},
            "orbit: must be an ellipse of an eccentricity",
        ),
        ({"horizontal_speed": 1.0}, "orbit: must be an ellipse"),
        ({"climb_rate": math.nan}, "orbit: climb rate"),
        ({"axes": ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))}, "in a frame that is named"),
        (
            {"axes": ((1.0, 0, 0), (0, 1.0, 0), (0, 0, -1.0)), "frame": "EME2000"},
            "orthonormal and right-handed",
        ),
        (
            {"axes": ((1.1, 0, 0), (0, 1.0, 0), (0, 0, 1.0)), "frame": "EME2000"},
            "orthonormal and right-handed",
        ),
    ],
)
def test_impossible_orbits(changes, message):
    with pytest.raises(ValueError, match=message):
        Orbit(radius=7e6, **changes)
