"""What pushers do: the protocol of their laws, and the wrenches that come of it.

A law says which force a pusher gives, what ends its push, and where the force has
kinks; those of separation springs are in `drakesep.systems.equations.springs`. Where it
pushes and along which axis is the same for all, and stands here. The form of the
functions, and the paper whose equations they number, are those of `relative_motion`.
"""

import functools
import math
from abc import ABC, abstractmethod
from collections import namedtuple
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple, TypeAlias

from drakesep.systems.checks import X_AXIS
from drakesep.systems.equations.mated_stack import mated_ends, pad_on_B
from drakesep.systems.equations.relative_motion import BodyState, Wrench, velocity_at
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.separation import Attachment, Separation
from drakesep.systems.vectors import (
    Ops,
    Rotation,
    Scalar,
    Vector,
    add,
    cross,
    dot,
    negate,
    rotate,
    scale,
    subtract,
)


class PushLaw(ABC):
    """The law of a pusher: made of its design, which does not vary.

    `p` holds the parameters under the names of the record's fields: the record itself,
    floats, or lanes. Laws compare by value.
    """

    by_time: ClassVar[bool]
    """Whether the force depends on the time since release; if not, on how far, and how
    fast, the pad has moved along the axis."""
    dampers: ClassVar[tuple[str, ...]] = ()
    """Parameters without which, all of them zero, the force is never of the other sign
    before the end, unless it `may_lift` even so."""

    @classmethod
    def of(cls, pusher: Any) -> "PushLaw":
        """Return the law of a record."""
        return cls()

    @abstractmethod
    def end(self, p: Any, ops: Ops) -> Scalar:
        """Return the time since release, s, or the displacement, m, that ends it."""

    @abstractmethod
    def force(
        self, p: Any, at: Scalar, speed: Scalar, passed: Sequence[Any], ops: Ops
    ) -> Scalar:
        """Return the force before the end, N.

        It is smooth: which of its pieces acts is told by the corners that are passed,
        and each piece goes on beyond its corners and beyond the end, where a step of an
        integrator may look before it is cut. One by displacement acts its `way` alone:
        where this is of the other sign, the pad has lifted off.

        Args:
            p: the parameters.
            at: time since release, s, or displacement, m.
            speed: of the displacement, m/s; 0 for a law by time.
            passed: whether each of its corners is passed.
            ops: module of the elementary functions.
        """

    @abstractmethod
    def frequency(self, p: Any, count: int, lightness: Scalar, ops: Ops) -> Scalar:
        """Return how fast the motion is that it drives, rad/s: for a first step.

        Args:
            p: the parameters.
            count: of pushers that may push together.
            lightness: sum of the inverse masses of both bodies, 1/kg.
            ops: module of the elementary functions.
        """

    def preload(self, p: Any) -> float:
        """Return the force with which it presses while its attachment holds, N."""
        return 0.0

    def energy(self, p: Any, displacement: Scalar) -> Scalar:
        """Return what it stores before the end, J; 0 of a law by time."""
        return 0.0

    def stroke(self, p: Any, ops: Ops) -> Scalar:
        """Return the displacement of which its corners are parts, m."""
        return self.end(p, ops)

    @property
    def corners(self) -> Sequence[float]:
        """Parts of the stroke at which the force has a kink."""
        return ()

    def passed(self, p: Any, at: Scalar, ops: Ops) -> list[Any]:
        """Return whether each corner is passed at a displacement, m."""
        return [at / self.stroke(p, ops) >= corner for corner in self.corners]

    @property
    def way(self) -> int:
        """1 if it pushes alone, -1 if it pulls alone, 0 if it does either.

        Of the other sign the force does not act. By time it acts as it is.
        """
        return 1

    def acting(self, force: Scalar) -> Scalar:
        """Return what acts of a force by displacement: its own way alone."""
        return self.way * positive_part(self.way * force) if self.way else force

    @property
    def may_lift(self) -> bool:
        """Whether the force may be of the other sign before the end without damper."""
        return False

    def ends_in_jump(self, p: Any) -> bool:
        """Return whether force is left where it ends; of floats."""
        return False


class _Asked:
    """A record that notes which of its fields are asked for."""

    def __init__(self, record: Any):
        self._record = record
        self.fields: set[str] = set()

    def __getattr__(self, field: str) -> Any:
        self.fields.add(field)
        return getattr(self._record, field)


def values_of(law: PushLaw, pusher: Pusher) -> Any:
    """Return the parameters of a pusher that its law reads, as a named tuple.

    The law is asked for everything once. What it does not read has no effect: it is
    none of the engines' parameters, and an error where it is named.
    """
    asked = _Asked(pusher)
    law.end(asked, math)
    law.force(asked, 0.0, 0.0, [False] * len(law.corners), math)
    law.energy(asked, 0.0)
    fields = tuple(f for f in pusher.PARAMETERS.by_field if f in asked.fields)
    values = _values_type(type(pusher).__name__, fields)
    return values(*(getattr(pusher, field) for field in fields))


@functools.cache
def _values_type(name: str, fields: tuple[str, ...]) -> Callable[..., Any]:
    return namedtuple(name, fields)


_OPPOSITE = 1e-12
"""Within this of it, an axis is the opposite of the x axis."""
AXIS = ("tilt_y", "tilt_z")
"""Fields of a pusher that turn its axis."""


class PushPlace(NamedTuple):
    """Where a pusher stands, while mated, and along which axis it pushes."""

    p_AoPad_A: Vector
    """Its pad in A, m."""
    p_BoPad_B: Vector
    """Its pad in B, m."""
    axis_A: Vector


def push_place(
    separation: Separation, attachment: Attachment, pusher: Pusher
) -> PushPlace:
    """Return where the pusher of an attachment stands."""
    pad_A = attachment.p_AoPad_A
    return PushPlace(
        pad_A,
        pad_on_B(*mated_ends(separation, attachment), pad_A),
        push_axis(pusher.axis_A, pusher.tilt_y, pusher.tilt_z, math),
    )


def push_axis(design_A: Vector, tilt_y: Scalar, tilt_z: Scalar, ops: Ops) -> Vector:
    """Return the axis in A along which a pusher pushes: R Rz(tilt_z) Ry(tilt_y) x.

    R turns A's axes the shortest way until their x axis is that of the design; for one
    against A's x axis, about z.

    Args:
        design_A: unit vector along which it pushes if it is not tilted.
        tilt_y: about the y axis so turned, rad.
        tilt_z: about the z axis so turned, then, rad.
        ops: module of the elementary functions.
    """
    c = ops.cos(tilt_y)
    tilted = c * ops.cos(tilt_z), c * ops.sin(tilt_z), -ops.sin(tilt_y)
    return tilted if design_A == X_AXIS else rotate(from_x_axis(design_A), tilted)


def from_x_axis(axis: Vector) -> Rotation:
    """Return the shortest rotation from the x axis to another; about z to its opposite.

    Args:
        axis: unit vector.
    """
    x, y, z = axis
    if 1.0 + x < _OPPOSITE:
        return -1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0
    k = 1.0 / (1.0 + x)  # Rodrigues: I + [v] + k [v]^2, of v = e_x x axis
    return (x, -y, -z, y, 1.0 - k * y * y, -k * y * z, z, -k * y * z, 1.0 - k * z * z)


def _axis_W(A: BodyState, axis_A: Vector | None) -> Vector:
    if axis_A is None:
        return A.R_WB[0], A.R_WB[3], A.R_WB[6]
    return rotate(A.R_WB, axis_A)


def push_displacement(
    A: BodyState,
    B: BodyState,
    p_AoPad_A: Vector,
    p_BoPad_B: Vector,
    axis_A: Vector | None = None,
) -> tuple[Scalar, Scalar]:
    """Return how far, m, and how fast, m/s, B's pad has moved along the push's axis.

    Args:
        A: body pushed from.
        B: body pushed away.
        p_AoPad_A: mated place of the pad in A, m.
        p_BoPad_B: the pad, fixed in B, m.
        axis_A: of the push, in A; A's x axis if None.
    """
    r_B = rotate(B.R_WB, p_BoPad_B)
    r_A = subtract(add(B.p_WBo, r_B), A.p_WBo)
    v_APad = subtract(velocity_at(B, r_B), velocity_at(A, r_A))
    axis_W = _axis_W(A, axis_A)
    mated = p_AoPad_A[0] if axis_A is None else dot(axis_A, p_AoPad_A)
    return dot(axis_W, r_A) - mated, dot(axis_W, v_APad)


def time_to_go(left: float, speed: float, acceleration: float) -> float:
    """Return in which time what is left of a way is gone, s; infinite if it is not.

    Args:
        left: m; 0 or less if it is gone.
        speed: m/s.
        acceleration: m/s^2.
    """
    if left <= 0.0:
        return 0.0
    square = speed * speed + 2.0 * acceleration * left
    steepness = speed + math.sqrt(max(square, 0.0))
    return 2.0 * left / steepness if square >= 0.0 < steepness else math.inf


def positive_part(x: Scalar) -> Scalar:
    """Return the larger of x and 0, of floats and of lanes."""
    return 0.5 * (x + abs(x))


class Pushing(NamedTuple):
    """A pusher that has been released, in numbers."""

    values: Any
    """Its parameters, as its law takes them."""
    end: Scalar
    """What ends it, as its law has it: s since its release, or m."""
    released: Scalar
    """s."""
    p_AoPad_A: Vector
    """Place of its pad in A, while mated, m."""
    p_BoPad_B: Vector
    """Place of its pad in B, m."""
    axis_A: Vector | None
    """Along which it pushes; None if it is A's x axis."""


def push_progress(
    law: PushLaw, push: Pushing, A: BodyState, B: BodyState, t: Scalar
) -> tuple[Scalar, Scalar]:
    """Return how far a push has gone, s or m, and how fast.

    Args:
        law: of the pusher.
        push: its numbers.
        A: body pushed from; a law by time reads neither.
        B: body pushed away.
        t: time, s.
    """
    if law.by_time:
        return t - push.released, 0.0
    return push_displacement(A, B, push.p_AoPad_A, push.p_BoPad_B, push.axis_A)


def is_push_over(law: PushLaw, push: Pushing, at: Scalar, t: Scalar) -> Any:
    """Return whether a push that has gone so far, s or m, has ended."""
    if law.by_time:
        return t >= push.released + push.end  # to the last digit, as is stepped to
    return at >= push.end


def push_force(
    law: PushLaw,
    jumps: bool,
    push: Pushing,
    A: BodyState,
    B: BodyState,
    t: Scalar,
    ops: Ops,
) -> Scalar:
    """Return the force of a pusher, N; nothing from the end of its push on.

    Args:
        law: of the pusher.
        jumps: whether it is one by time that ends in a jump, which ends a step: until
            then all is smooth.
        push: its numbers.
        A: body pushed from.
        B: body pushed away.
        t: time, s.
        ops: module of the elementary functions.
    """
    at, speed = push_progress(law, push, A, B, t)
    corners = law.passed(push.values, at, ops)
    force = law.force(push.values, at, speed, corners, ops)
    if jumps:
        return force
    acting = force if law.by_time else law.acting(force)
    return acting * (1 - is_push_over(law, push, at, t))


Push: TypeAlias = tuple[Scalar, Vector, Vector | None]
"""A pusher's force, N, its pad, fixed in B, m, and its axis in A; None: A's x axis."""


def push_wrenches(
    A: BodyState, B: BodyState, pushes: Sequence[Push]
) -> tuple[Wrench, Wrench]:
    """Return the wrenches on A and B of pushers.

    Each force acts on B at its pad and on A at the same point in space. Those along A's
    x axis are parallel, so their sum and their first moment in B are all it takes.

    Args:
        A: body pushed from; it gives the directions.
        B: body pushed away.
        pushes: of the pushers.
    """
    total = moment_x = moment_y = moment_z = 0.0
    tilted = []
    for force, (x, y, z), axis_A in pushes:
        if axis_A is not None:
            tilted.append((scale(force, rotate(A.R_WB, axis_A)), (x, y, z)))
            continue
        total = total + force
        moment_x = moment_x + force * x
        moment_y = moment_y + force * y
        moment_z = moment_z + force * z
    e_xA = _axis_W(A, None)
    force_W = scale(total, e_xA)
    torque_B = cross(rotate(B.R_WB, (moment_x, moment_y, moment_z)), e_xA)
    for push_W, pad_B in tilted:
        force_W = add(force_W, push_W)
        torque_B = add(torque_B, cross(rotate(B.R_WB, pad_B), push_W))
    torque_A = add(torque_B, cross(subtract(B.p_WBo, A.p_WBo), force_W))
    return Wrench(negate(torque_A), negate(force_W)), Wrench(torque_B, force_W)
