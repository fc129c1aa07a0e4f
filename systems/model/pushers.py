"""What all that pushes has in common: springs, and whatever else there will be.

A pusher stands at an attachment, and pushes B from A once that is released. Its record
says what it is; its law (see `drakesep.systems.equations.pushers`) what it does. Both
are registered under one name in `drakesep.systems.equations.springs`.
"""

from typing import ClassVar, Protocol

from drakesep.systems.checks import Vector3
from drakesep.systems.model.parameter_table import TILT, ParameterTable, scalar


TILTS = (
    scalar("tilt", "angle", TILT, axis="y"),
    scalar("tilt", "angle", TILT, axis="z"),
)
"""Of a pusher's axis; entries of every table."""
TILT_TABLE = ParameterTable(*TILTS)
"""What all pushers have."""


class Pusher(Protocol):
    """The record of a pusher."""

    PARAMETERS: ClassVar[ParameterTable]

    @property
    def name(self) -> str:
        """Of the pusher, unlike all others of the separation."""
        ...

    @property
    def axis_A(self) -> Vector3:
        """Unit vector along which it pushes B, fixed in A: a part of the design."""
        ...

    @property
    def tilt_y(self) -> float:
        """Of the push from that axis, about y, rad: a misalignment.

        About A's y axis where the axis is A's x axis; see
        `drakesep.systems.equations.pushers.push_axis`.
        """
        ...

    @property
    def tilt_z(self) -> float:
        """About z, then, rad."""
        ...

    @property
    def duration(self) -> float | None:
        """Time from release to the end of the push, s; None: a displacement ends it."""
        ...
