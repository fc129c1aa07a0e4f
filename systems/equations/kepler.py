"""The reference orbit: how W's origin falls about the Earth, by Kepler's equation.

Their form is that of `relative_motion`: on floats or lanes, with ``ops`` as the module
of the elementary functions.
"""

import math
from typing import NamedTuple

from drakesep.systems.model.orbit import Orbit
from drakesep.systems.vectors import Ops, Scalar, Vector


_ROUND_OFF = 2e-15
"""An eccentricity below it is none: of a circle it comes out as a few 1e-16."""
_STEPS = 4
"""Of Laguerre's method: three are enough up to an eccentricity of 0.99, four up to
0.999, for any time."""


class Ellipse(NamedTuple):
    """An orbit about the centre of the Earth, and the place on it at t = 0."""

    radius: float
    """At t = 0, m."""
    horizontal_speed: float
    """At t = 0, across the radius, m/s."""
    climb_rate: float
    """At t = 0, away from the centre, m/s."""
    semi_major_axis: float
    """m."""
    mean_motion: float
    """rad/s."""
    eccentricity: float
    e_cos: float
    """Eccentricity times the cosine of the eccentric anomaly at t = 0."""
    e_sin: float
    """The same with its sine."""


def ellipse(
    mu: float, radius: float, horizontal_speed: float, climb_rate: float
) -> Ellipse:
    """Return the orbit through a state at t = 0.

    Args:
        mu: gravitational parameter, m^3/s^2.
        radius: from the centre of the Earth, m.
        horizontal_speed: across the radius, m/s.
        climb_rate: away from the centre, m/s.
    """
    here = radius, horizontal_speed, climb_rate
    a = 1.0 / (2.0 / radius - (horizontal_speed**2 + climb_rate**2) / mu)  # vis viva
    e_cos, e_sin = 1.0 - radius / a, radius * climb_rate / math.sqrt(mu * a)
    e = math.hypot(e_cos, e_sin)
    if e < _ROUND_OFF:
        a, e, e_cos, e_sin = radius, 0.0, 0.0, 0.0
    return Ellipse(*here, a, math.sqrt(mu / a**3), e, e_cos, e_sin)


def ellipse_of(orbit: Orbit) -> Ellipse:
    """Return the ellipse of a reference orbit."""
    return ellipse(*orbit.start)


def eccentric_turn(t: Scalar, orbit: Ellipse, ops: Ops) -> Scalar:
    """Return by how much the eccentric anomaly has grown since t = 0, rad.

    Kepler's equation for the difference x of two anomalies (Battin, "An Introduction to
    the Mathematics and Methods of Astrodynamics", section 4.3), by Laguerre's method
    (Conway, doi:10.1007/BF01230852).

    Args:
        t: time, s.
        orbit: the orbit.
        ops: module of the elementary functions.
    """
    M = orbit.mean_motion * t
    if orbit.eccentricity == 0.0:
        return M
    e, e_cos, e_sin = orbit.eccentricity, orbit.e_cos, orbit.e_sin
    mean = M + math.atan2(e_sin, e_cos) - e_sin  # since the perigee
    x = M - e_sin
    x = x + e * ops.sin(mean) / ops.sqrt(1.0 - 2.0 * e * ops.cos(mean) + e * e)
    for _ in range(_STEPS):
        s, c = ops.sin(x), ops.cos(x)
        f = x - e_cos * s + e_sin * (1.0 - c) - M
        slope, curvature = 1.0 - e_cos * c + e_sin * s, e_cos * s + e_sin * c
        root = ops.sqrt(abs(16.0 * slope * slope - 20.0 * f * curvature))
        x = x - 5.0 * f / (slope + root)
    return x


def orbit_position(t: Scalar, orbit: Ellipse, ops: Ops) -> Vector:
    """Return W's origin from the centre of the Earth, in W, m.

    At t = 0, W's z axis points to the centre and its x axis lies in the orbit, across
    the radius and along the motion.

    Args:
        t: time, s.
        orbit: the orbit.
        ops: module of the elementary functions.
    """
    x = eccentric_turn(t, orbit, ops)
    r0, u0, w0 = orbit.radius, orbit.horizontal_speed, orbit.climb_rate
    half = ops.sin(0.5 * x)
    f = 1.0 - 2.0 * orbit.semi_major_axis / r0 * half * half
    g = t - (x - ops.sin(x)) / orbit.mean_motion
    return g * u0, 0.0 * x, -(f * r0 + g * w0)


def orbit_velocity(t: Scalar, orbit: Ellipse, ops: Ops) -> Vector:
    """Return the velocity of W's origin about the centre of the Earth, in W, m/s.

    Args:
        t: time, s.
        orbit: the orbit.
        ops: module of the elementary functions.
    """
    x = eccentric_turn(t, orbit, ops)
    r0, u0, w0, a = *orbit[:3], orbit.semi_major_axis
    s, half = ops.sin(x), ops.sin(0.5 * x)
    r = a * (1.0 - orbit.e_cos * ops.cos(x) + orbit.e_sin * s)
    f_dot = -orbit.mean_motion * a * a * s / (r * r0)
    g_dot = 1.0 - 2.0 * a / r * half * half
    return g_dot * u0, 0.0 * x, -(f_dot * r0 + g_dot * w0)
