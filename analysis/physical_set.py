"""The part of a box in which every body has a possible inertia.

A tolerance on each entry of an inertia spans matrices that no rigid body has. The
possible ones form a convex set (see `drakesep.systems.inertia`), and so does their
intersection with the box.
"""

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from drakesep.analysis.dispersions import Box
from drakesep.systems.inertia import ENTRIES, second_moment
from drakesep.systems.model import Body, Separation


Array = NDArray[np.float64]

# How far inside the set to stay, as a part of the nominal tr(Sigma): above the
# round-off of Drake's own check, far below any tolerance.
_MARGIN = 1e-9


class _DispersedInertia:
    """Second moment of one body over the box: Sigma(u) = nominal + u . slopes."""

    def __init__(self, body: Body, box: Box):
        names = [f"{body.name}.inertia_{entry}" for entry in ENTRIES]
        columns = [
            (box.names.index(name), k)
            for k, name in enumerate(names)
            if name in box.names
        ]
        self.indices = [i for i, _ in columns]
        nominal = second_moment(body.I_BBcm_B)
        self._scale = float(np.trace(nominal))
        self.nominal = nominal / self._scale - _MARGIN * np.eye(3)
        self.slopes = np.array(
            [
                box.tolerance[i] * second_moment(np.eye(6)[k]) / self._scale
                for i, k in columns
            ]
        )

    def deviation(self, u: Array) -> Array:
        return np.tensordot(u[self.indices], self.slopes, axes=1)


class PhysicalSet:
    """The physical part of a box."""

    def __init__(self, separation: Separation, box: Box):
        self._size = len(box)
        inertias = [_DispersedInertia(body, box) for body in separation.bodies]
        self._inertias = [inertia for inertia in inertias if inertia.indices]

    def margins(self, u: Array) -> Array:
        """Return the margins (3 m,) of the m dispersed inertias.

        The eigenvalues of their second moments over the nominal trace: a point is
        physical if none is negative.

        Args:
            u: (n,) scaled point.
        """
        return np.concatenate(
            [
                np.linalg.eigvalsh(inertia.nominal + inertia.deviation(u))
                for inertia in self._inertias
            ]
            or [np.zeros(0)]
        )

    def margins_jacobian(self, u: Array) -> Array:
        """Return the derivatives (3 m, n) of the margins."""
        jacobian = np.zeros((3 * len(self._inertias), self._size))
        for b, inertia in enumerate(self._inertias):
            _, V = np.linalg.eigh(inertia.nominal + inertia.deviation(u))
            jacobian[3 * b : 3 * b + 3, inertia.indices] = np.einsum(
                "ki,akl,li->ia", V, inertia.slopes, V
            )
        return jacobian

    def contains(self, u: Array) -> bool:
        """Return whether every inertia of a scaled point is possible."""
        return bool((self.margins(u) >= 0.0).all())

    def draw_back(self, u: Array) -> Array:
        """Return the point, its impossible inertias drawn towards the nominal.

        An inertia outside the set goes to where the line from its nominal value
        leaves the set; everything else stays.

        Args:
            u: (n,) scaled point.
        """
        drawn = np.array(u, dtype=float)
        for inertia in self._inertias:
            # nominal + s deviation is singular where s = -1 / eigenvalue.
            lowest = scipy.linalg.eigvalsh(inertia.deviation(u), inertia.nominal)[0]
            if lowest < -1.0:
                drawn[inertia.indices] *= (1.0 - 1e-12) / -lowest
        return drawn
