"""The inertial frame and the epoch in which states are handed over."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Self

from drakesep.exchange.epochs import check_time_system, parse_epoch
from drakesep.systems.checks import InputError
from drakesep.systems.model.orbit import Orbit, axes_of_plane


@dataclass(frozen=True, kw_only=True)
class InertialFrame:
    """An inertial frame, how the orbit lies in it, and when the run begins."""

    orbit: Orbit
    """With axes."""
    epoch: Decimal
    """Of t = 0, as `exchange.epochs` has it."""
    given: Mapping[str, str] = field(default_factory=dict)
    """What was said at the export of it, since the case does not, by its name."""

    @property
    def name(self) -> str:
        """Of the frame."""
        return self.orbit.frame

    @property
    def time_system(self) -> str:
        """Of epochs."""
        return self.orbit.time_system

    def epoch_at(self, time: float) -> Decimal:
        """Return the epoch of a time since the start of the run, s."""
        return self.epoch + Decimal(float(time))

    @classmethod
    def of(
        cls,
        orbit: Orbit | None,
        *,
        epoch: str | None,
        frame: str | None,
        plane: Sequence[float] | None,
        time_system: str | None,
    ) -> Self | None:
        """Return the frame of a case, with what is missing in that; None: of neither.

        Args:
            orbit: of the case.
            epoch: of t = 0.
            frame: its name.
            plane: inclination, ascending node and argument of latitude, deg.
            time_system: of the epoch; if it is said nowhere, UTC.

        Raises:
            ValueError: it is said in part, or twice and differently.
        """
        given = epoch, frame, plane, time_system
        if orbit is None:
            if any(x is not None for x in given):
                raise InputError("orbit: the case must have one to hand over, got none")
            return None
        if orbit.axes is None and not any(x is not None for x in given):
            return None
        of_case = orbit.time_system if orbit.epoch else None
        name = _one("frame", orbit.frame or None, frame)
        start = _one("epoch", orbit.epoch or None, epoch)
        system = _one("time_system", of_case, time_system or of_case or "UTC")
        check_time_system("time_system", system)
        if plane is not None and orbit.axes is not None:
            raise InputError("plane: must not be given, the case says how it lies")
        axes = orbit.axes
        if plane is not None:
            inclination, node, latitude = map(math.radians, plane)
            axes = axes_of_plane(inclination, node, latitude)
        if axes is None:
            raise InputError(
                "plane: must be given, inclination, ascending node and argument of "
                "latitude at t = 0, deg, where the case does not say how its orbit "
                "lies, got none"
            )
        placed = dataclasses.replace(
            orbit, axes=axes, frame=name, epoch=start, time_system=system
        )
        said = {
            "frame": "" if orbit.frame else name,
            "epoch": "" if orbit.epoch else start,
            "time_system": "" if orbit.epoch else system,
            "plane": "" if plane is None else ", ".join(map(_plain, plane)),
        }
        alone = {key: value for key, value in said.items() if value}
        return cls(orbit=placed, epoch=parse_epoch("epoch", start), given=alone)


def _one(name: str, of_case: str | None, given: str | None) -> str:
    """Return what the case says, or what is given.

    Raises:
        ValueError: neither does, or they differ.
    """
    if of_case is not None and given is not None and of_case != given:
        raise InputError(f"{name}: must be {of_case}, as the case says, got {given}")
    told = of_case or given
    if not told:
        raise InputError(f"{name}: must be given, where the case has none, got none")
    return told


def _plain(angle: float) -> str:
    """Return an angle with all its digits, and no more."""
    return repr(float(angle)).removesuffix(".0")
