"""What all bodies of a run have together, at every sample of it."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.run import Run


class Whole(NamedTuple):
    """In W, about its origin."""

    momentum: np.ndarray
    """(n, 3), N s."""
    angular: np.ndarray
    """(n, 3), N m s."""
    kinetic: np.ndarray
    """(n,), J."""


def of_all_bodies(run: Run) -> Whole:
    n = len(run.trajectory.time)
    momentum, angular, kinetic = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
    for body in run.separation.bodies:
        x = run.trajectory.of(body.name)
        R_WB, w_WB = Rotation.from_quat(x[:, :4], scalar_first=True), x[:, 7:10]
        p_BoBcm_W = R_WB.apply(body.p_BoBcm_B)
        p_WBcm, v_WBcm = x[:, 4:7] + p_BoBcm_W, x[:, 10:] + np.cross(w_WB, p_BoBcm_W)
        w_WB_B = R_WB.apply(w_WB, inverse=True)
        spin_B = w_WB_B @ inertia_matrix(body.I_BBcm_B)
        momentum += body.mass * v_WBcm
        angular += body.mass * np.cross(p_WBcm, v_WBcm) + R_WB.apply(spin_B)
        kinetic += 0.5 * body.mass * (v_WBcm**2).sum(axis=1)
        kinetic += 0.5 * (spin_B * w_WB_B).sum(axis=1)
    return Whole(momentum, angular, kinetic)
