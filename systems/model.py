"""The description of one separation: bodies, attachments, springs, orbit.

Frozen records in SI and radians, free of Drake, that check themselves, can be
pickled and compare by value. Frames: A is the body pushed from, B the body pushed
away, W the freely falling world (see README, "Frames").
"""

import math
from collections import Counter
from dataclasses import dataclass
from typing import TypeAlias

from drakesep.systems.checks import (
    InputError,
    check_entries,
    check_not_negative,
    check_positive,
    unknown,
)
from drakesep.systems.inertia import check_inertia


Vector3: TypeAlias = tuple[float, float, float]
Inertia: TypeAlias = tuple[float, float, float, float, float, float]
"""Matrix entries xx, yy, zz, xy, xz, yz (I_xy = -integral of x y dm), kg m^2."""

STACK = "before_separation"
"""Stands before the parameters of the mated stack's motion."""
RESERVED_NAMES = (STACK, "world")
"""Names that no element can have; the second is Drake's."""
EARTH_MU = 3.986004418e14
"""Gravitational parameter of the Earth, m^3/s^2 (WGS 84)."""
EARTH_RADIUS = 6378137.0
"""Equatorial radius of the Earth, m (WGS 84)."""


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

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive(f"{self.name}: mass", self.mass)
        check_entries(f"{self.name}: CG", self.p_BoBcm_B, 3)
        check_entries(f"{self.name}: inertia", self.I_BBcm_B, 6)
        check_inertia(f"{self.name}: inertia", self.I_BBcm_B)
        check_entries(f"{self.name}: mated position", self.p_ABo, 3)
        check_entries(f"{self.name}: mated attitude", self.rpy_AB, 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """Gains of a fixed joint by constraint forces, Eq. 3-4.

    Raises:
        ValueError: a gain is negative or not finite.
    """

    K_F: float
    """Stiffness in translation, N/m."""
    D_F: float
    """Damping in translation, N s/m."""
    K_T: float
    """Stiffness in rotation, N m/rad."""
    D_T: float
    """Damping in rotation, N m s/rad."""

    def __post_init__(self) -> None:
        """Check the values."""
        for gain in ("K_F", "D_F", "K_T", "D_T"):
            check_not_negative(f"joint {gain}", getattr(self, gain))


@dataclass(frozen=True, slots=True, kw_only=True)
class Spring:
    """A separation spring driven by time, Eq. 5.

    Raises:
        ValueError: the force, the stroke or the design mass is not positive.
    """

    name: str
    force_max: float
    """Force at release, N."""
    stroke: float
    """m."""
    design_mass: float
    """m_S of Eq. 5, kg: a constant of the design, whatever is dispersed."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive(f"{self.name}: maximum force", self.force_max)
        check_positive(f"{self.name}: stroke", self.stroke)
        check_positive(f"{self.name}: design mass", self.design_mass)

    @property
    def frequency(self) -> float:
        """Angular frequency of the force, rad/s."""
        return math.sqrt(self.force_max / (self.design_mass * self.stroke))  # Eq. 5

    @property
    def duration(self) -> float:
        """Time from release to the end of the stroke, s."""
        return 0.5 * math.pi / self.frequency  # Eq. 5


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearSpring:
    """A separation spring driven by displacement, with a damper beside it.

    Its force falls from `force_max` at the mated place to zero at its stroke, less
    what the damper takes; it never pulls.

    Raises:
        ValueError: the force or the stroke is not positive, or the damping negative.
    """

    name: str
    force_max: float
    """Force while mated, N."""
    stroke: float
    """m."""
    damping: float = 0.0
    """N s/m."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive(f"{self.name}: maximum force", self.force_max)
        check_positive(f"{self.name}: stroke", self.stroke)
        check_not_negative(f"{self.name}: damping", self.damping)

    @property
    def energy(self) -> float:
        """Energy stored while mated, J."""
        return 0.5 * self.force_max * self.stroke


@dataclass(frozen=True, slots=True, kw_only=True)
class Attachment:
    """A place where B is held to A, and pushed from it by a spring after release.

    Raises:
        ValueError: a value is not finite, or both bodies are the same.
    """

    name: str
    A: str
    """Name of the body pushed from."""
    B: str
    """Name of the body pushed away."""
    p_AoPad_A: Vector3
    """Place in A, m; the pad on B is where it coincides with this while mated."""
    joint: Joint
    spring: Spring | LinearSpring | None = None
    release_time: float = 0.0
    """s."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_entries(f"{self.name}: position", self.p_AoPad_A, 3)
        check_not_negative(f"{self.name}: release time", self.release_time)
        if self.A == self.B:
            raise InputError(
                f"{self.name}: must join two different bodies, got {self.A!r} twice"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Orbit:
    """The circular orbit along which W falls.

    Raises:
        ValueError: the radius or the gravitational parameter is not positive.
    """

    radius: float
    """From the centre of the Earth, m."""
    mu: float = EARTH_MU
    """Gravitational parameter, m^3/s^2."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive("orbit: radius", self.radius)
        check_positive("orbit: mu", self.mu)

    @property
    def mean_motion(self) -> float:
        """rad/s."""
        return math.sqrt(self.mu / self.radius**3)


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

    def __post_init__(self) -> None:
        """Check the values."""
        check_entries("attitude before separation", self.rpy_WA, 3)
        check_entries("rate before separation", self.w_WA_A, 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Separation:
    """Everything that decides how bodies leave each other.

    Raises:
        ValueError: a name is used twice or names nothing, a body is not attached, A
            is not at the origin of the mated stack, or a release or a spring's push
            does not end before the end of the run.
    """

    bodies: tuple[Body, ...]
    attachments: tuple[Attachment, ...]
    A: str
    """Name of the body pushed from; the mated stack is placed in its frame."""
    B: str
    """Name of the body pushed away, whose motion is analysed."""
    initial: InitialMotion = InitialMotion()
    orbit: Orbit | None = None
    """None: free of gravity."""
    duration: float
    """Length of the run from t = 0, s."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive("duration", self.duration)
        self._check_names()
        self._check_bodies_named()
        self._check_bodies_attached()
        base = self.body(self.A)
        if any((*base.p_ABo, *base.rpy_AB)):
            raise InputError(
                f"{base.name}: mated place must be zero, since the stack is placed in "
                f"its frame; got position {base.p_ABo}, attitude {base.rpy_AB}"
            )
        for attachment in self.attachments:
            if attachment.release_time >= self.duration:
                raise InputError(
                    f"{attachment.name}: release time must lie before the end of the "
                    f"run at {self.duration} s, got {attachment.release_time} s"
                )
        last = max(self.timed_stroke_ends.values(), default=0.0)
        if last >= self.duration:
            raise InputError(
                "duration must be longer than it takes the springs to reach their "
                f"stroke, {last:.4g} s, got {self.duration} s"
            )

    def _check_names(self) -> None:
        names = [body.name for body in self.bodies]
        names += [attachment.name for attachment in self.attachments]
        names += [spring.name for spring in self.springs]
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
        for name in (self.A, self.B):
            if name not in names:
                raise InputError(f"pair: {unknown('body', name, names)}")
        if self.A == self.B:
            raise InputError(f"pair: must name two different bodies, got {self.A!r}")

    def _check_bodies_attached(self) -> None:
        attached = {name for a in self.attachments for name in (a.A, a.B)}
        for body in self.bodies:
            if body.name not in attached:
                raise InputError(f"{body.name}: must be attached, got no attachment")

    def body(self, name: str) -> Body:
        """Return the body of this name."""
        return next(body for body in self.bodies if body.name == name)

    @property
    def springs(self) -> tuple[Spring | LinearSpring, ...]:
        """The springs, in the order of their attachments."""
        return tuple(a.spring for a in self.attachments if a.spring is not None)

    @property
    def release_start(self) -> float:
        """Time of the first release, s."""
        return min(a.release_time for a in self.attachments)

    @property
    def timed_stroke_ends(self) -> dict[str, float]:
        """When the springs driven by time reach their stroke, s, by their names."""
        return {
            a.spring.name: a.release_time + a.spring.duration
            for a in self.attachments
            if isinstance(a.spring, Spring)
        }
