"""The integration of a batch of separations, every lane at its own pace.

A lane is a sample on its way: see `step_control` for how long its steps are, `events`
for what ends them, and `tableaus` for DOP853, which takes them. Where events of all
lanes are near, as ends of strokes are, DOPRI5 goes from one to the next with half the
stages. What a lane does depends on its own parameters; on those of its neighbours in
the batch by less than a hundredth of its tolerance, as they choose between the two.

Within a step everything is smooth: which piece of a law acts is told by what has
happened by its start, and goes on beyond its end. So no step is rejected for a kink; it
is cut where the event is found.

Everything is differentiable in forward mode: steps end where events are, whose times
carry their derivatives; only the choice of the number of steps carries none.
"""

import enum
from typing import Any, NamedTuple, Protocol

import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.batch import runge_kutta, step_control
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.event_kinds import Latched
from drakesep.systems.batch.events import Crossed, Events, Found
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode
from drakesep.systems.batch.runge_kutta import Weights
from drakesep.systems.batch.step_control import StepControl
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.relative_motion import BodyState


_SHORTEST = 1e-12
"""Step, s, below which an integration has collapsed."""


class LaneStatus(enum.IntEnum):
    """How a lane fares, with what to say of a run that has no metrics.

    Messages are for `str.format`: `held` are the names of attachments that have not let
    go, `left` those of springs that have not reached their stroke, `time` is the time
    in s at which the lane ended, `max_steps` the largest number of steps.
    """

    message: str

    FLYING = 0, ""
    COMPLETED = 1, "a metric, or a derivative of one, is not finite"
    STILL_HELD = 2, "{held[0]} has not let go: its joint has not moved far enough"
    STROKE_LEFT = 3, "{left[0]} has not reached its stroke"
    STEP_COLLAPSED = 4, "the step size collapsed (at t = {time:g} s)"
    TOO_MANY_STEPS = 5, "more than {max_steps} integration steps (at t = {time:g} s)"

    def __new__(cls, value: int, message: str = "") -> "LaneStatus":
        """Return a status with its message."""
        status = int.__new__(cls, value)
        status._value_ = value
        status.message = message
        return status


class Step(NamedTuple):
    """A stretch of the motion of every lane, from event to event or shorter.

    A lane that did not move has the length zero, and its state at every node.
    """

    start: Lanes
    """(n,), s."""
    length: Lanes
    """(n,), s."""
    x: Lanes
    """(13, 8, m, n) states of the bodies at the nodes of `lobatto`."""
    mode: Mode
    """What has happened by the start."""

    @property
    def bodies(self) -> BodyState:
        """The bodies at the nodes, of (8, m, n)."""
        return _bodies(self.x)


class Fold(Protocol):
    """What is made of the steps of a run, one after the other."""

    def start(self, params: BatchParameters) -> Any:
        """Return what there is before the first step."""

    def add(self, carry: Any, params: BatchParameters, step: Step) -> Any:
        """Return what there is after a step."""


class Taken(NamedTuple):
    """What is taken of a step that was tried."""

    nodes: Lanes
    """(13, 8, m, n) states of the bodies at the nodes of `lobatto`."""
    accepted: Lanes
    """(n,) whether it is taken at all."""
    fraction: Lanes
    """(n,) of it, until the first event in it."""
    crossed: Crossed
    """The crossings that it was cut at."""


class LaneState(NamedTuple):
    """Where the lanes of a batch are."""

    t: Lanes
    """(n,), s."""
    x: Lanes
    """(13, m, n) states of the bodies."""
    latched: Latched
    """What has happened by t. One by one, what is left of t itself follows in steps of
    no length."""
    step: Lanes
    """(n,) that the error of the last step admits for the next, s."""
    fresh: Lanes
    """(n,) whether what acts has changed since: the next step is guessed anew."""
    foreseen: Lanes
    """(n,) time until a little beyond the next crossing that is foreseen, s."""
    status: Lanes
    """(n,) of `LaneStatus`."""
    steps: Lanes
    """(n,) tried so far."""
    evaluations: Lanes
    """(n,) of the equations so far."""
    folded: Any
    """What the fold has made of the steps so far."""


class FinalState(NamedTuple):
    """How the lanes of a batch ended."""

    status: Lanes
    """(n,) of `LaneStatus`: COMPLETED, or why not."""
    time: Lanes
    """(n,) at which they ended, s."""
    steps: Lanes
    """(n,) taken, the rejected among them."""
    evaluations: Lanes
    """(n,) of the equations; those of a short step depend on the neighbours."""
    released: Lanes
    """(a, n), s; infinite for attachments that hold."""
    stroke_ends: Lanes
    """(k, n), s; infinite for strokes that were not reached."""
    folded: Any


class BatchIntegrator:
    """Flies batches of one separation."""

    def __init__(
        self,
        equations: BatchEquations,
        *,
        tolerance: float,
        max_steps: int,
        one_by_one: bool = False,
    ):
        """Prepare.

        Args:
            equations: of the separation.
            tolerance: of the error estimates of all steps of a run together, in SI.
            max_steps: at which a lane is given up.
            one_by_one: whether known events at the same time happen in steps of their
                own, of no length: each has a derivative of its own.
        """
        self._equations = equations
        self._separation = equations.separation
        self._max_steps = max_steps
        self._events = Events(equations, one_by_one=one_by_one)
        self._control = StepControl(equations, tolerance)
        attachments = self._separation.attachments
        self._lets_go = np.array([[a.lets_go] for a in attachments], bool)
        pushing = [attachment for attachment, _ in self._separation.pushing]
        parts = [self._separation.may_part(attachment) for attachment in pushing]
        self._parts = np.array(parts, bool)[:, None]

    def fly(self, params: BatchParameters, fold: Fold) -> FinalState:
        """Fly a batch.

        Args:
            params: of the batch.
            fold: what is made of the steps.
        """
        most = jnp.asarray(self._max_steps + 1)  # by then all lanes have ended
        state, _ = self.go_on(self.start(params, fold), params, fold, most)
        return self.end(state)

    def go_on(
        self, state: LaneState, params: BatchParameters, fold: Fold, most: Lanes
    ) -> tuple[LaneState, Lanes]:
        """Return a batch after so many steps at most, and how many these were.

        Args:
            state: of the batch.
            params: of the batch.
            fold: what is made of the steps.
            most: steps; what comes of lanes in the end does not depend on it.
        """
        return lax.while_loop(
            lambda on: self.is_under_way(on[0]) & (on[1] < most),
            lambda on: (self._advance(on[0], params, fold), on[1] + 1),
            (state, jnp.zeros((), dtype=int)),
        )

    def is_under_way(self, state: LaneState) -> Lanes:
        """Return whether any lane of a batch flies."""
        return (state.status == LaneStatus.FLYING).any()

    def end(self, state: LaneState) -> FinalState:
        """Return how the lanes of a batch ended."""
        return FinalState(
            status=state.status,
            time=state.t,
            steps=state.steps,
            evaluations=state.evaluations,
            released=state.latched.mode.released,
            stroke_ends=state.latched.stroke_ends,
            folded=state.folded,
        )

    def start(self, params: BatchParameters, fold: Fold) -> LaneState:
        """Return the mated stack at the time zero, and what happens at once.

        Args:
            params: of the batch.
            fold: what is made of the steps.
        """
        x, mode = self._equations.start(params)
        t = jnp.zeros(x.shape[-1])
        none = self._events.start(mode)
        latched, _ = self._events.latch(none, none.watched, t, _bodies(x), params)
        return LaneState(
            t=t,
            x=x,
            latched=latched,
            step=jnp.zeros_like(t),
            fresh=jnp.full(t.shape, True),
            foreseen=jnp.full(t.shape, jnp.inf),
            status=jnp.full(t.shape, int(LaneStatus.FLYING)),
            steps=jnp.zeros(t.shape, dtype=int),
            evaluations=jnp.zeros(t.shape, dtype=int),
            folded=fold.start(params),
        )

    def _advance(
        self, state: LaneState, params: BatchParameters, fold: Fold
    ) -> LaneState:
        """Take one step of every lane, and let happen what happens at its end."""
        t, mode = state.t, state.latched.mode
        flying = state.status == LaneStatus.FLYING
        wanted = self._control.wanted(state.step, state.fresh, state.x, params, mode)
        end = self._events.next_known(params, mode)
        left = jnp.where(flying, end - t, 0.0)
        pieces = step_control.pieces(left, wanted)
        h, meets_known = left / pieces, pieces == 1.0
        if self._events.crossings:
            way = step_control.towards(state.foreseen, left, wanted)
            h, meets_known = jnp.where(way < h, way, h), meets_known & (way >= h)
        weights = runge_kutta.weights_for(step_control.is_short(h, wanted, flying))
        method = weights.method

        K = runge_kutta.stages(self._equations, method, t, h, state.x, params, mode)
        error = self._control.error(K, method)
        admitted = flying & (error <= 1.0)
        taken, found = self._take(state, K, weights, admitted, h, params)
        # A known event is met exactly.
        t_new = jnp.where(meets_known, end, t + h)
        t_new = jnp.where(taken.fraction < 1.0, t + taken.fraction * h, t_new)
        t_new = jnp.where(taken.accepted, t_new, t)
        length = jnp.where(taken.accepted, taken.fraction * h, 0.0)
        step = Step(t, length, taken.nodes, mode)

        x = taken.nodes[:, -1]
        latched, fresh = self._events.latch(
            state.latched, taken.crossed, t_new, _bodies(x), params
        )
        steps = state.steps + flying
        return LaneState(
            t=t_new,
            x=x,
            latched=latched,
            step=step_control.next_step(
                h, error, method.order_of_error, wanted, admitted
            ),
            fresh=fresh,
            foreseen=self._foreseen(state, taken, found, admitted, h, latched.mode),
            status=self._judge(
                state.status, latched.mode, t_new, steps, ~admitted & (h < _SHORTEST)
            ),
            steps=steps,
            evaluations=state.evaluations + jnp.where(flying, method.stages, 0),
            folded=fold.add(state.folded, params, step),
        )

    def _take(
        self,
        state: LaneState,
        K: Lanes,
        weights: Weights,
        admitted: Lanes,
        h: Lanes,
        params: BatchParameters,
    ) -> tuple[Taken, Found | None]:
        """Return what is taken of a step, and what was looked for within it.

        All is taken until the first event. Where the continuous extension is not exact
        enough to go on from there, nothing is, and the step is tried again, to the
        event that it has found.
        """
        change = jnp.tensordot(weights.at_nodes, K, 1)
        nodes = runge_kutta.at_nodes(state.x, change, h, admitted)
        none = tuple(jnp.zeros_like(watched) for watched in state.latched.watched)
        whole = Taken(nodes, admitted, jnp.ones_like(h), none)
        if not self._events.crossings:
            return whole, None
        moved = jnp.where(admitted, h, 0.0)
        found = self._events.find(state.latched, _bodies(nodes), moved, params)

        def cut(_: None) -> Taken:
            fraction, crossed = self._events.first(found)
            off = self._control.cut_error(K, weights.method, h, fraction)
            accepted = admitted & (off <= 1.0)
            change = runge_kutta.change_until(weights, K, fraction)
            nodes = runge_kutta.at_nodes(state.x, change, h, accepted)
            crossed = self._events.by_kind(crossed & accepted)
            return Taken(nodes, accepted, fraction, crossed)

        return lax.cond(found.beyond.any(), cut, lambda _: whole, None), found

    def _foreseen(
        self,
        state: LaneState,
        taken: Taken,
        found: Found | None,
        admitted: Lanes,
        h: Lanes,
        mode: Mode,
    ) -> Lanes:
        """Return (n,) time until a little beyond the next crossing, s; or infinite."""
        if found is None:
            return state.foreseen
        ahead = self._events.foresee(found, taken.fraction, mode)
        return step_control.beyond_foreseen(
            h, ahead, taken.fraction, taken.accepted, admitted, state.foreseen
        )

    # How it fares.

    def _judge(
        self, status: Lanes, mode: Mode, t: Lanes, steps: Lanes, collapsed: Lanes
    ) -> Lanes:
        """Return (n,) the status of lanes after a step; those that ended keep it."""
        flying = status == LaneStatus.FLYING
        held = (jnp.isinf(mode.released) & self._lets_go).any(axis=0)
        stroke_left = (~mode.spent & self._parts).any(axis=0)
        ended = t >= self._separation.duration
        # The first that holds.
        return jnp.select(
            [
                ~flying,
                collapsed,
                ended & held,
                ended & stroke_left,
                ended,
                steps >= self._max_steps,
            ],
            [
                status,
                int(LaneStatus.STEP_COLLAPSED),
                int(LaneStatus.STILL_HELD),
                int(LaneStatus.STROKE_LEFT),
                int(LaneStatus.COMPLETED),
                int(LaneStatus.TOO_MANY_STEPS),
            ],
            int(LaneStatus.FLYING),
        )


def _bodies(x: Lanes) -> BodyState:
    """Return the bodies, of (..., m, n), from states (13, ..., m, n)."""
    return motion_laws.body_state(x, 0, 7)
