"""The motion between steps, against motions that are known."""

import numpy as np
import pytest

from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.simulation.step_polynomials import StepPolynomials, quintics


LAYOUT = StateLayout(26, ((0, 14), (7, 20)))
"""Of two bodies in a plant."""
SPINS = np.array([[0.3, -1.1, 0.8], [-0.9, 0.2, 0.5]])
"""Steady, rad/s in W."""
ARM, PACE = np.array([0.4, -0.2, 0.7]), 3.0
"""Origins swing along it, rad/s."""


def motion(t):
    """Two bodies that spin about fixed axes, and swing: states and their slopes."""
    t = np.asarray(t)
    q, v, q_dot, v_dot = [], [], [], []
    for k, w in enumerate(SPINS, 1):
        rate = np.linalg.norm(w)
        half = 0.5 * rate * t
        axis = w / rate
        q += [np.cos(half), *np.outer(axis, np.sin(half))]
        turning = np.outer(axis, 0.5 * rate * np.cos(half))
        q_dot += [-0.5 * rate * np.sin(half), *turning]
        q += [*np.outer(k * ARM, np.sin(PACE * t))]
        swinging = [*np.outer(k * ARM, PACE * np.cos(PACE * t))]
        q_dot += swinging
        v += [*np.outer(w, np.ones_like(t)), *swinging]
        v_dot += [*np.zeros((3, t.size))]
        v_dot += [*np.outer(k * ARM, -PACE * PACE * np.sin(PACE * t))]
    return np.array(q + v), np.array(q_dot + v_dot)


def test_polynomials_of_fifth_degree_are_met():
    """And their kinks: where a point stands twice it is another one beyond."""
    rng = np.random.default_rng(4)
    first = np.polynomial.Polynomial(rng.normal(size=6))
    # The same value and rate at 0.5, another bend.
    second = first + np.polynomial.Polynomial.fromroots([0.5, 0.5]) * 3.0
    times = np.array([0.0, 0.2, 0.5, 0.5, 1.2])
    curves = [first] * 3 + [second] * 2
    q, v, a = (
        np.array([c.deriv(k)(t) for c, t in zip(curves, times, strict=True)])
        for k in range(3)
    )
    found = quintics(times, q, v, a)
    t = np.linspace(0.0, 1.2, 50)
    for k in range(3):
        expected = np.where(t < 0.5, first.deriv(k)(t), second.deriv(k)(t))
        assert found(t, k) == pytest.approx(expected, abs=1e-12)
    assert found(0.5, 2) == pytest.approx(second.deriv(2)(0.5), rel=1e-14)


def test_of_sixth_order():
    """Positions; velocities one less, accelerations two: halves of steps show it."""
    t = np.linspace(0.0, 1.0, 301)
    x, slope = motion(t)
    v_dot = np.stack([slope[v : v + 6] for _, v in LAYOUT.starts])
    errors = []
    for steps in (4, 8):
        times = np.linspace(0.0, 1.0, steps + 1)
        path = StepPolynomials(LAYOUT, times, *motion(times))
        apart = path.states(t) - x
        bend = path.accelerations(t) - v_dot
        errors.append([np.abs(e).max() for e in (apart[:14], apart[14:], bend)])
    orders = np.log2(np.array(errors[0]) / errors[1])
    assert orders == pytest.approx([6.0, 5.0, 4.0], abs=0.3)
    # (w h)^5 / 720 0.054 w of 1 m, with w h = 0.375
    assert errors[1][1] < 3e-6


def test_states_of_steps_are_kept():
    times = np.linspace(0.0, 1.0, 5)
    x, slope = motion(times)
    path = StepPolynomials(LAYOUT, times, x, slope)
    assert path.states(times) == pytest.approx(x, abs=1e-14)
    v_dot = np.stack([slope[v : v + 6] for _, v in LAYOUT.starts])
    assert path.accelerations(times) == pytest.approx(v_dot, abs=1e-12)


@pytest.mark.parametrize("step", [1e-9, 1e-6, 1.1e-4, 1e-2])
def test_short_steps_have_no_noise(step):
    """However short a step between two events is, a hundred metres away."""
    times = np.array([0.3, 0.3 + step])
    x, slope = motion(times)
    far = np.zeros(26)
    far[[4, 5, 6, 11, 12, 13]] = 100.0
    path = StepPolynomials(LAYOUT, times, x + far[:, None], slope)
    t = np.linspace(*times, 7)
    x, slope = motion(t)
    apart = np.abs(path.states(t) - x - far[:, None])
    # Round-off of 100 m; of velocities, that by a step of 1e-4 s at worst.
    assert apart[:14].max() < 1e-13
    assert apart[14:].max() < 1e-9
    v_dot = np.stack([slope[v : v + 6] for _, v in LAYOUT.starts])
    # and by its square; of shorter ones, by the step.
    assert np.abs(path.accelerations(t) - v_dot).max() < 1e-5
