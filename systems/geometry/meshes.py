"""Meshes from files."""

import base64
import functools
import json
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.checks import DrakesepWarning, InputError, check_positive
from drakesep.systems.geometry.mesh_faults import fault_of


if TYPE_CHECKING:
    import trimesh

MESH_SUFFIXES = (".obj", ".stl", ".ply", ".glb", ".gltf")
_CONVERSIONS = {
    ".dae": "COLLADA, which `assimp export FILE.dae FILE.glb` or Blender converts",
    ".fbx": "FBX, which `assimp export FILE.fbx FILE.glb` or Blender converts",
    ".3ds": "3DS, which `assimp export FILE.3ds FILE.glb` or Blender converts",
    ".wrl": "VRML, which `assimp export FILE.wrl FILE.glb` or MeshLab converts",
    ".blend": "a Blender file, which Blender exports as GLB",
    ".step": "STEP, which has no triangles: gmsh or FreeCAD make an STL of it",
    ".stp": "STEP, which has no triangles: gmsh or FreeCAD make an STL of it",
    ".igs": "IGES, which has no triangles: gmsh or FreeCAD make an STL of it",
    ".iges": "IGES, which has no triangles: gmsh or FreeCAD make an STL of it",
    ".usd": "USD, which Blender exports as GLB",
    ".usdz": "USD, which Blender exports as GLB",
}
"""What other formats are, and what makes a mesh of them that is read."""
_LFS = b"version https://git-lfs"
"""What stands in the place of a file that Git LFS keeps elsewhere."""


def read_mesh(file: str | Path) -> "trimesh.Trimesh":
    """Return the mesh in a file, in its axes; if it is closed, it faces outward.

    Args:
        file: OBJ, STL, PLY or glTF, of which all that is shown makes one mesh; buffers
            of a glTF may be in files beside it.

    Raises:
        ValueError: the file is missing or is no mesh.
    """
    path = readable(file, "mesh", MESH_SUFFIXES)
    files = [path, *_buffers_beside(path).values()]
    return _read(path, tuple(file.stat().st_mtime_ns for file in files))


def read_solid(file: str | Path) -> "trimesh.Trimesh":
    """Return the closed mesh in a file, whose triangles face outward.

    Args:
        file: as of `read_mesh`.

    Raises:
        ValueError: the file is missing, is no mesh, or one that bounds no volume.
    """
    mesh = read_mesh(file)
    name = Path(file).name
    if not is_closed(mesh):
        counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)[1]
        broken = int((counts == 1).sum())
        got = f"{broken} open edges" if broken else "triangles that face both ways"
        raise InputError(f"{name}: mesh must be closed, got {got}")
    with np.errstate(all="ignore"):  # of a volume of zero
        check_positive(f"{name}: volume", abs(float(mesh.volume)))
    return mesh


def is_closed(mesh: "trimesh.Trimesh") -> bool:
    """Return whether a mesh bounds a volume: else it is a surface."""
    return bool(mesh.is_watertight and mesh.is_winding_consistent)


@functools.lru_cache(maxsize=64)
def _read(path: Path, _: tuple[int, ...]) -> "trimesh.Trimesh":
    import trimesh  # half a second, for the few cases that have meshes

    try:
        with np.errstate(all="ignore"):  # of what is refused
            mesh = trimesh.load_mesh(path, skip_materials=True)
    except Exception as error:  # trimesh raises whatever its readers do
        got = fault_of(path) or str(error)
        raise InputError(f"{path.name}: must be a mesh, got {got}") from error
    if not len(getattr(mesh, "faces", ())):
        got = fault_of(path) or "no triangles"
        raise InputError(f"{path.name}: must be a mesh, got {got}")
    # Files give corners of their own to faces of other groups, textures and normals.
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    closed = is_closed(mesh)
    if not closed and (fault := fault_of(path)):
        raise InputError(f"{path.name}: must be a mesh, got {fault}")
    if not np.isfinite(mesh.vertices).all():
        raise InputError(f"{path.name}: must be a mesh, got corners that are no number")
    with np.errstate(all="ignore"):  # of a volume of zero
        if closed and float(mesh.volume) < 0.0:
            mesh.invert()
    return mesh


def mesh_bytes(file: Path) -> bytes:
    """Return what a mesh file holds; of a glTF, with the buffers that are beside it.

    Raises:
        ValueError: it is a glTF that cannot be read, or a buffer is not there.
    """
    beside = _buffers_beside(file)
    if not beside:
        return file.read_bytes()
    content = json.loads(file.read_bytes())
    for buffer in content["buffers"]:
        if (held := beside.get(buffer.get("uri"))) is not None:
            data = base64.b64encode(held.read_bytes()).decode()
            buffer["uri"] = f"data:application/octet-stream;base64,{data}"
    return json.dumps(content).encode()


def _buffers_beside(path: Path) -> dict[str, Path]:
    """Return the files beside a glTF that hold buffers of it, by their names in it."""
    if path.suffix.lower() != ".gltf":
        return {}
    try:
        content = json.loads(path.read_bytes())
        uris = [buffer.get("uri", "") for buffer in content.get("buffers", ())]
    except (ValueError, AttributeError):
        got = "a file that is no glTF"
        raise InputError(f"{path.name}: must be a mesh, got {got}") from None
    uris = [uri for uri in uris if uri and not uri.startswith("data:")]
    beside = {uri: path.parent / unquote(uri) for uri in uris}
    for uri, file in beside.items():
        if not file.is_file():
            raise InputError(
                f"{path.name}: must have its buffers beside it, got none at {uri!r}"
            )
    return beside


class DoubtfulScale(DrakesepWarning):
    """A mesh is of another size than what it stands for."""


_EXTENT = 1e-3, 300.0
"""Of a solid, m: the largest launchers are of 120 m."""
_DENSITY = 0.5, 3e4
"""Of a solid on the average, kg/m^3: of a hull around little, and of what is heaviest.
Millimetres taken for metres are a factor of 1e9."""


def warn_of_solid(name: str, extent: float, mass: float, volume: float) -> None:
    """Warn of a solid whose size does not go with its mass, or that nothing has.

    Args:
        name: of its file.
        extent: the diagonal of the box around it, m.
        mass: kg.
        volume: m^3.
    """
    density = mass / volume
    if not _EXTENT[0] <= extent <= _EXTENT[1] or not (
        _DENSITY[0] <= density <= _DENSITY[1]
    ):
        warnings.warn(
            f"{name}: solid is {extent:.3g} m across, of {density:.3g} kg/m^3 on the "
            "average; check scale, metres in a unit of the file, 0.001 of one in mm",
            DoubtfulScale,
            stacklevel=3,
        )


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
    suffix = path.suffix.lower()
    if suffix not in suffixes:
        also = _CONVERSIONS.get(suffix, "") if kind == "mesh" else ""
        raise InputError(
            f"{kind} file must end in {', '.join(suffixes)}, got {str(file)!r}"
            + (f": {also.replace('FILE', path.stem)}" if also else "")
        )
    if not path.is_file():
        raise InputError(f"{kind} file must exist, got {str(file)!r}")
    with path.open("rb") as opened:
        if opened.read(len(_LFS)) == _LFS:
            raise InputError(
                f"{path.name}: must be a {kind}, got a pointer of Git LFS to it: "
                "`git lfs pull` fetches the file itself"
            )
    target = path.resolve()
    # A link may lead to a file without a suffix, as stores of large files have them.
    return target if target.suffix.lower() in suffixes else path.absolute()
