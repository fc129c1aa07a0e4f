"""The weights against the conditions of their order, and scipy's own steps."""

import numpy as np
import pytest
import scipy.integrate

from drakesep.systems.batch.tableaus import DOP853, DOPRI5


both = pytest.mark.parametrize(
    ("method", "solver", "order"),
    [(DOP853, scipy.integrate.DOP853, 8), (DOPRI5, scipy.integrate.RK45, 5)],
    ids=["DOP853", "DOPRI5"],
)
Y = np.array([0.3, 0.7])


def pendulum(t, y):
    return np.array([y[1], -np.sin(y[0]) + np.cos(3.0 * t)])


def stages(method, h):
    K = np.zeros((len(method.A), len(Y)))
    for i in range(method.stages):
        K[i] = pendulum(method.C[i] * h, Y + h * method.A[i] @ K)
    return K


@both
def test_quadrature_conditions(method, solver, order):
    """Of order p: sum B_i C_i^k = 1 / (k + 1), k < p; the stages' rows sum to C."""
    for k in range(order):
        assert method.B @ method.C**k == pytest.approx(1.0 / (k + 1))
    assert method.A.sum(axis=1) == pytest.approx(method.C, abs=1e-14)


@both
def test_a_step_and_its_extension_are_scipys(method, solver, order):
    h = 0.4
    loose = {"rtol": 1e-2, "atol": 1e-2}  # the first try is accepted
    steps = solver(pendulum, 0.0, Y, 10.0, first_step=h, **loose)
    steps.step()
    assert steps.t == h
    K = stages(method, h)
    # round-off
    assert Y + h * method.B @ K == pytest.approx(steps.y, abs=1e-14)
    theta = np.linspace(0.0, 1.0, 9)
    extension = steps.dense_output()(theta * h).T
    assert Y + h * method.weights_at(theta) @ K == pytest.approx(extension, abs=1e-13)


@both
def test_error_of_a_step_falls_with_its_order(method, solver, order):
    tight = {"rtol": 1e-13, "atol": 1e-14}

    def error(h):
        exact = scipy.integrate.DOP853(pendulum, 0.0, Y, h, **tight)
        while exact.status == "running":
            exact.step()
        return np.abs(Y + h * method.B @ stages(method, h) - exact.y).max()

    # Steps short enough for the limit leave nothing but round-off.
    assert 2.0**order < error(0.8) / error(0.4) < 2.0 ** (order + 2)


@both
def test_error_estimate_falls_with_its_order(method, solver, order):
    """Of the error over the length of the step, as the state of a batch takes it."""

    def estimate(h):
        square, tempering = ((method.errors @ stages(method, h)) ** 2).sum(axis=1)
        return square / np.sqrt(square + 0.01 * tempering)

    expected = 2.0**method.order_of_error
    assert estimate(0.02) / estimate(0.01) == pytest.approx(expected, rel=0.2)
