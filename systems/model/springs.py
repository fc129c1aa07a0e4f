"""Separation springs: driven by time, as the paper's, or by displacement."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import X_AXIS, Vector3, unit_vector
from drakesep.systems.model.magnitudes import MAGNITUDES
from drakesep.systems.model.parameter_table import (
    NOT_NEGATIVE,
    POSITIVE,
    SHARE,
    ParameterTable,
    scalar,
)
from drakesep.systems.model.profiles import (
    LINEAR,
    Profile,
    check_profile,
    read_table,
)
from drakesep.systems.model.pushers import TILTS
from drakesep.systems.vectors import Ops, Scalar


_FORCE_MAX = scalar("force_max", "force", NOT_NEGATIVE, label="maximum force")
_LEAST = MAGNITUDES["force"].least
"""Below it, as round-off leaves of a difference, there is no force."""
_STROKE = scalar("stroke", "length", POSITIVE)
_LOST_STROKE = scalar("lost_stroke", "factor", SHARE)


def push_frequency(spring: Any, ops: Ops) -> Scalar:
    """Return the angular frequency of a spring driven by time, rad/s; 0 of no force.

    Args:
        spring: a `Spring`, or lanes of its parameters.
        ops: module of the elementary functions.
    """
    return (spring.force_max >= _LEAST) * _frequency_of_some(spring, ops)


def push_duration(spring: Any, ops: Ops) -> Scalar:
    """Return the time from release to the end of the push, s; 0 of no force; see above.

    A spring that loses a part of its stroke stops where the motion that Eq. 5 stands
    for, of the design mass on a linear spring, comes to that part.
    """
    lost = spring.lost_stroke
    phase = ops.atan2(ops.sqrt(1.0 - lost * lost), lost)  # arccos
    return (spring.force_max >= _LEAST) * phase / _frequency_of_some(spring, ops)


def push_travel(travel: Scalar, force: Scalar, damping: Scalar = 0.0) -> Scalar:
    """Return the displacement at which a push ends, m: of no force, at its release.

    That is one below zero, as no pad comes back: it is passed from the beginning.

    Args:
        travel: at which one of some force ends, m.
        force: its largest, N.
        damping: of a damper beside it, N s/m, which acts without a force.
    """
    none = (force < _LEAST) & (damping <= 0.0)
    return travel - none * 2.0 * travel


def _frequency_of_some(spring: Any, ops: Ops) -> Scalar:
    # Of no force, that of some: it divides, and its root has a slope.
    force = spring.force_max + (spring.force_max < _LEAST)
    return ops.sqrt(force / (spring.design_mass * spring.stroke))  # Eq. 5


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """A separation spring driven by time, Eq. 5.

    Raises:
        ValueError: the stroke or the design mass is not positive, the force is
            negative, all of the stroke is lost, or a tilt is a right angle or more.
    """

    name: str
    force_max: float
    """Force at release, N; 0: it does not push, and ends at its release."""
    stroke: float
    """Delta L of Eq. 5, m."""
    design_mass: float
    """m_S of Eq. 5, kg: a constant of the design, whatever is dispersed."""
    axis_A: Vector3 = X_AXIS
    """Unit vector along which it pushes B, fixed in A: a part of the design."""
    tilt_y: float = 0.0
    """Of the push from its axis, about y, rad: a misalignment."""
    tilt_z: float = 0.0
    """About z, then, rad."""
    lost_stroke: float = 0.0
    """Part of the stroke, before its end, over which it does not push: it is stuck."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        _FORCE_MAX,
        _STROKE,
        *TILTS,
        scalar("design_mass", "mass", POSITIVE),
        _LOST_STROKE,
    )

    def __post_init__(self) -> None:
        """Check the values."""
        self.PARAMETERS.check(f"{self.name}: ", self)
        axis = unit_vector(f"{self.name}: axis", self.axis_A)
        object.__setattr__(self, "axis_A", axis)

    @property
    def frequency(self) -> float:
        """Angular frequency of the force, rad/s."""
        return float(push_frequency(self, math))

    @property
    def duration(self) -> float:
        """Time from release to the end of the stroke, s."""
        return float(push_duration(self, math))

    @property
    def energy(self) -> float:
        """Energy that the linear spring that Eq. 5 stands for can give, J.

        It is given if what the spring moves is as heavy as its design mass.
        """
        return 0.5 * self.force_max * self.stroke * (1.0 - self.lost_stroke**2)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class DisplacementSpring:
    """A separation spring driven by displacement, with a damper beside it.

    Its force follows a profile over its stroke, less what the damper takes; it does not
    pull unless its profile does, and is zero beyond the stroke.

    Raises:
        ValueError: the stroke is not positive, the force or the damping is negative,
            all of the stroke is lost, the profile does not run from 0 to 1 with forces
            from -1 to 1, or a tilt is a right angle or more.
    """

    name: str
    force_max: float
    """Largest force of the profile, whichever way, N; 0: it does not push, and ends at
    its release, unless it damps."""
    stroke: float
    """Displacement at which the push ends, m."""
    damping: float = 0.0
    """Of a damper beside it, N s/m."""
    profile: Profile = LINEAR
    """A part of the design: it does not vary. Where it is negative it pulls."""
    axis_A: Vector3 = X_AXIS
    """Unit vector along which it pushes B, fixed in A: a part of the design."""
    tilt_y: float = 0.0
    """Of the push from its axis, about y, rad: a misalignment."""
    tilt_z: float = 0.0
    """About z, then, rad."""
    lost_stroke: float = 0.0
    """Part of the stroke, before its end, over which it does not push: it is stuck."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        _FORCE_MAX,
        _STROKE,
        *TILTS,
        scalar("damping", "damping", NOT_NEGATIVE),
        _LOST_STROKE,
    )

    def __post_init__(self) -> None:
        """Check the values."""
        self.PARAMETERS.check(f"{self.name}: ", self)
        axis = unit_vector(f"{self.name}: axis", self.axis_A)
        object.__setattr__(self, "axis_A", axis)
        check_profile(f"{self.name}: profile", self.profile, signed=True)

    @property
    def duration(self) -> None:
        """None: its stroke ends the push."""

    @classmethod
    def from_table(
        cls,
        *,
        name: str,
        displacements: tuple[float, ...],
        forces: tuple[float, ...],
        damping: float = 0.0,
        axis_A: Vector3 = X_AXIS,
        tilt_y: float = 0.0,
        tilt_z: float = 0.0,
        lost_stroke: float = 0.0,
    ) -> "DisplacementSpring":
        """Return the spring of a measured table of force over stroke.

        One that pulls somewhere, as a captive spring or a harness, does so both ways.

        Args:
            name: of the spring.
            displacements: (n,) of the rows, from 0, increasing, m.
            forces: (n,) at these displacements, N; negative where it pulls.
            damping: of a damper beside it, N s/m.
            axis_A: unit vector along which it pushes, fixed in A.
            tilt_y: of the push from its axis, about y, rad: a misalignment.
            tilt_z: about z, then, rad.
            lost_stroke: part of the stroke, before its end, over which it does not
                push.

        Raises:
            ValueError: the columns differ in length, or do not make a profile.
        """
        table = read_table(name, displacements, forces, signed=True)
        return cls(
            name=name,
            force_max=table.force_max,
            stroke=table.stroke,
            damping=damping,
            axis_A=axis_A,
            tilt_y=tilt_y,
            tilt_z=tilt_z,
            lost_stroke=lost_stroke,
            profile=table.profile,
        )

    @property
    def energy(self) -> float:
        """Energy that it can give, J."""
        end = 1.0 - self.lost_stroke
        places, forces = zip(*self.profile, strict=True)
        within = [*(s for s in places if s < end), end]
        area = np.trapezoid(np.interp(within, places, forces), within)
        return self.force_max * self.stroke * float(area)
