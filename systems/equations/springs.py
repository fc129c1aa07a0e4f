"""The laws of separation springs, by time (Eq. 5) and by displacement, and their kinds.

The form of the laws, and the paper whose equations they number, are those of
`relative_motion`.
"""

import functools
import inspect
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from drakesep.systems.checks import InputError
from drakesep.systems.equations.pushers import PushLaw, positive_part
from drakesep.systems.model.connectors import Connector, Guide
from drakesep.systems.model.magnitudes import Kind
from drakesep.systems.model.parameter_table import Parameter
from drakesep.systems.model.profiles import Profile
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.separation import Attachment, Separation
from drakesep.systems.model.springs import (
    DisplacementSpring,
    Spring,
    push_duration,
    push_frequency,
    push_travel,
)
from drakesep.systems.vectors import Ops, Scalar


@dataclass(frozen=True)
class TimedSpringLaw(PushLaw):
    """The paper's spring: a cosine of the time since release, until it is zero."""

    by_time: ClassVar[bool] = True

    def end(self, p: Any, ops: Ops) -> Scalar:
        """Return the time from release to the end of the stroke, s."""
        return push_duration(p, ops)

    def force(
        self, p: Any, at: Scalar, speed: Scalar, passed: Sequence[Any], ops: Ops
    ) -> Scalar:
        """Return the force, N."""
        return p.force_max * ops.cos(push_frequency(p, ops) * at)  # Eq. 5

    def frequency(self, p: Any, count: int, lightness: Scalar, ops: Ops) -> Scalar:
        """Return the angular frequency of the force, rad/s."""
        return push_frequency(p, ops)

    def preload(self, p: Any) -> float:
        """Return the force at release, N."""
        return float(p.force_max)

    def ends_in_jump(self, p: Any) -> bool:
        """Return whether the spring is stuck before its end."""
        return bool(p.lost_stroke > 0.0)


@dataclass(frozen=True)
class DisplacementSpringLaw(PushLaw):
    """A force over the stroke, less a damper's.

    With `push_displacement` as its argument, the spring's work is exactly what its
    energy loses: the force acts along the axis on which displacement is measured.
    """

    profile: Profile
    ramps: tuple[tuple[float, float], ...] = field(repr=False)
    """The profile: where each of its ramps begins, and its slope."""

    by_time: ClassVar[bool] = False
    dampers: ClassVar[tuple[str, ...]] = ("damping",)

    @classmethod
    def of(cls, pusher: DisplacementSpring) -> "DisplacementSpringLaw":
        """Return the law of a record."""
        return cls(pusher.profile, tuple(_ramps(pusher.profile)))

    def end(self, p: Any, ops: Ops) -> Scalar:
        """Return the stroke without what is lost of it, m; below 0 of no force."""
        travel = (1.0 - p.lost_stroke) * p.stroke
        return push_travel(travel, p.force_max, p.damping)

    def stroke(self, p: Any, ops: Ops) -> Scalar:
        """Return the whole stroke, m."""
        return p.stroke

    def force(
        self, p: Any, at: Scalar, speed: Scalar, passed: Sequence[Any], ops: Ops
    ) -> Scalar:
        """Return the force, were it to pull, N."""
        # The first ramp is a line: a pad pressed in further is pushed harder.
        force = _along(self.profile, self.ramps, at / p.stroke, passed)
        return p.force_max * force - p.damping * speed

    def frequency(self, p: Any, count: int, lightness: Scalar, ops: Ops) -> Scalar:
        """Return that of both bodies on all springs, rad/s."""
        return ops.sqrt(count * (p.force_max / p.stroke) * lightness)

    def preload(self, p: Any) -> float:
        """Return the force with which the profile begins, N."""
        return float(p.force_max * self.profile[0][1])

    def energy(self, p: Any, displacement: Scalar) -> Scalar:
        """Return what the spring can give until it ends, J."""
        u, end = displacement / p.stroke, 1.0 - p.lost_stroke
        area: Scalar = self.profile[0][1] * (end - u)
        for u_i, slope in self.ramps:
            passed, all_of_it = (
                positive_part(x - u_i) if u_i > 0.0 else x - u_i for x in (u, end)
            )
            area = area + 0.5 * slope * (all_of_it**2 - passed**2)
        return p.force_max * p.stroke * area

    @functools.cached_property
    def corners(self) -> Sequence[float]:
        """Where the profile has kinks."""
        return [u for u, _ in self.profile[1:-1]]

    @functools.cached_property
    def way(self) -> int:
        """0 if the profile is negative somewhere: what pulls there is not let go."""
        return 0 if min(force for _, force in self.profile) < 0.0 else 1

    @property
    def may_lift(self) -> bool:
        """Whether the profile rises at first: a pad pressed in far might be pulled."""
        return self.ramps[0][1] > 0.0

    def ends_in_jump(self, p: Any) -> bool:
        """Return whether force is left at the end, or where the spring is stuck."""
        return bool(self.profile[-1][1] != 0.0 or p.lost_stroke > 0.0)


CREEP = 1e-3
"""Speed about which rubbing takes its full force, m/s: at rest it has no direction."""


def rubbed(force: Scalar, speed: Scalar, ops: Ops) -> Scalar:
    """Return the force of dry friction, N: against the motion, smooth through rest.

    Less than the full force by half of (CREEP / speed)^2; where it should hold, it lets
    creep, at speeds below `CREEP`.

    Args:
        force: that it takes to rub, N.
        speed: of the motion, m/s.
        ops: module of the elementary functions.
    """
    return -force * speed / ops.sqrt(speed * speed + CREEP * CREEP)


@dataclass(frozen=True)
class ConnectorLaw(PushLaw):
    """What resists once over its travel, as pins and seals do: it only dissipates."""

    profile: Profile
    ramps: tuple[tuple[float, float], ...] = field(repr=False)
    """The profile: where each of its ramps begins, and its slope."""

    by_time: ClassVar[bool] = False

    @classmethod
    def of(cls, pusher: Connector) -> "ConnectorLaw":
        """Return the law of a record."""
        return cls(pusher.profile, tuple(_ramps(pusher.profile)))

    def end(self, p: Any, ops: Ops) -> Scalar:
        """Return the travel, m; below 0 of no force."""
        return push_travel(p.travel, p.force_max)

    def stroke(self, p: Any, ops: Ops) -> Scalar:
        """Return the travel, m."""
        return p.travel

    def force(
        self, p: Any, at: Scalar, speed: Scalar, passed: Sequence[Any], ops: Ops
    ) -> Scalar:
        """Return the force, were it to resist pads that come back, too."""
        part = _along(self.profile, self.ramps, at / p.travel, passed)
        return rubbed(p.force_max * part, speed, ops)

    def frequency(self, p: Any, count: int, lightness: Scalar, ops: Ops) -> Scalar:
        """Return that of both bodies on springs of such forces and strokes, rad/s."""
        return ops.sqrt(count * (p.force_max / p.travel) * lightness)

    @functools.cached_property
    def corners(self) -> Sequence[float]:
        """Where the profile has kinks."""
        return [u for u, _ in self.profile[1:-1]]

    @property
    def way(self) -> int:
        """It only resists."""
        return -1

    @property
    def may_lift(self) -> bool:
        """Whether a pad may come back, which it does not resist."""
        return True

    def ends_in_jump(self, p: Any) -> bool:
        """Return whether the profile ends above zero."""
        return self.profile[-1][1] > 0.0


@dataclass(frozen=True)
class GuideLaw(ConnectorLaw):
    """Dry friction over a travel, either way."""

    @property
    def way(self) -> int:
        """It resists either."""
        return 0

    @property
    def may_lift(self) -> bool:
        """Nothing lifts off."""
        return False


def _along(
    profile: Profile,
    ramps: Sequence[tuple[float, float]],
    u: Scalar,
    passed: Sequence[Any],
) -> Scalar:
    """Return a profile at a part of its stroke, of which some corners are passed."""
    value: Scalar = profile[0][1]
    for (u_i, slope), acts in zip(ramps, (True, *passed), strict=True):
        value = value + slope * (u - u_i) * acts
    return value


def _ramps(profile: Profile) -> list[tuple[float, float]]:
    """Return a piecewise straight line as ramps: where each begins, and its slope."""
    rows, before = [], 0.0
    for (s0, f0), (s1, f1) in itertools.pairwise(profile):
        slope = (f1 - f0) / (s1 - s0)
        rows.append((s0, slope - before))
        before = slope
    return rows


@dataclass(frozen=True, eq=False)
class PusherKind:
    """A kind of pusher: its record, its law, and how it is made from a case file."""

    record: type[Any]
    law: type[PushLaw]
    make: Callable[..., Any] | None = None
    """Makes the record of keyword arguments; None: the record itself."""
    columns: Mapping[str, Kind] = field(default_factory=dict)
    """Arguments of it that are columns of numbers, and what these measure."""

    @property
    def maker(self) -> Callable[..., Any]:
        """What makes the record."""
        return self.make or self.record

    @functools.cached_property
    def arguments(self) -> dict[str, bool]:
        """Its arguments, columns and parameters, and whether it needs each."""
        known = {*self.columns, *self.record.PARAMETERS.by_field}
        return {
            name: argument.default is argument.empty
            for name, argument in inspect.signature(self.maker).parameters.items()
            if name in known
        }

    def parameter(self, argument: str) -> Parameter:
        """Return the parameter that an argument gives, which holds one number."""
        [parameter] = self.record.PARAMETERS.by_field[argument]
        return parameter


PUSHERS: dict[str, PusherKind] = {
    "time": PusherKind(Spring, TimedSpringLaw),
    "displacement": PusherKind(DisplacementSpring, DisplacementSpringLaw),
    "table": PusherKind(
        DisplacementSpring,
        DisplacementSpringLaw,
        DisplacementSpring.from_table,
        {"displacements": "length", "forces": "force"},
    ),
    "connector": PusherKind(Connector, ConnectorLaw),
    "guide": PusherKind(Guide, GuideLaw),
    "connector_table": PusherKind(
        Connector,
        ConnectorLaw,
        Connector.from_table,
        {"displacements": "length", "forces": "force"},
    ),
}
"""All kinds, by the name of their law. A new kind is a record, a law and an entry."""


_BUILT_IN = dict(PUSHERS)


def own_pushers() -> dict[str, PusherKind]:
    """Return the kinds that are not drakesep's own, or in place of these."""
    known = PUSHERS.items()
    return {name: kind for name, kind in known if _BUILT_IN.get(name) is not kind}


def forget_own_pushers() -> None:
    """Leave the kinds that are drakesep's own alone, as they were."""
    PUSHERS.clear()
    PUSHERS.update(_BUILT_IN)


def law_name(pusher: Pusher) -> str:
    """Return the name under which the kind of a pusher is registered.

    Raises:
        ValueError: it is of no registered kind.
    """
    for name, kind in PUSHERS.items():
        if type(pusher) is kind.record:
            return name
    raise InputError(
        f"{pusher.name}: must be of a registered kind ({', '.join(PUSHERS)}), got a "
        f"{type(pusher).__name__}"
    )


def is_held_back(separation: Separation, attachment: Attachment) -> bool:
    """Return whether something between an attachment's bodies pulls, or resists.

    They need not part then, although all has let go.
    """
    ends = {attachment.A, attachment.B}
    return any(
        law_of(pusher).way < 1
        for other, pusher in separation.pushing
        if {other.A, other.B} == ends
    )


def law_of(pusher: Pusher) -> PushLaw:
    """Return the law of a pusher."""
    return PUSHERS[law_name(pusher)].law.of(pusher)
