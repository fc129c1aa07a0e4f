"""The metrics that runs are judged by, of a whole batch at once, from its steps.

Functionals of signals over time are those of `drakesep.analysis.metrics.metric`. A
few are gathered step by step, the others made of them at the end.

Every metric has its derivative. At a kink (a rate that is zero, two peaks as high, two
ends of strokes at once) it is a generalised one, between those of both sides.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from drakesep.analysis.engines.jax.step_parts import (
    Component,
    Components,
    Part,
    components_of,
)
from drakesep.analysis.engines.jax.step_signals import (
    Rows,
    StepSignals,
    rows,
    summed,
    unwrapped,
)
from drakesep.analysis.metrics.metric import (
    ANGLE,
    WHOLE_RUN,
    Combined,
    Functional,
    Metric,
    Moment,
    Outer,
    When,
    Window,
)
from drakesep.analysis.metrics.requirements import Limits, limits_of
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.integrator import Step
from drakesep.systems.batch.lanes import BatchParameters, Lanes, pick
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.equations.relative_motion import RelativeMotion


_ROUND_OFF = 1e-13
"""By which two values of the same may differ, as a part of them."""


_EXTREMES = (Functional.SMALLEST, Functional.LARGEST)
_GATHERED: Mapping[Functional, tuple[Functional, ...]] = {
    Functional.VALUE: (Functional.VALUE,),
    Functional.MAGNITUDE: (Functional.VALUE,),
    Functional.SMALLEST: (Functional.SMALLEST,),
    Functional.LARGEST: (Functional.LARGEST,),
    Functional.SMALLEST_MAGNITUDE: _EXTREMES,
    Functional.LARGEST_MAGNITUDE: _EXTREMES,
    Functional.INTEGRAL_OF_MAGNITUDE: (Functional.INTEGRAL_OF_MAGNITUDE,),
    Functional.INTEGRAL_OF_SQUARE: (Functional.INTEGRAL_OF_SQUARE,),
    Functional.TIME_WITHIN: (Functional.TIME_WITHIN,),
    Functional.TIME: (),
}
"""Of what each functional is made."""
_BEFORE_ANY = {
    Functional.VALUE: 0.0,
    Functional.SMALLEST: math.inf,
    Functional.LARGEST: -math.inf,
    Functional.INTEGRAL_OF_MAGNITUDE: 0.0,
    Functional.INTEGRAL_OF_SQUARE: 0.0,
    Functional.TIME_WITHIN: math.inf,
}
"""What is gathered before the first step."""


class _Gathered(NamedTuple):
    """What is gathered of some components at the same time of the run."""

    functional: Functional
    pair: str
    when: When
    components: tuple[Component, ...]


class Found(NamedTuple):
    """What has been found so far."""

    times: tuple[Lanes, ...]
    """(n,) when each moment was, s; infinite before it."""
    values: tuple[Lanes, ...]
    """(c, n) of the components of what is gathered."""
    going_on: Lanes
    """(a, n) of the components that go on from step to step, at the end of the last:
    integrals, and angles without jumps, which are NaN before the first."""


class MetricsFold:
    """Gathers metrics of a batch, step by step.

    Attributes:
        names: (n_m,) of the metrics.
    """

    def __init__(
        self,
        equations: BatchEquations,
        deviation_limits: Limits,
        metrics: Sequence[Metric],
    ):
        """Prepare.

        Args:
            equations: of the separation.
            deviation_limits: of roll, pitch and yaw, rad; infinite for none.
            metrics: to be told; those that steps do not tell are left out, and those
                that look at what comes about in no run.
        """
        self._equations = equations
        self._duration = equations.separation.duration
        pairs = equations.separation.pairs
        self._pairs = {"": pairs[0], **{pair.B: pair for pair in pairs}}
        self._limits = {
            component: limit
            for name in self._pairs
            for component, limit in zip(
                components_of(name, ANGLE),
                limits_of(deviation_limits, name),
                strict=True,
            )
            if limit < math.inf
        }
        self._metrics = [
            metric
            for metric in metrics
            if metric.of_steps and metric.comes_about(equations.separation)
        ]
        self.names = tuple(name for m in self._metrics for name in m.names)
        self._moments: list[tuple[str, Moment]] = list(
            dict.fromkeys(
                (metric.pair, metric.when)
                for metric in self._metrics
                if isinstance(metric.when, Moment) and metric.when is not Moment.END
            )
        )
        gathered = self._all_gathered()
        # Of these polynomials are made.
        self._components = list(
            dict.fromkeys(
                component
                for one in gathered
                for component in one.components
                if component.summed or not isinstance(one.when, Moment)
            )
        )
        self._gathered = [self._in_order(one) for one in gathered]
        turning = {
            component
            for metric in self._metrics
            if metric.signal is not None and metric.signal.turns
            for component in components_of(metric.pair, metric.signal)
        }
        self._angles = [c for c in self._components if c in turning]
        self._going_on = self._angles + [c for c in self._components if c.summed]

    def _in_order(self, gathered: _Gathered) -> _Gathered:
        """Return the same with its components in the order of the polynomials."""
        if isinstance(gathered.when, Moment):
            return gathered
        in_order = sorted(gathered.components, key=self._components.index)
        return gathered._replace(components=tuple(in_order))

    def _all_gathered(self) -> list[_Gathered]:
        """Return what is to be gathered, the same of several metrics once."""
        components: dict[tuple[Functional, str, When], dict[Component, None]] = {}
        for metric in self._metrics:
            for functional in _GATHERED[metric.functional]:
                key = functional, metric.pair, metric.when
                mine = components.setdefault(key, {})
                mine |= dict.fromkeys(self._looked_at(metric))
        return [
            _Gathered(*key, tuple(mine)) for key, mine in components.items() if mine
        ]

    def _looked_at(self, metric: Metric) -> list[Component]:
        """Return the components that a metric looks at: of limited ones, only those."""
        if metric.signal is None:
            return []
        every = components_of(metric.pair, metric.signal)
        if metric.functional is Functional.TIME_WITHIN:
            return [component for component in every if component in self._limits]
        return every

    def start(self, params: BatchParameters) -> Found:
        """Return what there is before the first step."""
        _, n = params.mass.shape
        return Found(
            tuple(jnp.full(n, jnp.inf) for _ in self._moments),
            tuple(
                jnp.full((len(g.components), n), _BEFORE_ANY[g.functional])
                for g in self._gathered
            ),
            jnp.full((len(self._going_on), n), jnp.nan).at[len(self._angles) :].set(0),
        )

    def add(self, found: Found, params: BatchParameters, step: Step) -> Found:
        """Return what there is after a step."""
        told = self._components_at(params, step)
        smooth = {c: told.lanes(c) for c in self._components}
        for c, before in zip(self._going_on, found.going_on, strict=True):
            if c.summed:
                smooth[c] = summed(smooth[c], step.length, before)
            else:
                smooth[c] = unwrapped(smooth[c], before)
        going_on = [smooth[c][-1] for c in self._going_on]
        looked_at = self._parts(list(smooth.values()), step)
        begins = {
            key: self._begun(*key, step) & jnp.isinf(before)
            for key, before in zip(self._moments, found.times, strict=True)
        }
        values = []
        for gathered, before in zip(self._gathered, found.values, strict=True):
            if isinstance(gathered.when, Window):
                part = looked_at[gathered.pair, gathered.when]
                values.append(self._over(gathered, before, part))
            elif isinstance(gathered.when, Moment):
                now = self._at(gathered, told, smooth)
                if gathered.when is not Moment.END:  # else it is the last that was
                    begin = begins[gathered.pair, gathered.when]
                    now = jnp.where(begin, now, before)
                values.append(now)
            else:
                values.append(self._at_time(gathered, before, looked_at))
        times = tuple(
            jnp.where(begins[key], step.start, before)
            for key, before in zip(self._moments, found.times, strict=True)
        )
        ends = jnp.stack(going_on) if going_on else found.going_on
        return Found(times, tuple(values), ends)

    def _components_at(self, params: BatchParameters, step: Step) -> Components:
        """Return the components of the motions of a step."""
        equations = self._equations

        def told(name: str) -> tuple[RelativeMotion, PairFacts]:
            pair = self._pairs[name]
            _, b = equations.bodies_of(pair)
            facts = PairFacts.of(equations.separation, pair)
            motion = equations.relative_motion(pair, step.bodies, params)
            return motion, facts._replace(I_BBcm_B=pick(params.I_BBcm_B, b))

        return Components(told)

    def _begun(self, name: str, moment: Moment, step: Step) -> Lanes:
        """Return (n,) whether a moment was at or before the start of a step."""
        if moment is Moment.START:
            return step.length >= 0.0
        if moment is Moment.END:
            return step.length < 0.0
        began, ended = self._equations.progress(self._pairs[name].B, step.mode)
        return began if moment is Moment.RELEASE else ended

    def _parts(
        self, smooth: Sequence[Lanes], step: Step
    ) -> dict[tuple[str, When], Part]:
        """Return the parts of a step that are looked at, with their signals."""
        if not smooth:
            return {}
        whole = Part(step.start, step.length, StepSignals(smooth), step.length >= 0.0)
        parts: dict[tuple[str, When], Part] = {("", WHOLE_RUN): whole}
        for gathered in self._gathered:
            key = gathered.pair, gathered.when
            if isinstance(gathered.when, Window) and key not in parts:
                parts[key] = self._part(whole, gathered.pair, gathered.when, step)
        return parts

    def _part(self, whole: Part, name: str, window: Window, step: Step) -> Part:
        """Return what lies in a window: steps end where moments are."""
        inside = whole.inside
        start, end = window.start, window.end
        if isinstance(start, Moment):
            inside &= self._begun(name, start, step)
        if isinstance(end, Moment):
            inside &= ~self._begun(name, end, step)
        return whole._replace(inside=inside).between(
            None if isinstance(start, Moment) else start,
            None if isinstance(end, Moment) else end,
        )

    def _at(
        self,
        gathered: _Gathered,
        told: Components,
        smooth: Mapping[Component, Lanes],
    ) -> Lanes:
        """Return (c, n) components at the start of a step, or at its end."""
        node = -1 if gathered.when is Moment.END else 0
        return jnp.stack(
            [
                (smooth[c] if c.summed else told.lanes(c))[node]
                for c in gathered.components
            ]
        )

    def _at_time(
        self,
        gathered: _Gathered,
        before: Lanes,
        parts: Mapping[tuple[str, When], Part],
    ) -> Lanes:
        """Return (c, n) components at a time in seconds, once a step holds it."""
        whole = parts["", WHOLE_RUN]
        assert isinstance(gathered.when, float)
        theta, holds = whole.fraction(gathered.when)
        which = rows([self._components.index(c) for c in gathered.components])
        now = whole.signals.at(theta[None])[0, which]
        turn = 2.0 * jnp.pi
        turns = np.array([c in self._angles for c in gathered.components])[:, None]
        now = jnp.where(turns, now - turn * jnp.round(now / turn), now)
        return jnp.where(holds, now, before)

    def _over(self, gathered: _Gathered, before: Lanes, part: Part) -> Lanes:
        """Return (c, n) what is gathered over some time, after a step."""
        which = rows([self._components.index(c) for c in gathered.components])
        signals = part.signals
        # Where events coincide, steps of no length lie between them: what stands there
        # has been seen, and moves with the time of another event.
        moving = part.inside & (part.length > 0.0)
        match gathered.functional:
            case Functional.SMALLEST:
                return -_larger(-before, -signals.lowest[which], moving)
            case Functional.LARGEST:
                return _larger(before, signals.highest[which], moving)
            case Functional.INTEGRAL_OF_MAGNITUDE:
                mean = signals.mean_magnitude(which)
            case Functional.INTEGRAL_OF_SQUARE:
                mean = signals.mean_square(which)
            case _:
                return self._within_until(gathered, which, before, part)
        return before + jnp.where(part.inside, part.length * mean, 0.0)

    def _within_until(
        self,
        gathered: _Gathered,
        which: Rows,
        before: Lanes,
        part: Part,
    ) -> Lanes:
        limits = jnp.array([self._limits[c] for c in gathered.components])
        beyond, theta = part.signals.first_beyond(which, limits)
        times = jnp.where(beyond, part.start + theta * part.length, jnp.inf)
        return jnp.where(jnp.isfinite(before), before, times)

    def finish(self, found: Found) -> Lanes:
        """Return (n_m, n) metrics, in the order of their names."""
        gathered = {
            (g.functional, g.when, component): value
            for g, values in zip(self._gathered, found.values, strict=True)
            for component, value in zip(g.components, values, strict=True)
        }
        told = [self._told(m, gathered, found) for m in self._metrics]
        none = jnp.zeros((0, found.going_on.shape[-1]))
        return jnp.concatenate([none, *told])

    def _told(
        self,
        metric: Metric,
        gathered: Mapping[tuple[Functional, When, Component], Lanes],
        found: Found,
    ) -> Lanes:
        """Return (k, n) the numbers of a metric."""

        def of(functional: Functional) -> Lanes:
            return jnp.stack(
                [gathered[functional, metric.when, c] for c in self._looked_at(metric)]
            )

        whole = jnp.full((1, found.going_on.shape[-1]), self._duration)
        if metric.functional is Functional.TIME:
            assert isinstance(metric.when, Moment)
            times = dict(zip(self._moments, found.times, strict=True))
            time = times.get((metric.pair, metric.when))
            each = whole if time is None else time[None]
        elif metric.functional is Functional.TIME_WITHIN:
            limited = self._looked_at(metric)
            each = jnp.minimum(of(metric.functional), whole) if limited else whole
        else:
            each = _derived(metric.functional, of)
            assert metric.signal is not None
            each = _outer(metric.signal.outer, each)
        return metric.sign * _combined(metric.combined, each)


def _larger(before: Lanes, value: Lanes, when: Lanes) -> Lanes:
    # A peak at a kink ends one step and begins the next: it is that of the first,
    # whatever round-off says.
    more = value - before > _ROUND_OFF * jnp.abs(value)
    return jnp.where(when & more, value, before)


def _derived(functional: Functional, of: Callable[[Functional], Lanes]) -> Lanes:
    """Return what a functional is, of what is gathered."""
    match functional:
        case Functional.MAGNITUDE:
            return jnp.abs(of(Functional.VALUE))
        case Functional.LARGEST_MAGNITUDE:
            return jnp.maximum(-of(Functional.SMALLEST), of(Functional.LARGEST))
        case Functional.SMALLEST_MAGNITUDE:
            lowest, highest = of(Functional.SMALLEST), of(Functional.LARGEST)
            return jnp.maximum(0.0, jnp.maximum(lowest, -highest))
        case _:
            return of(functional)


def _outer(outer: Outer, each: Lanes) -> Lanes:
    """Return what is made of signals; its derivative at zero, a kink, is zero."""
    match outer:
        case Outer.ITSELF:
            return each
        case Outer.ROOT:
            return _root(each)
        case Outer.CONE:
            inner = jnp.minimum(_root(each), 1.0 - _ROUND_OFF)
            return 2.0 * jnp.arcsin(inner)


def _combined(combined: Combined, each: Lanes) -> Lanes:
    """Return (k, n) what is made of the components (c, n)."""
    match combined:
        case Combined.EACH:
            return each
        case Combined.SUM:
            return each.sum(axis=0)[None]
        case Combined.ROOT_OF_SUM:
            return _root(each.sum(axis=0))[None]
        case Combined.SMALLEST:
            return each.min(axis=0)[None]


def _root(square: Lanes) -> Lanes:
    """Return the square root; its derivative at zero, a kink, is taken as zero."""
    some = square > 0.0
    return jnp.where(some, jnp.sqrt(jnp.where(some, square, 1.0)), 0.0)
