"""How the dispersed parameters of a case are distributed together.

Each has its own distribution. Of those in rank correlations, the standard normal values
behind them are correlated; see `drakesep.analysis.tolerances.correlations`. Those of an
ellipsoid are either all uniform, and then uniform within it, or all normal, and then
the ellipsoid's correlations are theirs: searches look within it, and some draws lie
beyond.

All operations are on single numbers, entry by entry: what becomes of a point does not
depend, in any bit, on those beside it.
"""

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from scipy.special import gammainc, ndtri

from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.correlations import (
    RankCorrelation,
    correlated_normals,
)
from drakesep.analysis.tolerances.distributions import (
    Discrete,
    Normal,
    Uniform,
    distribution_of,
)
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.sides import Distribution
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, named, unknown


class _Group(Protocol):
    """Parameters that depend on each other."""

    indices: list[int]
    """(m,) of the parameters."""

    def values(self, z: list[Array]) -> list[Array]:
        """Return the values (N,) of each, of independent standard normal ones."""
        ...


@typed
class JointDistribution:
    """The distribution of all dispersed parameters, of what cannot exist too.

    Attributes:
        names: (n,) of the parameters.
        distributions: (n,) of each.
        nominal: (n,) values, in SI.
    """

    def __init__(
        self,
        box: ToleranceBox,
        correlations: Sequence[RankCorrelation] = (),
        ellipsoids: Sequence[Ellipsoid] = (),
    ):
        """Prepare.

        Args:
            box: the dispersed parameters.
            correlations: of some of them.
            ellipsoids: of some of them, whose nominals are in the middle.

        Raises:
            ValueError: a correlation is of a parameter that is not dispersed, is
                discrete or stands in an ellipsoid, or none can be so; or parameters of
                an ellipsoid are neither all uniform nor all normal.
        """
        self.names = box.names
        self.nominal = box.nominal
        self._about: list[float] = box.nominal.tolist()
        self.distributions: tuple[Distribution, ...] = tuple(
            distribution_of(d.tolerance) for d in box.dispersions
        )
        in_ellipsoids = {name for one in ellipsoids for name in one.names}
        with named("correlations"):
            for correlation in correlations:
                self._check(correlation, in_ellipsoids)
            correlated = correlated_normals(correlations)
        groups: list[_Group] = [
            self._correlated(normals.names, normals.matrix) for normals in correlated
        ]
        for ellipsoid in ellipsoids:
            with named("ellipsoids"):
                kind = self._kind(ellipsoid)
            if kind is Normal:
                groups.append(self._correlated(ellipsoid.names, ellipsoid.matrix))
            else:
                groups.append(_Within(self._indices(ellipsoid.names), ellipsoid, box))
        self._groups = tuple(groups)
        together = {i for group in groups for i in group.indices}
        self._apart = [i for i in range(len(self.names)) if i not in together]

    def values(self, q: Array) -> Array:
        """Return the values (N, n), in SI, at points of the unit cube.

        Args:
            q: (N, n) of independent uniform numbers, 0 < q < 1.
        """
        return self._values(
            q,
            lambda column: np.asarray(ndtri(column)),
            lambda i, column: self.distributions[i].ppf(column, self._about[i]),
        )

    def of_normals(self, z: Array) -> Array:
        """Return the values (N, n), in SI, at points of standard normal space.

        Args:
            z: (N, n) of independent standard normal numbers.
        """
        return self._values(
            z,
            lambda column: column,
            lambda i, column: self.distributions[i].of_normal(column, self._about[i]),
        )

    def _values(
        self,
        points: Array,
        normal: Callable[[Array], Array],
        value: Callable[[int, Array], Array],
    ) -> Array:
        """Return the values of points whose entries have normal ones, and values."""
        columns = np.ascontiguousarray(points.T)
        values = np.empty(columns.shape).T  # by columns
        # What is too large for a number is infinite, and cannot be.
        with np.errstate(over="ignore", invalid="ignore"):
            for i in self._apart:
                values[:, i] = value(i, columns[i])
            for group in self._groups:
                of_group = group.values([normal(columns[i]) for i in group.indices])
                for i, column in zip(group.indices, of_group, strict=True):
                    values[:, i] = column
        return values

    def _indices(self, names: Sequence[str]) -> list[int]:
        return [self.names.index(name) for name in names]

    def _correlated(self, names: Sequence[str], matrix: Array) -> "_Correlated":
        indices = self._indices(names)
        return _Correlated(
            indices,
            matrix,
            [self.distributions[i] for i in indices],
            [self._about[i] for i in indices],
        )

    def _check(self, correlation: RankCorrelation, in_ellipsoids: set[str]) -> None:
        """Raise InputError unless parameters can be in a correlation."""
        label = correlation.label
        for name in correlation.names:
            if name not in self.names:
                why = unknown("dispersed parameter", name, self.names)
                raise InputError(f"{label}: {why}")
            if isinstance(self.distributions[self.names.index(name)], Discrete):
                raise InputError(
                    f"{label}: must be of continuous distributions, got {name}, which "
                    "is discrete"
                )
            if name in in_ellipsoids:
                raise InputError(
                    f"{label}: {name} must stand in no ellipsoid, which says how it "
                    "goes with others"
                )

    def _kind(self, ellipsoid: Ellipsoid) -> type[Distribution]:
        """Return of which kind the parameters of an ellipsoid are."""
        of = [self.distributions[i] for i in self._indices(ellipsoid.names)]
        if all(isinstance(one, Normal) for one in of):
            return Normal
        if all(isinstance(one, Uniform) and one.within is None for one in of):
            return Uniform
        kinds = ", ".join(
            f"{name} {one.kind}" for name, one in zip(ellipsoid.names, of, strict=True)
        )
        raise InputError(
            "ellipsoid: its parameters must be all normal, or all uniform without "
            f"'within', got {kinds}"
        )


class _Correlated:
    """Parameters whose standard normal values are correlated."""

    def __init__(
        self,
        indices: list[int],
        matrix: Array,
        distributions: Sequence[Distribution],
        nominal: Sequence[float],
    ):
        self.indices = indices
        self._root = np.asarray(np.linalg.cholesky(matrix), dtype=float)
        self._marginals = list(zip(distributions, nominal, strict=True))

    def values(self, z: list[Array]) -> list[Array]:
        """See `_Group`."""
        return [
            distribution.of_normal(column, nominal)
            for (distribution, nominal), column in zip(
                self._marginals, _times(self._root, z), strict=True
            )
        ]


class _Within:
    """Parameters that are uniform in an ellipsoid."""

    def __init__(self, indices: list[int], ellipsoid: Ellipsoid, box: ToleranceBox):
        self.indices = indices
        self._nominal = box.nominal[indices].tolist()
        scale = box.tolerance[indices]
        self._root = scale[:, None] * np.linalg.cholesky(ellipsoid.matrix)

    def values(self, z: list[Array]) -> list[Array]:
        """See `_Group`.

        Of m normal numbers the direction is uniform, and independent of their square,
        whose share is that of chi-squared; the m-th power of the radius of a point
        that is uniform in a ball is uniform.
        """
        m = len(self.indices)
        square = z[0] * z[0]
        for column in z[1:]:
            square = square + column * column
        radius: Array = gammainc(0.5 * m, 0.5 * square) ** (1.0 / m)
        factor = np.zeros(len(square))
        np.divide(radius, np.sqrt(square), out=factor, where=square > 0.0)
        deviations = _times(self._root, [factor * column for column in z])
        return [n + d for n, d in zip(self._nominal, deviations, strict=True)]


def _times(root: Array, z: list[Array]) -> list[Array]:
    """Return what a lower triangle (m, m) makes of (m,) columns, each (N,)."""
    products = []
    for i, row in enumerate(root.tolist()):
        total = row[0] * z[0]
        for k in range(1, i + 1):
            total = total + row[k] * z[k]
        products.append(total)
    return products
