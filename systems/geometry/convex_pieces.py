"""The convex pieces that parts are made of.

Drake measures between convex shapes, and takes the hull of any other: a plug inside a
tube overlaps it by its whole width. What is hollow or dented is therefore cut into
convex pieces here, a wall into staves and a mesh into its triangles. Round walls and
cones become polygons that never make a clearance larger, nor smaller by more than
`FACET` each.
"""

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pydrake.geometry as drake
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.geometry.meshes import is_closed, read_mesh
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere


if TYPE_CHECKING:
    import trimesh

FACET = 2.5e-5
"""By which a polygon misses the circle that it stands for, m."""
CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
"""(8, 3) corners of a cube whose edges are 2."""
Z_TO_X = RigidTransform(RotationMatrix.MakeYRotation(math.pi / 2.0))
"""Turns Drake's shapes, whose axis is z, to ours."""


class Piece(NamedTuple):
    """A convex shape, and points that span a box around it."""

    shape: Any
    X_BS: RigidTransform
    points: Array
    """(k, 3) in the body."""


def place_of(part: Part) -> RigidTransform:
    """Return the pose X_BG of a part's shape in its body."""
    return RigidTransform(RollPitchYaw(*part.rpy_BG), part.p_BoGo_B)


def mesh_of(part: Part) -> "trimesh.Trimesh":
    """Return the mesh of a part that is one, in the units of its file.

    Raises:
        ValueError: the file is missing or is no mesh.
    """
    assert isinstance(part.shape, Mesh)
    try:
        return read_mesh(part.shape.file)
    except InputError as error:
        raise InputError(f"{part.name}: {error}") from error


def pieces_of(part: Part) -> tuple[Piece, ...]:
    """Return the convex pieces that a part is made of."""
    X_BG = place_of(part)
    return tuple(
        Piece(shape, X_BG @ X_GS, (X_BG @ points.T).T)
        for shape, X_GS, points in _pieces(part)
    )


def _pieces(part: Part) -> list[Piece]:
    shape = part.shape
    match shape:
        case Box():
            return [_convex(CUBE * np.array(shape.size) / 2.0)]
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


def _centred(shape: Any, half: Array, X_GS: RigidTransform | None = None) -> Piece:
    return Piece(shape, X_GS or RigidTransform(), CUBE * half)


def _along_x(shape: Any, half: Sequence[float]) -> Piece:
    """Return a piece whose shape Drake has along z."""
    return _centred(shape, np.array(half), Z_TO_X)


def sides(radius: float) -> int:
    """Return how many sides a polygon has that misses its circle by `FACET`."""
    return max(8, math.ceil(math.pi / math.acos(max(1.0 - FACET / radius, 0.0))))


def _circle(x: float, radius: float, angles: Array) -> Array:
    return np.stack(
        [np.full_like(angles, x), radius * np.cos(angles), radius * np.sin(angles)], 1
    )


def _convex(points: Array) -> Piece:
    return Piece(hull(points), RigidTransform(), points)


def hull(points: Array) -> Any:
    """Return a polytope as Drake's.

    Boxes too: Drake's own end the process in some poses in which two of them overlap
    (drake 1.51.1, BoxBoxGradient: "Unreachable code was reached").
    """
    return drake.Convex(points.T, "piece")


def _solid_cone(cone: Cone) -> Piece:
    if cone.radius_aft == cone.radius_fore:
        half = [cone.length / 2.0, cone.radius_aft, cone.radius_aft]
        return _along_x(drake.Cylinder(cone.radius_aft, cone.length), half)
    n = sides(max(cone.radius_aft, cone.radius_fore))
    angles = 2.0 * np.pi * np.arange(n) / n
    ends = ((-0.5, cone.radius_aft), (0.5, cone.radius_fore))
    around = 1.0 / math.cos(math.pi / n)  # the circle is within the polygon
    rings = [_circle(x * cone.length, around * r, angles) for x, r in ends]
    return _convex(np.unique(np.concatenate(rings), axis=0))


def _staves(cone: Cone) -> list[Piece]:
    """Return the wall of a hollow cone, cut along its length."""
    assert cone.thickness is not None
    n = sides(max(cone.radius_aft, cone.radius_fore))
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
    straight. A dent takes from the volume; one that is not closed has none.
    """
    if not is_closed(mesh) or not mesh.volume > 0.0:
        return False
    hull = mesh.convex_hull
    return bool(hull.volume - mesh.volume <= _DENT * hull.volume)


_DENT = 1e-7
"""Part of a hull's volume that a convex mesh may lack, by round-off."""


def _mesh_pieces(mesh: "trimesh.Trimesh", scale: float) -> list[Piece]:
    """Return the mesh itself if it is convex, else the triangles of its surface."""
    vertices = scale * np.asarray(mesh.vertices)
    if _is_convex(mesh):
        return [_convex(vertices)]
    return [_convex(vertices[face]) for face in np.asarray(mesh.faces)]
