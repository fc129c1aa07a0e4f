"""How parts are drawn: Drake shapes for illustration."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pydrake.geometry as drake
from pydrake.common import MemoryFile
from pydrake.math import RigidTransform

from drakesep.systems.geometry.convex_pieces import Z_TO_X, mesh_of, place_of
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere


if TYPE_CHECKING:
    import trimesh

_SECTIONS = 96
"""Sides of a round wall as it is drawn."""


def illustration_of(part: Part) -> tuple[Any, RigidTransform]:
    """Return Drake's shape of a part as it is drawn, and its pose X_BG.

    Raises:
        ValueError: a mesh is missing or empty.
    """
    shape, X_BG = part.shape, place_of(part)
    match shape:
        case Box():
            return drake.Box(*shape.size), X_BG
        case Sphere():
            return drake.Sphere(shape.radius), X_BG
        case Capsule():
            return drake.Capsule(shape.radius, shape.length), X_BG @ Z_TO_X
        case Cone():
            return _drawn(_revolved(shape), 1.0, part.name), X_BG @ Z_TO_X
        case Mesh():
            return _drawn(mesh_of(part), shape.scale, part.name), X_BG


def _drawn(mesh: "trimesh.Trimesh", scale: float, name: str) -> Any:
    """Return a mesh in memory, in the one format that everything draws."""
    text = mesh.export(file_type="obj", include_normals=False, header=None)
    return drake.Mesh(
        drake.InMemoryMesh(mesh_file=MemoryFile(text, ".obj", name)), scale
    )


def _revolved(cone: Cone) -> "trimesh.Trimesh":
    """Return the surface of a cone along z."""
    import trimesh

    half = 0.5 * cone.length
    aft, fore = (cone.radius_aft, -half), (cone.radius_fore, half)
    if cone.thickness is None:
        profile = [(0.0, -half), aft, fore, (0.0, half)]
    else:
        inner_aft = (cone.radius_aft - cone.thickness, -half)
        inner_fore = (cone.radius_fore - cone.thickness, half)
        profile = [inner_aft, aft, fore, inner_fore, inner_aft]
    return trimesh.creation.revolve(np.array(profile), sections=_SECTIONS)
