"""The metrics that runs are judged by, of a whole batch at once, from its steps.

The metrics are those of `drakesep.analysis.metrics.of_run`, over continuous time: on
each step a signal is the polynomial through its values at the nodes of `lobatto`,
split where it turns: peaks, crossings and integrals of magnitudes are those of the
polynomial.

Every metric has its derivative. At a kink (a rate that is zero, two peaks as high, two
ends of strokes at once) it is a generalised one, between those of both sides. The place
of a peak or of a zero needs none, since the metric does not change with it to first
order; the time of a crossing carries its own.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.analysis.metrics.of_run import ANGLES, AXES, METRICS
from drakesep.systems.batch import lobatto
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.integrator import Step
from drakesep.systems.batch.lanes import BatchParameters, Lanes, pick
from drakesep.systems.batch.polynomials import (
    Pieces,
    first_place,
    pieces,
    polynomial,
    root,
)
from drakesep.systems.equations import relative_motion as motion_laws


_ANGLES = 7
"""Where the limited angles stand among the signals."""
_ROUND_OFF = 1e-13
"""By which two values of the same may differ, as a part of them."""


class Metrics(NamedTuple):
    """What has been found of each metric so far, (n,) or (3, n)."""

    magnitude: Lanes
    """Integral of the relative rates' magnitudes since release, rad."""
    square: Lanes
    """Integral of their squares, rad^2/s."""
    relative_peak: Lanes
    """(3, n) largest relative rates since release, rad/s."""
    released_speed: Lanes
    """Largest longitudinal speed since release, m/s."""
    final_rate: Lanes
    rate_min: Lanes
    """(3, n) smallest rates after separation, rad/s."""
    rate_max: Lanes
    """(3, n) largest rates after separation, rad/s."""
    angle: Lanes
    """(3, n) angles at separation, rad."""
    within_until: Lanes
    speed_max: Lanes
    speed_min_after: Lanes
    speed_max_after: Lanes
    separation_end: Lanes


class MetricsFold:
    """Gathers the metrics of a batch, step by step."""

    def __init__(self, equations: BatchEquations, deviation_limits: Sequence[float]):
        """Prepare.

        Args:
            equations: of the separation.
            deviation_limits: (3,) of roll, pitch and yaw, rad; infinite for none.
        """
        self._equations = equations
        self._duration = equations.separation.duration
        self._limited = [
            (i, limit) for i, limit in enumerate(deviation_limits) if limit < math.inf
        ]

    def start(self, params: BatchParameters) -> Metrics:
        """Return the metrics before the first step."""
        _, n = params.mass.shape
        zero, least, most = jnp.zeros(n), jnp.full(n, -jnp.inf), jnp.full(n, jnp.inf)
        none = jnp.full((3, n), -jnp.inf)
        return Metrics(
            magnitude=zero,
            square=zero,
            relative_peak=none,
            released_speed=least,
            final_rate=jnp.zeros((3, n)),
            rate_min=-none,
            rate_max=none,
            angle=jnp.zeros((3, n)),
            within_until=most,
            speed_max=least,
            speed_min_after=most,
            speed_max_after=least,
            separation_end=most,
        )

    def add(self, metrics: Metrics, params: BatchParameters, step: Step) -> Metrics:
        """Return the metrics after a step."""
        a, b = self._equations.pair
        bodies = step.bodies
        motion = motion_laws.relative_motion(
            pick(bodies, a), pick(bodies, b), *self._equations.mated_place(params), jnp
        )
        angles = [_unwrapped(motion.angle[i]) for i, _ in self._limited]
        signals = _Signals(
            [*motion.relative_rate, *motion.rate, motion.relative_velocity[0], *angles]
        )
        lowest, highest = signals.extremes()
        peaks = jnp.maximum(-lowest[:3], highest[:3])
        released, separated = step.separating, step.separated
        # Where events coincide, steps of no length lie between them: what stands there
        # has been seen, and moves with the time of another event.
        moving = step.length > 0.0

        def larger(before: Lanes, value: Lanes, when: Lanes | bool) -> Lanes:
            # A peak at a kink ends one step and begins the next: it is that of the
            # first, whatever round-off says.
            more = value - before > _ROUND_OFF * jnp.abs(value)
            return jnp.where(when & moving & more, value, before)

        magnitude = step.length * signals.mean_magnitude(3).sum(axis=0)
        square = step.length * signals.mean_square(3).sum(axis=0)
        ends_here = separated & jnp.isinf(metrics.separation_end)
        angle = jnp.stack([angle[0] for angle in motion.angle])
        return Metrics(
            magnitude=metrics.magnitude + jnp.where(released, magnitude, 0.0),
            square=metrics.square + jnp.where(released, square, 0.0),
            relative_peak=larger(metrics.relative_peak, peaks, released),
            released_speed=larger(metrics.released_speed, highest[6], released),
            final_rate=jnp.stack([rate[-1] for rate in motion.rate]),
            rate_min=-larger(-metrics.rate_min, -lowest[3:6], separated),
            rate_max=larger(metrics.rate_max, highest[3:6], separated),
            angle=jnp.where(ends_here, angle, metrics.angle),
            within_until=self._within_until(metrics, signals, step),
            speed_max=larger(metrics.speed_max, highest[6], True),
            speed_min_after=-larger(-metrics.speed_min_after, -lowest[6], separated),
            speed_max_after=larger(metrics.speed_max_after, highest[6], separated),
            separation_end=jnp.where(ends_here, step.start, metrics.separation_end),
        )

    def _within_until(self, metrics: Metrics, signals: "_Signals", step: Step) -> Lanes:
        if not self._limited:
            return metrics.within_until
        limits = jnp.array([limit for _, limit in self._limited])
        beyond, theta = signals.first_beyond(_ANGLES, limits)
        times = jnp.where(beyond, step.start + theta * step.length, jnp.inf)
        found = jnp.isfinite(metrics.within_until)
        return jnp.where(found, metrics.within_until, times.min(axis=0))

    def finish(self, metrics: Metrics) -> Lanes:
        """Return (n_m, n) metrics, in the order of `METRICS`."""
        values = {
            "G_L1": metrics.magnitude,  # Eq. 11
            "G_L2": _root_of_square(metrics.square),  # Eq. 12
            "G_Linf": metrics.relative_peak.sum(axis=0),  # Eq. 13
            "G_PM": -metrics.released_speed,  # Eq. 14
            "deviation_within_limits_until": jnp.minimum(
                metrics.within_until, self._duration
            ),
            "longitudinal_speed_max": metrics.speed_max,
            "longitudinal_speed_after_separation": metrics.speed_min_after,
            "longitudinal_speed_max_after_separation": metrics.speed_max_after,
            "separation_end": metrics.separation_end,
        }
        peaks = jnp.maximum(-metrics.rate_min, metrics.rate_max)
        least = jnp.maximum(0.0, jnp.maximum(metrics.rate_min, -metrics.rate_max))
        for i, axis in enumerate(AXES):
            values[f"final_rate_{axis}"] = metrics.final_rate[i]
            values[f"rate_after_separation_{axis}"] = peaks[i]
            values[f"rate_min_after_separation_{axis}"] = metrics.rate_min[i]
            values[f"rate_max_after_separation_{axis}"] = metrics.rate_max[i]
            values[f"rate_magnitude_min_after_separation_{axis}"] = least[i]
        for i, angle in enumerate(ANGLES):
            values[f"deviation_at_separation_{angle}"] = jnp.abs(metrics.angle[i])
            values[f"angle_at_separation_{angle}"] = metrics.angle[i]
        return jnp.stack([values[name] for name in METRICS])


class _Signals:
    """Signals on one step, as polynomials, (8, s, n)."""

    def __init__(self, signals: Sequence[Lanes]):
        self._at_nodes = jnp.stack(signals, axis=1)
        self._pieces = pieces(self._at_nodes)

    def extremes(self) -> tuple[Lanes, Lanes]:
        """Return (s, n) the smallest and the largest values."""
        values = self._pieces.values
        return values.min(axis=0), values.max(axis=0)

    def mean_square(self, count: int) -> Lanes:
        """Return the mean square of the first signals."""
        return jnp.tensordot(lobatto.WEIGHTS, self._at_nodes[:, :count] ** 2, 1)

    def mean_magnitude(self, count: int) -> Lanes:
        """Return the mean magnitude of the first signals."""
        c, xi, values = (x[:, :count] for x in self._pieces)
        crosses = values[:-1] * values[1:] < 0.0

        def split(_: None) -> Lanes:
            zero = root(c[:, None], xi[:-1], xi[1:])
            zero = jnp.where(crosses, zero, xi[1:])
            powers = np.arange(1.0, lobatto.COUNT + 1.0)[:, None, None]
            area = jnp.concatenate([jnp.zeros_like(c[:1]), c / powers])[:, None]
            at_points, at_zeros = polynomial(area, xi), polynomial(area, zero)
            return 0.5 * (
                jnp.abs(at_zeros - at_points[:-1]) + jnp.abs(at_points[1:] - at_zeros)
            ).sum(axis=0)

        def whole(_: None) -> Lanes:
            mean = jnp.tensordot(lobatto.WEIGHTS, self._at_nodes[:, :count], 1)
            return jnp.abs(mean)

        return lax.cond(crosses.any(), split, whole, None)

    def first_beyond(self, first: int, limits: Lanes) -> tuple[Lanes, Lanes]:
        """Return (l, n) whether signals' magnitudes exceed limits, and first where.

        Args:
            first: of the signals, which follow one another.
            limits: (l,) of their magnitudes.

        Returns:
            Whether they do, and the fractions of the step.
        """
        some = Pieces(*(x[:, first:] for x in self._pieces))
        beyond = jnp.abs(some.values) > limits[:, None]

        def find(_: None) -> Lanes:
            after = jnp.argmax(beyond, axis=0)[None]
            side = jnp.sign(jnp.take_along_axis(some.values, after, 0)[0])
            return first_place(some, beyond, limits[:, None] * side)

        def nowhere(_: None) -> Lanes:
            return jnp.zeros(beyond.shape[1:])

        theta = lax.cond(beyond.any(), find, nowhere, None)
        return beyond.any(axis=0), theta


def _unwrapped(angle: Lanes) -> Lanes:
    """Return an angle (8, n) at the nodes without its jumps by a whole turn."""
    changes = jnp.diff(angle, axis=0)
    turns = 2.0 * jnp.pi * jnp.cumsum(jnp.round(changes / (2.0 * jnp.pi)), axis=0)
    return jnp.concatenate([angle[:1], angle[1:] - turns])


def _root_of_square(square: Lanes) -> Lanes:
    """Return the square root; its derivative at zero, a kink, is taken as zero."""
    some = square > 0.0
    return jnp.where(some, jnp.sqrt(jnp.where(some, square, 1.0)), 0.0)
