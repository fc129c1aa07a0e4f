"""Connectors and guides: what resists as B leaves, as pins, seals and rails do."""

from dataclasses import dataclass
from typing import ClassVar, Self

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import X_AXIS, Vector3, unit_vector
from drakesep.systems.model.parameter_table import (
    NOT_NEGATIVE,
    POSITIVE,
    ParameterTable,
    scalar,
)
from drakesep.systems.model.profiles import (
    CONSTANT,
    Profile,
    check_profile,
    read_table,
)
from drakesep.systems.model.pushers import TILTS


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Connector:
    """What resists the motion of B along its axis over its travel, once.

    Its force is against the motion and follows a profile over the travel, one way
    alone: it does not resist a pad that comes back. It only dissipates. Beyond the
    travel it is gone. As all that pushes it acts from its attachment's release on.

    Raises:
        ValueError: the travel is not positive, the force is negative, the profile does
            not run from 0 to 1 with forces from 0 to 1, or a tilt is a right angle or
            more.
    """

    name: str
    force_max: float
    """Largest force with which it resists, N; 0: none, and it is gone at release."""
    travel: float
    """Displacement at which it is gone, m."""
    profile: Profile = CONSTANT
    """A part of the design: it does not vary."""
    axis_A: Vector3 = X_AXIS
    """Unit vector along which B leaves it, fixed in A: a part of the design."""
    tilt_y: float = 0.0
    """Of that from its axis, about y, rad: a misalignment."""
    tilt_z: float = 0.0
    """About z, then, rad."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        scalar("force_max", "force", NOT_NEGATIVE, label="maximum force"),
        scalar("travel", "length", POSITIVE),
        *TILTS,
    )

    def __post_init__(self) -> None:
        """Check the values."""
        self.PARAMETERS.check(f"{self.name}: ", self)
        axis = unit_vector(f"{self.name}: axis", self.axis_A)
        object.__setattr__(self, "axis_A", axis)
        check_profile(f"{self.name}: profile", self.profile)

    @property
    def duration(self) -> None:
        """None: its travel ends it."""

    @classmethod
    def from_table(
        cls,
        *,
        name: str,
        displacements: tuple[float, ...],
        forces: tuple[float, ...],
        axis_A: Vector3 = X_AXIS,
        tilt_y: float = 0.0,
        tilt_z: float = 0.0,
    ) -> Self:
        """Return what a measured table of force over travel says.

        Args:
            name: of the connector.
            displacements: (n,) of the rows, from 0, increasing, m.
            forces: (n,) with which it resists at these displacements, N.
            axis_A: unit vector along which B leaves it, fixed in A.
            tilt_y: of that from its axis, about y, rad: a misalignment.
            tilt_z: about z, then, rad.

        Raises:
            ValueError: the columns differ in length, or do not make a profile.
        """
        travel, force_max, profile = read_table(name, displacements, forces)
        return cls(
            name=name,
            force_max=force_max,
            travel=travel,
            axis_A=axis_A,
            tilt_y=tilt_y,
            tilt_z=tilt_z,
            profile=profile,
        )


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Guide(Connector):
    """A guide that rubs over its travel with dry friction, whichever way B slides.

    As a connector, but for what comes back: that it resists, too. It does not lead: a
    joint does that, at an attachment of its own. Its force, mu N of a guide that is
    pressed with N, is given.
    """
