"""The inertias that a body can have, as a constraint on a box of tolerances.

A tolerance on each entry of an inertia spans matrices that no rigid body has. The
possible ones form a convex set (see `drakesep.systems.model.inertia`), and so does
their intersection with the box.
"""

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.inertia import is_positive_definite, second_moment
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Body


# How far inside the set to stay, as a part of the nominal tr(Sigma): above the
# round-off of Drake's own check, far below any tolerance.
_MARGIN = 1e-8


class PhysicalInertia:
    """That the inertia of one body stays possible over a box.

    Its second moment of mass, over the nominal trace, is nominal + u . slopes, and must
    be positive semidefinite.

    Attributes:
        label: of the constraint.
        indices: of its parameters in the box.
    """

    def __init__(self, body: Body, box: ToleranceBox):
        """Prepare.

        Raises:
            ValueError: the nominal inertia is at the edge of the possible ones.
        """
        self.label = f"{body.name}.inertia"
        names = names_of([body], ["I_BBcm_B"])
        columns = [
            (box.names.index(name), k)
            for k, name in enumerate(names)
            if name in box.names
        ]
        self.indices = [i for i, _ in columns]
        nominal = second_moment(body.I_BBcm_B)
        scale = float(np.trace(nominal))
        self._nominal = nominal / scale - _MARGIN * np.eye(3)
        if np.linalg.eigvalsh(self._nominal)[0] <= 0.0:
            raise InputError(
                f"{self.label}: the nominal must be possible with something to spare "
                "for its tolerances to hold any possible inertia around it, got that "
                "of a flat body; leave its inertia out of the dispersions"
            )
        self._slopes = np.array(
            [box.tolerance[i] * second_moment(np.eye(6)[k]) / scale for i, k in columns]
        ).reshape(-1, 3, 3)
        # L with L nominal L^T = 1
        self._whitening = np.linalg.inv(np.linalg.cholesky(self._nominal))

    def _deviation(self, u: Array) -> Array:
        return np.tensordot(u[..., self.indices], self._slopes, axes=1)

    def margins(self, u: Array) -> Array:
        """Return (..., 3) eigenvalues of the second moment, over the nominal trace.

        Args:
            u: (..., n) scaled points.
        """
        moment = self._nominal + self._deviation(u)
        return np.asarray(np.linalg.eigvalsh(moment), dtype=float)

    def jacobian(self, u: Array) -> Array:
        """Return (3, n) derivatives of the margins at a point (n,)."""
        jacobian = np.zeros((3, len(u)))
        _, V = np.linalg.eigh(self._nominal + self._deviation(u))
        jacobian[:, self.indices] = np.einsum("ki,akl,li->ia", V, self._slopes, V)
        return jacobian

    def holds(self, u: Array) -> NDArray[np.bool_]:
        """Return (N,) whether points (N, n), in the box or beyond, are possible.

        What is said of a point does not depend on those beside it.
        """
        moment = {(i, j): self._nominal[i, j] for i in range(3) for j in range(i, 3)}
        for index, slope in zip(self.indices, self._slopes, strict=True):
            for i, j in moment:
                if slope[i, j]:
                    moment[i, j] = moment[i, j] + slope[i, j] * u[:, index]
        return is_positive_definite(
            *(moment[i, i] for i in range(3)),
            *(moment[i, j] for i, j in ((0, 1), (0, 2), (1, 2))),
        )

    def reach(self, u: Array) -> Array:
        """Return (...,) by what factor points (..., n) may be scaled and stay inside.

        Infinite where any factor does.
        """
        white = self._whitening @ self._deviation(u) @ self._whitening.T
        lowest = np.linalg.eigvalsh(white)[..., 0]
        # nominal + s deviation is singular where s = -1 / eigenvalue
        reach = np.full(lowest.shape, np.inf)
        with np.errstate(over="ignore"):  # so little that any factor does
            np.divide(-1.0, lowest, out=reach, where=lowest < 0.0)
        return reach
