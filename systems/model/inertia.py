"""Which inertias a rigid body can have.

A body's inertia I about its CG comes from a distribution of mass exactly when
its second moment of mass, Sigma = integral of r r^T dm = tr(I)/2 1 - I, is
positive semidefinite. This one condition holds both the positive definiteness of
I and the triangle inequality of its principal moments (Wensing, Kim and Slotine
2018, doi:10.1109/LRA.2017.2729659). It is convex in I.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drakesep.systems.checks import InputError
from drakesep.systems.model.magnitudes import check_size


Inertia: TypeAlias = tuple[float, float, float, float, float, float]
"""Matrix entries xx, yy, zz, xy, xz, yz (I_xy = -integral of x y dm), kg m^2."""

Entry: TypeAlias = float | NDArray[np.float64]
"""One of a matrix, or that of each of n matrices (n,)."""

ENTRIES = ("xx", "yy", "zz", "xy", "xz", "yz")
"""Names of the entries, in order."""

# A flat body has Sigma's smallest eigenvalue at zero, up to round-off.
_ROUND_OFF = 16 * np.finfo(float).eps


def inertia_matrix(I_BBcm_B: ArrayLike) -> NDArray[np.float64]:
    """Return (3, 3) inertia matrices from entries xx, yy, zz, xy, xz, yz.

    Args:
        I_BBcm_B: (..., 6) entries of the matrix, kg m^2.

    Returns:
        (..., 3, 3) matrices.
    """
    order = [[0, 3, 4], [3, 1, 5], [4, 5, 2]]
    return np.asarray(I_BBcm_B, dtype=float)[..., order]


def second_moment(I_BBcm_B: ArrayLike) -> NDArray[np.float64]:
    """Return Sigma = tr(I)/2 1 - I, (..., 3, 3), kg m^2; linear in I.

    Args:
        I_BBcm_B: (..., 6) entries xx, yy, zz, xy, xz, yz of I, kg m^2.
    """
    inertia = inertia_matrix(I_BBcm_B)
    half_trace = 0.5 * np.trace(inertia, axis1=-2, axis2=-1)
    return half_trace[..., None, None] * np.eye(3) - inertia


def physical_margin(I_BBcm_B: ArrayLike) -> NDArray[np.float64]:
    """Return Sigma's smallest eigenvalue, kg m^2; a negative one is impossible.

    Args:
        I_BBcm_B: (..., 6) entries xx, yy, zz, xy, xz, yz, kg m^2.

    Returns:
        (...) smallest eigenvalues.
    """
    eigenvalues = np.linalg.eigvalsh(second_moment(I_BBcm_B))
    return np.asarray(eigenvalues[..., 0], dtype=np.float64)


def is_positive_definite(
    xx: Entry, yy: Entry, zz: Entry, xy: Entry, xz: Entry, yz: Entry
) -> NDArray[np.bool_]:
    """Return (n,) whether symmetric matrices are, by their leading minors (Sylvester).

    Entry by entry: that of one does not depend on those beside it. Eigenvalues take ten
    times as long.
    """
    second = xx * yy - xy * xy
    third = zz * second - xx * yz * yz - yy * xz * xz + 2.0 * xy * xz * yz
    return np.asarray((xx > 0.0) & (second > 0.0) & (third > 0.0))


def check_inertia(name: str, I_BBcm_B: tuple[float, ...]) -> None:
    """Raise ValueError unless some rigid body has this inertia about its CG."""
    moments = np.linalg.eigvalsh(inertia_matrix(I_BBcm_B))
    entries = ", ".join(
        f"{axes} {value:g}" for axes, value in zip(ENTRIES, I_BBcm_B, strict=True)
    )
    if moments[0] <= 0:
        raise InputError(
            f"{name} must be positive definite; got {entries} kg m^2, whose "
            f"smallest principal moment is {moments[0]:g}"
        )
    check_size("inertia", f"{name}: smallest principal moment", float(moments[0]))
    if physical_margin(I_BBcm_B) < -_ROUND_OFF * moments[2]:
        raise InputError(
            f"{name} must have principal moments that obey the triangle inequality; "
            f"got {entries} kg m^2, with principal moments "
            + ", ".join(f"{moment:g}" for moment in moments)
        )
