"""Mass properties of bodies: from a shape, from a mesh, from a model file."""

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import SpatialInertia

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    Vector3,
    check_entries,
    unknown,
)
from drakesep.systems.design.model_reader import read_apart
from drakesep.systems.geometry.meshes import read_solid, readable, warn_of_solid
from drakesep.systems.model.inertia import Inertia
from drakesep.systems.model.magnitudes import check_size, check_within


SolidKind: TypeAlias = Literal["box", "cylinder", "sphere", "ellipsoid", "capsule"]
SOLIDS: dict[SolidKind, int] = {
    "box": 3,
    "cylinder": 2,
    "sphere": 1,
    "ellipsoid": 3,
    "capsule": 2,
}
"""Shapes, and how many dimensions each has; see `mass_properties_of_shape`."""
_X = np.array([1.0, 0.0, 0.0])
_MODEL_SUFFIXES = (".sdf", ".urdf", ".xml")
_ORIGIN = (0.0, 0.0, 0.0)


class MassProperties(NamedTuple):
    """What a body needs of its mass, as `Body` takes it."""

    mass: float
    """kg."""
    p_BoBcm_B: Vector3
    """CG from the body's origin, m."""
    I_BBcm_B: Inertia
    """Inertia about the CG in body axes, kg m^2."""


@typed
def mass_properties_of_shape(
    shape: SolidKind,
    dimensions: Sequence[float],
    *,
    mass: float | None = None,
    density: float | None = None,
    p_BoSo_B: Vector3 = _ORIGIN,
    rpy_BS: Vector3 = _ORIGIN,
) -> MassProperties:
    """Return the mass properties of a uniform solid S that makes up a body B.

    Args:
        shape: its frame S has its origin at the centre.
        dimensions: m; of a box its edges along x, y and z; of a cylinder its radius,
            and its length along x; of a sphere its radius; of an ellipsoid its
            semi-axes along x, y and z; of a capsule its radius, and the length along x
            between the centres of its round ends.
        mass: kg; this or `density`.
        density: kg/m^3.
        p_BoSo_B: place of the solid's centre in the body, m.
        rpy_BS: roll, pitch and yaw of the solid in the body, rad.

    Raises:
        ValueError: the shape is unknown, a dimension, mass or density is not positive,
            or not one of mass and density is given.
    """
    if shape not in SOLIDS:
        raise InputError(unknown("shape", shape, SOLIDS))
    if len(dimensions) != SOLIDS[shape]:
        raise InputError(
            f"{shape} must have {SOLIDS[shape]} dimensions, got {len(dimensions)}"
        )
    for dimension in dimensions:
        check_size("length", f"{shape}: dimension", dimension)
    solid = _unit_solid(shape, dimensions)
    scale = _mass(shape, mass, density, solid.get_mass()) / solid.get_mass()
    return _placed(
        solid.get_mass() * scale,
        solid.get_com(),
        scale * _central_inertia(solid),
        p_BoSo_B,
        rpy_BS,
    )


def _unit_solid(shape: SolidKind, dimensions: Sequence[float]) -> SpatialInertia:
    match shape:
        case "box":
            return SpatialInertia.SolidBoxWithDensity(1.0, *dimensions)
        case "cylinder":
            return SpatialInertia.SolidCylinderWithDensity(1.0, *dimensions, _X)
        case "sphere":
            return SpatialInertia.SolidSphereWithDensity(1.0, *dimensions)
        case "ellipsoid":
            return SpatialInertia.SolidEllipsoidWithDensity(1.0, *dimensions)
        case "capsule":
            return SpatialInertia.SolidCapsuleWithDensity(1.0, *dimensions, _X)


@typed
def mass_properties_of_mesh(
    file: str | Path,
    *,
    mass: float | None = None,
    density: float | None = None,
    scale: float = 1.0,
    p_BoSo_B: Vector3 = _ORIGIN,
    rpy_BS: Vector3 = _ORIGIN,
) -> MassProperties:
    """Return the mass properties of a uniform solid, bounded by a closed mesh.

    Where a mesh has several shells their volumes add up, also where they overlap.

    Args:
        file: OBJ, STL, PLY or glTF.
        mass: kg; this or `density`.
        density: kg/m^3.
        scale: metres in a unit of the file, such as 0.001 for one in millimetres.
        p_BoSo_B: place of the mesh's origin in the body, m.
        rpy_BS: roll, pitch and yaw of the mesh in the body, rad.

    Raises:
        ValueError: the file is missing, is no mesh, or one that is not closed, or as
            for a shape.
    """
    check_size("factor", "mesh: scale", scale)
    mesh = read_solid(file)
    volume = scale**3 * float(mesh.volume)
    m = _mass(str(file), mass, density, volume)
    warn_of_solid(Path(file).name, scale * float(mesh.scale), m, volume)
    # The file's inertia is that of density one, in its own units.
    inertia = m / volume * scale**5 * np.array(mesh.moment_inertia)
    return _placed(m, scale * np.array(mesh.center_mass), inertia, p_BoSo_B, rpy_BS)


@typed
def mass_properties_of_model(
    file: str | Path, *, frame: str | None = None
) -> MassProperties:
    """Return the mass properties of a model in an SDF, URDF or MJCF file.

    Args:
        file: read by Drake's parser, in a process of its own. Joints that can move are
            taken as they stand: the model is one rigid body. Files that it includes are
            looked for beside it.
        frame: name of the frame that becomes the body's; by default that of the first
            body.

    Raises:
        ValueError: the file is missing or no model, has no such frame or no mass.
    """
    path = readable(file, "model", _MODEL_SUFFIXES)
    return _read_model(path, frame, path.stat().st_mtime_ns)


@functools.cache
def _read_model(path: Path, frame: str | None, _: int) -> MassProperties:
    read = read_apart(path, frame)
    return _placed(
        read.mass, np.array(read.p_BoBcm_B), np.array(read.I_BBcm_B), _ORIGIN, _ORIGIN
    )


def mass_properties_of(M_BBo_B: SpatialInertia) -> MassProperties:
    """Return the mass properties that a spatial inertia of Drake's stands for."""
    return _placed(
        M_BBo_B.get_mass(),
        M_BBo_B.get_com(),
        _central_inertia(M_BBo_B),
        _ORIGIN,
        _ORIGIN,
    )


def _mass(name: str, mass: float | None, density: float | None, volume: float) -> float:
    if (mass is None) == (density is None):
        got = "neither" if mass is None else "both"
        raise InputError(f"{name}: must have a mass or a density, got {got}")
    if mass is not None:
        check_size("mass", f"{name}: mass", mass)
        return mass
    assert density is not None  # above
    check_size("density", f"{name}: density", density)
    return density * volume


def _central_inertia(M: SpatialInertia) -> np.ndarray:
    about_cm = M.Shift(M.get_com())
    return np.array(about_cm.CalcRotationalInertia().CopyToFullMatrix3())


def _placed(
    mass: float,
    p_SoScm_S: np.ndarray,
    I_SScm_S: np.ndarray,
    p_BoSo_B: Vector3,
    rpy_BS: Vector3,
) -> MassProperties:
    check_entries("solid: position", p_BoSo_B, 3)
    check_entries("solid: attitude", rpy_BS, 3)
    check_within("length", "solid: position", *p_BoSo_B)
    check_within("angle", "solid: attitude", *rpy_BS)
    X_BS = RigidTransform(RollPitchYaw(np.array(rpy_BS)), np.array(p_BoSo_B))
    R = X_BS.rotation().matrix()
    I_B = R @ I_SScm_S @ R.T
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = I_B.tolist()
    x, y, z = X_BS.multiply(p_SoScm_S).tolist()
    return MassProperties(mass, (x, y, z), (xx, yy, zz, xy, xz, yz))
