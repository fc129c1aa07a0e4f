"""The metrics of a run, in SI and radians, from its samples.

Functionals of signals over time are those of `drakesep.analysis.metrics.metric`; a
signal is made of splines through its samples.
"""

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from scipy.interpolate import PPoly

from drakesep.analysis.metrics import sampled_signals as signals
from drakesep.analysis.metrics.metric import (
    Combined,
    Functional,
    Metric,
    Moment,
    Outer,
    Owner,
    Signal,
    Time,
    Window,
)
from drakesep.analysis.metrics.registry import METRICS, find_metric, registered_metrics
from drakesep.analysis.metrics.requirements import Limits, limits_of
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.equations.forces_of_run import spring_force_over
from drakesep.systems.equations.loads_of_run import joint_loads
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Attachment, Separation


@typed
def metrics_of_run(
    run: Run, deviation_limits: Limits, also: Iterable[str] = ()
) -> dict[str, float]:
    """Return every metric of a completed run, by name: of each body that leaves.

    Separation ends when every attachment is released and the last spring has reached
    its stroke. Rates are those of B in W, in B; deviations are its roll, pitch and yaw
    in W; the longitudinal speed is that of B's CG as seen from A. A metric of a rate's
    or an angle's magnitude stands beside those of its two directions. Those of the
    first body have plain names, those of others begin with theirs.

    Args:
        run: a completed run.
        deviation_limits: (3,) limits of roll, pitch and yaw, rad, for the time
            until which all stay within theirs; infinite where there is none; or those
            of several pairs, see `Limits`.
        also: names of metrics that are not registered (see
            `drakesep.analysis.metrics.quantities`). One that a run does not tell (see
            `Metric.told_by`) is NaN.

    Raises:
        RuntimeError: the run failed.
        ValueError: there is no such metric of every run.
    """
    samples = _samples_of(run)
    values: dict[str, float] = {}
    for metric in metrics_of(run.separation, also):
        limits = limits_of(deviation_limits, metric.pair)
        values |= _values(metric, samples(metric), limits)
    return values


def metrics_of(separation: Separation, also: Iterable[str] = ()) -> list[Metric]:
    """Return the metrics that are told of every run of a separation.

    Args:
        separation: with the bodies that leave.
        also: names of others, that are not registered.

    Raises:
        ValueError: there is no such metric of every run.
    """
    metrics = [metric for metric in registered_metrics() if metric.of_every_run]
    metrics += [m.of(pair.B) for pair in separation.others for m in metrics]
    return [*dict.fromkeys([*metrics, *map(metric_named, also)])]


def metric_of_run(run: Run, name: str, deviation_limits: Limits) -> float:
    """Return one metric of a completed run, as `metrics_of_run` does.

    Args:
        run: a completed run.
        name: one of `METRICS`, or of a quantity.
        deviation_limits: as there.

    Raises:
        RuntimeError: the run failed.
        ValueError: there is no such metric of every run.
    """
    metric = metric_named(name)
    limits = limits_of(deviation_limits, metric.pair)
    return _values(metric, _samples_of(run)(metric), limits)[name]


def metric_within(run: Run, metric: str, window: tuple[float, float]) -> float:
    """Return a metric over a part of a run alone.

    The window takes the place of the time that the metric looks at: a rate "after
    separation" is looked at from the window's start, be separation over or not. What
    looks since the first release, as the paper's objectives do, still begins there at
    the earliest.

    Args:
        run: a completed run.
        metric: one of those that look at a window.
        window: from when to when, s.

    Raises:
        RuntimeError: the run failed.
        ValueError: there is no such metric, or the window leaves nothing of the run to
            look at.
    """
    entry = metric_named(metric)
    check_windowed(entry, metric)
    samples = _samples_of(run)(entry)
    since = 0.0
    if isinstance(entry.when, Window) and entry.when.start is Moment.RELEASE:
        since = samples.time(Moment.RELEASE)
    start, stop = max(window[0], since), min(window[1], run.separation.duration)
    if start >= stop:
        raise InputError(
            f"window: must end after {since:g} s and begin before the run's end at "
            f"{run.separation.duration:g} s, got {window[0]:g} to {window[1]:g} s"
        )
    return _over_time(entry, samples, start, stop)[metric]


def time_of(time: Time, run: Run, body: str = "") -> float:
    """Return when a time of a run was, s from its start.

    Args:
        time: in question.
        run: completed.
        body: that leaves, whose release and separation are meant; the first if empty.
    """
    body = body or run.separation.B
    match time:
        case Moment.START:
            return 0.0
        case Moment.RELEASE:
            return run.start_of(body)
        case Moment.SEPARATION:
            return run.end_of(body)
        case Moment.END:
            return run.separation.duration
        case _:
            return time


def signal_of_run(run: Run, metric: Metric) -> Array:
    """Return what a metric looks at, at the times of a run's motion.

    Args:
        run: a completed run.
        metric: with a signal.

    Returns:
        (n, c) the c components of its signal: the quantities themselves, angles
        beyond half a turn going on.

    Raises:
        RuntimeError: the run failed.
        ValueError: the run has no such owner of the metric.
    """
    assert metric.signal is not None
    samples = _samples_of(run)(metric).samples(metric.signal)
    outer = metric.signal.outer
    return samples if outer is Outer.ITSELF else np.vectorize(_outer)(outer, samples)


def body_of(metric: Metric, separation: Separation) -> str:
    """Return the body that leaves whose metric it is, or whose joint or spring.

    Raises:
        ValueError: the separation has no such owner of the metric.
    """
    return _found(separation, metric.owner, metric.pair)[0]


def metric_named(name: str) -> Metric:
    """Return the entry of a metric of every run.

    Raises:
        ValueError: there is none.
    """
    found = find_metric(name)
    if found is None or name not in found[0].names or not found[0].of_every_run:
        raise InputError(unknown("metric", name, METRICS))
    return found[0]


def check_windowed(metric: Metric, name: str) -> None:
    """Raise InputError if a metric cannot look at a part of a run."""
    if not metric.windowed:
        every = [name for m in registered_metrics() if m.windowed for name in m.names]
        raise InputError(f"window: must be of one of {', '.join(every)}, got {name}")


def _samples_of(run: Run) -> "Callable[[Metric], _Samples]":
    """Return what gives the signals of a metric's owner; each is made once."""
    # Those of rigid joints follow from one another: all at once.
    loads = functools.cache(lambda: joint_loads(run))

    @functools.cache
    def of(owner: Owner, name: str) -> _Samples:
        return _Samples(run, owner, *_found(run.separation, owner, name), loads)

    return lambda metric: of(metric.owner, metric.pair)


def _found(separation: Separation, owner: Owner, name: str) -> tuple[str, str]:
    """Return the body that leaves, whose moments are meant, and the part.

    Raises:
        ValueError: there is no such owner.
    """
    bodies = [pair.B for pair in separation.pairs]
    if owner is Owner.PAIR:
        name = name or bodies[0]
        if name not in bodies:
            raise InputError(unknown(owner.value, name, bodies))
        return name, ""
    parts = separation.owners_of_forces(springs=owner is Owner.SPRING)
    if name not in parts:
        raise InputError(unknown(owner.value, name, parts))
    return separation.leaving_at(parts[name]), name


class _Samples:
    """The signals of a body that leaves, or of a joint or spring that holds it."""

    def __init__(
        self,
        run: Run,
        owner: Owner,
        body: str,
        part: str,
        loads: Callable[[], dict[str, Array]],
    ):
        self._run, self._owner, self._body, self._part = run, owner, body, part
        self._loads = loads
        self._motion = run.motion_of(body)
        pair = run.separation.pair_of(body)
        self._facts = PairFacts.of(run.separation, pair)
        self.stretch = functools.cache(self._stretch)
        self._whole = functools.cache(self._interpolated)

    @property
    def separation(self) -> Separation:
        """As it was flown."""
        return self._run.separation

    def time(self, time: Time) -> float:
        """Return when a time was, s from the start.

        A spring is released with its attachment, which need not be its body's first.
        """
        if time is Moment.RELEASE and self._owner is Owner.SPRING:
            return self._own_release
        return time_of(time, self._run, self._body)

    def at(self, signal: Signal, when: Time) -> list[float]:
        """Return the values of a signal's components at a time."""
        if when is Moment.END:  # its last sample, to the last digit
            return [float(x) for x in self._columns(signal)[-1]]
        if when is Moment.RELEASE and self._owner is Owner.ATTACHMENT:
            # What it lets go of: with its release the load is gone.
            at = int(np.searchsorted(self._motion.time, self._own_release))
            return [float(x) for x in self._columns(signal)[max(at - 1, 0)]]
        time = self.time(when)
        values = [float(component(time)) for component in self._whole(signal)]
        if signal.turns:
            return [math.remainder(value, math.tau) for value in values]
        return values

    def _stretch(self, signal: Signal, start: float, stop: float) -> list[PPoly]:
        """Return the components of a signal from one time to another."""
        return [signals.between(one, start, stop) for one in self._whole(signal)]

    def _interpolated(self, signal: Signal) -> list[PPoly]:
        values = self.samples(signal)
        if signal.jumps:
            return signals.straight(self._motion.time, values)
        return signals.interpolate(self._motion.time, values, self._run.breaks)

    def samples(self, signal: Signal) -> Array:
        """Return the samples (n, c) of a signal's components; angles go on."""
        values = self._columns(signal)
        return np.unwrap(values, axis=0) if signal.turns else values

    def _columns(self, signal: Signal) -> Array:
        """Return them as they are at each time."""
        field = self._field(signal)
        if signal.law is not None:
            made = signal.law(tuple(field.T), self._facts, np)
            field = np.stack(made, axis=1)
        values = field[:, list(signal.components)]
        if signal.summed:
            return signals.summed(self._motion.time, values, self._run.breaks)
        return values

    @property
    def _own_release(self) -> float:
        """When the attachment of the part lets go, s."""
        held = self._held(springs=self._owner is Owner.SPRING)
        return self._run.releases[held.name]

    def _held(self, *, springs: bool) -> Attachment:
        """Return the attachment of the part."""
        return self._run.separation.owners_of_forces(springs=springs)[self._part]

    def _field(self, signal: Signal) -> Array:
        """Return the samples (n, k) of what a signal is made of."""
        match signal.owner:
            case Owner.ATTACHMENT:
                return self._loads()[self._held(springs=False).name]
            case Owner.SPRING:
                force = spring_force_over(self._run, self._held(springs=True))
                return force[:, None]
            case Owner.PAIR:
                field: Array = getattr(self._motion, signal.quantity)
                return field


_OVER_TIME: Mapping[Functional, Callable[[PPoly], float]] = {
    Functional.SMALLEST: lambda signal: signals.extremes(signal)[0],
    Functional.LARGEST: lambda signal: signals.extremes(signal)[1],
    Functional.SMALLEST_MAGNITUDE: signals.smallest_magnitude,
    Functional.LARGEST_MAGNITUDE: signals.peak,
    Functional.INTEGRAL_OF_MAGNITUDE: signals.integral_of_magnitude,
    Functional.INTEGRAL_OF_SQUARE: signals.integral_of_square,
}
_COMBINED: Mapping[Combined, Callable[[Sequence[float]], float]] = {
    Combined.SUM: sum,
    Combined.ROOT_OF_SUM: lambda each: math.sqrt(sum(each)),
    Combined.SMALLEST: min,
}


def _values(
    metric: Metric, samples: _Samples, deviation_limits: Sequence[float]
) -> dict[str, float]:
    """Return the numbers of a metric, by name."""
    if not metric.told_by(samples.separation):
        return dict.fromkeys(metric.names, math.nan)
    times = metric.when[:2] if isinstance(metric.when, Window) else (metric.when,)
    if not all(math.isfinite(samples.time(time)) for time in times):
        return dict.fromkeys(metric.names, math.nan)
    if isinstance(metric.when, Window):
        start, stop = map(samples.time, metric.when[:2])
        return _over_time(metric, samples, start, stop, deviation_limits)
    if metric.signal is None:
        return _named(metric, [samples.time(metric.when)])
    values = samples.at(metric.signal, metric.when)
    if metric.functional is Functional.MAGNITUDE:
        values = [abs(value) for value in values]
    return _named(metric, values)


def _over_time(
    metric: Metric,
    samples: _Samples,
    start: float,
    stop: float,
    limits: Sequence[float] = (),
) -> dict[str, float]:
    """Return the numbers of a metric that looks at a stretch of time."""
    assert metric.signal is not None
    stretches = samples.stretch(metric.signal, start, stop)
    if metric.functional is Functional.TIME_WITHIN:
        pairs = zip(stretches, limits, strict=True)
        return _named(metric, [signals.time_within(*pair) for pair in pairs])
    functional = _OVER_TIME[metric.functional]
    return _named(metric, [functional(stretch) for stretch in stretches])


def _named(metric: Metric, each: Sequence[float]) -> dict[str, float]:
    """Return the numbers of a metric from what its functional makes of components."""
    if metric.signal is not None:
        each = [_outer(metric.signal.outer, number) for number in each]
    if metric.combined is not Combined.EACH:
        each = [_COMBINED[metric.combined](each)]
    numbers = [metric.sign * number for number in each]
    return dict(zip(metric.names, numbers, strict=True))


def _outer(outer: Outer, number: float) -> float:
    """Return a quantity from its signal, of which round-off may be below zero."""
    match outer:
        case Outer.ITSELF:
            return number
        case Outer.ROOT:
            return math.sqrt(max(number, 0.0))
        case Outer.CONE:
            return 2.0 * math.asin(math.sqrt(min(max(number, 0.0), 1.0)))
