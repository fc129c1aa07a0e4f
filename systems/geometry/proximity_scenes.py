"""What Drake says of the distance between two nodes, where B is placed as one asks.

Drake places bodies in a scene and is then asked, and both change the scene. That stays
in this file: to callers a measurement is a function of two nodes and a pose, the same
to the last bit in whatever thread and after whatever other measurements.

- A lock is held from placing until the answer is there: all threads share the scenes.
- Drake takes two shapes in the order of their ids, and its iteration ends some
  nanometres elsewhere if that is reversed. Ids rise as geometries are made, so those of
  the body with fewer nodes are all made first: of the other, most are never needed, and
  one takes longer than the query.
"""

import threading
from collections.abc import Sequence
from typing import Any, NamedTuple

import pydrake.geometry as drake
from pydrake.math import RigidTransform, RotationMatrix

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.bounding_tree import Node, Pair, nodes_of
from drakesep.systems.geometry.relative_path import Pose


_ROOM = 128
"""Geometries of a scene: one more takes Drake the longer, the more there are."""


class SignedDistance(NamedTuple):
    """What Drake tells of two nodes; it is not certain."""

    distance: float
    """m; negative where they overlap."""
    n_A: Array
    """Unit vector from the first to the second; between what touches, it may be NaN."""
    p_GCa: Array
    """Nearest point of the first, in the frame of its shape, m."""
    p_GCb: Array
    """Nearest point of the second, in the frame of its shape, m."""


class ProximityScenes:
    """Drake's distances between nodes of trees on A and on B."""

    def __init__(self, on_A: Sequence[Node], on_B: Sequence[Node]):
        """Prepare for the trees with these roots."""
        self._lock = threading.Lock()
        self._instances: dict[Node, Any] = {}
        # Of what has been measured: the many pieces that never come near cost nothing.
        self._scenes: list[_Scene] = []
        self._known: dict[Pair, _KnownPair] = {}
        of_A, of_B = (sum(len(root.pieces) for root in roots) for roots in (on_A, on_B))
        self._A_is_first = of_A < of_B
        for root in on_A if self._A_is_first else on_B:
            for node in nodes_of(root):
                self._instance(node)

    def measure(self, pair: Pair, pose: Pose) -> SignedDistance:
        """Return what Drake tells of two nodes where B is at a pose in A."""
        with self._lock:
            scene, a, b = self._known.get(pair) or self._add(pair)
            found = scene.query(pose).ComputeSignedDistancePairClosestPoints(a, b)
        distance, n_W, p, q = found.distance, found.nhat_BA_W, found.p_ACa, found.p_BCb
        # What Drake calls A is the first in its order.
        if self._A_is_first:
            return SignedDistance(distance, -n_W, p, q)
        return SignedDistance(distance, n_W, q, p)

    def _add(self, pair: Pair) -> "_KnownPair":
        """Find a pair a scene."""
        if not self._scenes or self._scenes[-1].is_full:
            self._scenes.append(_Scene())
        scene = self._scenes[-1]
        a, b = (
            scene.id_of(node, self._instance(node), on_A=on_A)
            for node, on_A in zip(pair, (True, False), strict=True)
        )
        self._known[pair] = _KnownPair(scene, a, b)
        return self._known[pair]

    def _instance(self, node: Node) -> Any:
        """Return the geometry of a node, which has its id from now on."""
        if node not in self._instances:
            name = f"node_{len(self._instances)}"
            instance = drake.GeometryInstance(node.X_BG, node.shape, name)
            # With its role at once: assigned later, it would cost three times as much.
            instance.set_proximity_properties(drake.ProximityProperties())
            self._instances[node] = instance
        return self._instances[node]


class _Scene:
    """Some of the nodes, as Drake knows them."""

    def __init__(self) -> None:
        self._scene = drake.SceneGraph()
        self._source = self._scene.RegisterSource("parts")
        self._B = self._scene.RegisterFrame(self._source, drake.GeometryFrame("B"))
        self._context = self._scene.CreateDefaultContext()
        self._pose_port = self._scene.get_source_pose_port(self._source)
        self._query_port = self._scene.get_query_output_port()
        self._query: Any = None
        self._placed: Pose | None = None
        self._ids: dict[Node, Any] = {}

    @property
    def is_full(self) -> bool:
        return len(self._ids) >= _ROOM

    def id_of(self, node: Node, instance: Any, *, on_A: bool) -> Any:
        """Return the id of a node, which Drake knows from now on."""
        if node not in self._ids:
            # A stands still: what is anchored costs nothing when B moves.
            frame = self._scene.world_frame_id() if on_A else self._B
            self._ids[node] = self._scene.RegisterGeometry(
                self._context, self._source, frame, instance
            )
        return self._ids[node]

    def query(self, pose: Pose) -> Any:
        """Return what answers where B is at a pose in A, until it is at another."""
        if pose is not self._placed:
            X_AB = RigidTransform(RotationMatrix(pose.R_AB), pose.p_AoBo_A)
            poses = drake.FramePoseVector()
            poses.set_value(self._B, X_AB)
            self._pose_port.FixValue(self._context, poses)
            self._query = self._query_port.Eval(self._context)
            self._placed = pose
        return self._query


class _KnownPair(NamedTuple):
    """A pair of nodes in a scene."""

    scene: _Scene
    a: Any
    """Drake's id of the first."""
    b: Any
    """Drake's id of the second."""
