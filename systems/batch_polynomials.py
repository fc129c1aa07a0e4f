"""Roots of the polynomials by which a step of a batch is described, on lanes."""

import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.batch_equations import Lanes


_BISECTIONS, _NEWTONS = 4, 3


def polynomial(c: Lanes, xi: Lanes) -> Lanes:
    """Return the values of polynomials.

    Args:
        c: (k, ...) coefficients of the powers 0 to k - 1.
        xi: where.
    """
    total = jnp.zeros_like(xi)
    for coefficient in c[::-1]:
        total = total * xi + coefficient
    return total


def derivative(c: Lanes) -> Lanes:
    """Return the coefficients (k - 1, ...) of the derivatives of polynomials."""
    powers = np.arange(1.0, len(c))
    return c[1:] * powers.reshape(-1, *[1] * (c.ndim - 1))


def root(c: Lanes, low: Lanes, high: Lanes) -> Lanes:
    """Return the roots between two places; without derivative.

    Bisection keeps Newton's method within reach, and to the side of the root: where a
    polynomial has none, something between the places is returned.

    Args:
        c: (k, ...) coefficients.
        low: lower places.
        high: upper places.
    """
    c, low, high = (lax.stop_gradient(x) for x in (c, low, high))
    side = jnp.sign(polynomial(c, high))
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        beyond = jnp.sign(polynomial(c, middle)) == side
        low, high = jnp.where(beyond, low, middle), jnp.where(beyond, middle, high)
    xi = 0.5 * (low + high)
    for _ in range(_NEWTONS):
        xi = jnp.clip(xi - polynomial(c, xi) / _slope(c, xi), low, high)
    return xi


def crossing(c: Lanes, low: Lanes, high: Lanes) -> Lanes:
    """Return the roots between two places; with their derivative.

    Args:
        c: (k, ...) coefficients.
        low: lower places.
        high: upper places.
    """
    xi = root(c, low, high)
    # A step of Newton's with the slope held: the derivative of an implicit function.
    return xi - polynomial(c, xi) / lax.stop_gradient(_slope(c, xi))


def _slope(c: Lanes, xi: Lanes) -> Lanes:
    slope = polynomial(derivative(c), xi)
    return jnp.where(slope == 0.0, 1.0, slope)
