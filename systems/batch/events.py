"""The events of a separation together: let happen, foreseen, and found within steps.

What there is, and what each does, is told in `event_kinds`. Events at known times are
stepped to. The others are looked for within each step, which is cut where the first of
them is: one at a time, since what happens at once has derivatives of its own, and
follows in a step of no length. Where a step ends, the way that its quantities went
foresees the next of them.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import jax.numpy as jnp
from jax import lax

from drakesep.systems.batch import polynomials
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.event_kinds import (
    Crossings,
    KnownEvents,
    Latched,
    LiftOffs,
    LoadRows,
    ProfileCorners,
    ReleasesAfterTravel,
    ReleasesAtAngle,
    StrokeEnds,
    TimedReleases,
    TimedStrokeEnds,
)
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode
from drakesep.systems.batch.polynomials import Pieces
from drakesep.systems.equations.relative_motion import BodyState


Crossed: TypeAlias = tuple[Lanes, ...]
"""Of each kind of crossings, (e, n) which happen."""


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
        crossings: kinds of events that are found within steps, in such an order too: a
            corner that is passed changes the force by which a pad lifts off.
    """

    def __init__(self, equations: BatchEquations, *, one_by_one: bool = False):
        """Prepare.

        Args:
            equations: of the separation.
            one_by_one: whether known events at the same time happen in steps of their
                own, of no length: each has a derivative of its own.
        """
        springs = equations.springs
        self._duration = equations.separation.duration
        self._one_by_one = one_by_one
        self.known: Sequence[KnownEvents] = (
            TimedReleases(),
            TimedStrokeEnds(springs),
            LoadRows(equations),
        )
        self.crossings: Sequence[Crossings] = _crossings(equations)

    def start(self, mode: Mode) -> Latched:
        """Return that nothing has happened yet, and nothing is watched."""
        watched = tuple(jnp.zeros_like(kind.watched(mode)) for kind in self.crossings)
        return Latched(mode, jnp.full(mode.spent.shape, jnp.inf), watched)

    # Latching.

    def latch(
        self,
        latched: Latched,
        crossed: Crossed,
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
            crossed: which crossings the step was cut at.
            t: (n,) the time, s.
            x: the bodies then, of (m, n).
            params: of the batch.

        Returns:
            What has happened, and (n,) whether anything was latched.
        """
        fresh = jnp.full(t.shape, False)
        for kind, now in zip(self.crossings, crossed, strict=True):
            latched = kind.happen(latched, now, t)
            fresh = fresh | _any_latched(kind, now)
        latched, due = self._latch_due(latched, t, params)
        fresh = fresh | due
        before = latched.watched
        for kind, watched in zip(self.crossings, before, strict=True):
            begins = kind.watched(latched.mode) & ~watched
            upper = kind.quantities(x, params, latched.mode) >= 0.0
            now = begins & (upper != kind.beyond(latched.mode))
            latched = kind.happen(latched, now, t)
            fresh = fresh | _any_latched(kind, now)
        watched = tuple(kind.watched(latched.mode) for kind in self.crossings)
        return latched._replace(watched=watched), fresh

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
        mode = latched.mode
        quantities = polynomials.pieces(
            jnp.concatenate(
                [kind.quantities(nodes, params, mode) for kind in self.crossings], 1
            )
        )
        upper = quantities.values >= 0.0
        beyond = (upper != self._beyond(mode)) & self._watched(mode) & (moved > 0.0)
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

    def by_kind(self, crossed: Lanes) -> Crossed:
        """Return (c, n) crossings kind by kind."""
        kinds, first = [], 0
        for kind in self.crossings:
            last = first + kind.count
            kinds.append(crossed[first:last])
            first = last
        return tuple(kinds)

    def foresee(self, found: Found, end: Lanes, mode: Mode) -> Lanes:
        """Return (n,) after which part of a step's length the next crossing follows.

        By a parabola: as its quantity goes on from where the step was cut. Infinite
        where nothing comes.

        Args:
            found: what has been looked for within the step.
            end: (n,) the part of it that was taken.
            mode: what has happened by its end.
        """
        c = lax.stop_gradient(found.quantities.c)
        xi = 2.0 * lax.stop_gradient(end) - 1.0
        side = jnp.where(self._beyond(mode), -1.0, 1.0)
        # What has just been crossed is on either side of zero.
        slopes = polynomials.derivative(c)
        value = jnp.minimum(side * polynomials.polynomial(c, xi), 0.0)
        slope = side * polynomials.polynomial(slopes, xi)
        bend = side * polynomials.polynomial(polynomials.derivative(slopes), xi)
        square = slope * slope - 2.0 * bend * value
        steepness = slope + jnp.sqrt(jnp.maximum(square, 0.0))
        comes = self._watched(mode) & (square >= 0.0) & (steepness > 0.0)
        # A step's length is two of xi.
        after = -value / jnp.where(comes, steepness, 1.0)
        return jnp.where(comes, after, jnp.inf).min(axis=0)

    def _watched(self, mode: Mode) -> Lanes:
        return jnp.concatenate([kind.watched(mode) for kind in self.crossings])

    def _beyond(self, mode: Mode) -> Lanes:
        return jnp.concatenate([kind.beyond(mode) for kind in self.crossings])


def _any_latched(kind: Crossings, now: Lanes) -> Lanes:
    """Return (n,) whether any of a kind happens now, and latches."""
    return now.any(axis=0) if kind.latches else jnp.full(now.shape[1:], False)


def _crossings(equations: BatchEquations) -> list[Crossings]:
    """Return the kinds of which a separation has some."""
    springs = equations.springs
    crossings: list[Crossings] = []
    if springs.corners:
        crossings.append(ProfileCorners(springs))
    if springs.by_stroke:
        crossings.append(StrokeEnds(springs))
    if springs.may_lift:
        crossings.append(LiftOffs(springs))
    attachments = [*enumerate(equations.separation.attachments)]
    if at_angle := [i for i, a in attachments if math.isfinite(a.release_angle)]:
        crossings.append(ReleasesAtAngle(equations, at_angle))
    if after_travel := [i for i, a in attachments if math.isfinite(a.release_travel)]:
        crossings.append(ReleasesAfterTravel(equations, after_travel))
    return crossings
