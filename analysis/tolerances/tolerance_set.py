"""The set of parameter values that the tolerances admit, and that can exist.

A box around the nominal; within it, ellipsoids of parameters that go together; and the
inertias that a rigid body can have. Each of these is convex and holds the nominal, so
the line from the nominal to a point leaves the set once.
"""

import functools
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.ellipsoid import (
    Ellipsoid,
    WithinEllipsoid,
    check_apart,
)
from drakesep.analysis.tolerances.physical_inertia import PhysicalInertia
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation


_INSIDE = 1e-12
"""How far inside a constraint a point is drawn back to, above round-off."""
_LEAST_SHARE = 1e-3
"""Of the box that must be physical for samples to be drawn from it."""


class Constraint(Protocol):
    """What a point must fulfil beside the box: every margin >= 0."""

    label: str
    indices: list[int]

    def margins(self, u: Array) -> Array:
        """Return (..., k) margins of points (..., n)."""
        ...

    def jacobian(self, u: Array) -> Array:
        """Return (k, n) their derivatives at a point (n,)."""
        ...

    def reach(self, u: Array) -> Array:
        """Return (...,) by what factor points may be scaled and stay inside."""
        ...


@typed
class ToleranceSet:
    """Every point that the tolerances admit.

    Points are scaled, as those of a `ToleranceBox`.

    Attributes:
        separation: whose parameters they are.
        box: the tolerances.
        ellipsoids: of parameters that go together.
        constraints: what a point of the box must fulfil.
    """

    def __init__(
        self,
        separation: Separation,
        box: ToleranceBox,
        ellipsoids: Sequence[Ellipsoid] = (),
    ):
        """Prepare.

        Raises:
            ValueError: an ellipsoid names a parameter that is not dispersed, stands in
                another one or has not its nominal in the middle, or no inertia around
                a nominal one is possible.
        """
        check_apart(ellipsoids)
        self.separation = separation
        self.box = box
        self.ellipsoids = tuple(ellipsoids)
        self._within = [WithinEllipsoid(ellipsoid, box) for ellipsoid in ellipsoids]
        self._physical = [
            PhysicalInertia(body, box)
            for body in separation.bodies
            if set(names_of([body], ["I_BBcm_B"])) & set(box.names)
        ]
        self.constraints: tuple[Constraint, ...] = (*self._within, *self._physical)

    def __len__(self) -> int:
        return len(self.box)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the dispersed parameters."""
        return self.box.names

    def rows(self, u: ArrayLike) -> Array:
        """Return parameter values (..., n), in SI, of scaled points (..., n)."""
        deviations: Array = self.box.tolerance * np.asarray(u, dtype=float)
        return self.box.nominal + deviations

    def values(self, u: ArrayLike) -> dict[str, float]:
        """Return the parameter values of a scaled point (n,), by name, in SI."""
        return self.box.values(u)

    def grown(self, factors: float | Array) -> "ToleranceSet":
        """Return the set with its tolerances multiplied about the nominal.

        Args:
            factors: one for all, or (n,).
        """
        return ToleranceSet(self.separation, self.box.grown(factors), self.ellipsoids)

    def margins(self, u: Array) -> Array:
        """Return (..., k) margins of all constraints at points (..., n)."""
        none = np.zeros((*np.shape(u)[:-1], 0))
        return np.concatenate([none, *(c.margins(u) for c in self.constraints)], -1)

    def jacobian(self, u: Array) -> Array:
        """Return (k, n) the derivatives of the margins at a point (n,)."""
        none = np.zeros((0, len(self)))
        return np.concatenate([none, *(c.jacobian(u) for c in self.constraints)])

    @functools.cached_property
    def margin_labels(self) -> tuple[str, ...]:
        """(k,) label of each margin's constraint."""
        u = np.zeros(len(self))
        return tuple(c.label for c in self.constraints for _ in c.margins(u))

    def contains(self, u: ArrayLike) -> NDArray[np.bool_]:
        """Return (...,) whether points (..., n) are in the set."""
        points = np.asarray(u, dtype=float)
        inside = self.box.contains(points)
        for constraint in self.constraints:
            inside &= constraint.reach(points) >= 1.0 - _INSIDE
        return np.asarray(inside)

    def draw_back(self, u: ArrayLike) -> Array:
        """Return points (..., n) drawn into the set.

        First into the box, entry by entry. Then the parameters of a constraint that is
        not fulfilled go to where the line from their nominal values leaves it;
        constraints that share parameters go together. Everything else stays.
        """
        drawn = self.box.clipped(u)
        for indices, constraints in self._groups:
            reach = np.min([c.reach(drawn) for c in constraints], axis=0)
            factor = np.where(reach < 1.0, (1.0 - _INSIDE) * reach, 1.0)
            drawn[..., indices] *= factor[..., None]
        return drawn

    def grown_points(self, u: ArrayLike, factors: ArrayLike) -> Array:
        """Return the points (..., n) of grown sets that points of this one turn into.

        Args:
            u: (..., n) points of this set.
            factors: (..., n) by which the tolerances grow.

        Returns:
            Scaled by the tolerances of this set; drawn back to possible inertias.
        """
        points: Array = np.asarray(u, dtype=float) * np.asarray(factors, dtype=float)
        for indices, constraints in self._groups:
            for constraint in constraints:
                if constraint in self._physical:
                    reach = constraint.reach(points)
                    factor = np.where(reach < 1.0, (1.0 - _INSIDE) * reach, 1.0)
                    points[..., indices] *= factor[..., None]
        return points

    @functools.cached_property
    def _groups(self) -> list[tuple[list[int], list[Constraint]]]:
        """Constraints that share parameters, with their parameters."""
        groups: list[tuple[set[int], list[Constraint]]] = []
        for constraint in self.constraints:
            indices, together = set(constraint.indices), [constraint]
            for group in [g for g in groups if g[0] & indices]:
                groups.remove(group)
                indices |= group[0]
                together = group[1] + together
            groups.append((indices, together))
        return [(sorted(indices), together) for indices, together in groups]

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        """Return (count, n) points drawn uniformly from the set.

        Raises:
            ValueError: hardly any point of the box is physical.
        """
        drawn: list[Array] = []
        tried = found = 0
        while found < count:
            points = self._draw_tolerances(max(count - found, 1000), rng)
            points = points[self.can_exist(points)]
            tried += max(count - found, 1000)
            found += len(points)
            drawn.append(points)
            if tried >= 10 / _LEAST_SHARE and found < _LEAST_SHARE * tried:
                raise InputError(
                    "dispersions: samples need a set of which a thousandth is "
                    f"physical, got {found} of {tried} points with possible inertias; "
                    "narrow the tolerances of the inertia"
                )
        return np.concatenate(drawn)[:count] if drawn else np.zeros((0, len(self)))

    def share_unphysical(self, count: int = 100_000, seed: int = 0) -> float:
        """Return the share of the tolerances whose inertias no body can have.

        Args:
            count: of the samples that tell.
            seed: of the samples.
        """
        if not self._physical:
            return 0.0
        points = self._draw_tolerances(count, np.random.default_rng(seed))
        return 1.0 - float(self.can_exist(points).mean())

    def _draw_tolerances(self, count: int, rng: np.random.Generator) -> Array:
        points = rng.uniform(self.box.lower, self.box.upper, size=(count, len(self)))
        for within in self._within:
            points[:, within.indices] = within.draw(count, rng)
        return points

    def can_exist(self, points: Array) -> NDArray[np.bool_]:
        """Return (N,) whether a body can have the inertias of points (N, n).

        They may lie beyond the tolerances.
        """
        exists = np.full(len(points), True)
        for inertia in self._physical:
            exists &= inertia.holds(points)
        return exists
