"""Runge-Kutta methods as weights of their stages.

DOP853, of eighth order; and DOPRI5, of fifth, for steps far shorter than that one would
take. Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.5 and
II.6. The coefficients are scipy's. All that a step of length h gives is a weighted sum
of its stages k_1 to k_s, among them those of the continuous extension.
"""

from typing import NamedTuple

import numpy as np
import scipy.integrate
from numpy.polynomial import Polynomial

from drakesep.systems.arrays import Array


MOST_STAGES = 16


class Method(NamedTuple):
    """A method, its weights padded with zeros to those of the most stages."""

    stages: int
    order_of_error: int
    """The error estimate over the step falls with this power of its length."""
    A: Array
    """(16, 16): stage i is at y + h sum_j A_ij k_j."""
    B: Array
    """(16,): the step ends at y + h sum_j B_j k_j."""
    C: Array
    """(16,): stage i is evaluated at t + C_i h."""
    errors: Array
    """(2, 16): h sum_j E_j k_j is the error of an embedded method, and that of one of
    lower order which tempers it (II.10.17); zero if there is none."""
    powers: Array
    """(8, 16): at t + theta h the solution is y + h sum_i theta^i sum_j P_ij k_j."""

    def weights_at(self, theta: Array) -> Array:
        """Return (m, 16) weights of the stages for the solution at t + theta h.

        Args:
            theta: (m,) from 0 to 1.
        """
        return np.power.outer(theta, np.arange(8)) @ self.powers


def _padded(weights: Array, *shape: int) -> Array:
    wide: Array = np.zeros((*shape, MOST_STAGES))
    wide[tuple(map(slice, weights.shape))] = weights
    return wide


def _dop853() -> Method:
    method = scipy.integrate.DOP853
    own = 12  # the 13th is at the end of the step
    A = _padded(method.A, MOST_STAGES)
    A[own] = _padded(method.B)
    A[own + 1 :] = _padded(method.A_EXTRA, MOST_STAGES - own - 1)
    first, last = np.eye(MOST_STAGES)[0], np.eye(MOST_STAGES)[own]
    B = _padded(method.B)
    # The continuous extension, II.6.30, factor by factor.
    rows = [B, first - B, 2.0 * B - (first + last), *_padded(method.D, 4)]
    theta = Polynomial([0.0, 1.0])
    basis = Polynomial([1.0])
    powers = np.zeros((8, MOST_STAGES))
    for i, row in enumerate(rows):
        basis = basis * (theta if i % 2 == 0 else 1.0 - theta)
        powers[: len(basis.coef)] += np.outer(basis.coef, row)
    return Method(
        stages=MOST_STAGES,
        order_of_error=7,
        A=A,
        B=B,
        C=np.concatenate([method.C, [1.0], method.C_EXTRA]),
        errors=np.stack([_padded(method.E5), _padded(method.E3)]),
        powers=powers,
    )


def _dopri5() -> Method:
    method = scipy.integrate.RK45
    own = 6  # the 7th is at the end of the step
    A = _padded(method.A, MOST_STAGES)
    A[own] = _padded(method.B)
    C = _padded(method.C)
    C[own] = 1.0
    powers = np.zeros((8, MOST_STAGES))
    powers[1:5] = _padded(method.P.T, 4)
    return Method(
        stages=own + 1,
        order_of_error=4,
        A=A,
        B=_padded(method.B),
        C=C,
        errors=_padded(method.E[None], 2),
        powers=powers,
    )


DOP853 = _dop853()
DOPRI5 = _dopri5()
