"""The metrics of a run, in SI and radians, from its samples.

Functionals of signals over time are those of `drakesep.analysis.metrics.metric`; a
signal is made of splines through its samples.
"""

import functools
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.interpolate import PPoly

from drakesep.analysis.metrics import sampled_signals as signals
from drakesep.analysis.metrics.metric import (
    Combined,
    Functional,
    Metric,
    Moment,
    Signal,
)
from drakesep.analysis.metrics.registry import METRICS, find_metric, registered_metrics
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.run import Run


def metrics_of_run(run: Run, deviation_limits: Sequence[float]) -> dict[str, float]:
    """Return every metric of a completed run, by name.

    Separation ends when every attachment is released and the last spring has reached
    its stroke. Rates are those of B in W, in B; deviations are its roll, pitch and yaw
    in W; the longitudinal speed is that of B's CG as seen from A. A metric of a rate's
    or an angle's magnitude stands beside those of its two directions.

    Args:
        run: a completed run.
        deviation_limits: (3,) limits of roll, pitch and yaw, rad, for the time
            until which all stay within theirs; infinite where there is none.

    Raises:
        RuntimeError: the run failed.
    """
    samples = _Samples(run)
    values: dict[str, float] = {}
    for metric in registered_metrics():
        if metric.of_every_run:
            values |= _values(metric, samples, deviation_limits)
    return values


def metric_of_run(run: Run, name: str, deviation_limits: Sequence[float]) -> float:
    """Return one metric of a completed run, as `metrics_of_run` does.

    Args:
        run: a completed run.
        name: one of `METRICS`.
        deviation_limits: (3,) as there.

    Raises:
        RuntimeError: the run failed.
        ValueError: there is no such metric of every run.
    """
    return _values(metric_named(name), _Samples(run), deviation_limits)[name]


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
    samples = _Samples(run)
    since = 0.0
    if not isinstance(entry.when, Moment) and entry.when.start is Moment.RELEASE:
        since = time_of(Moment.RELEASE, run)
    start, stop = max(window[0], since), min(window[1], run.separation.duration)
    if start >= stop:
        raise InputError(
            f"window: must end after {since:g} s and begin before the run's end at "
            f"{run.separation.duration:g} s, got {window[0]:g} to {window[1]:g} s"
        )
    return _over_time(entry, samples, start, stop)[metric]


def time_of(moment: Moment, run: Run) -> float:
    """Return when a moment of a run was, s."""
    match moment:
        case Moment.START:
            return 0.0
        case Moment.RELEASE:
            return run.separation_start
        case Moment.SEPARATION:
            return run.separation_end
        case Moment.END:
            return run.separation.duration


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


class _Samples:
    """The signals of a run; what is asked for twice is made once."""

    def __init__(self, run: Run):
        self._run = run
        self._motion = run.completed_motion
        self.stretch = functools.cache(self._stretch)
        self._whole = functools.cache(self._interpolated)

    def time(self, moment: Moment) -> float:
        """Return when a moment was, s."""
        return time_of(moment, self._run)

    def at(self, signal: Signal, moment: Moment) -> list[float]:
        """Return the values of a signal's components at a moment."""
        if moment is Moment.END:  # its last sample, to the last digit
            last = getattr(self._motion, signal.quantity)[-1]
            return [float(last[i]) for i in signal.components]
        time = self.time(moment)
        values = [float(component(time)) for component in self._whole(signal)]
        if signal.turns:
            return [math.remainder(value, math.tau) for value in values]
        return values

    def _stretch(self, signal: Signal, start: float, stop: float) -> list[PPoly]:
        """Return the components of a signal from one time to another."""
        return [signals.between(one, start, stop) for one in self._whole(signal)]

    def _interpolated(self, signal: Signal) -> list[PPoly]:
        values = getattr(self._motion, signal.quantity)[:, list(signal.components)]
        if signal.turns:
            values = np.unwrap(values, axis=0)
        return signals.interpolate(self._motion.time, values, self._run.breaks)


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
    if not isinstance(metric.when, Moment):
        start, stop = map(samples.time, (metric.when.start, metric.when.end))
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
    if metric.combined is not Combined.EACH:
        each = [_COMBINED[metric.combined](each)]
    numbers = [metric.sign * number for number in each]
    return dict(zip(metric.names, numbers, strict=True))
