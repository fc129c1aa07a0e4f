"""Joints by constraint forces: which directions they hold, and with which gains.

The Constraint Force Equation (CFE) method writes a joint as equations of translation,
(x_B - x_A) . e_A = 0 (Eq. 1), and of rotation, e_A . e_B = 0 (Eq. 2). Here each of them
is held by a spring and a damper (Eq. 3-4).
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, get_args

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    DECIMALS,
    InputError,
    Vector3,
    check_entries,
    check_not_negative,
    check_unit,
    unknown,
)
from drakesep.systems.model.magnitudes import Kind, check_within
from drakesep.systems.vectors import Rotation, cross, dot, scale, subtract


JointType: TypeAlias = Literal[
    "fixed",
    "revolute",
    "universal",
    "spherical",
    "prismatic",
    "cylindrical",
    "planar",
]
JOINT_TYPES: tuple[str, ...] = get_args(JointType)
Gains: TypeAlias = float | Vector3
"""Along x, y and z of the joint's frame; one number stands for all three."""


class Constraints(NamedTuple):
    """Which directions of its frame a joint holds."""

    translation: tuple[bool, bool, bool]
    """One equation each (Eq. 1)."""
    rotation: tuple[bool, bool, bool]
    """One equation each (Eq. 2)."""


_A_AXES = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
_ALL, _NONE = (True, True, True), (False, False, False)
_NOT_X = (False, True, True)
_NO_GAINS = (0.0, 0.0, 0.0)
CONSTRAINTS: dict[JointType, Constraints] = {
    "fixed": Constraints(_ALL, _ALL),
    "revolute": Constraints(_ALL, _NOT_X),
    "universal": Constraints(_ALL, (False, False, True)),
    "spherical": Constraints(_ALL, _NONE),
    "prismatic": Constraints(_NOT_X, _ALL),
    "cylindrical": Constraints(_NOT_X, _NOT_X),
    "planar": Constraints((True, False, False), _NOT_X),
}
"""A revolute joint turns about x, a universal one about x (fixed in A) and y (fixed in
B); a prismatic one slides along x, a cylindrical one also turns about it, and a planar
one slides across x and turns about it."""


def holds_all_rotations(joint_type: JointType) -> bool:
    """Return whether joints of a type hold the three rotations."""
    return all(CONSTRAINTS[joint_type].rotation)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """A joint by constraint forces: its type, its frame and its gains, Eq. 3-4.

    Or a rigid one, which holds Eq. 1 and 2 exactly, and has no gains. Gains of
    directions that the type leaves free are not used.

    Raises:
        ValueError: the type is unknown, a gain is missing, negative or not finite, a
            rigid joint has one, or the axes are not of unit length or not at a right
            angle.
    """

    type: JointType = "fixed"
    rigid: bool = False
    """Whether it holds exactly."""
    K_F: Gains | None = None
    """Stiffness in translation, N/m; zero of a rigid joint, as the others."""
    D_F: Gains | None = None
    """Damping in translation, N s/m."""
    K_T: Gains | None = None
    """Stiffness in rotation, N m/rad."""
    D_T: Gains | None = None
    """Damping in rotation, N m s/rad."""
    x_axis_A: Vector3 = (1.0, 0.0, 0.0)
    """The x axis of the joint's frame, in A."""
    y_axis_A: Vector3 = (0.0, 1.0, 0.0)
    """Its y axis, in A; z completes them."""

    def __post_init__(self) -> None:
        """Check the values; write each gain as three, and the axes at full length."""
        if self.type not in JOINT_TYPES:
            raise InputError(f"joint: {unknown('type', self.type, JOINT_TYPES)}")
        for name, kind in _KINDS.items():
            gains = getattr(self, name)
            if self.rigid:
                if gains not in (None, _NO_GAINS):
                    raise InputError(
                        f"joint {name}: a rigid joint has none, got {gains}"
                    )
                gains = _NO_GAINS
            if gains is None:
                raise InputError(f"joint {name}: missing, and the joint is not rigid")
            if not isinstance(gains, tuple | list):
                gains = (gains,) * 3
            check_entries(f"joint {name}", gains, 3)
            for gain in gains:
                check_not_negative(f"joint {name}", gain)
            check_within(kind, f"joint {name}", *gains)
            object.__setattr__(self, name, tuple(gains))
        check_unit("joint x axis", self.x_axis_A)
        check_unit("joint y axis", self.y_axis_A)
        cosine = dot(self.x_axis_A, self.y_axis_A)
        if abs(cosine) > DECIMALS:
            raise InputError(
                "joint axes x and y must be at a right angle, got "
                f"{math.degrees(math.acos(cosine)):.6g} deg between {self.x_axis_A} "
                f"and {self.y_axis_A}"
            )
        # Axes in decimals would pull at their joint while it is mated.
        x = scale(1.0 / math.hypot(*self.x_axis_A), self.x_axis_A)
        y = subtract(self.y_axis_A, scale(dot(x, self.y_axis_A), x))
        object.__setattr__(self, "x_axis_A", x)
        object.__setattr__(self, "y_axis_A", scale(1.0 / math.hypot(*y), y))

    @property
    def constraints(self) -> Constraints:
        """Which directions it holds."""
        return CONSTRAINTS[self.type]

    @property
    def holds(self) -> bool:
        """Whether it holds anything: it is rigid, or has stiffness or damping."""
        return self.rigid or any(any(gains) for gains in self.held_gains())

    @property
    def R_AJ(self) -> Rotation:
        """Orientation of the joint's frame in A."""
        x, y = self.x_axis_A, self.y_axis_A
        z = cross(x, y)
        return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]

    @property
    def R_AJ_if_turned(self) -> Rotation | None:
        """The same; None where the frame is that of A: nothing to rotate."""
        return None if self.R_AJ == _A_AXES else self.R_AJ

    def held_gains(self) -> tuple[Vector3, Vector3, Vector3, Vector3]:
        """Return K_F, D_F, K_T, D_T, (4, 3), with zero along free directions."""
        translation, rotation = self.constraints
        return (
            _held(self.K_F, translation),
            _held(self.D_F, translation),
            _held(self.K_T, rotation),
            _held(self.D_T, rotation),
        )


_KINDS: dict[str, Kind] = {
    "K_F": "stiffness",
    "D_F": "damping",
    "K_T": "angular_stiffness",
    "D_T": "angular_damping",
}
"""What the gains measure."""


def _held(gains: Gains | None, directions: tuple[bool, bool, bool]) -> Vector3:
    assert isinstance(gains, tuple)  # since Joint's own check
    x, y, z = (
        gain if held else 0.0 for gain, held in zip(gains, directions, strict=True)
    )
    return x, y, z
