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
`ProfileCorners`       its spring pushes  displacement - corner       corners     as is
`StrokeEnds`           its spring pushes  displacement - stroke       spent, its  fresh
                                                                      time
`LiftOffs`             its spring pushes  - force, its way          lifted      as is
`ReleasesAtAngle`      it holds           twist to one side - angle   released    fresh
                                          of release
`ReleasesAfterTravel`  it holds           slide to one side - travel  released    fresh
                                          of release
=====================  =================  ==========================  ==========  =====

Every event ends a step: within one, all that acts is smooth, as if the event were not
to come. One that latches happens once, upwards, and the next step is guessed anew,
fresh. The others are crossed in either direction, as often as it comes, and the step
control goes on: its steps are as good beyond a corner.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import jax.numpy as jnp
import numpy as np

from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode, pick
from drakesep.systems.batch.springs import BatchSprings
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations.pushers import push_displacement
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.vectors import Vector


class Latched(NamedTuple):
    """What has happened to the lanes, and where they stand to what may happen."""

    mode: Mode
    stroke_ends: Lanes
    """(k, n) when each stroke was reached, s; infinite before."""
    watched: tuple[Lanes, ...]
    """Of each kind of crossings, (e, n) which were watched when events were last
    latched: the side of zero is asked only of what begins to be watched."""

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


# Events found within steps: one kind is all of its events, on an axis before the lanes.


class Crossings(Protocol):
    """A kind of events, each where a quantity crosses zero."""

    latches: bool
    """Whether each happens once, upwards."""
    count: int
    """How many there are, e."""

    def watched(self, mode: Mode) -> Lanes:
        """Return (e, n) which can happen."""

    def beyond(self, mode: Mode) -> Lanes:
        """Return (e, n) which quantities are on the upper side of zero.

        A crossing changes it: at a crossing a quantity is zero but for round-off, and
        its sign means nothing.
        """

    def quantities(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return (..., e, n) the quantities, of bodies (..., m, n)."""

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Return what has happened with those that happen now, of (e, n)."""


class ProfileCorners:
    """Pads pass corners of their springs' profiles: another piece of the force acts."""

    latches = False

    def __init__(self, springs: BatchSprings):
        self._springs = springs
        places, parts = zip(*springs.corners, strict=True)
        self._of, self._parts = np.array(places), np.array(parts)[:, None]
        self.count = len(places)

    def watched(self, mode: Mode) -> Lanes:
        """Return (e, n) whose springs push."""
        return self._springs.pushing(mode)[np.array(self._springs.by_stroke)[self._of]]

    def beyond(self, mode: Mode) -> Lanes:
        """Return (e, n) which are passed."""
        return mode.corners

    def quantities(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return (..., e, n) how far the pads are past the corners, m."""
        displacements = self._springs.displacements(bodies, params)
        places = self._parts * self._springs.strokes(params)[self._of]
        return displacements[..., self._of, :] - places

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Pass them, or pass them back."""
        mode = latched.mode
        return latched._replace(mode=mode._replace(corners=mode.corners ^ now))


class StrokeEnds:
    """Pads reach the ends of their springs' strokes."""

    latches = True

    def __init__(self, springs: BatchSprings):
        self._springs = springs
        self._index = np.array(springs.by_stroke)
        self.count = len(self._index)

    def watched(self, mode: Mode) -> Lanes:
        """Return (e, n) whose springs push."""
        return self._springs.pushing(mode)[self._index]

    def beyond(self, mode: Mode) -> Lanes:
        """Return (e, n) which are reached."""
        return mode.spent[self._index]

    def quantities(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return (..., e, n) how far the pads are past their strokes, m."""
        displacements = self._springs.displacements(bodies, params)
        return displacements - self._springs.ends(params)

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Let the springs go of their pads."""
        spent, ends = latched.mode.spent, latched.stroke_ends
        before = ends[self._index]
        return latched.end_strokes(
            spent.at[self._index].set(spent[self._index] | now),
            ends.at[self._index].set(jnp.where(now, t, before)),
        )


class LiftOffs:
    """Pads lift off their springs, which do not pull, or are met again."""

    latches = False

    def __init__(self, springs: BatchSprings):
        self._springs = springs
        self._places = np.array(springs.may_lift)
        self._index = np.array(springs.by_stroke)[self._places]
        self.count = len(self._index)

    def watched(self, mode: Mode) -> Lanes:
        """Return (e, n) whose springs push."""
        return self._springs.pushing(mode)[self._index]

    def beyond(self, mode: Mode) -> Lanes:
        """Return (e, n) which pads are off."""
        return mode.lifted[self._index]

    def quantities(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return (..., e, n) what keeps the pads from their springs, N."""
        forces = self._springs.stroke_forces(bodies, params, mode)
        return -self._springs.ways * forces[..., self._places, :]

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Let the pads off, or let them be met."""
        mode = latched.mode
        lifted = mode.lifted.at[self._index].set(mode.lifted[self._index] ^ now)
        return latched._replace(mode=mode._replace(lifted=lifted))


class ReleasesByMotion(ABC):
    """Joints let go where they have moved far enough, either way."""

    latches = True

    def __init__(self, equations: BatchEquations, released: Sequence[int]):
        """Prepare.

        Args:
            equations: of the separation.
            released: indices of the attachments that let go so.
        """
        self._equations = equations
        self._joints = [(i, way) for i in released for way in (1.0, -1.0)]
        self._index = np.array([i for i, _ in self._joints])
        self.count = len(self._joints)

    @abstractmethod
    def _past(self, i: int, way: float, bodies: BodyState, p: BatchParameters) -> Lanes:
        """Return (..., n) how far an attachment's joint is past where it lets go.

        Args:
            i: its index.
            way: to one side, or the other: 1 or -1.
            bodies: of (..., m, n).
            p: of the batch.
        """

    def watched(self, mode: Mode) -> Lanes:
        """Return (e, n) which hold."""
        return ~self.beyond(mode)

    def beyond(self, mode: Mode) -> Lanes:
        """Return (e, n) which have let go."""
        return jnp.isfinite(mode.released)[self._index]

    def quantities(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Lanes:
        """Return (..., e, n) how far each is past where it lets go, rad or m."""
        past = [self._past(i, way, bodies, params) for i, way in self._joints]
        return jnp.stack(past, axis=-2)

    def happen(self, latched: Latched, now: Lanes, t: Lanes) -> Latched:
        """Release them."""
        released = latched.mode.released
        for (i, _), here in zip(self._joints, now, strict=True):
            released = released.at[i].set(jnp.where(here, t, released[i]))
        return latched.release(released)

    def _ends(self, i: int, bodies: BodyState) -> tuple[BodyState, BodyState]:
        a, b = self._equations.ends[i]
        return pick(bodies, a), pick(bodies, b)

    def _axis_A(self, i: int) -> Vector:
        """Return the x axis of a joint."""
        return self._equations.separation.attachments[i].joint.x_axis_A


class ReleasesAtAngle(ReleasesByMotion):
    """Joints let go where they have turned far enough, either way."""

    def _past(self, i: int, way: float, bodies: BodyState, p: BatchParameters) -> Lanes:
        A, B = self._ends(i, bodies)
        q_AB = self._equations.places.orientation(*self._equations.ends[i], p)
        angle = joint_laws.twist_angle(A.q_WB, B.q_WB, q_AB, self._axis_A(i), jnp)
        return way * angle - p.release_angle[i]


class ReleasesAfterTravel(ReleasesByMotion):
    """Joints let go where they have slid far enough, either way."""

    def _past(self, i: int, way: float, bodies: BodyState, p: BatchParameters) -> Lanes:
        pads = pick(p.p_AoPad_A, i), pick(p.p_BoPad_B, i)
        travel, _ = push_displacement(*self._ends(i, bodies), *pads, self._axis_A(i))
        return way * travel - p.release_travel[i]
