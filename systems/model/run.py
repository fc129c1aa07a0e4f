"""What comes out of one simulated separation."""

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.model.separation import Attachment, Pair, Separation


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """The motion of B at n sample times, in SI and radians; vectors are (n, 3)."""

    time: Array
    """(n,), s."""
    rate: Array
    """Angular velocity of B in W, in B, rad/s."""
    relative_rate: Array
    """Angular velocity of B in A, in B, rad/s."""
    angle: Array
    """Roll, pitch and yaw of B in W, rad."""
    relative_position: Array
    """B's CG from its mated place, in A, m."""
    relative_velocity: Array
    """Velocity of B's CG as seen from A, in A, m/s."""
    acceleration: Array
    """Acceleration of B's CG in W, m/s^2."""
    linear_momentum_change: Array
    """Given to B by the springs, in B, N s (Eq. 6)."""
    angular_momentum_change: Array
    """Given to B by the springs about its CG, in B, N m s (Eq. 7)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """The motion of all m bodies in W at n sample times."""

    names: tuple[str, ...]
    """(m,) of the bodies."""
    time: Array
    """(n,), s."""
    states: Array
    """(n, m, 13) of each body, as in Drake's plant: orientation q_WB, position p_WBo,
    m, angular velocity w_WB, rad/s, and velocity v_WBo, m/s, all in W."""

    def of(self, body: str) -> Array:
        """Return the states (n, 13) of one body."""
        return self.states[:, self.names.index(body)]

    def around(self, t: float) -> "Trajectory":
        """Return the two samples between which a time lies, s."""
        after = int(np.searchsorted(self.time, t, side="right"))
        last = min(max(after, 1), len(self.time) - 1)
        two = slice(last - 1, last + 1)
        return Trajectory(
            names=self.names, time=self.time[two], states=self.states[two]
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactForces:
    """How two parts push each other, at the integration steps at which they do.

    And at the step after, with no force: it parts one contact from the next.
    """

    first: str
    second: str
    time: Array
    """(n,), s."""
    force: Array
    """(n, 3) on the second, in W, N."""


class RunStatus(enum.Enum):
    """How a run ended."""

    COMPLETED = "completed"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One simulated separation."""

    separation: Separation
    """As it was flown, with its varied values."""
    status: RunStatus
    message: str = ""
    """Why the run failed; empty if it did not."""
    motion: Motion | None = field(default=None, repr=False)
    """None if the run failed."""
    others: Mapping[str, Motion] = field(default_factory=dict, repr=False)
    """Motions of the other bodies that leave, by their names; as seen from their A."""
    trajectory: Trajectory | None = field(default=None, repr=False)
    """None if the run failed."""
    breaks: tuple[float, ...] = ()
    """Where the motion has a kink: start, releases, ends of strokes, edges of loads,
    end, s."""
    releases: Mapping[str, float] = field(default_factory=dict)
    """When each attachment let go, s, by its name; infinite if it never does."""
    stroke_ends: Mapping[str, float] = field(default_factory=dict)
    """When each spring reached its stroke, s, by its name; infinite if it does not,
    since its bodies stay together."""
    contacts: tuple[ContactForces, ...] = ()
    """Of parts that touch again, if the separation has recontact."""
    steps: int = 0
    """Integration steps taken."""
    evaluations: int = 0
    """Evaluations of the time derivatives."""

    @property
    def completed_motion(self) -> Motion:
        """The motion of a completed run.

        Raises:
            RuntimeError: the run failed.
        """
        if self.motion is None:
            raise RuntimeError(f"the run failed: {self.message}")
        return self.motion

    def motion_of(self, body: str) -> Motion:
        """Return the motion of a body that leaves, of a completed run.

        Raises:
            RuntimeError: the run failed.
        """
        motion = self.completed_motion
        return motion if body == self.separation.B else self.others[body]

    @property
    def completed_trajectory(self) -> Trajectory:
        """The motion of all bodies of a completed run.

        Raises:
            RuntimeError: the run failed.
        """
        if self.trajectory is None:
            raise RuntimeError(f"the run failed: {self.message}")
        return self.trajectory

    @property
    def held(self) -> tuple[str, ...]:
        """The attachments that hold to the end: what they join does not separate."""
        return tuple(name for name, t in self.releases.items() if math.isinf(t))

    @property
    def held_back(self) -> tuple[str, ...]:
        """Springs that have let go, and whose strokes are not reached.

        What pulls, or resists, keeps their bodies together.
        """
        return tuple(
            spring.name
            for attachment, spring in self.separation.pushing
            if math.isinf(self.stroke_ends.get(spring.name, 0.0))
            and self.separation.may_part(attachment)
        )

    @property
    def not_separated(self) -> str:
        """Why bodies that would leave have not by the end; empty if they have."""
        for attachment in self.separation.attachments:
            if attachment.lets_go and attachment.name in self.held:
                return (
                    f"{attachment.name} has not let go: its joint has not "
                    f"{_motion_to_release(attachment)}"
                )
        back = self.held_back
        return f"{back[0]} has not reached its stroke" if back else ""

    @property
    def separation_start(self) -> float:
        """When the first attachment of the measured body B let go, s."""
        return self.start_of(self.separation.B)

    @property
    def separation_end(self) -> float:
        """When all attachments of B have let go and their strokes are reached, s.

        Infinite if that does not come about.
        """
        return self.end_of(self.separation.B)

    def start_of(self, body: str) -> float:
        """Return when the first attachment of a body let go, s."""
        return min(self.releases[a.name] for a in self.separation.attached_to(body))

    def end_of(self, body: str) -> float:
        """Return when a body is free, and the strokes of what pushed it are reached."""
        return max(
            self.stroke_ends[a.spring.name] if a.spring else self.releases[a.name]
            for a in self.separation.attached_to(body)
        )

    def push_of(self, pair: Pair) -> tuple[float, float]:
        """Return from when to when B is pushed from A, s.

        Where nothing between them pushes: by whatever does; where nothing does: from
        the first release of B to its end of separation. Both are within the run.

        Args:
            pair: of the separation.
        """
        springs = [a for a in self.separation.attached_to(pair.B) if a.spring]
        springs = [a for a in springs if pair.A in (a.A, a.B)] or springs
        start, end = self.start_of(pair.B), self.end_of(pair.B)
        if springs:
            start = min(self.releases[a.name] for a in springs)
            end = max(self.stroke_ends[a.spring.name] for a in springs if a.spring)
        last = self.separation.duration
        return min(start, last), min(end, last)


def _motion_to_release(attachment: Attachment) -> str:
    angle, travel = attachment.release_angle, attachment.release_travel
    ways = [f"turned by {math.degrees(angle):g} deg"] * math.isfinite(angle)
    ways += [f"slid by {1e3 * travel:g} mm"] * math.isfinite(travel)
    return " or ".join(ways)
