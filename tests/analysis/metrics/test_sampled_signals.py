"""Functionals of sampled signals against closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drakesep.analysis.metrics import sampled_signals as signals


TIME = np.linspace(0.0, 3.0, 301)


def signal(function, time=TIME, breaks=(0.0, 3.0)):
    [result] = signals.interpolate(time, function(time)[:, None], breaks)
    return result


# A cubic spline over steps of 0.01 s is off by 5/384 h^4 w^4, 8e-8 at 5 rad/s, and
# by a few times that in its first and last interval.
SPLINE = 5e-7


@given(w=st.floats(0.5, 5.0), phase=st.floats(0.0, 6.0))
def test_integrals_and_extremes_of_a_sine(w, phase):
    sine = signal(lambda t: np.sin(w * t + phase))
    # |sin| integrates to 2 over each half turn.
    angles = np.array([phase, 3.0 * w + phase])
    halves = np.floor(angles / math.pi)
    areas = 2.0 * halves + 1.0 - np.cos(angles - halves * math.pi)
    assert signals.integral_of_magnitude(sine) == pytest.approx(
        np.diff(areas)[0] / w, abs=3.0 * SPLINE / w + 1e-10
    )
    square = 1.5 - np.diff(np.sin(2.0 * angles))[0] / (4.0 * w)
    assert signals.integral_of_square(sine) == pytest.approx(square, abs=6.0 * SPLINE)

    dense = np.sin(w * np.linspace(0.0, 3.0, 100_001) + phase)
    assert signals.extremes(sine) == pytest.approx(
        (dense.min(), dense.max()), abs=SPLINE + 3e-9
    )
    assert signals.peak(sine) == pytest.approx(np.abs(dense).max(), abs=SPLINE + 3e-9)


def test_peak_between_samples_is_found():
    time = np.linspace(0.0, 3.0, 31)  # 1.234 is not among them
    bump = signal(lambda t: 1.0 - (t - 1.234) ** 2, time)
    assert signals.peak(bump) == pytest.approx(2.1187560, abs=1e-6)  # at the end
    assert signals.extremes(bump)[1] == pytest.approx(1.0, abs=1e-13)


def test_kinks_are_kept():
    """|t - 1| is a straight line on either side of its break: exact."""
    kinked = signal(lambda t: np.abs(t - 1.0), breaks=(0.0, 1.0, 3.0))
    assert signals.integral_of_magnitude(kinked) == pytest.approx(2.5, abs=1e-13)
    assert float(kinked(0.999)) == pytest.approx(0.001, abs=1e-13)


def test_a_signal_of_zeros():
    nothing = signal(np.zeros_like)
    assert signals.integral_of_magnitude(nothing) == 0.0
    assert signals.integral_of_square(nothing) == 0.0
    assert signals.peak(nothing) == 0.0
    assert signals.time_within(nothing, 1.0) == 3.0


@given(t0=st.floats(0.0, 1.4), t1=st.floats(1.6, 3.0))
def test_between_is_the_same_signal(t0, t1):
    whole = signal(lambda t: t**3 - 2.0 * t, breaks=(0.0, 1.5, 3.0))
    part = signals.between(whole, t0, t1)
    assert (part.x[0], part.x[-1]) == (t0, t1)
    at = np.linspace(t0, t1, 57)
    assert part(at) == pytest.approx(whole(at), abs=1e-12)


@pytest.mark.parametrize(
    ("function", "limit", "expected"),
    [
        (lambda t: t, 1.234, 1.234),
        (lambda t: -t, 1.234, 1.234),  # a limit of the magnitude
        (lambda t: t, 5.0, 3.0),  # never reached: the end
        (lambda t: 2.0 + t, 1.0, 0.0),  # exceeded from the start
        (lambda t: t, math.inf, 3.0),  # no limit
        (lambda t: 0.5 - (t - 1.0) ** 2, 1.0, 1.0 + math.sqrt(1.5)),
    ],
)
def test_time_within(function, limit, expected):
    within = signals.time_within(signal(function), limit)
    assert within == pytest.approx(expected, abs=1e-9)
