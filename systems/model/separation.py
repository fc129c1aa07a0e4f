"""The description of one separation: bodies, attachments, springs, orbit.

Frozen records in SI and radians, free of Drake, that check themselves, can be
pickled and compare by value. Frames: A is the body pushed from, B the body pushed
away, W the freely falling world (see docs/frames.md).
"""

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    DECIMALS,
    X_AXIS,
    InputError,
    Vector3,
    check_entries,
    unit_vector,
    unknown,
)
from drakesep.systems.model.inertia import ENTRIES, Inertia, check_inertia
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.magnitudes import check_size, check_within
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parameter_table import (
    NOT_NEGATIVE,
    POSITIVE,
    ROLL_PITCH_YAW,
    TURN,
    XYZ,
    ParameterTable,
    scalar,
    vector,
)
from drakesep.systems.model.parts import Part
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.vectors import cross, subtract


STACK = "before_separation"
"""Stands before the parameters of the mated stack's motion."""
RESERVED_NAMES = (STACK, "world")
"""Names that no part can have; the second is Drake's."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A rigid body and its place in the mated stack.

    Raises:
        ValueError: a value is not finite, the mass is not positive, or no rigid
            body has such an inertia.
    """

    name: str
    mass: float
    """kg."""
    p_BoBcm_B: Vector3
    """CG from the body's origin, m."""
    I_BBcm_B: Inertia
    """Inertia about the CG in body axes, kg m^2."""
    p_ABo: Vector3 = (0.0, 0.0, 0.0)
    """Place of the body's origin in the frame of A while mated, m."""
    rpy_AB: Vector3 = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of the body in the frame of A while mated, rad."""
    mated_offset: Vector3 = (0.0, 0.0, 0.0)
    """By how much it sits beside its place while mated, in A, m."""
    mated_misalignment: Vector3 = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw by which it is turned from its attitude while mated, about
    its own origin and axes, rad. What hangs on it is displaced with it."""
    spin: float = 0.0
    """At which it turns in the mated stack, about the x axis of the joint that holds
    it, rad/s; see `Separation.spins_on`."""
    parts: tuple[Part, ...] = ()
    """Parts of it that may come near others."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        scalar("mass", "mass", POSITIVE),
        *vector("cg", "p_BoBcm_B", XYZ, "length", label="CG"),
        *vector("inertia", "I_BBcm_B", ENTRIES, "inertia"),
        *vector("mated_offset", "mated_offset", XYZ, "length", label="mated offset"),
        *vector(
            "mated_misalignment",
            "mated_misalignment",
            ROLL_PITCH_YAW,
            "angle",
            label="mated misalignment",
        ),
        scalar("spin", "angular_rate"),
    )

    def __post_init__(self) -> None:
        """Check the values."""
        self.PARAMETERS.check(f"{self.name}: ", self)
        check_inertia(f"{self.name}: inertia", self.I_BBcm_B)
        check_entries(f"{self.name}: mated position", self.p_ABo, 3)
        check_entries(f"{self.name}: mated attitude", self.rpy_AB, 3)
        check_within("length", f"{self.name}: mated position", *self.p_ABo)
        check_within("angle", f"{self.name}: mated attitude", *self.rpy_AB)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Attachment:
    """A place where B is held to A, and pushed from it by a spring after release.

    It lets go at its release time, or once its joint has turned by its release angle or
    slid by its release travel, whichever comes first; a signal of the surrounding
    diagram takes the place of the time (see `Release`). With none of them, and without
    such a signal, it never lets go.

    Raises:
        ValueError: a value is not finite, both bodies are the same, or it lets go at an
            angle about which its joint does not turn, or after a travel along which it
            does not slide.
    """

    name: str
    A: str
    """Name of the body pushed from."""
    B: str
    """Name of the body pushed away."""
    p_AoPad_A: Vector3
    """Place in A, m; the pad on B is where it coincides with this while mated."""
    joint: Joint
    spring: Pusher | None = None
    release_time: float = 0.0
    """s; infinite: not by time."""
    release_angle: float = math.inf
    """About the joint's x axis, either way, rad; infinite: not by angle."""
    release_travel: float = math.inf
    """Of B's pad along the joint's x axis, either way, m; infinite: not by travel."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        *vector("position", "p_AoPad_A", XYZ, "length"),
        scalar("release_time", "time", NOT_NEGATIVE, optional=True),
        scalar("release_angle", "angle", TURN, optional=True),
        scalar("release_travel", "length", POSITIVE, optional=True),
    )

    def __post_init__(self) -> None:
        """Check the values."""
        self.PARAMETERS.check(f"{self.name}: ", self)
        if self.release_angle != math.inf:
            self._check_hinge()
        if self.release_travel != math.inf:
            self._check_rail()
        if self.A == self.B:
            raise InputError(
                f"{self.name}: must join two different bodies, got {self.A!r} twice"
            )

    @property
    def lets_go(self) -> bool:
        """Whether it may let go by itself: at a time, an angle or after a travel."""
        times_and_ways = self.release_time, self.release_angle, self.release_travel
        return any(map(math.isfinite, times_and_ways))

    @property
    def released_by_motion(self) -> bool:
        """Whether it may let go at an angle or after a travel."""
        return math.isfinite(min(self.release_angle, self.release_travel))

    def _check_hinge(self) -> None:
        constraints = self.joint.constraints
        if constraints.rotation[0] or not constraints.rotation[1]:
            raise InputError(
                f"{self.name}: release angle needs a joint that turns about its x axis "
                f"alone, got {self.joint.type}"
            )

    def _check_rail(self) -> None:
        constraints = self.joint.constraints
        if constraints.translation[0] or not constraints.translation[1]:
            raise InputError(
                f"{self.name}: release travel needs a joint that slides along its x "
                f"axis alone, got {self.joint.type}"
            )


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class InitialMotion:
    """Motion of the mated stack at t = 0, when A's CG is at rest in W.

    Raises:
        ValueError: a value is not finite.
    """

    rpy_WA: Vector3 = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of A in W, rad."""
    w_WA_A: Vector3 = (0.0, 0.0, 0.0)
    """Angular velocity of A in W, in A, rad/s."""

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        *vector(
            "attitude",
            "rpy_WA",
            ROLL_PITCH_YAW,
            "angle",
            label="attitude before separation",
        ),
        *vector("rate", "w_WA_A", XYZ, "angular_rate", label="rate before separation"),
    )

    def __post_init__(self) -> None:
        """Check the values."""
        self.PARAMETERS.check("", self)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """A body that leaves another, and in which direction.

    Raises:
        ValueError: both bodies are the same, or the direction is no unit vector.
    """

    A: str
    """Name of the body pushed from."""
    B: str
    """Name of the body pushed away."""
    direction: Vector3 = X_AXIS
    """In which B leaves A, fixed in A: longitudinal is along it, lateral across it."""

    def __post_init__(self) -> None:
        """Check the values."""
        if self.A == self.B:
            raise InputError(f"pair: must name two different bodies, got {self.A!r}")
        direction = unit_vector(f"pair: {self.B}: direction", self.direction)
        object.__setattr__(self, "direction", direction)


def leaving_among(pairs: Sequence[Pair], bodies: Collection[str]) -> Pair:
    """Return the pair that says how far two bodies have moved apart.

    That of the two; if there is none, the first in which one of them leaves, whatever
    it leaves; and the first of all if neither leaves.

    Args:
        pairs: one or more.
        bodies: names of the two.
    """
    return min(pairs, key=lambda p: ({p.A, p.B} != {*bodies}, p.B not in bodies))


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Separation:
    """Everything that decides how bodies leave each other.

    Raises:
        ValueError: a name is used twice or names nothing, a body is not attached, A
            is not at the origin of the mated stack, or a scheduled release or the push
            of a spring driven by time does not end before the end of the run.
    """

    bodies: tuple[Body, ...]
    attachments: tuple[Attachment, ...]
    A: str
    """Name of the body pushed from; the mated stack is placed in its frame."""
    B: str
    """Name of the body pushed away, whose motion is analysed."""
    direction: Vector3 = X_AXIS
    """In which B leaves A, fixed in A."""
    others: tuple[Pair, ...] = ()
    """More bodies that leave, each in one pair."""
    loads: tuple[Load, ...] = ()
    """Thrusters, retro-rockets, disturbances."""
    initial: InitialMotion = InitialMotion()
    orbit: Orbit | None = None
    """None: free of gravity."""
    recontact: Recontact | None = None
    """None: parts are measured and feel no force."""
    duration: float
    """Length of the run from t = 0, s."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_size("time", "duration", self.duration)
        self._check_names()
        self._check_bodies_named()
        self._check_bodies_attached()
        self._check_recontact()
        self._check_spins()
        base = self.body(self.A)
        if any((*base.p_ABo, *base.rpy_AB)):
            raise InputError(
                f"{base.name}: mated place must be zero, since the stack is placed in "
                f"its frame; got position {base.p_ABo}, attitude {base.rpy_AB}"
            )
        if any((*base.mated_offset, *base.mated_misalignment)):
            raise InputError(
                f"{base.name}: mated offset and misalignment must be zero, since the "
                f"stack is placed in its frame; got {base.mated_offset} and "
                f"{base.mated_misalignment}"
            )
        for attachment in self.attachments:
            if self.duration <= attachment.release_time < math.inf:
                raise InputError(
                    f"{attachment.name}: release time must lie before the end of the "
                    f"run at {self.duration} s, got {attachment.release_time} s"
                )
        for load in self.loads:
            if load.after is None and load.start + load.times[0] >= self.duration:
                raise InputError(
                    f"{load.name}: must begin before the end of the run at "
                    f"{self.duration} s, got {load.start + load.times[0]} s"
                )
        last = max(
            self.timed_stroke_ends(self.scheduled_releases).values(), default=0.0
        )
        if last >= self.duration:
            raise InputError(
                "duration must be longer than it takes the springs to reach their "
                f"stroke, {last:.4g} s, got {self.duration} s"
            )

    def _check_names(self) -> None:
        names = [body.name for body in self.bodies]
        names += [attachment.name for attachment in self.attachments]
        names += [spring.name for spring in self.springs]
        names += [load.name for load in self.loads]
        names += [part.name for body in self.bodies for part in body.parts]
        counts = Counter([*names, *RESERVED_NAMES])
        for name, count in counts.items():
            if count > 1:
                raise InputError(
                    f"names must differ, got {name!r} {count} times"
                    + (" (it is reserved)" if name in RESERVED_NAMES else "")
                )

    def _check_bodies_named(self) -> None:
        names = [body.name for body in self.bodies]
        for attachment in self.attachments:
            for name in (attachment.A, attachment.B):
                if name not in names:
                    raise InputError(
                        f"{attachment.name}: {unknown('body', name, names)}"
                    )
        attachments = [attachment.name for attachment in self.attachments]
        for load in self.loads:
            if load.body not in names:
                raise InputError(f"{load.name}: {unknown('body', load.body, names)}")
            if load.after is not None and load.after not in attachments:
                raise InputError(
                    f"{load.name}: {unknown('attachment', load.after, attachments)}"
                )
        leaving = [pair.B for pair in self.pairs]
        for pair in self.pairs:
            for name in (pair.A, pair.B):
                if name not in names:
                    raise InputError(f"pair: {unknown('body', name, names)}")
            if leaving.count(pair.B) > 1:
                raise InputError(f"pairs: {pair.B!r} must leave in one pair, got two")

    def _check_bodies_attached(self) -> None:
        attached = {name for a in self.attachments for name in (a.A, a.B)}
        for body in self.bodies:
            if body.name not in attached:
                raise InputError(f"{body.name}: must be attached, got no attachment")

    def _check_recontact(self) -> None:
        shaped = [body.name for body in self.bodies if body.parts]
        if self.recontact is not None and len(shaped) < 2:
            raise InputError(
                "recontact: needs geometry on two bodies, got "
                f"{' and '.join(shaped) or 'none'}"
            )
        rigid = [a.name for a in self.attachments if a.joint.rigid]
        if self.recontact is not None and rigid:
            raise InputError(
                f"recontact: {rigid[0]} must not be rigid, since rigid joints do not "
                "see what contact does to their bodies; give it stiffness and damping"
            )

    def _check_spins(self) -> None:
        for body in self.bodies:
            if body.spin != 0.0 and self.spins_on(body) is None:
                raise InputError(
                    f"{body.name}: spin must be 0, unless it is held by one other body "
                    "alone, by joints that all turn about the same x axis; got "
                    f"{math.degrees(body.spin):g} deg/s"
                )

    def spins_on(self, body: Body) -> Attachment | None:
        """Return an attachment about whose joint's x axis a body may spin while mated.

        None of the first A; nor of one with a joint that holds it otherwise. Joints
        without gains hold nothing.
        """
        holding = [a for a in self.attached_to(body.name) if a.joint.holds]
        if not holding or body.name == self.A:
            return None
        first = holding[0]
        for a in holding:
            apart = subtract(a.p_AoPad_A, first.p_AoPad_A)
            beside = cross(first.joint.x_axis_A, apart)
            turned = cross(first.joint.x_axis_A, a.joint.x_axis_A)
            off = max(map(abs, (*beside, *turned)))
            if (a.A, a.B) != (first.A, first.B) or off > DECIMALS:
                return None
            if a.joint.constraints.rotation[0]:
                return None
        return first

    def body(self, name: str) -> Body:
        """Return the body of this name."""
        return next(body for body in self.bodies if body.name == name)

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """The bodies that leave: the first, and the others."""
        return (Pair(A=self.A, B=self.B, direction=self.direction), *self.others)

    def pair_of(self, body: str) -> Pair:
        """Return the pair in which a body leaves."""
        return next(pair for pair in self.pairs if pair.B == body)

    def owners_of_forces(self, *, springs: bool) -> dict[str, Attachment]:
        """Return the attachments by their names, or by those of their springs."""
        if springs:
            return {spring.name: attachment for attachment, spring in self.pushing}
        return {attachment.name: attachment for attachment in self.attachments}

    def attached_to(self, body: str) -> list[Attachment]:
        """Return the attachments that hold a body."""
        return [a for a in self.attachments if body in (a.A, a.B)]

    def lets_go_of(self, body: str) -> bool:
        """Return whether any of the attachments that hold a body lets go."""
        return any(a.lets_go for a in self.attached_to(body))

    def separates(self, body: str) -> bool:
        """Return whether all attachments that hold a body let go."""
        return all(a.lets_go for a in self.attached_to(body))

    def may_part(self, attachment: Attachment, held: Collection[str] = ()) -> bool:
        """Return whether nothing that never lets go joins an attachment's bodies.

        Args:
            attachment: whose bodies are asked about.
            held: names of attachments that have not let go in a run, though they may.
        """
        joined, reached = {attachment.A}, {attachment.A}
        for_good = [a for a in self.attachments if not a.lets_go or a.name in held]
        while reached:
            near = [(a.A, a.B) for a in for_good if not reached.isdisjoint((a.A, a.B))]
            reached = {name for ends in near for name in ends} - joined
            joined |= reached
        return attachment.B not in joined

    def leaving_at(self, attachment: Attachment) -> str:
        """Return the body that leaves at an attachment; the first if none does."""
        bodies = [pair.B for pair in self.pairs]
        return next((b for b in bodies if b in (attachment.A, attachment.B)), bodies[0])

    def ends(self, attachment: Attachment) -> tuple[int, int]:
        """Return the indices of an attachment's bodies A and B."""
        names = [body.name for body in self.bodies]
        return names.index(attachment.A), names.index(attachment.B)

    @property
    def springs(self) -> tuple[Pusher, ...]:
        """The springs, in the order of their attachments."""
        return tuple(spring for _, spring in self.pushing)

    @property
    def pushing(self) -> tuple[tuple[Attachment, Pusher], ...]:
        """The attachments that have a spring, each with it."""
        return tuple((a, a.spring) for a in self.attachments if a.spring is not None)

    def timed_stroke_ends(self, releases: Mapping[str, float]) -> dict[str, float]:
        """Return when the springs that push for a time end, s, by their names.

        Args:
            releases: times of release by attachment, s.
        """
        return {
            spring.name: releases[attachment.name] + spring.duration
            for attachment, spring in self.pushing
            if spring.duration is not None and attachment.name in releases
        }

    @property
    def scheduled_releases(self) -> dict[str, float]:
        """Times of the releases by time, s, by their attachments' names."""
        return {
            a.name: a.release_time
            for a in self.attachments
            if math.isfinite(a.release_time)
        }
