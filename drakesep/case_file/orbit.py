"""The orbit in a case file: a circle, an ellipse or a state, and how it lies."""

import math
from typing import Any, Self

from pydantic import model_validator

from drakesep.case_file.section import Name, Positive, Section, Vector, check_one
from drakesep.exchange.epochs import TimeSystem, epoch_text, parse_epoch
from drakesep.systems.model.orbit import (
    EARTH_MU,
    EARTH_RADIUS,
    Orbit,
    axes_of_plane,
)


_KM = 1000.0
_FORMS = ("altitude_km", "perigee_altitude_km", "position_km")
_OF_PLANE = ("inclination_deg", "ascending_node_deg", "argument_of_latitude_deg")


class OrbitSection(Section):
    """The orbit along which W falls: a circle, an ellipse, or a state at t = 0.

    How it lies in an inertial frame matters to what is handed over alone.
    """

    altitude_km: Positive | None = None
    """Of a circle, above a sphere of the Earth's equatorial radius."""
    perigee_altitude_km: float | None = None
    """Of an ellipse, likewise; with `apogee_altitude_km`, in place of `altitude_km`."""
    apogee_altitude_km: float | None = None
    """Of the ellipse."""
    true_anomaly_deg: float = 0.0
    """Where on the ellipse W's origin is at t = 0: the angle from the perigee, along
    the motion."""
    position_km: Vector | None = None
    """Of W's origin at t = 0, from the centre of the Earth, in `frame`; with
    `velocity_km_s`, in place of all above."""
    velocity_km_s: Vector | None = None
    """Of W's origin at t = 0, in `frame`."""
    inclination_deg: float | None = None
    """Of a circle or an ellipse in `frame`; with the two angles that follow."""
    ascending_node_deg: float | None = None
    """Right ascension of the ascending node."""
    argument_of_latitude_deg: float | None = None
    """Of W's origin at t = 0: the angle from the ascending node, along the motion."""
    frame: Name | None = None
    """Name of the inertial frame, such as `EME2000`."""
    epoch: str | None = None
    """Of t = 0: YYYY-MM-DDThh:mm:ss, with decimals of a second or none."""
    time_system: TimeSystem = "UTC"
    """Of the epoch."""

    @model_validator(mode="after")
    def _check_form(self) -> Self:
        check_one(self, _FORMS)
        self._check_together("perigee_altitude_km", "apogee_altitude_km")
        self._check_together("position_km", "velocity_km_s")
        self._check_together(*_OF_PLANE)
        if self.true_anomaly_deg and self.perigee_altitude_km is None:
            raise ValueError("true_anomaly_deg must stand with perigee_altitude_km")
        if self.position_km is not None and self.inclination_deg is not None:
            raise ValueError("inclination_deg must not stand with position_km")
        lies = self.position_km is not None or self.inclination_deg is not None
        if lies and self.frame is None:
            raise ValueError("must have 'frame', in which the orbit lies, got none")
        if lies and self.epoch is None:
            raise ValueError("must have 'epoch', of t = 0, got none")
        if self.frame is not None and not lies:
            raise ValueError(
                f"frame must stand with position_km or {', '.join(_OF_PLANE)}"
            )
        if self.epoch is not None:
            parse_epoch("epoch", self.epoch)
        return self

    def _check_together(self, *keys: str) -> None:
        given = [key for key in keys if getattr(self, key) is not None]
        if given and len(given) < len(keys):
            raise ValueError(
                f"{', '.join(keys)} must stand together, got {', '.join(given)} alone"
            )

    def in_si(self) -> Orbit:
        """Return the orbit."""
        if self.position_km is not None and self.velocity_km_s is not None:
            x, y, z = self.position_km
            u, v, w = self.velocity_km_s
            return Orbit.of_state(
                (_KM * x, _KM * y, _KM * z),
                (_KM * u, _KM * v, _KM * w),
                frame=self.frame or "",
                epoch=self._epoch,
                time_system=self.time_system,
            )
        radius, across, climb = self._on_the_way()
        return Orbit(
            radius=radius,
            horizontal_speed=across,
            climb_rate=climb,
            axes=self._axes(),
            frame=self.frame or "",
            epoch=self._epoch,
            time_system=self.time_system,
        )

    @property
    def _epoch(self) -> str:
        """As epochs are written, however it stands."""
        if self.epoch is None:
            return ""
        return epoch_text(parse_epoch("epoch", self.epoch))

    def _axes(self) -> tuple[Any, Any, Any] | None:
        angles = [getattr(self, key) for key in _OF_PLANE]
        if None in angles:
            return None
        return axes_of_plane(*map(math.radians, angles))

    def _on_the_way(self) -> tuple[float, float | None, float]:
        """Return radius, horizontal speed and climb rate at t = 0."""
        low, high = self.perigee_altitude_km, self.apogee_altitude_km
        if low is None or high is None:
            return EARTH_RADIUS + _KM * (self.altitude_km or 0.0), None, 0.0
        perigee, apogee = (EARTH_RADIUS + _KM * x for x in (low, high))
        if not 0.0 < perigee <= apogee:
            raise ValueError(
                "perigee_altitude_km must not be above apogee_altitude_km, nor below "
                f"the centre of the Earth, got {low:g} and {high:g}"
            )
        e = (apogee - perigee) / (apogee + perigee)
        p = perigee * (1.0 + e)
        anomaly = math.radians(self.true_anomaly_deg)
        radius = p / (1.0 + e * math.cos(anomaly))
        of_circle = math.sqrt(EARTH_MU / p)
        return radius, of_circle * (p / radius), of_circle * e * math.sin(anomaly)
