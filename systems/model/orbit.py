"""The reference orbit along which W falls, and how it lies in an inertial frame."""

import itertools
import math
from dataclasses import dataclass
from typing import Self, TypeAlias

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    Vector3,
    check_entries,
    check_finite,
    check_positive,
)
from drakesep.systems.model.magnitudes import check_size
from drakesep.systems.vectors import cross, dot, scale, subtract


EARTH_MU = 3.986004418e14
"""Gravitational parameter of the Earth, m^3/s^2 (WGS 84)."""
EARTH_RADIUS = 6378137.0
"""Equatorial radius of the Earth, m (WGS 84)."""
MOST_ECCENTRIC = 0.999
"""Beyond it Kepler's equation is not solved to round-off."""
_ROUND_OFF = 1e-12
"""Of axes that are orthonormal."""
Axes: TypeAlias = tuple[Vector3, Vector3, Vector3]


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Orbit:
    """The orbit along which W falls: any ellipse, a circle if no speed is given.

    At t = 0, W's z axis points to the centre of the Earth, and its x axis lies in the
    orbit, across the radius and along the motion.

    Raises:
        ValueError: the radius, the gravitational parameter or the horizontal speed is
            not positive, the orbit is no ellipse of an eccentricity up to
            `MOST_ECCENTRIC`, or axes are not orthonormal or have no frame.
    """

    radius: float
    """From the centre of the Earth at t = 0, m."""
    mu: float = EARTH_MU
    """Gravitational parameter, m^3/s^2."""
    horizontal_speed: float | None = None
    """At t = 0, across the radius, m/s; None: that of a circular orbit."""
    climb_rate: float = 0.0
    """At t = 0, away from the centre, m/s."""
    axes: Axes | None = None
    """W's axes x, y and z in `frame`; None: it is not known how the orbit lies."""
    frame: str = ""
    """Name of an inertial frame, such as ``EME2000``."""
    epoch: str = ""
    """Of t = 0, in ISO 8601."""
    time_system: str = "UTC"
    """Of the epoch."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_size("orbit_radius", "orbit: radius", self.radius)
        check_positive("orbit: mu", self.mu)
        if self.horizontal_speed is not None:
            check_positive("orbit: horizontal speed", self.horizontal_speed)
        check_finite("orbit: climb rate", self.climb_rate)
        # Not a power, which raises where a product is infinite.
        energy = 2.0 - self.radius * self.speed * self.speed / self.mu
        if energy <= 0.0 or self.eccentricity > MOST_ECCENTRIC:
            raise InputError(
                f"orbit: must be an ellipse of an eccentricity up to {MOST_ECCENTRIC}, "
                f"got {self.speed:g} m/s at a radius of {self.radius:g} m"
            )
        if self.axes is not None:
            _check_axes(self.axes)
            if not self.frame:
                raise InputError("orbit: axes must be in a frame that is named")

    @property
    def start(self) -> tuple[float, float, float, float]:
        """`mu`, `radius`, horizontal speed and `climb_rate`."""
        across = self.horizontal_speed
        if across is None:
            across = math.sqrt(self.mu / self.radius)
        return self.mu, self.radius, across, self.climb_rate

    @property
    def speed(self) -> float:
        """At t = 0, m/s."""
        return math.hypot(*self.start[2:])

    @property
    def semi_major_axis(self) -> float:
        """M."""
        return self.radius / (2.0 - self.radius * self.speed**2 / self.mu)

    @property
    def eccentricity(self) -> float:
        """0 of a circle; below 1e-15 of what is one but for round-off."""
        a = self.semi_major_axis
        e_sin = self.radius * self.climb_rate / math.sqrt(self.mu * a)
        return math.hypot(1.0 - self.radius / a, e_sin)

    @property
    def mean_motion(self) -> float:
        """rad/s."""
        return math.sqrt(self.mu / self.semi_major_axis**3)

    @classmethod
    def of_state(
        cls,
        position: Vector3,
        velocity: Vector3,
        *,
        frame: str,
        epoch: str,
        time_system: str = "UTC",
        mu: float = EARTH_MU,
    ) -> Self:
        """Return the orbit through a state in an inertial frame.

        Args:
            position: of W's origin at t = 0, from the centre of the Earth, m.
            velocity: of it, m/s.
            frame: in which they are.
            epoch: of t = 0, in ISO 8601.
            time_system: of the epoch.
            mu: gravitational parameter, m^3/s^2.

        Raises:
            ValueError: they are not on an ellipse.
        """
        check_entries("orbit: position", position, 3)
        check_entries("orbit: velocity", velocity, 3)
        radius = math.hypot(*position)
        check_size("orbit_radius", "orbit: radius", radius)
        up = scale(1.0 / radius, position)
        climb = dot(velocity, up)
        across = subtract(velocity, scale(climb, up))
        speed = math.hypot(*across)
        check_positive("orbit: horizontal speed", speed)
        ahead = scale(1.0 / speed, across)
        down = scale(-1.0, up)
        return cls(
            radius=radius,
            mu=mu,
            horizontal_speed=speed,
            climb_rate=climb,
            axes=(ahead, cross(down, ahead), down),
            frame=frame,
            epoch=epoch,
            time_system=time_system,
        )


def axes_of_plane(inclination: float, node: float, latitude: float) -> Axes:
    """Return W's axes x, y and z in an inertial frame.

    Args:
        inclination: of the orbit, rad.
        node: right ascension of its ascending node, rad.
        latitude: argument of latitude of W's origin at t = 0: its angle from the
            ascending node, along the motion, rad.
    """
    ci, si = math.cos(inclination), math.sin(inclination)
    cn, sn = math.cos(node), math.sin(node)
    cu, su = math.cos(latitude), math.sin(latitude)
    up = (cn * cu - sn * su * ci, sn * cu + cn * su * ci, su * si)
    ahead = (-cn * su - sn * cu * ci, -sn * su + cn * cu * ci, cu * si)
    down = scale(-1.0, up)
    return ahead, cross(down, ahead), down


def _check_axes(axes: Axes) -> None:
    """Raise InputError unless three vectors are orthonormal and right-handed."""
    x, y, z = axes
    off = [abs(dot(a, a) - 1.0) for a in axes]
    off += [abs(dot(a, b)) for a, b in itertools.combinations(axes, 2)]
    off += [abs(dot(cross(x, y), z) - 1.0)]
    if not max(off) <= _ROUND_OFF:
        raise InputError(
            f"orbit: axes must be orthonormal and right-handed to {_ROUND_OFF:g}, got "
            f"{axes}, off by {max(off):g}"
        )
