"""Signed distance between elements of two bodies, by Drake's proximity queries.

Drake measures between convex shapes, and takes the hull of any other: a plug inside a
tube overlaps it by its whole width. What is hollow or dented is therefore cut into
convex pieces here, a wall into staves and a mesh into its triangles, and a tree of
boxes around them tells which come near. Round walls and cones become polygons that
never make a clearance larger, nor smaller by more than `FACET` each.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pydrake.geometry as drake
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from drakesep.systems.checks import InputError
from drakesep.systems.elements import Box, Capsule, Cone, Element, Mesh, Sphere
from drakesep.systems.least_distance import least_distance
from drakesep.systems.mesh_files import encloses, read_mesh
from drakesep.systems.run import Array


if TYPE_CHECKING:
    import trimesh

FACET = 2.5e-5
"""By which a polygon misses the circle that it stands for, m."""
_LOOSE = 5e-6
"""Between the distance and what is certain, beyond which it is measured anew, m."""
TOUCHING = 1e-6
"""Distance up to which Drake cannot tell shapes that touch, m."""
Z_TO_X = RigidTransform(RotationMatrix.MakeYRotation(math.pi / 2.0))
"""Turns Drake's shapes, whose axis is z, to ours."""


class _Piece(NamedTuple):
    """A convex shape, and points that span a box around it."""

    shape: Any
    X_BS: RigidTransform
    points: Array
    """(k, 3) in the body."""


@dataclass(slots=True, eq=False)
class Node:
    """A convex piece of an element, or a box around some of its pieces."""

    shape: Any
    """Drake's."""
    X_BG: RigidTransform
    centre: tuple[float, float, float]
    """Of a ball around it, in its body, m."""
    radius: float
    """Of the ball, m."""
    children: "tuple[Node, ...]"
    """Empty for a piece."""
    corners: Array | None
    """(k, 3) of a polytope, in its body; None: the shape tells its own."""


class Told(NamedTuple):
    """What was measured between two nodes."""

    distance: float
    """m."""
    low: float
    """What it is at least, m: that of a plane between them."""
    n_A: Array
    """Across the plane, from the first to the second."""
    p_GCa: Array
    p_GCb: Array
    """Nearest points, each in its node's frame, m."""


class Nearest(NamedTuple):
    """How near two elements are at some moment."""

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
    """Measures elements of a body A to elements of a body B.

    Attributes:
        elements: by their names.
        roots: of their trees of pieces, by the same.
    """

    def __init__(self, on_A: Sequence[Element], on_B: Sequence[Element]):
        """Prepare.

        Raises:
            ValueError: a mesh is missing, empty or not closed.
        """
        self.elements = {element.name: element for element in (*on_A, *on_B)}
        self.roots = {name: tree_of(element) for name, element in self.elements.items()}
        self._scene = drake.SceneGraph()
        self._source = self._scene.RegisterSource("elements")
        self._B = self._scene.RegisterFrame(self._source, drake.GeometryFrame("B"))
        self._context = self._scene.CreateDefaultContext()
        self._pose_port = self._scene.get_source_pose_port(self._source)
        self._query_port = self._scene.get_query_output_port()
        self._query: Any = None
        # Of what has been measured: the many pieces that never come near cost nothing.
        self._geometry: dict[Node, Any] = {}

    def place(self, R_AB: Array, p_AoBo_A: Array) -> None:
        """Place B in A."""
        self._R_AB, self._p_AoBo_A = R_AB, p_AoBo_A
        poses = drake.FramePoseVector()
        poses.set_value(self._B, RigidTransform(RotationMatrix(R_AB), p_AoBo_A))
        self._pose_port.FixValue(self._context, poses)
        self._query = self._query_port.Eval(self._context)

    def measure(self, pair: Pair) -> Told:
        """Return how near two nodes are, as they are placed.

        Drake's iteration ends early now and then (drake 1.51.1: in one pose of a
        hundred by more than 20 um, up to millimetres). The plane between the farthest
        points along its normal tells what is certain; where the two differ, pieces are
        measured anew.
        """
        a, b = self._registered(pair[0], on_A=True), self._registered(pair[1])
        told = self._query.ComputeSignedDistancePairClosestPoints(a, b)
        n_A: Array = -told.nhat_BA_W if told.id_A == a else told.nhat_BA_W
        distance = float(told.distance)
        points = told.p_ACa, told.p_BCb
        if told.id_A != a:
            points = points[1], points[0]
        if distance <= TOUCHING or not np.isfinite(n_A).all():
            return Told(distance, -np.inf, n_A, *points)
        first, second = self._farthest(pair, n_A)
        low = float(n_A @ (second - first))
        if distance - low > _LOOSE and is_leaf(pair):
            return self._anew(pair, n_A)
        return Told(distance, low, n_A, *points)

    def _anew(self, pair: Pair, n_A: Array) -> Told:
        found = least_distance(lambda n: self._farthest(pair, n), n_A)
        a, b = pair
        second_B = self._R_AB.T @ (found.second - self._p_AoBo_A)
        return Told(
            found.distance,
            found.low,
            found.n,
            a.X_BG.inverse() @ found.first,
            b.X_BG.inverse() @ second_B,
        )

    def _farthest(self, pair: Pair, n_A: Array) -> tuple[Array, Array]:
        """Return the farthest points of two nodes along n and against it, in A."""
        first = farthest(pair[0], n_A)
        second = farthest(pair[1], -(self._R_AB.T @ n_A))
        return first, self._R_AB @ second + self._p_AoBo_A

    def _registered(self, node: Node, *, on_A: bool = False) -> Any:
        """Return the geometry of a node, which Drake knows from now on."""
        if node not in self._geometry:
            # A stands still: what is anchored costs nothing when B moves.
            frame = self._scene.world_frame_id() if on_A else self._B
            name = f"piece_{len(self._geometry)}"
            instance = drake.GeometryInstance(node.X_BG, node.shape, name)
            where = self._context, self._source
            geometry = self._scene.RegisterGeometry(*where, frame, instance)
            self._scene.AssignRole(*where, geometry, drake.ProximityProperties())
            self._geometry[node] = geometry
        return self._geometry[node]


def nearest_of(pair: Pair, told: Told) -> Nearest:
    """Return what was told of two nodes, in the axes of their bodies."""
    a, b = pair
    return Nearest(told.distance, a.X_BG @ told.p_GCa, b.X_BG @ told.p_GCb, told.n_A)


def farthest(node: Node, n_B: Array) -> Array:
    """Return a node's farthest point along a direction, both in its body."""
    if node.corners is not None:
        corner: Array = node.corners[(node.corners @ n_B).argmax()]
        return corner
    R = node.X_BG.rotation().matrix()
    n = R.T @ n_B
    shape = node.shape
    match shape:
        case drake.Box():
            point = 0.5 * np.copysign(shape.size(), n)
        case drake.Sphere():
            point = shape.radius() * n
        case drake.Capsule():
            point = shape.radius() * n
            point[2] += math.copysign(0.5 * shape.length(), n[2])
        case _:  # drake.Cylinder
            across = max(math.hypot(n[0], n[1]), 1e-300)
            point = shape.radius() / across * n
            point[2] = math.copysign(0.5 * shape.length(), n[2])
    p: Array = R @ point + node.X_BG.translation()
    return p


def is_leaf(pair: Pair) -> bool:
    """Return whether both nodes are pieces."""
    return not (pair[0].children or pair[1].children)


def split(pair: Pair) -> list[Pair]:
    """Return the pairs that a pair of nodes holds, from the larger one's children."""
    a, b = pair
    if a.children and (a.radius >= b.radius or not b.children):
        return [(child, b) for child in a.children]
    return [(a, child) for child in b.children]


def leaves_of(node: Node) -> list[Node]:
    """Return the pieces that a node holds; itself if it is one."""
    if not node.children:
        return [node]
    return [leaf for child in node.children for leaf in leaves_of(child)]


def is_inside(element: Element, p_BoQ_B: Array) -> bool:
    """Return whether a point of its body is inside an element measured by its surface.

    To that, what is wholly inside keeps a distance; to what is solid it has none.
    """
    if not isinstance(element.shape, Mesh):
        return False
    p_GoQ_G = place_of(element).inverse() @ p_BoQ_B
    return encloses(mesh_of(element), p_GoQ_G / element.shape.scale)


# Trees of pieces.


def tree_of(element: Element) -> Node:
    """Return the pieces of an element, with boxes around more and more of them."""
    pieces = pieces_of(element)

    def grow(mine: Sequence[_Piece], centres: Array) -> Node:
        points = np.concatenate([piece.points for piece in mine])
        centre, axes, half = _box_around(points)
        radius = float(np.linalg.norm(points - centre, axis=1).max())
        ball = tuple(centre.tolist())
        if len(mine) == 1:
            shape, X_BS, _ = mine[0]
            corners = points if isinstance(shape, drake.Convex) else None
            return Node(shape, X_BS, ball, radius, (), corners)
        X_BS = RigidTransform(RotationMatrix(axes), centre)
        box = drake.Box(*(2.0 * half + 1e-9))
        order = np.argsort((centres - centre) @ axes[:, 0], kind="stable")
        children = tuple(
            grow([mine[i] for i in part], centres[part])
            for part in np.array_split(order, 2)
        )
        return Node(box, X_BS, ball, radius, children, None)

    return grow(pieces, np.array([piece.points.mean(axis=0) for piece in pieces]))


def _box_around(points: Array) -> tuple[Array, Array, Array]:
    """Return centre, axes (as columns, the longest first) and half edges of a box."""
    mean = points.mean(axis=0)
    _, axes = np.linalg.eigh((points - mean).T @ (points - mean))
    axes = axes[:, ::-1]
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    along = (points - mean) @ axes
    low, high = along.min(axis=0), along.max(axis=0)
    return mean + axes @ (0.5 * (low + high)), axes, 0.5 * (high - low)


# Pieces.


def place_of(element: Element) -> RigidTransform:
    """Return the pose X_BG of an element's shape in its body."""
    return RigidTransform(RollPitchYaw(*element.rpy_BG), element.p_BoGo_B)


def mesh_of(element: Element) -> "trimesh.Trimesh":
    """Return the mesh of an element that is one, in the units of its file.

    Raises:
        ValueError: the file is missing, is no mesh, or one that is not closed.
    """
    assert isinstance(element.shape, Mesh)
    try:
        return read_mesh(element.shape.file)
    except InputError as error:
        raise InputError(f"{element.name}: {error}") from error


def pieces_of(element: Element) -> tuple[_Piece, ...]:
    """Return the convex pieces that an element is made of."""
    X_BG = place_of(element)
    return tuple(
        _Piece(shape, X_BG @ X_GS, (X_BG @ points.T).T)
        for shape, X_GS, points in _pieces(element)
    )


def _pieces(element: Element) -> list[_Piece]:
    shape = element.shape
    match shape:
        case Box():
            return [_centred(drake.Box(*shape.size), np.array(shape.size) / 2.0)]
        case Sphere():
            return [_centred(drake.Sphere(shape.radius), np.full(3, shape.radius))]
        case Capsule():
            half = [shape.length / 2.0 + shape.radius, shape.radius, shape.radius]
            return [_along_x(drake.Capsule(shape.radius, shape.length), half)]
        case Cone(thickness=None):
            return [_solid_cone(shape)]
        case Cone():
            return _staves(shape)
        case Mesh():
            return _mesh_pieces(mesh_of(element), shape.scale)


def _centred(shape: Any, half: Array, X_GS: RigidTransform | None = None) -> _Piece:
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    return _Piece(shape, X_GS or RigidTransform(), corners * half)


def _along_x(shape: Any, half: Sequence[float]) -> _Piece:
    """Return a piece whose shape Drake has along z."""
    return _centred(shape, np.array(half), Z_TO_X)


def _sides(radius: float) -> int:
    """Return how many sides a polygon has that misses its circle by `FACET`."""
    return max(8, math.ceil(math.pi / math.acos(max(1.0 - FACET / radius, 0.0))))


def _circle(x: float, radius: float, angles: Array) -> Array:
    return np.stack(
        [np.full_like(angles, x), radius * np.cos(angles), radius * np.sin(angles)], 1
    )


def _convex(points: Array) -> _Piece:
    return _Piece(drake.Convex(points.T, "piece"), RigidTransform(), points)


def _solid_cone(cone: Cone) -> _Piece:
    if cone.radius_aft == cone.radius_fore:
        half = [cone.length / 2.0, cone.radius_aft, cone.radius_aft]
        return _along_x(drake.Cylinder(cone.radius_aft, cone.length), half)
    n = _sides(max(cone.radius_aft, cone.radius_fore))
    angles = 2.0 * np.pi * np.arange(n) / n
    ends = ((-0.5, cone.radius_aft), (0.5, cone.radius_fore))
    around = 1.0 / math.cos(math.pi / n)  # the circle is within the polygon
    rings = [_circle(x * cone.length, around * r, angles) for x, r in ends]
    return _convex(np.unique(np.concatenate(rings), axis=0))


def _staves(cone: Cone) -> list[_Piece]:
    """Return the wall of a hollow cone, cut along its length."""
    assert cone.thickness is not None
    n = _sides(max(cone.radius_aft, cone.radius_fore))
    angles = 2.0 * np.pi * np.arange(n + 1) / n
    around = 1.0 / math.cos(math.pi / n)
    # Inside, the corners are on the circle: the wall is never thinner than it is.
    circles = [
        _circle(x * cone.length, radius, angles)
        for x, r in ((-0.5, cone.radius_aft), (0.5, cone.radius_fore))
        for radius in (r - cone.thickness, around * r)
    ]
    return [
        _convex(np.concatenate([circle[k : k + 2] for circle in circles]))
        for k in range(n)
    ]


def _is_convex(mesh: "trimesh.Trimesh") -> bool:
    """Return whether a mesh fills its hull.

    Not by the angles at its edges: those of a fine mesh of a shallow dish are all but
    straight. A dent takes from the volume.
    """
    hull = mesh.convex_hull
    return bool(hull.volume - mesh.volume <= _DENT * hull.volume)


_DENT = 1e-7
"""Part of a hull's volume that a convex mesh may lack, by round-off."""


def _mesh_pieces(mesh: "trimesh.Trimesh", scale: float) -> list[_Piece]:
    """Return the mesh itself if it is convex, else the triangles of its surface."""
    vertices = scale * np.asarray(mesh.vertices)
    if _is_convex(mesh):
        return [_convex(vertices)]
    return [_convex(vertices[face]) for face in np.asarray(mesh.faces)]
