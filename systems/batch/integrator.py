"""The integration of a batch of separations, every sample at its own pace.

Each sample takes steps of DOP853 (see `runge_kutta`), controlled by its own error
estimate and ended at its own kinks: releases, ends of strokes and rows of load tables
at times that are known beforehand, and strokes, corners of profiles and hinge angles
that are found within a step. Where kinks of all samples are near, as ends of strokes
are, DOPRI5 goes from one to the next with half the stages. What a sample does depends
on its own params; on those of its neighbours in the batch by less than a hundredth
of its tolerance, as they choose between the two.

Everything is differentiable in forward mode: steps end where events are, whose times
carry their derivatives; only the choice of the number of steps carries none.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.batch import lobatto, polynomials
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode, pick
from drakesep.systems.batch.tableaus import DOP853, DOPRI5, Method
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.mated_stack import mated_orientation
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.vectors import TINY


FLYING, COMPLETED, STILL_HELD, STROKE_LEFT, STEP_COLLAPSED, TOO_MANY_STEPS = range(6)
"""How a sample fares."""
_SHORTEST = 1e-12
"""Step, s, below which an integration has collapsed."""
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 6.0
_PHASE = 0.8
"""First guess of a step, rad of the fastest motion, at a tolerance of 1e-8."""
_TURN = 0.4
"""Largest rotation in a step, rad: its nodes resolve rates and angles to 1e-9."""
_SHORT = 0.02
"""Part of the wanted step below which DOPRI5 is as exact."""


class _Weights(NamedTuple):
    """What makes a step of the stages' derivatives: params, or their traces."""

    method: Method
    at_nodes: Lanes
    """(8, 16) weights of the stages for the states at the nodes of `lobatto`."""

    @classmethod
    def of(cls, method: Method) -> "_Weights":
        # At the ends exactly: nothing, and the step's own.
        inner = method.weights_at(lobatto.THETA[1:-1])
        return cls(method, np.vstack([0.0 * method.B, inner, method.B]))


_LONG, _BRIEF = _Weights.of(DOP853), _Weights.of(DOPRI5)


class Step(NamedTuple):
    """A stretch of the motion of every sample, from kink to kink or shorter.

    A sample that did not move has the length zero, and its state at every node.
    """

    start: Lanes
    """(n,), s."""
    length: Lanes
    """(n,), s."""
    x: Lanes
    """(13, 8, m, n) states of the bodies at the nodes of `lobatto`."""
    mode: Mode
    """What has happened by the start."""
    separating: Lanes
    """(n,) whether an attachment of B has let go."""
    separated: Lanes
    """(n,) whether all have, and all their strokes are reached."""

    @property
    def bodies(self) -> BodyState:
        """The bodies at the nodes, of (8, m, n)."""
        return motion_laws.body_state(self.x, 0, 7)


class Fold(Protocol):
    """What is made of the steps of a run, one after the other."""

    def start(self, params: BatchParameters) -> Any:
        """Return what there is before the first step."""

    def add(self, carry: Any, params: BatchParameters, step: Step) -> Any:
        """Return what there is after a step."""


class LaneState(NamedTuple):
    """Where the samples of a batch are."""

    t: Lanes
    x: Lanes
    mode: Mode
    stroke_ends: Lanes
    beyond: Lanes
    """(e, n) whether the quantity of each event was at or above its threshold."""
    watched: Lanes
    """(e, n) whether it could happen in the step before."""
    step: Lanes
    """(n,) that the next would like to take, s."""
    status: Lanes
    steps: Lanes
    evaluations: Lanes
    folded: Any


class FinalState(NamedTuple):
    """How the samples of a batch ended."""

    status: Lanes
    """(n,) COMPLETED, or why not."""
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


class _Event(NamedTuple):
    """Something that happens where a quantity crosses zero."""

    quantity: Callable[[BodyState, BatchParameters], Lanes]
    attachment: int
    spring: int | None
    """That must push; None: the attachment must hold."""
    latches: bool
    """Whether it happens once, upwards: the stroke's end, or the release."""


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
            max_steps: at which a sample is given up.
            one_by_one: whether known events at the same time happen in steps of their
                own, of no length: each has a derivative of its own.
        """
        self._equations = equations
        self._separation = equations.separation
        self._tolerance = tolerance
        self._max_steps = max_steps
        self._one_by_one = one_by_one
        self._events = _events(equations)
        B = self._separation.B
        self._of_B = [
            i for i, a in enumerate(self._separation.attachments) if B in (a.A, a.B)
        ]

    def fly(self, params: BatchParameters, fold: Fold) -> FinalState:
        """Fly a batch.

        Args:
            params: of the batch.
            fold: what is made of the steps.
        """
        x, mode = self._equations.start(params)
        n = x.shape[-1]
        events = jnp.full((len(self._events), n), False)
        state = LaneState(
            t=jnp.zeros(n),
            x=x,
            mode=mode,
            stroke_ends=jnp.full(mode.spent.shape, jnp.inf),
            beyond=events,
            watched=events,
            step=jnp.full(n, jnp.nan),
            status=jnp.full(n, FLYING),
            steps=jnp.zeros(n, dtype=int),
            evaluations=jnp.zeros(n, dtype=int),
            folded=fold.start(params),
        )
        state = lax.while_loop(
            lambda state: (state.status == FLYING).any(),
            lambda state: self._advance(state, params, fold),
            state,
        )
        return FinalState(
            state.status,
            state.t,
            state.steps,
            state.evaluations,
            state.mode.released,
            state.stroke_ends,
            state.folded,
        )

    def _advance(
        self, state: LaneState, params: BatchParameters, fold: Fold
    ) -> LaneState:
        """Take one step of every sample."""
        state = self._latch(state, params)
        t, mode = state.t, state.mode
        flying = state.status == FLYING
        wanted = jnp.where(
            jnp.isnan(state.step), self._first_guess(state, params), state.step
        )
        wanted = jnp.minimum(wanted, _TURN / (_fastest(state.x) + TINY))
        end = self._next_known_event(params, mode)
        left = jnp.where(flying, end - t, 0.0)
        pieces = jnp.maximum(jnp.ceil(_still(left / wanted) - 1e-9), 1.0)
        h = left / pieces

        short = jnp.where(flying, h < _SHORT * wanted, True).all()
        weights: _Weights = jax.tree.map(
            lambda long, brief: jnp.where(short, brief, long), _LONG, _BRIEF
        )
        method = weights.method

        K = self._stages(state, h, method, params)
        error = self._error(K, method)
        accepted = flying & (error <= 1.0)
        moved = jnp.where(accepted, h, 0.0)
        nodes, fraction, beyond, crossed = self._to_first_event(
            state, K, weights, accepted, moved, params
        )
        t_new = jnp.where(pieces > 1.0, t + h, end)
        t_new = jnp.where(fraction < 1.0, t + fraction * h, t_new)
        separating, separated = self._progress(mode)
        step = Step(t, fraction * moved, nodes, mode, separating, separated)
        factor = jnp.clip(
            _SAFETY * (error + TINY) ** (-1.0 / method.order_of_error),
            _SHRINK,
            _GROW,
        )
        factor = jnp.where(jnp.isfinite(error), factor, _SHRINK)
        controlled = _still(h * factor)
        controlled = jnp.where(accepted, jnp.maximum(controlled, wanted), controlled)
        state = state._replace(
            t=jnp.where(accepted, t_new, t),
            x=nodes[:, -1],
            beyond=beyond,
            step=jnp.where(flying, controlled, state.step),
            steps=state.steps + flying,
            evaluations=state.evaluations + jnp.where(flying, method.stages, 0),
            folded=fold.add(state.folded, params, step),
        )
        state = self._latch_crossed(state, crossed)
        return state._replace(status=self._judge(state, accepted, h))

    # What happens at known times.

    def _known_events(self, params: BatchParameters, mode: Mode) -> tuple[Lanes, Lanes]:
        """Return (e, n) the times of known events, s, and whether they are to come.

        First the releases, then the ends of strokes by time, then the rows of loads.
        """
        timed = np.isin(np.arange(len(mode.spent)), self._equations.springs.timed)[
            :, None
        ]
        times = [
            params.release_time,
            self._equations.springs.stroke_end(params, mode),
            self._equations.row_times(params, mode),
        ]
        ahead = [jnp.isinf(mode.released), timed & ~mode.spent, ~mode.passed]
        return jnp.concatenate(times), jnp.concatenate(ahead)

    def _latch(self, state: LaneState, params: BatchParameters) -> LaneState:
        """Let happen what is due by now."""
        state = self._latch_due(state, params)
        if not self._one_by_one:
            state = self._latch_due(state, params)  # loads that a release starts
        if not self._events:
            return state
        # What begins to be watched may be beyond its threshold already.
        watched = self._watched(state.mode)
        begins = watched & ~state.watched
        now = self._quantities(state.x, params) >= 0.0
        state = state._replace(
            beyond=jnp.where(begins, now, state.beyond), watched=watched
        )
        return self._latch_crossed(state, begins & now)

    def _latch_due(self, state: LaneState, params: BatchParameters) -> LaneState:
        mode = state.mode
        times, ahead = self._known_events(params, mode)
        due = ahead & (times <= state.t)
        if self._one_by_one:
            due = due & (jnp.cumsum(due, axis=0) == 1)
        a, k = len(mode.released), len(mode.spent)
        released, ended, passed = due[:a], due[a : a + k], due[a + k :]
        return state._replace(
            mode=Mode(
                jnp.where(released, times[:a], mode.released),
                mode.spent | ended,
                mode.passed | passed,
            ),
            stroke_ends=jnp.where(ended, times[a : a + k], state.stroke_ends),
            step=jnp.where(due.any(axis=0), jnp.nan, state.step),
        )

    def _latch_crossed(self, state: LaneState, crossed: Lanes) -> LaneState:
        """Let happen what was crossed at this time."""
        released, spent, passed = state.mode
        stroke_ends, step = state.stroke_ends, state.step
        for event, happened in zip(self._events, crossed, strict=True):
            if not event.latches:
                continue
            if event.spring is None:
                i = event.attachment
                released = released.at[i].set(jnp.where(happened, state.t, released[i]))
            else:
                k = event.spring
                spent = spent.at[k].set(spent[k] | happened)
                stroke_ends = stroke_ends.at[k].set(
                    jnp.where(happened, state.t, stroke_ends[k])
                )
            step = jnp.where(happened, jnp.nan, step)
        return state._replace(
            mode=Mode(released, spent, passed), stroke_ends=stroke_ends, step=step
        )

    def _next_known_event(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (n,) the next time at which something is known to happen, s."""
        times, ahead = self._known_events(params, mode)
        times = jnp.where(ahead, times, jnp.inf)
        # Not min: of events at the same time, it would mix the derivatives.
        first = jnp.argmin(times, axis=0)[None]
        time = jnp.take_along_axis(times, first, 0)[0]
        duration = self._separation.duration
        return jnp.where(time < duration, time, duration)

    def _first_guess(self, state: LaneState, params: BatchParameters) -> Lanes:
        """Return (n,) a step that suits what acts now, s."""
        mode = state.mode
        frequency = _fastest(state.x)
        pushing = self._equations.springs.pushing(mode)
        for k in range(len(pushing)):
            spring = self._equations.springs.frequency(k, params)
            frequency = jnp.maximum(frequency, jnp.where(pushing[k], spring, 0.0))
        if self._equations.holds:
            frequency = jnp.maximum(frequency, self._held_frequency(params, mode))
        scale = (self._tolerance / 1e-8) ** (1.0 / DOP853.order_of_error)
        return _still(_PHASE * scale / (frequency + 1e-3))

    def _held_frequency(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (n,) the fastest motion of bodies in the joints that hold, rad/s."""
        lightness = 1.0 / params.mass
        inverse_inertia = 1.0 / jnp.stack(tuple(params.I_BBcm_B)[:3]).min(axis=0)
        K, D = jnp.zeros_like(lightness[0]), jnp.zeros_like(lightness[0])
        for i, attachment in enumerate(self._separation.attachments):
            gains = np.reshape(attachment.joint.held_gains(), (4, 3)).max(axis=1)
            a, b = self._equations.ends[i]
            arms = [
                sum(x * x for x in _arm(params, body, pads, i))
                for body, pads in ((a, params.p_AoPad_A), (b, params.p_BoPad_B))
            ]
            turning = inverse_inertia[a] + inverse_inertia[b]
            moving = (
                lightness[a]
                + lightness[b]
                + arms[0] * inverse_inertia[a]
                + arms[1] * inverse_inertia[b]
            )
            held = jnp.isinf(mode.released[i])
            K = K + jnp.where(held, gains[0] * moving + gains[2] * turning, 0.0)
            D = D + jnp.where(held, gains[1] * moving + gains[3] * turning, 0.0)
        return jnp.maximum(jnp.sqrt(K + TINY), D)

    # A step.

    def _stages(
        self, state: LaneState, h: Lanes, method: Method, params: BatchParameters
    ) -> Lanes:
        """Return (16, 13, m, n) derivatives at the stages of a step."""
        x, t, mode = state.x, state.t, state.mode
        times = t + method.C[:, None] * h
        timed = self._equations.at_times(times, params, mode)

        def stages(holding: bool) -> Callable[[None], Lanes]:
            def stage(i: int, K: Lanes) -> Lanes:
                y = x + h * jnp.tensordot(method.A[i], K, 1)
                now = jax.tree.map(lambda lanes: lanes[i], timed)
                k = self._equations.derivative(holding, now, y, params, mode)
                return K.at[i].set(k)

            K = jnp.zeros((len(method.A), *x.shape))
            return lambda _: lax.fori_loop(0, method.stages, stage, K)

        if not self._equations.holds:
            return stages(False)(None)
        held = jnp.isinf(mode.released).any()
        return lax.cond(held, stages(True), stages(False), None)

    def _error(self, K: Lanes, method: Method) -> Lanes:
        """Return (n,) the error estimate of a step over its share of the tolerance."""
        share = self._tolerance / self._separation.duration
        errors = jnp.tensordot(method.errors, _still(K), 1) / share
        square, tempering = (errors**2).sum(axis=(1, 2))
        states = K.shape[1] * K.shape[2]
        return square / jnp.sqrt((square + 0.01 * tempering) * states + TINY)

    def _to_first_event(
        self,
        state: LaneState,
        K: Lanes,
        weights: _Weights,
        accepted: Lanes,
        moved: Lanes,
        params: BatchParameters,
    ) -> tuple[Lanes, Lanes, Lanes, Lanes]:
        """Return the states at the nodes of a step, cut off at the first event in it.

        Returns:
            (13, 8, m, n) states, (n,) the fraction of the step that was taken, (e, n)
            which events are now beyond their threshold, and (e, n) which happened.
        """
        change = jnp.tensordot(weights.at_nodes, K, 1)
        nodes = state.x + jnp.where(accepted, moved * change, 0.0)
        nodes = jnp.moveaxis(nodes, 0, 1)
        whole = jnp.ones_like(moved)
        none = jnp.full(state.beyond.shape, False)
        if not self._events:
            return nodes, whole, state.beyond, none
        values = self._quantities(nodes, params)
        watched = self._watched(state.mode) & (moved > 0.0)
        quantities = polynomials.pieces(jnp.moveaxis(values, 1, 0))
        beyond = ((quantities.values >= 0.0) != state.beyond) & watched
        # At the start stands what has just been crossed, on either side of zero.
        beyond = beyond & (quantities.xi > -1.0)

        def cut(_: None) -> tuple[Lanes, Lanes, Lanes]:
            zero = jnp.zeros_like(values[:, 0])
            at = polynomials.first_place(quantities, beyond, zero)
            at = jnp.where(beyond.any(axis=0), at, 2.0)
            # One at a time: what happens at once has derivatives of its own, and
            # follows in a step of no length.
            first = jnp.argmin(at, axis=0)[None]
            fraction = jnp.minimum(jnp.take_along_axis(at, first, 0)[0], 1.0)
            index = jnp.arange(len(at))[:, None]
            happened = (index == first) & (at < 1.0)
            powers = jnp.tensordot(weights.method.powers, K, 1)
            theta = lobatto.THETA[:, None] * fraction
            total = jnp.zeros_like(change)
            for coefficient in powers[::-1]:
                total = total * theta[:, None, None, :] + coefficient
            cut_nodes = state.x + jnp.where(accepted, moved * total, 0.0)
            return jnp.moveaxis(cut_nodes, 0, 1), fraction, happened

        nodes, fraction, happened = lax.cond(
            beyond.any(), cut, lambda _: (nodes, whole, none), None
        )
        return nodes, fraction, state.beyond ^ happened, happened

    def _quantities(self, x: Lanes, params: BatchParameters) -> Lanes:
        """Return (e, ..., n) the events' quantities at states (13, ..., m, n)."""
        bodies = motion_laws.body_state(x, 0, 7)
        return jnp.stack([event.quantity(bodies, params) for event in self._events])

    def _watched(self, mode: Mode) -> Lanes:
        """Return (e, n) whether each event can happen."""
        pushing = self._equations.springs.pushing(mode)
        held = jnp.isinf(mode.released)
        return jnp.stack(
            [
                held[event.attachment]
                if event.spring is None
                else pushing[event.spring]
                for event in self._events
            ]
        )

    # How it fares.

    def _progress(self, mode: Mode) -> tuple[Lanes, Lanes]:
        """Return (n,) whether B has begun to separate, and whether it has ended."""
        free = jnp.isfinite(mode.released)
        began, ended = jnp.full(free.shape[1:], False), jnp.full(free.shape[1:], True)
        for i in self._of_B:
            began, ended = began | free[i], ended & free[i]
            if i in self._equations.springs.attachments:
                k = self._equations.springs.attachments.index(i)
                ended = ended & mode.spent[k]
        return began, ended

    def _judge(self, state: LaneState, accepted: Lanes, h: Lanes) -> Lanes:
        """Return (n,) the status of the samples after a step."""
        held = jnp.isinf(state.mode.released).any(axis=0)
        stroke_left = ~state.mode.spent.all(axis=0)
        end = jnp.where(
            held, STILL_HELD, jnp.where(stroke_left, STROKE_LEFT, COMPLETED)
        )
        status = jnp.where(state.t >= self._separation.duration, end, FLYING)
        collapsed = ~accepted & (h < _SHORTEST)
        status = jnp.where(collapsed, STEP_COLLAPSED, status)
        too_many = (status == FLYING) & (state.steps >= self._max_steps)
        status = jnp.where(too_many, TOO_MANY_STEPS, status)
        return jnp.where(state.status == FLYING, status, state.status)


def _still(x: Lanes) -> Lanes:
    """Return x without its derivative: what only decides how to go on."""
    return lax.stop_gradient(x)


def _fastest(x: Lanes) -> Lanes:
    """Return (n,) the largest angular velocity of the bodies, rad/s."""
    w = _still(x[7:10])
    return jnp.sqrt((w * w).sum(axis=0)).max(axis=0)


def _arm(params: BatchParameters, body: int, pads: Any, i: int) -> tuple[Lanes, ...]:
    cg = pick(params.p_BoBcm_B, body)
    return tuple(pad - c for pad, c in zip(pick(pads, i), cg, strict=True))


def _events(equations: BatchEquations) -> list[_Event]:
    """Return what is found within steps."""
    separation = equations.separation
    events = []
    springs = equations.springs
    for k in springs.by_stroke:
        i = springs.attachments[k]
        for u in (*springs.corners(k), 1.0):
            events.append(_Event(_beyond(equations, k, u), i, k, u == 1.0))
        if springs.may_lift(k):
            events.append(_Event(_lifted(equations, k), i, k, False))
    for i, attachment in enumerate(separation.attachments):
        if np.isfinite(attachment.release_angle):
            events += [
                _Event(_turned(equations, i, way), i, None, True) for way in (1.0, -1.0)
            ]
    return events


def _beyond(equations: BatchEquations, k: int, u: float) -> Callable[..., Lanes]:
    def quantity(bodies: BodyState, params: BatchParameters) -> Lanes:
        displacement, _ = equations.springs.displacement(k, bodies, params)
        return displacement - u * equations.springs.stroke(k, params)

    return quantity


def _lifted(equations: BatchEquations, k: int) -> Callable[..., Lanes]:
    def quantity(bodies: BodyState, params: BatchParameters) -> Lanes:
        return -equations.springs.stroke_force(k, bodies, params)

    return quantity


def _turned(equations: BatchEquations, i: int, way: float) -> Callable[..., Lanes]:
    a, b = equations.ends[i]
    separation = equations.separation
    q_AB = mated_orientation(separation.bodies[a], separation.bodies[b])
    axis_A = separation.attachments[i].joint.x_axis_A

    def quantity(bodies: BodyState, params: BatchParameters) -> Lanes:
        A, B = pick(bodies, a), pick(bodies, b)
        angle = joint_laws.twist_angle(A.q_WB, B.q_WB, q_AB, axis_A, jnp)
        return way * angle - params.release_angle[i]

    return quantity
