"""The impulses of springs of Eq. 5 over time, with their derivatives, enclosed.

The force depends on time alone, so its impulse is known in closed form, and is
continuously differentiable in the parameters across the end of the stroke. That of a
spring that is stuck before has a kink there, at which its derivatives are those of
either side.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.bounds.intervals import HALF_PI, Interval, arcsin, cos, sin
from drakesep.systems.arrays import Array


class Law(NamedTuple):
    """Numbers of a spring, (boxes, 1) each."""

    force_max: Interval
    stroke: Interval
    design_mass: Interval
    lost_stroke: Interval
    """Part of the stroke before which it is stuck."""

    @property
    def amplitude(self) -> Interval:
        """Impulse of the whole stroke, N s."""
        return (self.force_max * self.stroke * self.design_mass).sqrt()

    @property
    def frequency(self) -> Interval:
        """Angular frequency of the force, rad/s."""
        return (self.force_max / (self.design_mass * self.stroke)).sqrt()  # Eq. 5

    @property
    def last_phase(self) -> Interval:
        """Phase at which the push ends: a quarter turn, or the part's arccosine."""
        return HALF_PI - arcsin(self.lost_stroke)

    @property
    def duration(self) -> Interval:
        """Time to the end of the push, s."""
        return self.last_phase / self.frequency


class Impulse(NamedTuple):
    """An impulse, and its derivatives by the numbers of the law."""

    value: Interval
    by: tuple[Interval, Interval, Interval, Interval]


_TURN = (1.0768, 1.0770)
"""Between which x tan x = 2: there sin x + x cos x is largest."""
_LARGEST = 1.3913
"""More than which it is not: 1.39101 at 1.07687."""


def impulse(law: Law, times: Interval) -> Impulse:
    """Return the impulse since t = 0 over times (pieces,), from least to greatest."""
    end, phase = law.last_phase, law.frequency * times
    low, high = (_shapes(x, end) for x in (phase.lo, phase.hi))
    after = _shapes(end.lo, end).sine.hull(_shapes(end.hi, end).sine)
    may_push, may_be_over = phase.lo <= end.hi, phase.hi >= end.lo
    plus = _rising(phase, low, high).hull(after)
    # Where the push surely goes on, or surely is over, it is one of the two.
    plus = _chosen(may_push & may_be_over, plus, _rising(phase, low, high))
    plus = _chosen(may_push, plus, after)
    minus = Interval(
        np.where(may_push, low.minus.lo, after.lo),
        np.where(may_be_over, after.hi, high.minus.hi),
    )
    F, L, m, lost = law
    kept = (1.0 - lost.square()).sqrt()  # the sine of the last phase
    by_lost = -(law.amplitude * lost / kept)
    return Impulse(
        law.amplitude * Interval(low.sine.lo, high.sine.hi),
        (
            (L * m / F).sqrt() * 0.5 * plus,
            (F * m / L).sqrt() * 0.5 * minus,
            (F * L / m).sqrt() * 0.5 * minus,
            Interval(
                np.where(may_be_over, by_lost.lo, 0.0),
                np.where(may_push, 0.0, by_lost.hi),
            ),
        ),
    )


def _chosen(where: NDArray[np.bool_], this: Interval, other: Interval) -> Interval:
    return Interval(
        np.where(where, this.lo, other.lo), np.where(where, this.hi, other.hi)
    )


class _Shapes(NamedTuple):
    """What impulses and their derivatives are made of, at a phase x before the end."""

    sine: Interval
    plus: Interval
    """sin x + x cos x."""
    minus: Interval
    """sin x - x cos x."""


def _shapes(phase: Array, end: Interval) -> _Shapes:
    """Return shapes at phases, or at the end where that may come first."""
    x = Interval(np.minimum(phase, end.lo), np.minimum(phase, end.hi))
    s, c = sin(x), cos(x)
    x = Interval(np.minimum(x.lo, HALF_PI.lo), np.minimum(x.hi, HALF_PI.hi))
    part = x * c
    return _Shapes(s, s + part, s - part)


def _rising(phase: Interval, low: _Shapes, high: _Shapes) -> Interval:
    """Return sin x + x cos x between two phases."""
    falling, rising = phase.lo > _TURN[1], phase.hi < _TURN[0]
    least = np.minimum(low.plus.lo, high.plus.lo)
    most = np.maximum(low.plus.hi, high.plus.hi)
    return Interval(least, np.where(falling | rising, most, _LARGEST))


def summed_impulse(law: Law, times: Array) -> Interval:
    """Return the integral of the impulse from t = 0 to times (n,), N s^2."""
    t, end = Interval(times), law.last_phase
    phase = law.frequency * t
    phase = Interval(np.minimum(phase.lo, end.lo), np.minimum(phase.hi, end.hi))
    until = (1.0 - cos(phase)) * (law.amplitude / law.frequency)
    since = t - law.duration
    after = Interval(np.maximum(since.lo, 0.0), np.maximum(since.hi, 0.0))
    return until + law.amplitude * sin(end) * after
