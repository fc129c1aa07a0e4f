"""The events of a separation together: let happen, foreseen, and found within steps.

What there is, and what each does, is told in `event_kinds`. Events at known times are
stepped to. The others are looked for within each step, which is cut where the first of
them is: one at a time, since what happens at once has derivatives of its own, and
follows in a step of no length.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp

from drakesep.systems.batch import polynomials
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.event_kinds import (
    Crossing,
    KnownEvents,
    Latched,
    LiftOff,
    LoadRows,
    ProfileCorner,
    ReleaseAtAngle,
    StrokeEnd,
    TimedReleases,
    TimedStrokeEnds,
)
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode
from drakesep.systems.batch.polynomials import Pieces
from drakesep.systems.batch.springs import BatchSprings
from drakesep.systems.equations.relative_motion import BodyState


class Found(NamedTuple):
    """The crossings on the other side of zero somewhere in a step."""

    quantities: Pieces
    """Of the c crossings, over the step."""
    beyond: Lanes
    """(15, c, n) at which points of the pieces."""


class Events:
    """All that can happen to the lanes of one separation.

    Attributes:
        known: kinds of events at known times, in the order in which one brings about
            another at the same instant: a release starts springs and loads.
        crossings: events that are found within steps.
    """

    def __init__(self, equations: BatchEquations, *, one_by_one: bool = False):
        """Prepare.

        Args:
            equations: of the separation.
            one_by_one: whether known events at the same time happen in steps of their
                own, of no length: each has a derivative of its own.
        """
        self._springs = springs = equations.springs
        self._duration = equations.separation.duration
        self._one_by_one = one_by_one
        self.known: Sequence[KnownEvents] = (
            TimedReleases(),
            TimedStrokeEnds(springs),
            LoadRows(equations),
        )
        self.crossings: Sequence[Crossing] = (
            *_of_springs(springs),
            *_of_joints(equations),
        )

    def start(self, mode: Mode) -> Latched:
        """Return that nothing has happened yet, and nothing is watched."""
        k, n = mode.spent.shape
        none = jnp.full((len(self.crossings), n), False)
        return Latched(mode, jnp.full((k, n), jnp.inf), none, none)

    # Latching.

    def latch(
        self,
        latched: Latched,
        crossed: Lanes,
        t: Lanes,
        x: BodyState,
        params: BatchParameters,
    ) -> tuple[Latched, Lanes]:
        """Let happen all that happens at a time, at the end of each step.

        In the order of cause and effect: first what was crossed at the step's end, then
        what is due, as a load that starts with the release just crossed. What begins to
        be watched by then may be on the upper side of zero already, and happens as
        well: a pad that has moved past its stroke before its attachment lets go.

        Args:
            latched: what has happened before.
            crossed: (c, n) which crossings the step was cut at.
            t: (n,) the time, s.
            x: the bodies then, of (m, n).
            params: of the batch.

        Returns:
            What has happened, and (n,) whether anything was latched.
        """
        latched = latched._replace(beyond=latched.beyond ^ crossed)
        latched, fresh = self._happen(latched, crossed, t)
        latched, due = self._latch_due(latched, t, params)
        if not self.crossings:
            return latched, fresh | due
        watched = self._watched(latched.mode)
        begins = watched & ~latched.watched
        upper = self._quantities(x, params) >= 0.0
        beyond = jnp.where(begins, upper, latched.beyond)
        latched = latched._replace(beyond=beyond, watched=watched)
        latched, begun = self._happen(latched, begins & upper, t)
        return latched, fresh | due | begun

    def _latch_due(
        self, latched: Latched, t: Lanes, params: BatchParameters
    ) -> tuple[Latched, Lanes]:
        """Let happen what is due; what one kind does, the next one sees.

        One by one it is only the first that is due, kind after kind: the next known
        event is then at the same time, and the step to it has no length.
        """
        happened = jnp.full(t.shape, False)
        for kind in self.known:
            times = kind.times(params, latched.mode)
            due = kind.watched(latched.mode) & (times <= t)
            if self._one_by_one:
                due = due & (jnp.cumsum(due, axis=0) == 1) & ~happened
            latched = kind.happen(latched, due, times)
            happened = happened | due.any(axis=0)
        return latched, happened

    def _happen(self, latched: Latched, now: Lanes, t: Lanes) -> tuple[Latched, Lanes]:
        """Let happen those crossings that latch, of (c, n)."""
        happened = jnp.full(t.shape, False)
        for event, here in zip(self.crossings, now, strict=True):
            if event.latches:
                latched = event.happen(latched, here, t)
                happened = happened | here
        return latched, happened

    # Looking ahead.

    def next_known(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (n,) the next time at which something is known to happen, s.

        Args:
            params: of the batch.
            mode: what has happened so far.
        """
        times = jnp.concatenate(
            [
                jnp.where(kind.watched(mode), kind.times(params, mode), jnp.inf)
                for kind in self.known
            ]
        )
        # Not min: of events at the same time, it would mix the derivatives.
        first = jnp.argmin(times, axis=0)[None]
        time = jnp.take_along_axis(times, first, 0)[0]
        return jnp.where(time < self._duration, time, self._duration)

    # Looking back on a step.

    def find(
        self, latched: Latched, nodes: BodyState, moved: Lanes, params: BatchParameters
    ) -> Found:
        """Return what has been crossed within a step.

        Args:
            latched: what has happened by its start.
            nodes: the bodies at its nodes, of (8, m, n).
            moved: (n,) its length, s.
            params: of the batch.
        """
        values = jnp.moveaxis(self._quantities(nodes, params), 1, 0)
        quantities = polynomials.pieces(values)
        watched = self._watched(latched.mode) & (moved > 0.0)
        beyond = ((quantities.values >= 0.0) != latched.beyond) & watched
        # At the start stands what has just been crossed, on either side of zero.
        return Found(quantities, beyond & (quantities.xi > -1.0))

    def first(self, found: Found) -> tuple[Lanes, Lanes]:
        """Return (n,) the part of a step until the first crossing, and (c, n) which.

        Args:
            found: what has been crossed within it.
        """
        zero = jnp.zeros_like(found.quantities.values[0])
        at = polynomials.first_place(found.quantities, found.beyond, zero)
        at = jnp.where(found.beyond.any(axis=0), at, 2.0)
        first = jnp.argmin(at, axis=0)[None]
        fraction = jnp.minimum(jnp.take_along_axis(at, first, 0)[0], 1.0)
        index = jnp.arange(len(at))[:, None]
        return fraction, (index == first) & (at < 1.0)

    def _quantities(self, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return (c, ..., n) the crossings' quantities, of bodies (..., m, n)."""
        return jnp.stack([event.quantity(bodies, params) for event in self.crossings])

    def _watched(self, mode: Mode) -> Lanes:
        """Return (c, n) whether each crossing can happen."""
        held, pushing = jnp.isinf(mode.released), self._springs.pushing(mode)
        return jnp.stack([event.watched(held, pushing) for event in self.crossings])


def _of_springs(springs: BatchSprings) -> list[Crossing]:
    crossings: list[Crossing] = []
    for k in range(springs.count):
        crossings += [ProfileCorner(springs, k, u) for u in springs.corners(k)]
        if not springs.known_end[k]:
            crossings.append(StrokeEnd(springs, k, 1.0))
        if springs.may_lift(k):
            crossings.append(LiftOff(springs, k))
    return crossings


def _of_joints(equations: BatchEquations) -> list[Crossing]:
    return [
        ReleaseAtAngle(equations, i, way)
        for i, attachment in enumerate(equations.separation.attachments)
        if math.isfinite(attachment.release_angle)
        for way in (1.0, -1.0)
    ]
