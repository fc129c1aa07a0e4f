"""What the nodes promise, on polynomials whose integrals and slopes are known."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from drakesep.systems.batch import lobatto


@pytest.mark.parametrize("degree", range(14))
def test_mean_is_exact_to_degree_13(degree):
    mean = 1.0 / (degree + 1) if degree % 2 == 0 else 0.0
    assert lobatto.WEIGHTS @ lobatto.XI**degree == pytest.approx(mean, abs=1e-14)


def test_polynomials_of_degree_seven_are_kept():
    p = Polynomial(np.random.default_rng(0).normal(size=8))
    values = p(lobatto.XI)
    # round-off times the condition of the Vandermonde matrix, some hundreds
    assert lobatto.COEFFICIENTS @ values == pytest.approx(p.coef, abs=1e-12)
    assert lobatto.SLOPES @ values == pytest.approx(p.deriv()(lobatto.XI), abs=1e-12)
    integral = p.integ(lbnd=-1.0)(lobatto.XI)
    assert lobatto.INTEGRALS @ values == pytest.approx(integral, abs=1e-12)


def test_theta_is_the_fraction_of_the_interval():
    assert lobatto.THETA[[0, -1]] == pytest.approx([0.0, 1.0])
    assert np.diff(lobatto.THETA).min() > 0.0
