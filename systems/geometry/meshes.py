"""Closed meshes from files."""

import functools
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.checks import DrakesepWarning, InputError, check_positive
from drakesep.systems.geometry.mesh_faults import fault_of


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
        with np.errstate(all="ignore"):  # of what is refused
            mesh = trimesh.load_mesh(path)
    except Exception as error:  # trimesh raises whatever its readers do
        got = fault_of(path) or str(error)
        raise InputError(f"{path.name}: must be a mesh, got {got}") from error
    if not len(getattr(mesh, "faces", ())):
        got = fault_of(path) or "no triangles"
        raise InputError(f"{path.name}: must be a mesh, got {got}")
    # Files give corners of their own to faces of other groups, textures and normals.
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    if not mesh.is_watertight or not mesh.is_winding_consistent:
        if fault := fault_of(path):
            raise InputError(f"{path.name}: must be a mesh, got {fault}")
        counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)[1]
        broken = int((counts == 1).sum())
        got = f"{broken} open edges" if broken else "triangles that face both ways"
        raise InputError(f"{path.name}: mesh must be closed, got {got}")
    with np.errstate(all="ignore"):  # of a volume of zero
        volume = float(mesh.volume)
    check_positive(f"{path.name}: volume", abs(volume))
    if volume < 0.0:
        mesh.invert()
    return mesh


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
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"{kind} file must end in {', '.join(suffixes)}, got {str(file)!r}"
        )
    if not path.is_file():
        raise InputError(f"{kind} file must exist, got {str(file)!r}")
    target = path.resolve()
    # A link may lead to a file without a suffix, as stores of large files have them.
    return target if target.suffix.lower() in suffixes else path.absolute()
