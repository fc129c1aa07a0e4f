"""Signed distance between parts of two bodies, by Drake's proximity queries.

Between the convex pieces of `drakesep.systems.geometry.convex_pieces`, whose trees of
boxes tell which come near.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pydrake.geometry as drake
from pydrake.math import RigidTransform, RotationMatrix

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.convex_pieces import (
    Node,
    farthest,
    mesh_of,
    place_of,
    reach,
    tree_of,
)
from drakesep.systems.geometry.gjk import least_distance
from drakesep.systems.geometry.meshes import encloses
from drakesep.systems.model.parts import Mesh, Part


_LOOSE = 5e-6
"""Between a distance and what is certain, up to which it is taken for certain, m."""
TOUCHING = 1e-6
"""Distance up to which Drake cannot tell shapes that touch, m."""
_ROOM = 128
"""Geometries of a scene: one more takes Drake the longer, the more there are."""


class _Points(NamedTuple):
    """Nearest points of two nodes, each in its node's frame, m; as Drake names them."""

    p_ACa: Array
    p_BCb: Array


class Told(NamedTuple):
    """What was measured between two nodes."""

    distance: float
    """m."""
    low: float
    """What it is at least, m: that of a plane between them."""
    n_A: Array
    """Across the plane, from the first to the second."""
    points: Any
    """`_Points`, or Drake's own: taken out where they are wanted, which is seldom."""
    is_swapped: bool
    """Whether the points' A is the second node."""
    is_sharp: bool
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


Pair = tuple[Node, Node]


class Proximity:
    """Measures parts of a body A to parts of a body B.

    Attributes:
        parts: by their names.
        roots: of their trees of pieces, by the same.
    """

    def __init__(self, on_A: Sequence[Part], on_B: Sequence[Part]):
        """Prepare.

        Raises:
            ValueError: a mesh is missing, empty or not closed.
        """
        self.parts = {part.name: part for part in (*on_A, *on_B)}
        self.roots = {name: tree_of(part) for name, part in self.parts.items()}
        # Of what has been measured: the many pieces that never come near cost nothing.
        self._scenes: list[_Scene] = []
        self._scene_of: dict[Pair, _Scene] = {}

    def place(self, R_AB: Array, p_AoBo_A: Array) -> None:
        """Place B in A."""
        self._R_AB, self._p_AoBo_A = R_AB, p_AoBo_A
        self._X_AB = RigidTransform(RotationMatrix(R_AB), p_AoBo_A)

    def measure(self, pair: Pair) -> Told:
        """Return how near two nodes are, as they are placed.

        Drake's iteration ends early now and then (drake 1.51.1: in one pose of a
        hundred by more than 20 um, up to millimetres). The plane between the farthest
        points along its normal tells what is certain; where the two differ, `sharpen`
        tells more.
        """
        a, told = self._scene(pair).measure(pair, self._X_AB)
        is_swapped = told.id_A != a
        n_A: Array = told.nhat_BA_W if is_swapped else -told.nhat_BA_W
        distance: float = told.distance
        # Between shapes that touch, the normal may be no number.
        if distance <= TOUCHING or not math.isfinite(n_A @ n_A):
            return Told(distance, -np.inf, n_A, told, is_swapped, is_sharp=True)
        first, second = pair
        to_second = float(n_A @ self._p_AoBo_A) - reach(second, -n_A @ self._R_AB)
        low = to_second - reach(first, n_A)
        is_sharp = distance - low <= _LOOSE
        return Told(distance, low, n_A, told, is_swapped, is_sharp)

    def sharpen(self, pair: Pair, told: Told) -> Told:
        """Return how near two nodes are, as they are placed and certainly."""
        found = least_distance(lambda n: self._farthest(pair, n), told.n_A)
        a, b = pair
        second_B = self._R_AB.T @ (found.second - self._p_AoBo_A)
        return Told(
            found.distance,
            found.low,
            found.n,
            _Points(a.X_BG.inverse() @ found.first, b.X_BG.inverse() @ second_B),
            is_swapped=False,
            is_sharp=True,
        )

    def _farthest(self, pair: Pair, n_A: Array) -> tuple[Array, Array]:
        """Return the farthest points of two nodes along n and against it, in A."""
        first = farthest(pair[0], n_A)
        second = farthest(pair[1], -(self._R_AB.T @ n_A))
        return first, self._R_AB @ second + self._p_AoBo_A

    def _scene(self, pair: Pair) -> "_Scene":
        """Return the scene of a pair; from now on it has one."""
        if pair not in self._scene_of:
            if not self._scenes or self._scenes[-1].is_full:
                self._scenes.append(_Scene())
            self._scene_of[pair] = self._scenes[-1]
        return self._scene_of[pair]


class _Scene:
    """Some of the pieces, as Drake knows them."""

    def __init__(self) -> None:
        self._scene = drake.SceneGraph()
        self._source = self._scene.RegisterSource("parts")
        self._B = self._scene.RegisterFrame(self._source, drake.GeometryFrame("B"))
        self._context = self._scene.CreateDefaultContext()
        self._pose_port = self._scene.get_source_pose_port(self._source)
        self._query_port = self._scene.get_query_output_port()
        self._query: Any = None
        self._X_AB: RigidTransform | None = None
        self._geometry: dict[Node, Any] = {}

    @property
    def is_full(self) -> bool:
        return len(self._geometry) >= _ROOM

    def measure(self, pair: Pair, X_AB: RigidTransform) -> tuple[Any, Any]:
        """Return which geometry the first node is, and what Drake tells of both."""
        a, b = self._known(pair[0], on_A=True), self._known(pair[1])
        if X_AB is not self._X_AB:
            poses = drake.FramePoseVector()
            poses.set_value(self._B, X_AB)
            self._pose_port.FixValue(self._context, poses)
            self._query = self._query_port.Eval(self._context)
            self._X_AB = X_AB
        return a, self._query.ComputeSignedDistancePairClosestPoints(a, b)

    def _known(self, node: Node, *, on_A: bool = False) -> Any:
        """Return the geometry of a node, which Drake knows from now on."""
        if node not in self._geometry:
            # A stands still: what is anchored costs nothing when B moves.
            frame = self._scene.world_frame_id() if on_A else self._B
            name = f"piece_{len(self._geometry)}"
            instance = drake.GeometryInstance(node.X_BG, node.shape, name)
            # With its role at once: assigned later, it would cost three times as much.
            instance.set_proximity_properties(drake.ProximityProperties())
            self._geometry[node] = self._scene.RegisterGeometry(
                self._context, self._source, frame, instance
            )
        return self._geometry[node]


def nearest_of(pair: Pair, told: Told) -> Nearest:
    """Return what was told of two nodes, in the axes of their bodies."""
    a, b = pair
    p_GCa, p_GCb = told.points.p_ACa, told.points.p_BCb
    if told.is_swapped:
        p_GCa, p_GCb = p_GCb, p_GCa
    return Nearest(told.distance, a.X_BG @ p_GCa, b.X_BG @ p_GCb, told.n_A)


def is_leaf(pair: Pair) -> bool:
    """Return whether both nodes are pieces."""
    return not (pair[0].children or pair[1].children)


def split(pair: Pair) -> list[Pair]:
    """Return the pairs that a pair of nodes holds, from the larger one's children."""
    a, b = pair
    if a.children and (a.radius >= b.radius or not b.children):
        return [(child, b) for child in a.children]
    return [(a, child) for child in b.children]


def is_inside(part: Part, p_BoQ_B: Array) -> bool:
    """Return whether a point of its body is inside an part measured by its surface.

    To that, what is wholly inside keeps a distance; to what is solid it has none.
    """
    if not isinstance(part.shape, Mesh):
        return False
    p_GoQ_G = place_of(part).inverse() @ p_BoQ_B
    return encloses(mesh_of(part), p_GoQ_G / part.shape.scale)
