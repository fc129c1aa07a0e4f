"""Signed distance between parts of two bodies, with what is certain about it.

Drake measures between nodes of the trees of `drakesep.systems.geometry.bounding_tree`.
Its iteration ends early now and then (drake 1.51.1: in one pose of a hundred by more
than 20 um, up to millimetres). The plane between the support points of both nodes along
its normal proves a distance from below; where the two differ, `certify` measures anew.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.bounding_tree import (
    Pair,
    support,
    support_point,
    tree_of,
)
from drakesep.systems.geometry.convex_pieces import mesh_of, place_of
from drakesep.systems.geometry.gjk import gjk
from drakesep.systems.geometry.meshes import encloses, is_closed
from drakesep.systems.geometry.proximity_scenes import ProximityScenes
from drakesep.systems.geometry.relative_path import Pose
from drakesep.systems.model.parts import Mesh, Part


_LOOSE = 5e-6
"""Between a distance and what is certain, up to which it is taken for certain, m."""
TOUCHING = 1e-6
"""Distance up to which Drake cannot tell shapes that touch, m."""


class DistanceBound(NamedTuple):
    """What was measured between two nodes."""

    distance: float
    """m; negative where they overlap."""
    low: float
    """What it is at least, m: that of a plane between them; -inf if they touch."""
    n_A: Array
    """Unit vector across the plane, from the first to the second, in A."""
    p_GCa: Array
    """Nearest point of the first, in the frame of its shape, m."""
    p_GCb: Array
    """Nearest point of the second, in the frame of its shape, m."""
    is_certified: bool
    """Whether the distance is certain, or as certain as it can be."""


class Nearest(NamedTuple):
    """How near two parts are at some moment."""

    distance: float
    """m; negative where pieces of them overlap, by how far these do."""
    p_AoCa_A: Array
    """Nearest point of the first, in its body, m."""
    p_BoCb_B: Array
    """Nearest point of the second, in its body, m."""
    n_A: Array
    """Unit vector from the first to the second, in the first's body."""


class Proximity:
    """Measures parts of a body A to parts of a body B.

    Attributes:
        parts: by their names.
        roots: of their trees of pieces, by the same.
    """

    def __init__(self, on_A: Sequence[Part], on_B: Sequence[Part]):
        """Cut parts into pieces.

        Raises:
            ValueError: a mesh is missing or empty.
        """
        self.parts = {part.name: part for part in (*on_A, *on_B)}
        self.roots = {name: tree_of(part) for name, part in self.parts.items()}
        self._scenes = ProximityScenes(
            [self.roots[part.name] for part in on_A],
            [self.roots[part.name] for part in on_B],
        )

    def measure(self, pair: Pair, pose: Pose) -> DistanceBound:
        """Return how near two nodes are where B is at a pose in A.

        The same whatever was measured before; any number of threads may ask at once.
        """
        try:
            distance, n_A, p_GCa, p_GCb = self._scenes.measure(pair, pose)
        except RuntimeError:
            # Its libccd gives up now and then where polytopes just touch.
            return _measured_without_drake(pair, pose)
        # Between shapes that touch, the normal may be no number.
        if distance <= TOUCHING or not math.isfinite(n_A @ n_A):
            return DistanceBound(distance, -np.inf, n_A, p_GCa, p_GCb, True)
        first, second = pair
        to_second = float(n_A @ pose.p_AoBo_A) - support(second, -n_A @ pose.R_AB)
        low = to_second - support(first, n_A)
        is_certified = distance - low <= _LOOSE
        return DistanceBound(distance, low, n_A, p_GCa, p_GCb, is_certified)


def certify(pair: Pair, pose: Pose, bound: DistanceBound) -> DistanceBound:
    """Return how near two nodes are where B is at a pose in A, certainly.

    Args:
        pair: the nodes.
        pose: of B in A.
        bound: what was measured between them there, which is where this begins.
    """

    def support_points(n_A: Array) -> tuple[Array, Array]:
        second_B = support_point(pair[1], -(pose.R_AB.T @ n_A))
        return support_point(pair[0], n_A), pose.R_AB @ second_B + pose.p_AoBo_A

    found = gjk(support_points, bound.n_A)
    second_B = pose.R_AB.T @ (found.second - pose.p_AoBo_A)
    return DistanceBound(
        found.distance,
        found.low,
        found.n,
        pair[0].X_BG.inverse() @ found.first,
        pair[1].X_BG.inverse() @ second_B,
        is_certified=True,
    )


def _measured_without_drake(pair: Pair, pose: Pose) -> DistanceBound:
    """Return how near two nodes are; 0 where they overlap, by however much."""
    towards = pose.p_AoBo_A + pose.R_AB @ pair[1].X_BG.translation()
    towards = towards - pair[0].X_BG.translation()
    length = np.linalg.norm(towards)
    n_A = towards / length if length > 0.0 else np.array([1.0, 0.0, 0.0])
    unknown = DistanceBound(0.0, -np.inf, n_A, n_A, n_A, is_certified=False)
    bound = certify(pair, pose, unknown)
    return bound._replace(low=-np.inf) if bound.distance <= TOUCHING else bound


def nearest_of(pair: Pair, bound: DistanceBound) -> Nearest:
    """Return what was measured between two nodes, in the axes of their bodies."""
    return Nearest(
        bound.distance,
        pair[0].X_BG @ bound.p_GCa,
        pair[1].X_BG @ bound.p_GCb,
        bound.n_A,
    )


def is_inside(part: Part, p_BoQ_B: Array) -> bool:
    """Return whether a point of its body is inside a part measured by its surface.

    To that, what is wholly inside keeps a distance; to what is solid it has none.
    """
    if not isinstance(part.shape, Mesh):
        return False
    p_GoQ_G = place_of(part).inverse() @ p_BoQ_B
    mesh = mesh_of(part)
    # Nothing is inside of what is not closed.
    return is_closed(mesh) and encloses(mesh, p_GoQ_G / part.shape.scale)
