"""Planes between two parts, found at one pose, that bound their distance at others.

Whatever plane lies between two convex sets, they are no nearer than it tells. Planes
that were the best at one pose are all but the best at poses near by, and to hold them
against many poses takes a product of matrices, where to measure takes an iteration.
"""

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pydrake.geometry as drake

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.bounding_tree import (
    Node,
    Pair,
    is_leaf,
    split,
    support,
)
from drakesep.systems.geometry.convex_pieces import sides
from drakesep.systems.geometry.distance import DistanceBound, Proximity, certify
from drakesep.systems.geometry.relative_path import Pose


_COARSE = 1e-4
"""By which a box may be nearer than what is in it, m: it stands for that."""
_MOST = 600
"""Pairs of boxes or pieces that are opened at a pose."""


class _Planes(NamedTuple):
    """Planes between k pairs of convex sets, of about as many corners each."""

    n_A: Array
    """(k, 3) unit vectors across them, from the first part to the second."""
    reach: Array
    """(k,) how far the first part's sets, and the roundings of the second's, go along
    these, m."""
    corners: Array
    """(k, c, 3) of the second part's sets, in B, m: those that may come nearest to the
    plane if B is turned by no more than the spread."""
    across: Array
    """(k,) diameters of these sets, m."""

    def lower_bounds(self, R_AB: Array, p_AoBo_A: Array, turned: Array) -> Array:
        """Return (n,) what the distance of these sets is at least, m.

        Args:
            R_AB: (n, 3, 3).
            p_AoBo_A: (n, 3), m.
            turned: (n,) by how much more than the spread B is.
        """
        n = len(R_AB)
        n_B = (self.n_A @ R_AB.transpose(1, 2, 0).reshape(3, -1)).reshape(-1, 3, n)
        to_second = (self.corners @ n_B).min(axis=1) + self.n_A @ p_AoBo_A.T
        # A corner that was left out lies behind one that was not, until B is turned by
        # more than the spread: then in front of it by no more than this.
        missed = self.across[:, None] * turned
        least: Array = (to_second - self.reach[:, None] - missed).min(axis=0)
        return least


@dataclass(frozen=True, eq=False)
class SeparatingPlanes:
    """Planes between all of two parts: one for each two convex sets of a cover."""

    R_AB: Array
    """(3, 3) of the pose at which they were found."""
    spread: float
    """Of the rotations for which they are meant; see `turned_by`."""
    groups: tuple[_Planes, ...]

    def lower_bounds(self, R_AB: Array, p_AoBo_A: Array) -> Array:
        """Return (n,) what the parts' distance is at least where B is in A, m.

        Below zero it tells nothing.

        Args:
            R_AB: (n, 3, 3).
            p_AoBo_A: (n, 3), m.
        """
        turned = np.maximum(turned_by(R_AB, self.R_AB) - self.spread, 0.0)
        told = [group.lower_bounds(R_AB, p_AoBo_A, turned) for group in self.groups]
        least: Array = np.minimum.reduce(told)
        return least


def turned_by(R: Array, R_0: Array) -> Array:
    """Return (...) how far a unit vector is moved at most if one rotation is another.

    Args:
        R: (..., 3, 3).
        R_0: (..., 3, 3).
    """
    # Two of the singular values of the difference are equal, and the third is zero.
    norm: Array = np.linalg.norm(R - R_0, axis=(-2, -1)) / math.sqrt(2.0)
    return norm


def separating_planes(
    proximity: Proximity, roots: Pair, pose: Pose, enough: float, spread: float
) -> SeparatingPlanes:
    """Return planes between two parts.

    Args:
        proximity: measures them.
        roots: of their trees.
        pose: of B in A.
        enough: distance, m, from which boxes need not be opened.
        spread: of the rotations for which the planes are meant.
    """
    of_size: dict[int, list[tuple[Array, float, Array, float]]] = {}
    for pair, bound in _cover(proximity, roots, pose, enough):
        n_A = _plane(pair, pose, bound)
        points, radius = _rounded(pair[1])
        corners = _foremost(points, pose.R_AB.T @ n_A, spread)
        plane = n_A, support(pair[0], n_A) + radius, corners, 2.0 * pair[1].radius
        of_size.setdefault(len(corners).bit_length(), []).append(plane)
    groups = [zip(*planes, strict=True) for planes in of_size.values()]
    return SeparatingPlanes(
        R_AB=pose.R_AB,
        spread=spread,
        groups=tuple(
            _Planes(np.array(n_A), np.array(reach), _of_one_size(corners), np.array(d))
            for n_A, reach, corners, d in groups
        ),
    )


def _cover(
    proximity: Proximity, roots: Pair, pose: Pose, enough: float
) -> list[tuple[Pair, DistanceBound]]:
    """Return pairs of nodes that hold two parts, the nearest ones opened first.

    What is opened to little avail is put together again.
    """

    def measured(pair: Pair) -> DistanceBound:
        bound = proximity.measure(pair, pose)
        return bound if bound.is_certified else certify(pair, pose, bound)

    pairs, bounds = [roots], [measured(roots)]
    heap, cover = [(bounds[0].low, 0)], {0}
    opened: list[tuple[int, list[int]]] = []
    while heap and len(opened) < _MOST:
        low, k = heapq.heappop(heap)
        if low >= enough:
            break
        if is_leaf(pairs[k]):
            continue
        children = []
        for pair in split(pairs[k]):
            children.append(len(pairs))
            pairs.append(pair)
            bounds.append(measured(pair))
            heapq.heappush(heap, (bounds[-1].low, children[-1]))
        opened.append((k, children))
        cover = cover - {k} | {*children}
    for k, children in reversed(opened):
        nearest = min(bounds[child].low for child in children)
        if cover.issuperset(children) and nearest <= bounds[k].low + _COARSE:
            cover = cover - {*children} | {k}
    return [(pairs[k], bounds[k]) for k in sorted(cover)]


def _plane(pair: Pair, pose: Pose, bound: DistanceBound) -> Array:
    """Return the unit vector across a plane between two nodes: any, if they touch."""
    n_A = np.asarray(bound.n_A, dtype=float)
    if not math.isfinite(n_A @ n_A) or not n_A.any():
        n_A = pose.R_AB @ pair[1].centre + pose.p_AoBo_A - pair[0].centre
    length = float(np.linalg.norm(n_A))
    return n_A / length if length > 0.0 else np.array([1.0, 0.0, 0.0])


def _rounded(node: Node) -> tuple[Array, float]:
    """Return points (k, 3) in the body and a radius about them that hold a node, m.

    Nothing more; but for a cylinder, whose circles become polygons around them.
    """
    if node.corners is not None:
        return node.corners, 0.0
    X_BG, shape = node.X_BG, node.shape
    match shape:
        case drake.Sphere():
            points, radius = np.zeros((1, 3)), shape.radius()
        case drake.Capsule():
            half = 0.5 * shape.length()
            points, radius = np.array([[0, 0, -half], [0, 0, half]]), shape.radius()
        case _:  # drake.Cylinder
            n = sides(shape.radius())
            angles = 2.0 * np.pi * np.arange(n) / n
            around = shape.radius() / math.cos(math.pi / n)
            ring = around * np.stack([np.cos(angles), np.sin(angles)], axis=1)
            points = np.concatenate(
                [
                    np.column_stack([ring, np.full(n, z * 0.5 * shape.length())])
                    for z in (-1.0, 1.0)
                ]
            )
            radius = 0.0
    return points @ X_BG.rotation().matrix().T + X_BG.translation(), radius


def _foremost(points: Array, n_B: Array, spread: float) -> Array:
    """Return those of points (k, 3) that may be the last against a direction.

    If that is n_B, or differs from it by no more than the spread.
    """
    along = points @ n_B
    first = along.argmin()
    apart = np.linalg.norm(points - points[first], axis=1)
    return points[along - along[first] <= spread * apart + 1e-12]


def _of_one_size(corners: Sequence[Array]) -> Array:
    """Return (k, c, 3) of arrays (c_k, 3), the last of each repeated."""
    most = max(map(len, corners))
    return np.stack(
        [np.concatenate([c, np.repeat(c[-1:], most - len(c), axis=0)]) for c in corners]
    )
