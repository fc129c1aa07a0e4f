"""The convex pieces that parts are made of, and trees of boxes around them.

Drake measures between convex shapes, and takes the hull of any other: a plug inside a
tube overlaps it by its whole width. What is hollow or dented is therefore cut into
convex pieces here, a wall into staves and a mesh into its triangles. Round walls and
cones become polygons that never make a clearance larger, nor smaller by more than
`FACET` each.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pydrake.geometry as drake
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.geometry.meshes import read_mesh
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere


if TYPE_CHECKING:
    import trimesh

FACET = 2.5e-5
"""By which a polygon misses the circle that it stands for, m."""
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
    """A convex piece of an part, or a box around some of its pieces."""

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


def farthest(node: Node, n_B: Array) -> Array:
    """Return a node's farthest point along a direction, both in its body."""
    if node.corners is not None:
        corner: Array = node.corners[(node.corners @ n_B).argmax()]
        return corner
    R = node.X_BG.rotation().matrix()
    n = R.T @ n_B
    shape = node.shape
    match shape:
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


def reach(node: Node, n_B: Array) -> float:
    """Return how far a node reaches along a direction, both in its body, m."""
    if node.corners is None:
        return float(n_B @ farthest(node, n_B))
    return float((node.corners @ n_B).max())


def leaves_of(node: Node) -> list[Node]:
    """Return the pieces that a node holds; itself if it is one."""
    if not node.children:
        return [node]
    return [leaf for child in node.children for leaf in leaves_of(child)]


# Trees of pieces.


def tree_of(part: Part) -> Node:
    """Return the pieces of an part, with boxes around more and more of them."""
    pieces = pieces_of(part)

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
        half += _THICK
        box = _hull(_CUBE * half)
        order = np.argsort((centres - centre) @ axes[:, 0], kind="stable")
        children = tuple(
            grow([mine[i] for i in indices], centres[indices])
            for indices in np.array_split(order, 2)
        )
        return Node(box, X_BS, ball, radius, children, centre + _CUBE * half @ axes.T)

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


def place_of(part: Part) -> RigidTransform:
    """Return the pose X_BG of an part's shape in its body."""
    return RigidTransform(RollPitchYaw(*part.rpy_BG), part.p_BoGo_B)


def mesh_of(part: Part) -> "trimesh.Trimesh":
    """Return the mesh of an part that is one, in the units of its file.

    Raises:
        ValueError: the file is missing, is no mesh, or one that is not closed.
    """
    assert isinstance(part.shape, Mesh)
    try:
        return read_mesh(part.shape.file)
    except InputError as error:
        raise InputError(f"{part.name}: {error}") from error


def pieces_of(part: Part) -> tuple[_Piece, ...]:
    """Return the convex pieces that an part is made of."""
    X_BG = place_of(part)
    return tuple(
        _Piece(shape, X_BG @ X_GS, (X_BG @ points.T).T)
        for shape, X_GS, points in _pieces(part)
    )


def _pieces(part: Part) -> list[_Piece]:
    shape = part.shape
    match shape:
        case Box():
            return [_convex(_CUBE * np.array(shape.size) / 2.0)]
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
            return _mesh_pieces(mesh_of(part), shape.scale)


def _centred(shape: Any, half: Array, X_GS: RigidTransform | None = None) -> _Piece:
    return _Piece(shape, X_GS or RigidTransform(), _CUBE * half)


_THICK = 1e-6
"""What boxes are larger by to each side, m: Drake makes no hull of what is flat."""
_CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
"""(8, 3) corners."""


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
    return _Piece(_hull(points), RigidTransform(), points)


def _hull(points: Array) -> Any:
    """Return a polytope as Drake's.

    Boxes too: Drake's own end the process in some poses in which two of them overlap
    (drake 1.51.1, BoxBoxGradient: "Unreachable code was reached").
    """
    return drake.Convex(points.T, "piece")


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
