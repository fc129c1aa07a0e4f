"""The metrics that runs are judged by, of a whole batch at once, from its steps.

Functionals of signals over time are those of `drakesep.analysis.metrics.metric`. A
few are gathered step by step, the others made of them at the end.

Every metric has its derivative. At a kink (a rate that is zero, two peaks as high, two
ends of strokes at once) it is a generalised one, between those of both sides.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import jax.numpy as jnp

from drakesep.analysis.engines.jax.step_signals import (
    Rows,
    StepSignals,
    rows,
    unwrapped,
)
from drakesep.analysis.metrics.metric import (
    ANGLE,
    Combined,
    Functional,
    Metric,
    Moment,
    Signal,
    Window,
)
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.integrator import Step
from drakesep.systems.batch.lanes import BatchParameters, Lanes, pick
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.relative_motion import RelativeMotion


_ROUND_OFF = 1e-13
"""By which two values of the same may differ, as a part of them."""

Component: TypeAlias = tuple[str, int]
"""A field of `RelativeMotion`, and which of its components."""
When: TypeAlias = Window | Moment

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
    when: When
    components: tuple[Component, ...]


class Found(NamedTuple):
    """What has been found so far."""

    times: Mapping[str, Lanes]
    """(n,) when each moment was, s; infinite before it."""
    values: tuple[Lanes, ...]
    """(c, n) of the components of what is gathered."""
    angles: Lanes
    """(a, n) of the components that are angles, at the end of the last step, without
    jumps; NaN before the first."""


class MetricsFold:
    """Gathers metrics of a batch, step by step.

    Attributes:
        names: (n_m,) of the metrics.
    """

    def __init__(
        self,
        equations: BatchEquations,
        deviation_limits: Sequence[float],
        metrics: Sequence[Metric],
    ):
        """Prepare.

        Args:
            equations: of the separation.
            deviation_limits: (3,) of roll, pitch and yaw, rad; infinite for none.
            metrics: to be told; those that are not of every run are left out.
        """
        self._equations = equations
        self._duration = equations.separation.duration
        limits = zip(_components_of(ANGLE), deviation_limits, strict=True)
        self._limits = {c: limit for c, limit in limits if limit < math.inf}
        self._metrics = [metric for metric in metrics if metric.of_every_run]
        self.names = tuple(name for m in self._metrics for name in m.names)
        self._moments = [
            moment
            for moment in Moment
            if moment is not Moment.END
            and any(metric.when is moment for metric in self._metrics)
        ]
        gathered = self._all_gathered()
        # Of these polynomials are made.
        self._components = list(
            dict.fromkeys(
                component
                for one in gathered
                if isinstance(one.when, Window)
                for component in one.components
            )
        )
        self._gathered = [self._in_order(one) for one in gathered]
        turning = {
            component
            for metric in self._metrics
            if metric.signal is not None and metric.signal.turns
            for component in _components_of(metric.signal)
        }
        self._angles = [c for c in self._components if c in turning]

    def _in_order(self, gathered: _Gathered) -> _Gathered:
        """Return the same with its components in the order of the polynomials."""
        if isinstance(gathered.when, Moment):
            return gathered
        in_order = sorted(gathered.components, key=self._components.index)
        return gathered._replace(components=tuple(in_order))

    def _all_gathered(self) -> list[_Gathered]:
        """Return what is to be gathered, the same of several metrics once."""
        components: dict[tuple[Functional, When], dict[Component, None]] = {}
        for metric in self._metrics:
            for functional in _GATHERED[metric.functional]:
                mine = components.setdefault((functional, metric.when), {})
                mine |= dict.fromkeys(self._looked_at(metric))
        return [
            _Gathered(*key, tuple(mine)) for key, mine in components.items() if mine
        ]

    def _looked_at(self, metric: Metric) -> list[Component]:
        """Return the components that a metric looks at: of limited ones, only those."""
        every = [] if metric.signal is None else _components_of(metric.signal)
        if metric.functional is Functional.TIME_WITHIN:
            return [component for component in every if component in self._limits]
        return every

    def start(self, params: BatchParameters) -> Found:
        """Return what there is before the first step."""
        _, n = params.mass.shape
        return Found(
            {moment.name: jnp.full(n, jnp.inf) for moment in self._moments},
            tuple(
                jnp.full((len(g.components), n), _BEFORE_ANY[g.functional])
                for g in self._gathered
            ),
            jnp.full((len(self._angles), n), jnp.nan),
        )

    def add(self, found: Found, params: BatchParameters, step: Step) -> Found:
        """Return what there is after a step."""
        a, b = self._equations.pair
        bodies = step.bodies
        motion = motion_laws.relative_motion(
            pick(bodies, a), pick(bodies, b), *self._equations.mated_place(params), jnp
        )
        smooth = {c: _component(motion, c) for c in self._components}
        for component, before in zip(self._angles, found.angles, strict=True):
            smooth[component] = unwrapped(smooth[component], before)
        signals = StepSignals(list(smooth.values()))
        angles = [smooth[component][-1] for component in self._angles]
        begins = {
            moment: _begun(moment, step) & jnp.isinf(found.times[moment.name])
            for moment in self._moments
        }
        values = []
        for gathered, before in zip(self._gathered, found.values, strict=True):
            if isinstance(gathered.when, Moment):
                now = self._at(gathered, motion)
                if gathered.when is not Moment.END:  # else it is the last that was
                    now = jnp.where(begins[gathered.when], now, before)
                values.append(now)
            else:
                values.append(self._over(gathered, before, signals, step))
        times = {
            moment.name: jnp.where(begins[moment], step.start, found.times[moment.name])
            for moment in self._moments
        }
        return Found(
            times, tuple(values), jnp.stack(angles) if angles else found.angles
        )

    def _at(self, gathered: _Gathered, motion: RelativeMotion) -> Lanes:
        """Return (c, n) components at the start of a step, or at its end."""
        node = -1 if gathered.when is Moment.END else 0
        return jnp.stack([_component(motion, c)[node] for c in gathered.components])

    def _over(
        self, gathered: _Gathered, before: Lanes, signals: StepSignals, step: Step
    ) -> Lanes:
        """Return (c, n) what is gathered over some time, after a step."""
        assert isinstance(gathered.when, Window)
        which = rows([self._components.index(c) for c in gathered.components])
        inside = _inside(gathered.when, step)
        # Where events coincide, steps of no length lie between them: what stands there
        # has been seen, and moves with the time of another event.
        moving = inside & (step.length > 0.0)
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
                return self._within_until(gathered, which, before, signals, step)
        return before + jnp.where(inside, step.length * mean, 0.0)

    def _within_until(
        self,
        gathered: _Gathered,
        which: Rows,
        before: Lanes,
        signals: StepSignals,
        step: Step,
    ) -> Lanes:
        limits = jnp.array([self._limits[c] for c in gathered.components])
        beyond, theta = signals.first_beyond(which, limits)
        times = jnp.where(beyond, step.start + theta * step.length, jnp.inf)
        return jnp.where(jnp.isfinite(before), before, times)

    def finish(self, found: Found) -> Lanes:
        """Return (n_m, n) metrics, in the order of their names."""
        gathered = {
            (g.functional, g.when, component): value
            for g, values in zip(self._gathered, found.values, strict=True)
            for component, value in zip(g.components, values, strict=True)
        }
        return jnp.concatenate([self._told(m, gathered, found) for m in self._metrics])

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

        whole = jnp.full((1, found.values[0].shape[-1]), self._duration)
        if metric.functional is Functional.TIME:
            assert isinstance(metric.when, Moment)
            time = found.times.get(metric.when.name)
            each = whole if time is None else time[None]
        elif metric.functional is Functional.TIME_WITHIN:
            limited = self._looked_at(metric)
            each = jnp.minimum(of(metric.functional), whole) if limited else whole
        else:
            each = _derived(metric.functional, of)
        return metric.sign * _combined(metric.combined, each)


def _components_of(signal: Signal) -> list[Component]:
    return [(signal.quantity, i) for i in signal.components]


def _component(motion: RelativeMotion, component: Component) -> Lanes:
    """Return a component (8, n) of the motion, at the nodes."""
    quantity, i = component
    lanes: Lanes = getattr(motion, quantity)[i]
    return lanes


def _begun(moment: Moment, step: Step) -> Lanes:
    """Return (n,) whether a moment was at or before the start of a step."""
    match moment:
        case Moment.START:
            return step.length >= 0.0
        case Moment.RELEASE:
            return step.separating
        case Moment.SEPARATION:
            return step.separated
        case Moment.END:
            return jnp.zeros_like(step.separated)


def _inside(window: Window, step: Step) -> Lanes:
    """Return (n,) whether a step is in a window: steps end where moments are."""
    return _begun(window.start, step) & ~_begun(window.end, step)


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
