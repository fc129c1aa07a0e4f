"""Polynomials through the Legendre-Gauss-Lobatto nodes of an interval.

Eight nodes: the continuous extension of the integrator has degree seven. Quadrature on
them is exact up to degree 13.
"""

import numpy as np
from numpy.polynomial import Legendre, chebyshev, polynomial

from drakesep.systems.arrays import Array


COUNT = 8


def _nodes() -> Array:
    inner = Legendre.basis(COUNT - 1).deriv().roots()
    return np.array([-1.0, *np.real(inner).tolist(), 1.0])


XI: Array = _nodes()
"""(8,) nodes from -1 to 1."""
THETA: Array = 0.5 * (1.0 + XI)
"""(8,) nodes as fractions of the interval."""
WEIGHTS: Array = 1.0 / (COUNT * (COUNT - 1) * Legendre.basis(COUNT - 1)(XI) ** 2)
"""(8,) of the mean over the interval."""
COEFFICIENTS: Array = np.asarray(
    np.linalg.inv(polynomial.polyvander(XI, COUNT - 1)), dtype=np.float64
)
"""(8, 8): from values at the nodes to coefficients of the powers of xi."""
SLOPES: Array = polynomial.polyvander(XI, COUNT - 2) @ (
    np.arange(1.0, COUNT)[:, None] * COEFFICIENTS[1:]
)
"""(8, 8): from values at the nodes to derivatives with xi at the nodes."""
INTEGRALS: Array = (
    polynomial.polyvander(XI, COUNT)[:, 1:]
    - polynomial.polyvander([-1.0], COUNT)[:, 1:]
) @ (COEFFICIENTS / np.arange(1.0, COUNT + 1.0)[:, None])
"""(8, 8): from values at the nodes to integrals over xi from -1 to the nodes."""

CHEBYSHEV: Array = np.asarray(
    np.linalg.inv(chebyshev.chebvander(XI, COUNT - 1)), dtype=np.float64
)
"""(8, 8): from values at the nodes to coefficients of Chebyshev's polynomials, none of
which is beyond 1: the sum of their magnitudes bounds a polynomial."""
