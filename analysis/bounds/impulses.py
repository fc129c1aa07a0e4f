"""The impulses of springs of Eq. 5 over time, with their derivatives, enclosed.

The force depends on time alone, so its impulse is known in closed form, and is
continuously differentiable in the parameters across the end of the stroke.
"""

from typing import NamedTuple

import numpy as np

from drakesep.analysis.bounds.intervals import HALF_PI, Interval, cos, sin
from drakesep.systems.arrays import Array


class Law(NamedTuple):
    """Numbers of a spring, (boxes, 1) each."""

    force_max: Interval
    stroke: Interval
    design_mass: Interval

    @property
    def amplitude(self) -> Interval:
        """Impulse of the whole stroke, N s."""
        return (self.force_max * self.stroke * self.design_mass).sqrt()

    @property
    def frequency(self) -> Interval:
        """Angular frequency of the force, rad/s."""
        return (self.force_max / (self.design_mass * self.stroke)).sqrt()  # Eq. 5

    @property
    def duration(self) -> Interval:
        """Time to the end of the stroke, s."""
        return HALF_PI / self.frequency


class Impulse(NamedTuple):
    """An impulse, and its derivatives by the numbers of the law."""

    value: Interval
    by: tuple[Interval, Interval, Interval]


_TURN = (1.0768, 1.0770)
"""Between which x tan x = 2: there sin x + x cos x is largest."""
_LARGEST = 1.3913
"""More than which it is not: 1.39101 at 1.07687."""


def impulse(law: Law, times: Interval) -> Impulse:
    """Return the impulse since t = 0 over times (pieces,), from least to greatest."""
    phase = law.frequency * times
    low, high = (_shapes(Interval(end)) for end in (phase.lo, phase.hi))
    falling, rising = phase.lo > _TURN[1], phase.hi < _TURN[0]
    least = np.minimum(low.plus.lo, high.plus.lo)
    most = np.maximum(low.plus.hi, high.plus.hi)
    plus = Interval(least, np.where(falling | rising, most, _LARGEST))
    minus = Interval(low.minus.lo, high.minus.hi)
    F, L, m = law
    return Impulse(
        law.amplitude * Interval(low.sine.lo, high.sine.hi),
        (
            (L * m / F).sqrt() * 0.5 * plus,
            (F * m / L).sqrt() * 0.5 * minus,
            (F * L / m).sqrt() * 0.5 * minus,
        ),
    )


class _Shapes(NamedTuple):
    """What impulses and their derivatives are made of, at a phase x cut to pi / 2."""

    sine: Interval
    plus: Interval
    """sin x + x cos x."""
    minus: Interval
    """sin x - x cos x."""


def _shapes(phase: Interval) -> _Shapes:
    s, c = sin(phase), cos(phase)
    x = Interval(np.minimum(phase.lo, HALF_PI.lo), np.minimum(phase.hi, HALF_PI.hi))
    part = x * c
    return _Shapes(s, s + part, s - part)


def summed_impulse(law: Law, times: Array) -> Interval:
    """Return the integral of the impulse from t = 0 to times (n,), N s^2."""
    t = Interval(times)
    until = (1.0 - cos(law.frequency * t)) * (law.amplitude / law.frequency)
    since = t - law.duration
    after = Interval(np.maximum(since.lo, 0.0), np.maximum(since.hi, 0.0))
    return until + law.amplitude * after
