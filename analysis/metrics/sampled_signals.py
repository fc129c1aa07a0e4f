"""Functionals of sampled signals, over continuous time.

A signal is a scipy PPoly: cubic splines between the kinks of a run, so that
integrals, peaks and crossings do not depend on where the samples happen to lie.
"""

import functools
import itertools
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from drakesep.systems.arrays import Array


# Gauss-Legendre with 4 nodes is exact for the square of a cubic.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


def interpolate(time: Array, samples: Array, breaks: Sequence[float]) -> list[PPoly]:
    """Return the signals through samples, smooth between the breaks.

    Args:
        time: (n,) sample times, s, the breaks among them.
        samples: (n, k) values.
        breaks: times of the kinks, with the first and the last sample.

    Returns:
        k signals.
    """
    edges = np.searchsorted(time, breaks)
    c = np.concatenate(
        [
            CubicSpline(time[i : j + 1], samples[i : j + 1]).c
            for i, j in itertools.pairwise(edges)
        ],
        axis=1,
    )
    return [PPoly.construct_fast(c[..., k].copy(), time) for k in range(c.shape[2])]


def straight(time: Array, samples: Array) -> list[PPoly]:
    """Return the signals through samples by straight lines.

    Args:
        time: (n,) sample times, s.
        samples: (n, k) values.
    """
    slopes = np.diff(samples, axis=0) / np.diff(time)[:, None]
    none = np.zeros_like(slopes)
    c = np.stack([none, none, slopes, samples[:-1]])
    return [PPoly.construct_fast(c[..., k].copy(), time) for k in range(c.shape[2])]


def summed(time: Array, samples: Array, breaks: Sequence[float]) -> Array:
    """Return the integrals (n, k) of signals over time, at their samples.

    Args:
        time: (n,) sample times, s, the breaks among them.
        samples: (n, k) values.
        breaks: as of `interpolate`.
    """
    signals = interpolate(time, samples, breaks)
    return np.stack([signal.antiderivative()(time) for signal in signals], axis=1)


def between(signal: PPoly, t0: float, t1: float) -> PPoly:
    """Return the signal from t0 to t1 alone."""
    inner = signal.x[(signal.x > t0) & (signal.x < t1)]
    x = np.array([t0, *inner, t1])
    i = np.clip(np.searchsorted(signal.x, x[:-1], side="right") - 1, 0, None)
    shift = x[:-1] - signal.x[i]
    a, b, c, d = signal.c[:, i]
    moved = [
        a,
        b + 3 * a * shift,
        c + (2 * b + 3 * a * shift) * shift,
        d + (c + (b + a * shift) * shift) * shift,
    ]
    return PPoly(np.array(moved), x)


def _crossings(signal: PPoly, level: float) -> Array:
    times: Array = np.asarray(signal.solve(level, extrapolate=False), dtype=float)
    # NaN marks a stretch that lies on the level.
    return np.compress(np.isfinite(times), times)


def integral_of_magnitude(signal: PPoly) -> float:
    """Return the integral of |signal|."""
    nodes = np.sort(np.concatenate([signal.x[[0, -1]], _crossings(signal, 0.0)]))
    return float(np.abs(np.diff(signal.antiderivative()(nodes))).sum())


def integral_of_square(signal: PPoly) -> float:
    """Return the integral of signal^2."""
    half = 0.5 * np.diff(signal.x)
    middle = signal.x[:-1] + half
    values = signal(middle[:, None] + half[:, None] * _NODES)
    return float((values**2 @ _WEIGHTS) @ half)


@functools.lru_cache(maxsize=32)  # several functionals ask for those of one signal
def extremes(signal: PPoly) -> tuple[float, float]:
    """Return the smallest and the largest value."""
    turning = _crossings(signal.derivative(), 0.0)
    values = signal(np.concatenate([signal.x, turning]))
    return float(values.min()), float(values.max())


def peak(signal: PPoly) -> float:
    """Return the largest |signal|."""
    lowest, highest = extremes(signal)
    return max(-lowest, highest)


def smallest_magnitude(signal: PPoly) -> float:
    """Return the smallest |signal|."""
    lowest, highest = extremes(signal)
    return max(0.0, lowest, -highest)


def time_within(signal: PPoly, limit: float) -> float:
    """Return the time until which |signal| <= limit: its end if it always is."""
    start, end = float(signal.x[0]), float(signal.x[-1])
    if abs(float(signal(start))) > limit:
        return start
    # A signal that only touches its limit is still within it.
    times = np.sort(
        np.concatenate([_crossings(signal, limit), _crossings(signal, -limit), [end]])
    )
    middles = 0.5 * (times[:-1] + times[1:])
    beyond = np.abs(signal(middles)) > limit
    return float(times[:-1][beyond][0]) if beyond.any() else end
