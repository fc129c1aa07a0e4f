"""Closed meshes from files."""

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.checks import InputError, check_positive


if TYPE_CHECKING:
    import trimesh

MESH_SUFFIXES = (".obj", ".stl")


def read_mesh(file: str | Path) -> "trimesh.Trimesh":
    """Return the closed mesh in a file, whose triangles face outward.

    Args:
        file: OBJ or STL.

    Raises:
        ValueError: the file is missing, is no mesh, or one that is not closed.
    """
    path = readable(file, "mesh", MESH_SUFFIXES)
    return _read(path, path.stat().st_mtime_ns)


@functools.lru_cache(maxsize=64)
def _read(path: Path, _: int) -> "trimesh.Trimesh":
    import trimesh  # half a second, for the few cases that have meshes

    try:
        mesh = trimesh.load_mesh(path)
    except Exception as error:  # trimesh raises whatever its readers do
        raise InputError(f"{path.name}: must be a mesh, got: {error}") from error
    if not len(getattr(mesh, "faces", ())):
        raise InputError(f"{path.name}: must be a mesh, got no triangles")
    # Files give corners of their own to faces of other groups, textures and normals.
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    if not mesh.is_watertight or not mesh.is_winding_consistent:
        counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)[1]
        broken = int((counts == 1).sum())
        got = f"{broken} open edges" if broken else "triangles that face both ways"
        raise InputError(f"{path.name}: mesh must be closed, got {got}")
    if mesh.volume < 0.0:
        mesh.invert()
    check_positive(f"{path.name}: volume", float(mesh.volume))
    return mesh


def encloses(mesh: "trimesh.Trimesh", point: NDArray[np.float64]) -> bool:
    """Return whether a point (3,) is inside a closed mesh, by its winding number.

    The sum of the solid angles of the triangles (van Oosterom and Strackee, "The solid
    angle of a plane triangle", doi 10.1109/TBME.1983.325207).
    """
    a, b, c = np.moveaxis(np.asarray(mesh.triangles) - point, 1, 0)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    over = np.einsum("ti,ti->t", a, np.cross(b, c))
    under = (
        la * lb * lc
        + np.einsum("ti,ti->t", a, b) * lc
        + np.einsum("ti,ti->t", b, c) * la
        + np.einsum("ti,ti->t", c, a) * lb
    )
    return bool(abs(np.arctan2(over, under).sum()) > np.pi)


def readable(file: str | Path, kind: str, suffixes: Sequence[str]) -> Path:
    """Return the path of a file that exists and is of a kind.

    Raises:
        ValueError: it is not there, or its name says that it is something else.
    """
    path = Path(file)
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"{kind} file must end in {', '.join(suffixes)}, got {str(file)!r}"
        )
    if not path.is_file():
        raise InputError(f"{kind} file must exist, got {str(file)!r}")
    return path.resolve()
