"""How bodies ring on their joints while these hold: small motions of the stack."""

import functools
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.checks import Vector3
from drakesep.systems.equations.mated_stack import (
    Place,
    mated_places,
    place_in_stack,
)
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import rotation_matrix


class JointModes(NamedTuple):
    """Oscillations of bodies on their joints; those that creep back are left out."""

    periods: Array
    """(k,) s."""
    decays: Array
    """(k,) by which the logarithm of each amplitude falls, 1/s."""


def joint_modes(separation: Separation, held: Collection[str]) -> JointModes:
    """Return how bodies ring on some of their joints.

    Of M x'' + D x' + K x = 0, with the damping of each mode by itself.

    Args:
        separation: with the bodies, in their mated places.
        held: names of the attachments that hold.
    """
    attachments = [a for a in separation.attachments if a.name in held]
    names = list(dict.fromkeys(name for a in attachments for name in (a.A, a.B)))
    if not names:
        return JointModes(np.empty(0), np.empty(0))
    places = mated_places(separation)
    bodies = ((separation.body(name), places[name]) for name in names)
    return _modes(
        tuple(_Mass(b.mass, b.p_BoBcm_B, b.I_BBcm_B, place) for b, place in bodies),
        tuple(
            _Held(names.index(a.A), names.index(a.B), a.p_AoPad_A, a.joint)
            for a in attachments
        ),
    )


class _Mass(NamedTuple):
    """Of a body, what its ringing depends on."""

    mass: float
    p_BoBcm_B: Vector3
    I_BBcm_B: tuple[float, ...]
    place: Place


class _Held(NamedTuple):
    """A joint that holds, between two of the bodies."""

    A: int
    B: int
    p_AoPad_A: Vector3
    joint: Joint


@functools.lru_cache(maxsize=64)  # runs of a case often differ in other numbers alone
def _modes(bodies: tuple[_Mass, ...], held: tuple[_Held, ...]) -> JointModes:
    K, D = np.zeros((2, 6 * len(bodies), 6 * len(bodies)))
    for one in held:
        J = _deviation(one, bodies)
        K_F, D_F, K_T, D_T = one.joint.held_gains()
        K += J.T @ (np.array([*K_F, *K_T])[:, None] * J)
        D += J.T @ (np.array([*D_F, *D_T])[:, None] * J)
    root = np.zeros_like(K)
    for i, body in enumerate(bodies):
        root[6 * i : 6 * i + 6, 6 * i : 6 * i + 6] = _whitening(body)
    squares, modes = np.linalg.eigh(root.T @ K @ root)
    decays = 0.5 * np.einsum("ik,ij,jk->k", modes, root.T @ D @ root, modes)
    # Round-off of what moves without the joints is no oscillation.
    least = 1e-9 * squares.max(initial=0.0)
    rings = (squares > least) & (squares > decays**2)
    rates = np.sqrt(squares[rings] - decays[rings] ** 2)
    found = JointModes(2.0 * np.pi / rates, decays[rings])
    for shared in found:
        shared.flags.writeable = False
    return found


def _deviation(held: _Held, bodies: tuple[_Mass, ...]) -> Array:
    """Return (6, 6 n): a joint's deviation, in its frame, from motions of bodies in S.

    A body moves by the translation of its CG, and by a rotation.
    """
    A = bodies[held.A].place
    R_SJ = _orientation(A) @ np.reshape(held.joint.R_AJ, (3, 3))
    pad = np.array(place_in_stack(A, held.p_AoPad_A))
    J = np.zeros((6, 6 * len(bodies)))
    for sign, i in ((-1.0, held.A), (1.0, held.B)):
        cg = np.array(place_in_stack(bodies[i].place, bodies[i].p_BoBcm_B))
        own = J[:, 6 * i : 6 * i + 6]
        own[:3, :3] = own[3:, 3:] = sign * R_SJ.T
        # Rows e . (theta x r) = theta . (r x e).
        own[:3, 3:] = sign * np.cross(pad - cg, R_SJ.T)
    return J


def _whitening(body: _Mass) -> Array:
    """Return (6, 6) what makes a body's mass matrix the identity, in S."""
    R = _orientation(body.place)
    inertia = R @ inertia_matrix(body.I_BBcm_B) @ R.T
    root = np.eye(6) / np.sqrt(body.mass)
    root[3:, 3:] = np.linalg.inv(np.linalg.cholesky(inertia)).T
    return root


def _orientation(place: Place) -> Array:
    return np.reshape(np.array(rotation_matrix(place.q_SB)), (3, 3))
