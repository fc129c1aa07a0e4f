"""Parameters whose tolerances go together: an ellipsoid, correlated or not."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, unknown


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipsoid:
    """Parameters that reach their tolerances one at a time, not all together.

    With u the deviations over their tolerances, u^T C^-1 u <= 1. Each parameter alone
    still reaches its own tolerance: for normal deviations with tolerances of k sigma,
    it is the ellipsoid of k sigma.

    Raises:
        ValueError: fewer than two parameters, or C is not a correlation matrix.
    """

    names: tuple[str, ...]
    """Of the m parameters."""
    correlation: tuple[tuple[float, ...], ...] | None = None
    """C, (m, m): 1 on the diagonal, positive definite; None: uncorrelated."""

    def __post_init__(self) -> None:
        """Check the values."""
        listed = ", ".join(self.names)
        if len(set(self.names)) < max(2, len(self.names)):
            raise InputError(
                f"ellipsoid: must have two different parameters or more, got {listed}"
            )
        C, m = self.matrix, len(self.names)
        if C.shape != (m, m) or not np.isfinite(C).all():
            raise InputError(
                f"ellipsoid of {listed}: correlation must be a matrix of {m} by {m} "
                f"numbers, got {self.correlation}"
            )
        if (np.diag(C) != 1.0).any() or (C != C.T).any():
            raise InputError(
                f"ellipsoid of {listed}: correlation must be symmetric with 1 on its "
                f"diagonal, got {self.correlation}"
            )
        if np.linalg.eigvalsh(C)[0] < _LEAST:
            raise InputError(
                f"ellipsoid of {listed}: correlation must be positive definite, got "
                f"{self.correlation}"
            )

    def without(self, names: Collection[str]) -> "Ellipsoid | None":
        """Return that of the other parameters; None if no two are left."""
        kept = [i for i, name in enumerate(self.names) if name not in names]
        if len(kept) < 2:
            return None
        C = self.correlation
        return Ellipsoid(
            names=tuple(self.names[i] for i in kept),
            correlation=C and tuple(tuple(C[i][j] for j in kept) for i in kept),
        )

    @property
    def matrix(self) -> Array:
        """C, (m, m)."""
        if self.correlation is None:
            return np.eye(len(self.names))
        rows = [list(row) for row in self.correlation]
        if any(len(row) != len(rows) for row in rows):
            return np.zeros((0, 0))
        return np.array(rows, dtype=float)


_LEAST = 1e-9
"""Smallest eigenvalue of a correlation matrix: a flatter ellipsoid has no inside."""


class WithinEllipsoid:
    """That points of a box stay in an ellipsoid.

    Attributes:
        label: of the constraint.
        indices: of its parameters in the box.
    """

    def __init__(self, ellipsoid: Ellipsoid, box: ToleranceBox):
        """Prepare.

        Raises:
            ValueError: a parameter of the ellipsoid is not dispersed, or its nominal is
                not the middle of its tolerance.
        """
        sides = {d.name: d.sides for d in box.dispersions}
        for name in ellipsoid.names:
            if name not in sides:
                raise InputError(
                    f"ellipsoid: {unknown('dispersed parameter', name, box.names)}"
                )
            if not sides[name].symmetric:
                raise InputError(
                    f"ellipsoid: {name} must have the same tolerance to either side, "
                    f"got {sides[name].minus:g} below its nominal and "
                    f"{sides[name].plus:g} above, in SI"
                )
        self.label = f"ellipsoid of {' '.join(ellipsoid.names)}"
        self.indices = [box.names.index(name) for name in ellipsoid.names]
        self._root = np.linalg.cholesky(ellipsoid.matrix)
        self._inverse = np.linalg.inv(ellipsoid.matrix)

    def _square(self, u: Array) -> Array:
        mine = u[..., self.indices]
        return np.asarray(np.einsum("...i,ij,...j->...", mine, self._inverse, mine))

    def margins(self, u: Array) -> Array:
        """Return (..., 1) margins 1 - u^T C^-1 u of points (..., n)."""
        return 1.0 - self._square(u)[..., None]

    def jacobian(self, u: Array) -> Array:
        """Return (1, n) derivatives of the margin at a point (n,)."""
        jacobian = np.zeros((1, len(u)))
        jacobian[0, self.indices] = -2.0 * self._inverse @ u[self.indices]
        return jacobian

    def reach(self, u: Array) -> Array:
        """Return (...,) by what factor points (..., n) may be scaled and stay inside.

        Infinite where any factor does.
        """
        square = self._square(u)
        reach = np.full(square.shape, np.inf)
        np.divide(1.0, np.sqrt(square), out=reach, where=square > 0.0)
        return reach

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        """Return (count, m) points drawn uniformly inside."""
        m = len(self.indices)
        direction = rng.standard_normal((count, m))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        radius = rng.uniform(size=(count, 1)) ** (1.0 / m)
        return np.asarray(radius * direction @ self._root.T)


def check_apart(ellipsoids: Sequence[Ellipsoid]) -> None:
    """Raise ValueError if a parameter stands in two ellipsoids."""
    names = [name for ellipsoid in ellipsoids for name in ellipsoid.names]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"ellipsoid: {name} must stand in one of them, got two")
