"""Roots and turning points against those of functions that are known."""

import jax
import numpy as np
import pytest

from drakesep.systems import batch_polynomials as polynomials
from drakesep.systems import lobatto


COUNT = 2000


def sines(phase):
    """Return starts, and values at the nodes, of sines over so many radians."""
    start = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, COUNT)
    return start, np.sin(start + phase * lobatto.THETA[:, None])


@pytest.mark.parametrize("phase", [0.01, 0.5, 2.0])
def test_root_of_a_sine(phase):
    start, values = sines(phase)
    coefficients = lobatto.COEFFICIENTS @ values
    ends = np.full(COUNT, -1.0), np.full(COUNT, 1.0)
    with jax.enable_x64(True):
        xi = np.array(polynomials.root(coefficients, *ends))
    assert (np.abs(xi) <= 1.0).all()
    zero = (np.pi - start % np.pi) / phase  # as a fraction of the step
    found = (zero > 0.0) & (zero < 1.0) & (zero + np.pi / phase > 1.0)
    assert found.any()
    # the polynomial's own error at these phases: (phase / 2)^8 / 8!
    error = (0.5 * phase) ** 8 / 40320 + 1e-12
    assert 0.5 * (1.0 + xi[found]) == pytest.approx(zero[found], abs=error / phase)


def test_root_of_rough_polynomials_stays_between_the_places():
    c = np.random.default_rng(0).normal(size=(8, COUNT))
    with jax.enable_x64(True):
        xi = np.array(polynomials.root(c, np.full(COUNT, -0.25), np.full(COUNT, 0.5)))
    assert ((xi >= -0.25) & (xi <= 0.5)).all()


@pytest.mark.parametrize("phase", [0.01, 0.5, 2.0])
def test_pieces_have_the_extremes_of_sines(phase):
    start, values = sines(phase)
    with jax.enable_x64(True):
        found = np.array(polynomials.pieces(values[:, None, :]).values)[:, 0]
    top = np.mod(0.5 * np.pi - start, 2.0 * np.pi) <= phase
    expected = np.where(top, 1.0, np.maximum(values[0], values[-1]))
    # the polynomial's own error, as above
    assert found.max(axis=0) == pytest.approx(expected, abs=phase**8 / 1e7 + 1e-14)
