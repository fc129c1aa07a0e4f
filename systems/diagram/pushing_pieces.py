"""How parts push where they touch: over all of their faces, or at a point.

By Drake's hydroelastic contact: pieces with faces are elastic, with a pressure that
rises with the depth below their faces, and press where the pressures of both are equal.
Of two alike in series, each is twice as stiff as both together.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pydrake.geometry as drake
from pydrake.multibody.plant import CoulombFriction
from scipy.spatial import ConvexHull

from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.geometry.convex_pieces import (
    Piece,
    hull,
    pieces_of,
    place_of,
    sides,
)
from drakesep.systems.model.parts import Box, Mesh, Part
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.model.separation import Separation


_APART = 1e-6
"""By which faces of each body's parts lie deeper than those of the body before, m.

Where planes of two parts coincide, Drake loses some of the contact: a cube that slides
between walls as wide as it is would roll."""
_MOST = 0.99
"""Of its size that a piece keeps, however small it is."""


def pushing_pieces(separation: Separation) -> dict[Part, tuple[Piece, ...]]:
    """Return the convex pieces of each part of a separation, as they push.

    Raises:
        ValueError: a mesh cannot be read or is not convex.
    """
    return {
        part: _pieces(part, _APART * number)
        for number, body in enumerate(separation.bodies)
        for part in body.parts
    }


def _pieces(part: Part, less: float) -> tuple[Piece, ...]:
    """Return the pieces of a part.

    Args:
        part: of a body.
        less: how much deeper faces lie, m.
    """
    pieces = pieces_of(part)
    if isinstance(part.shape, Mesh) and len(pieces) > 1:
        # There is no depth in a triangle.
        raise InputError(
            f"recontact: {part.name}: a mesh that pushes must be convex, "
            "got one that is not; make it of boxes, cones and convex meshes"
        )
    return tuple(_pushing(piece, part, less) for piece in pieces)


def _pushing(piece: Piece, part: Part, less: float) -> Piece:
    shape, X_BS, points = piece
    if isinstance(part.shape, Box):
        # Drake's own: its pressure rises alike from each of its faces, in a polytope
        # from the faces to the middle.
        edges = np.array(part.shape.size)
        edges = np.maximum(edges - 2.0 * less, _MOST * edges)
        return Piece(drake.Box(*edges.tolist()), place_of(part), points)
    match shape:
        case drake.Cylinder():
            radius, length = shape.radius(), shape.length()
            shape = drake.Cylinder(
                max(radius - less, _MOST * radius),
                max(length - 2.0 * less, _MOST * length),
            )
        case drake.Convex():
            shape = hull(_drawn_in((X_BS.inverse() @ points.T).T, less))
    return Piece(shape, X_BS, points)


def smallest_area(cut: Mapping[Part, Sequence[Piece]]) -> float:
    """Return how large the smallest piece with faces is across, m^2.

    That is the area of its shadow, on the average over all directions: a quarter of its
    surface, as it is convex (Cauchy). 1 if there is no such piece.
    """
    pieces = [piece for each in cut.values() for piece in each]
    areas = [0.25 * ConvexHull(p.points).area for p in pieces if _depth(p) is not None]
    return float(min(areas, default=1.0))


def properties_of(
    piece: Piece, contact: Recontact, face_stiffness: float
) -> drake.ProximityProperties:
    """Return how a piece pushes.

    Args:
        piece: of a part.
        contact: between the parts.
        face_stiffness: of two faces, N/m^3.
    """
    properties = drake.ProximityProperties()
    drake.AddContactMaterial(
        point_stiffness=2.0 * contact.stiffness,
        dissipation=contact.dissipation,
        friction=CoulombFriction(contact.friction, contact.friction),
        properties=properties,
    )
    depth = _depth(piece)
    if depth is not None:
        # Drake's modulus is the pressure in the middle.
        drake.AddCompliantHydroelasticProperties(
            resolution_hint=_edge(piece),
            hydroelastic_modulus=2.0 * face_stiffness * depth,
            properties=properties,
        )
    return properties


def _depth(piece: Piece) -> float | None:
    """Return how deep the middle of a piece is, m; None if it has no faces."""
    match piece.shape:
        case drake.Box():
            return 0.5 * float(piece.shape.size().min())
        case drake.Cylinder():
            return min(piece.shape.radius(), 0.5 * piece.shape.length())
        case drake.Convex():
            # From the face that it is farthest from: below others pressure rises more.
            return float(_depths_of(piece.points).max())
    return None


def _drawn_in(corners: Array, less: float) -> Array:
    """Return a polytope's corners (k, 3) drawn in along its principal axes, m."""
    middle = corners.mean(axis=0)
    axes = np.linalg.svd(corners - middle, full_matrices=False)[2]
    along = (corners - middle) @ axes.T
    scale = np.maximum(1.0 - 2.0 * less / np.ptp(along, axis=0), _MOST)
    drawn: Array = middle + (scale * along) @ axes
    return drawn


def _depths_of(corners: Array) -> Array:
    """Return how deep the middle of a polytope is below its faces, m.

    Args:
        corners: (k, 3) of it, m.
    """
    faces = ConvexHull(corners).equations
    return -(faces[:, :3] @ corners.mean(axis=0) + faces[:, 3])


def thickness_of(shape: drake.Shape) -> float:
    """Return how thick a pushing piece is across its two nearest faces, m."""
    match shape:
        case drake.Sphere() | drake.Capsule():
            return 2.0 * float(shape.radius())
        case drake.Box():
            return float(shape.size().min())
        case drake.Cylinder():
            return min(2.0 * float(shape.radius()), float(shape.length()))
        case drake.Convex():
            mesh = shape.GetConvexHull()
            corners = np.array([mesh.vertex(k) for k in range(mesh.num_vertices())])
            faces = ConvexHull(corners).equations
            across = -(corners @ faces[:, :3].T + faces[:, 3]).min(axis=0)
            return float(across.min())
    raise TypeError(f"no piece that pushes has the shape {shape}")


def _edge(piece: Piece) -> float:
    """Return how long edges of the mesh of a round piece are, m."""
    if isinstance(piece.shape, drake.Cylinder):
        radius = piece.shape.radius()
        return 2.0 * math.pi * radius / sides(radius)
    return 1.0
