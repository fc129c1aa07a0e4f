"""The weights against the conditions of their order, and scipy's own steps."""

import numpy as np
import pytest
from scipy.integrate import DOP853

from drakesep.systems import runge_kutta


def pendulum(t, y):
    return np.array([y[1], -np.sin(y[0]) + np.cos(3.0 * t)])


def stages(h, y):
    K = np.zeros((runge_kutta.STAGES, len(y)))
    for i in range(runge_kutta.STAGES):
        K[i] = pendulum(runge_kutta.C[i] * h, y + h * runge_kutta.A[i] @ K)
    return K


def test_quadrature_conditions():
    """Order 8: sum B_i C_i^k = 1 / (k + 1); the stages' rows sum to C."""
    for k in range(8):
        assert runge_kutta.B @ runge_kutta.C**k == pytest.approx(1.0 / (k + 1))
    assert runge_kutta.A.sum(axis=1) == pytest.approx(runge_kutta.C, abs=1e-14)


def test_a_step_and_its_extension_are_scipys():
    y, h = np.array([0.3, 0.7]), 0.4
    loose = {"rtol": 1e-2, "atol": 1e-2}  # the first try is accepted
    solver = DOP853(pendulum, 0.0, y, 10.0, first_step=h, **loose)
    solver.step()
    K = stages(h, y)
    # round-off
    assert y + h * runge_kutta.B @ K == pytest.approx(solver.y, abs=1e-14)
    theta = np.linspace(0.0, 1.0, 9)
    extension = solver.dense_output()(theta * h).T
    assert y + h * runge_kutta.weights_at(theta) @ K == pytest.approx(
        extension, abs=1e-13
    )


def test_error_of_a_step_falls_with_the_ninth_power():
    y = np.array([0.3, 0.7])
    tight = {"rtol": 1e-13, "atol": 1e-14}

    def error(h):
        solver = DOP853(pendulum, 0.0, y, h, **tight)
        while solver.status == "running":
            solver.step()
        return np.abs(y + h * runge_kutta.B @ stages(h, y) - solver.y).max()

    # Steps short enough for the limit leave nothing but round-off.
    assert 2.0**8 < error(0.8) / error(0.4) < 2.0**10
