"""The eighth-order method of Dormand and Prince, DOP853, as weights of its stages.

Hairer, Norsett and Wanner, "Solving Ordinary Differential Equations I", II.5 and II.6.
The coefficients are scipy's. With stages k_1 to k_16, of which the last four serve the
continuous extension, all that a step of length h gives is a weighted sum of them.
"""

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.integrate import DOP853


Array = NDArray[np.float64]

STAGES = 16
_OWN = 12
"""Stages of the step itself."""
ORDER_OF_ERROR = 7
"""The error estimate over the step falls with this power of its length."""


def _padded(weights: Array) -> Array:
    wide: Array = np.zeros((*weights.shape[:-1], STAGES))
    wide[..., : weights.shape[-1]] = weights
    return wide


A: Array = np.concatenate(
    [_padded(DOP853.A), _padded(DOP853.B)[None], _padded(DOP853.A_EXTRA)]
)
"""(16, 16): stage i is at y + h sum_j A_ij k_j; the 13th at the end of the step."""
B: Array = _padded(DOP853.B)
"""(16,): the step ends at y + h sum_j B_j k_j."""
C: Array = np.concatenate([DOP853.C, [1.0], DOP853.C_EXTRA])
"""(16,): stage i is evaluated at t + C_i h."""
E3: Array = _padded(DOP853.E3)
E5: Array = _padded(DOP853.E5)
"""(16,): errors of the embedded third- and fifth-order methods are h sum_j E_j k_j."""


def _continuous_extension() -> Array:
    """Return (8, 16) weights of the powers 0 to 7 of theta, II.6.30."""
    first, last = np.eye(STAGES)[0], np.eye(STAGES)[_OWN]
    rows = [B, first - B, 2.0 * B - (first + last), *_padded(DOP853.D)]
    theta = Polynomial([0.0, 1.0])
    basis = Polynomial([1.0])
    powers = np.zeros((8, STAGES))
    for i, row in enumerate(rows):
        basis = basis * (theta if i % 2 == 0 else 1.0 - theta)
        powers[: len(basis.coef)] += np.outer(basis.coef, row)
    return powers


POWERS: Array = _continuous_extension()
"""(8, 16): at t + theta h the solution is y + h sum_i theta^i sum_j POWERS_ij k_j."""


def weights_at(theta: Array) -> Array:
    """Return (m, 16) weights of the stages for the solution at t + theta h.

    Args:
        theta: (m,) from 0 to 1.
    """
    return np.power.outer(theta, np.arange(8)) @ POWERS
