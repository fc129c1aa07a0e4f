"""Forces and torques over time: thrusters, retro-rockets, disturbances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias, get_args

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    Vector3,
    check_entries,
    check_finite,
    check_not_negative,
    check_unit,
    unknown,
)
from drakesep.systems.model.magnitudes import Kind, check_within
from drakesep.systems.model.parameter_table import (
    NOT_NEGATIVE,
    XYZ,
    ParameterTable,
    scalar,
    vector,
)
from drakesep.systems.vectors import scale


Axes: TypeAlias = Literal["body", "world"]
AXES: tuple[str, ...] = get_args(Axes)
_ZERO = (0.0, 0.0, 0.0)
_COLUMNS: dict[str, Kind] = {"forces": "force", "torques": "torque"}


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Load:
    """A force and a torque on a body, given by a table over time.

    Straight lines join the rows; before the first and after the last the load is zero.
    The body's mass does not change: a burn is short.

    Raises:
        ValueError: the columns differ in length, the times do not increase from zero or
            later, or a value is not finite.
    """

    name: str
    body: str
    """Name of the body that feels it."""
    p_BoQ_B: Vector3 = _ZERO
    """Where the force acts, fixed in the body, m."""
    axes: Axes = "body"
    """Of forces and torques: the body's, or the world's."""
    times: tuple[float, ...]
    """(n,) increasing, from the start, s."""
    forces: tuple[Vector3, ...] = ()
    """(n, 3), N; empty: none."""
    torques: tuple[Vector3, ...] = ()
    """(n, 3), N m; empty: none."""
    start: float = 0.0
    """When the table begins: in the run, or after the release of `after`, s."""
    after: str | None = None
    """Name of the attachment whose release starts the table."""
    factor: float = 1.0
    """On forces and torques."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        *vector("position", "p_BoQ_B", XYZ, "length"),
        scalar("start", "time", NOT_NEGATIVE),
        scalar("factor", "factor"),
    )

    def __post_init__(self) -> None:
        """Check the values, and fill in the column that is not given."""
        if self.axes not in AXES:
            raise InputError(f"{self.name}: {unknown('axes', self.axes, AXES)}")
        self.PARAMETERS.check(f"{self.name}: ", self)
        check_within("time", f"{self.name}: times", *self.times)
        if len(self.times) < 2 or list(self.times) != sorted(set(self.times)):
            raise InputError(
                f"{self.name}: times must be two or more and increase, "
                f"got {', '.join(f'{t:g}' for t in self.times)}"
            )
        check_not_negative(f"{self.name}: first time", self.times[0])
        if not len(self.forces) and not len(self.torques):
            raise InputError(f"{self.name}: must have forces or torques, got none")
        for column, kind in _COLUMNS.items():
            rows = getattr(self, column) or (_ZERO,) * len(self.times)
            if len(rows) != len(self.times):
                raise InputError(
                    f"{self.name}: {column} must have a row for each of the "
                    f"{len(self.times)} times, got {len(rows)}"
                )
            for row in rows:
                check_entries(f"{self.name}: {column}", row, 3)
                check_within(kind, f"{self.name}: {column}", *row)
            object.__setattr__(self, column, tuple(map(tuple, rows)))

    def acts_after(self, row: int) -> bool:
        """Return whether the load acts between a row of its table and the next."""
        return row + 1 < len(self.times) and any(
            any((*self.forces[i], *self.torques[i])) for i in (row, row + 1)
        )

    @property
    def kinks(self) -> tuple[float, ...]:
        """Times in the table at which the load jumps or changes its slope, s."""
        return tuple(
            t
            for i, t in enumerate(self.times)
            if (i > 0 and self.acts_after(i - 1)) or self.acts_after(i)
        )


@typed
def thruster(
    *,
    name: str,
    body: str,
    p_BoQ_B: Vector3,
    direction_B: Vector3,
    times: Sequence[float],
    thrusts: Sequence[float],
    start: float = 0.0,
    after: str | None = None,
) -> Load:
    """Return the load of a thruster or a retro-rocket, fixed in its body.

    Args:
        name: of the thruster.
        body: name of its body.
        p_BoQ_B: where it acts, m.
        direction_B: unit vector along which it pushes its body.
        times: (n,) increasing, s.
        thrusts: (n,) N.
        start: when the table begins, s; see `Load`.
        after: name of the attachment whose release ignites it.

    Raises:
        ValueError: the direction is not of unit length, or as for `Load`.
    """
    check_unit(f"{name}: direction", direction_B)
    if len(thrusts) != len(times):
        raise InputError(
            f"{name}: thrusts must be as many as the {len(times)} times, "
            f"got {len(thrusts)}"
        )
    check_finite(f"{name}: thrust", *thrusts)
    x, y, z = scale(1.0 / math.hypot(*direction_B), direction_B)
    return Load(
        name=name,
        body=body,
        p_BoQ_B=p_BoQ_B,
        times=tuple(times),
        forces=tuple((f * x, f * y, f * z) for f in thrusts),
        start=start,
        after=after,
    )
