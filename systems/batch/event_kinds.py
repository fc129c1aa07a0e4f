"""What can happen during a run, when, and what it leaves behind: a row a kind.

=====================  =================  ==========================  ==========  =====
Stepped to             Watched while      Time                        Latches     Next
=====================  =================  ==========================  ==========  =====
`TimedReleases`        it holds           time of release             released    fresh
`TimedStrokeEnds`      it is not spent    release + a quarter of a    spent, its  fresh
                                          period (Eq. 5)              time
`LoadRows`             it is not passed   start + time in the table   passed      fresh
=====================  =================  ==========================  ==========  =====
Found within steps     Watched while      Quantity that crosses zero  Latches     Next
=====================  =================  ==========================  ==========  =====
`ProfileCorner`        its spring pushes  displacement - corner       nothing     as is
`StrokeEnd`            its spring pushes  displacement - stroke       spent, its  fresh
                                                                      time
`LiftOff`              its spring pushes  - force                     nothing     as is
`ReleaseAtAngle`       it holds           twist to one side - angle   released    fresh
                                          of release
=====================  =================  ==========================  ==========  =====

Every event ends a step. One that latches happens once, upwards, and the next step is
guessed anew, fresh. The others are crossed in either direction, as often as it comes,
and the step control goes on: its steps are as good beyond a corner.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import jax.numpy as jnp

from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode, pick
from drakesep.systems.batch.springs import BatchSprings
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations.mated_stack import mated_orientation
from drakesep.systems.equations.relative_motion import BodyState


class Latched(NamedTuple):
    """What has happened to the lanes, and where they stand to what may happen."""

    mode: Mode
    stroke_ends: Lanes
    """(k, n) when each stroke was reached, s; infinite before."""
    beyond: Lanes
    """(c, n) whether the quantity of each crossing is on the upper side of zero.

    A crossing changes it; a quantity's sign is asked only when it begins to be watched.
    At a crossing it is zero but for round-off, and its sign means nothing."""
    watched: Lanes
    """(c, n) whether each crossing was watched when events were last latched."""

    def release(self, released: Lanes) -> "Latched":
        """Return what has happened with other times of release."""
        return self._replace(mode=self.mode._replace(released=released))

    def end_strokes(self, spent: Lanes, stroke_ends: Lanes) -> "Latched":
        """Return what has happened with other strokes reached."""
        mode = self.mode._replace(spent=spent)
        return self._replace(mode=mode, stroke_ends=stroke_ends)


# Events at known times: one kind is all of its events, on an axis before the lanes.


class KnownEvents(Protocol):
    """A kind of event whose times are known beforehand."""

    def times(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (e, n) when they happen, s; infinite while that is not known."""

    def watched(self, mode: Mode) -> Lanes:
        """Return (e, n) which are to come."""

    def happen(self, latched: Latched, due: Lanes, times: Lanes) -> Latched:
        """Return what has happened with those that are due, of (e, n)."""


class TimedReleases:
    """Attachments let go."""

    def times(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (a, n), s."""
        return params.release_time

    def watched(self, mode: Mode) -> Lanes:
        """Return (a, n) which hold."""
        return jnp.isinf(mode.released)

    def happen(self, latched: Latched, due: Lanes, times: Lanes) -> Latched:
        """Release them."""
        return latched.release(jnp.where(due, times, latched.mode.released))


@dataclass(frozen=True)
class TimedStrokeEnds:
    """Springs reach the end of their stroke at a time that follows from release."""

    springs: BatchSprings

    def times(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (k, n), s."""
        return self.springs.stroke_end(params, mode)

    def watched(self, mode: Mode) -> Lanes:
        """Return (k, n) which have not got there, of those with such a time."""
        return self.springs.known_end & ~mode.spent

    def happen(self, latched: Latched, due: Lanes, times: Lanes) -> Latched:
        """Let them go of their pads."""
        ends = jnp.where(due, times, latched.stroke_ends)
        return latched.end_strokes(latched.mode.spent | due, ends)


@dataclass(frozen=True)
class LoadRows:
    """Loads pass from one row of their tables to the next."""

    equations: BatchEquations

    def times(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (r, n), s; of loads that start with a release, infinite before."""
        return self.equations.row_times(params, mode)

    def watched(self, mode: Mode) -> Lanes:
        """Return (r, n) which are to come."""
        return ~mode.passed

    def happen(self, latched: Latched, due: Lanes, times: Lanes) -> Latched:
        """Pass them."""
        mode = latched.mode
        return latched._replace(mode=mode._replace(passed=mode.passed | due))


# Events found within steps: each crosses zero in its own way.


class Crossing(Protocol):
    """An event where a quantity crosses zero."""

    @property
    def latches(self) -> bool:
        """Whether it happens once, upwards."""

    def watched(self, held: Lanes, pushing: Lanes) -> Lanes:
        """Return (n,) whether it can happen.

        Args:
            held: (a, n) which attachments hold.
            pushing: (k, n) which springs push.
        """

    def quantity(self, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return (..., n) the quantity, of bodies (..., m, n)."""

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Return what has happened with it, where it happens now, of (n,)."""


@dataclass(frozen=True)
class ProfileCorner:
    """A spring's pad passes a corner of its profile, which is a kink of its force."""

    springs: BatchSprings
    k: int
    part: float
    """Of the stroke."""
    latches = False

    def watched(self, held: Lanes, pushing: Lanes) -> Lanes:
        """Return (n,) whether the spring pushes."""
        return pushing[self.k]

    def quantity(self, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return (..., n) how far the pad is past the corner, m."""
        return self.springs.past(self.k, self.part, bodies, params)

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Leave all as it is."""
        return latched


class StrokeEnd(ProfileCorner):
    """A spring's pad reaches the end of its stroke."""

    latches = True

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Let the spring go of its pad."""
        spent, ends = latched.mode.spent, latched.stroke_ends
        return latched.end_strokes(
            spent.at[self.k].set(spent[self.k] | now),
            ends.at[self.k].set(jnp.where(now, t, ends[self.k])),
        )


@dataclass(frozen=True)
class LiftOff:
    """A pad lifts off its damper, or is met again: the spring does not pull."""

    springs: BatchSprings
    k: int
    latches = False

    def watched(self, held: Lanes, pushing: Lanes) -> Lanes:
        """Return (n,) whether the spring pushes."""
        return pushing[self.k]

    def quantity(self, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return (..., n) what keeps the pad from its spring, N."""
        return -self.springs.stroke_force(self.k, bodies, params)

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Leave all as it is."""
        return latched


class ReleaseAtAngle:
    """A joint lets go where it has turned far enough, one way."""

    latches = True

    def __init__(self, equations: BatchEquations, i: int, way: float):
        """Prepare.

        Args:
            equations: of the separation.
            i: the attachment.
            way: 1 or -1, about the joint's x axis.
        """
        separation = equations.separation
        self._i, self._way = i, way
        self._a, self._b = a, b = equations.ends[i]
        self._q_AB = mated_orientation(separation.bodies[a], separation.bodies[b])
        self._axis_A = separation.attachments[i].joint.x_axis_A

    def watched(self, held: Lanes, pushing: Lanes) -> Lanes:
        """Return (n,) whether it holds."""
        return held[self._i]

    def quantity(self, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return (..., n) how far it has turned past its angle of release, rad."""
        q_WA, q_WB = (pick(bodies, body).q_WB for body in (self._a, self._b))
        angle = joint_laws.twist_angle(q_WA, q_WB, self._q_AB, self._axis_A, jnp)
        return self._way * angle - params.release_angle[self._i]

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Release it."""
        released = latched.mode.released
        at = jnp.where(now, t, released[self._i])
        return latched.release(released.at[self._i].set(at))
