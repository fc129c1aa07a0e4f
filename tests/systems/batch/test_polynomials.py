"""Roots and turning points against those of functions that are known."""

import jax
import numpy as np
import pytest

from drakesep.systems.batch import lobatto, polynomials


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


@pytest.mark.parametrize("excess", [1e-1, 1e-2, 1e-3, 1e-4])
def test_place_where_a_peak_only_just_passes_a_level(excess):
    """With its derivative: what deviations, strokes and hinge angles are found by."""
    phase = 0.4
    start = np.linspace(0.5 * np.pi - 0.9 * phase, 0.5 * np.pi - 0.1 * phase, 9)
    values = np.sin(start + phase * lobatto.THETA[:, None])[:, None, :]
    rise = 1.0 - np.sin(start)
    level = 1.0 - excess * rise

    def place(level):
        some = polynomials.pieces(values)
        return polynomials.first_place(some, some.values > level, level[None])[0]

    with jax.enable_x64(True):
        theta, slope = jax.jvp(place, (level,), (np.ones_like(level),))
    passed = np.arcsin(level)
    # Newton's last step leaves the square of an error, over that of a peak's width.
    assert np.array(theta) == pytest.approx((passed - start) / phase, abs=1e-7)
    # near the peak the derivative doubles within a thousandth of the step
    expected = 1.0 / (phase * np.cos(passed))
    assert np.array(slope) == pytest.approx(expected, rel=1e-3)
