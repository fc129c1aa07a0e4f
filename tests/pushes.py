"""How bodies that move as one give way to a push."""

import numpy as np
from scipy.spatial.transform import Rotation


def lightness(bodies, place, e):
    """1 / mu of bodies as mated, 1/kg: 1 / M + (r x e) . I^-1 (r x e).

    Args:
        bodies: that move as one.
        place: of the push in the mated stack, m; r from their CG.
        e: its direction, a unit vector.
    """
    masses = np.array([body.mass for body in bodies])
    turns = [Rotation.from_euler("xyz", body.rpy_AB).as_matrix() for body in bodies]
    places = np.array(
        [
            np.add(body.p_ABo, R @ body.p_BoBcm_B)
            for body, R in zip(bodies, turns, strict=True)
        ]
    )
    cg = masses @ places / masses.sum()
    inertia = np.zeros((3, 3))
    for body, R, r in zip(bodies, turns, places - cg, strict=True):
        xx, yy, zz, xy, xz, yz = body.I_BBcm_B
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        parallel = body.mass * (r @ r * np.eye(3) - np.outer(r, r))  # Steiner
        inertia += R @ own @ R.T + parallel
    moment = np.cross(np.subtract(place, cg), e)
    return 1.0 / masses.sum() + moment @ np.linalg.solve(inertia, moment)
