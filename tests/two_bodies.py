"""Two bodies that attract each other, integrated by themselves: an oracle."""

import numpy as np
from scipy.integrate import solve_ivp


EARTH_MU = 3.986004418e14
"""m^3/s^2 (WGS 84)."""


def two_bodies(start, times) -> np.ndarray:
    """Positions and velocities (n, 6) of a particle that falls about the Earth.

    In an inertial frame, m and m/s, by an explicit method of order 8.
    """
    scale = np.repeat([1e7, 1e4], 3)

    def fall(_, scaled):
        state = scaled * scale
        r = state[:3]
        field = -EARTH_MU * r / np.linalg.norm(r) ** 3
        return np.concatenate([state[3:], field]) / scale

    told = solve_ivp(
        fall,
        (0.0, times[-1]),
        np.asarray(start) / scale,
        method="DOP853",
        rtol=3e-14,
        atol=1e-15,
        t_eval=times,
    )
    return told.y.T * scale
