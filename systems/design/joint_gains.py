"""Gains for a joint by constraint forces, from how far it may give."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    Vector3,
    check_entries,
    check_not_negative,
    check_positive,
)
from drakesep.systems.equations.mated_stack import (
    mated_orientation,
    nominal_place,
    place_in_stack,
)
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.joints import Joint, JointType
from drakesep.systems.model.separation import Body
from drakesep.systems.vectors import quaternion, rotation_matrix


_Matrix = NDArray[np.float64]


@typed
def propose_joint(
    A: Body,
    B: Body,
    p_AoPad_A: Vector3,
    *,
    force: float,
    torque: float,
    deviation: float,
    rotation: float,
    damping_ratio: float = 0.7,
    type: JointType = "fixed",
    x_axis_A: Vector3 = (1.0, 0.0, 0.0),
    y_axis_A: Vector3 = (0.0, 1.0, 0.0),
) -> Joint:
    """Return a joint that gives no more than wanted, and does not ring for long.

    The stiffness is load over deviation. The damping along an axis is that of the given
    ratio for what the joint moves along it: the effective mass 1 / m = e . (a_B - a_A)
    for a unit force e between the bodies at the joint, and the effective inertia
    likewise. Where other joints hold the same bodies, stiffnesses add up, and each is
    proposed for its share of the load; n equal ones then have a damping ratio of
    sqrt(n) times the given one.

    A joint ten times stiffer deviates a tenth as much, and its oscillations take
    sqrt(10) times as many steps (`benchmarks/joint_gains.py`).

    Args:
        A: first body.
        B: second body, in its mated place.
        p_AoPad_A: place of the joint in A, m.
        force: largest that the joint has to carry, N.
        torque: largest that it has to carry, N m.
        deviation: that it may have under the force, m.
        rotation: that it may have under the torque, rad.
        damping_ratio: of its oscillations, if no other joint holds.
        type: of the joint.
        x_axis_A: x axis of the joint's frame, in A.
        y_axis_A: y axis of the joint's frame, in A.

    Raises:
        ValueError: a load or a deviation is not positive, the damping ratio is
            negative, or the axes are not at a right angle and of length one.
    """
    for name, value in {
        "force": force,
        "torque": torque,
        "deviation": deviation,
        "rotation": rotation,
    }.items():
        check_positive(f"joint: {name}", value)
    check_not_negative("joint: damping ratio", damping_ratio)
    check_entries("joint: position", p_AoPad_A, 3)
    if A.name == B.name:
        raise InputError(f"joint: must join two different bodies, got {A.name!r} twice")
    K_F, K_T = force / deviation, torque / rotation
    joint = Joint(
        type=type,
        K_F=K_F,
        D_F=0.0,
        K_T=K_T,
        D_T=0.0,
        x_axis_A=x_axis_A,
        y_axis_A=y_axis_A,
    )
    axes = np.reshape(joint.R_AJ, (3, 3)).T
    masses, inertias = _effective(A, B, np.array(p_AoPad_A), axes)

    def damping(K: float, moved: Sequence[float]) -> Vector3:
        x, y, z = (2.0 * damping_ratio * float(np.sqrt(K * m)) for m in moved)
        return x, y, z

    return Joint(
        type=type,
        K_F=K_F,
        D_F=damping(K_F, masses),
        K_T=K_T,
        D_T=damping(K_T, inertias),
        x_axis_A=x_axis_A,
        y_axis_A=y_axis_A,
    )


def _effective(
    A: Body, B: Body, p_AoPad_A: _Matrix, axes: _Matrix
) -> tuple[list[float], list[float]]:
    """Return the mass and the inertia that the joint moves along each axis."""
    places = nominal_place(A), nominal_place(B)
    R_AB = np.reshape(rotation_matrix(mated_orientation(*places)), (3, 3))
    inverse_A = np.linalg.inv(inertia_matrix(A.I_BBcm_B))
    inverse_B = R_AB @ np.linalg.inv(inertia_matrix(B.I_BBcm_B)) @ R_AB.T
    R_SA = np.reshape(rotation_matrix(quaternion(A.rpy_AB, math)), (3, 3))
    p_SPad = R_SA @ p_AoPad_A + A.p_ABo
    r_A = p_AoPad_A - A.p_BoBcm_B
    r_B = R_SA.T @ (p_SPad - place_in_stack(places[1], B.p_BoBcm_B))
    masses, inertias = [], []
    for e in axes:
        arm_A, arm_B = np.cross(r_A, e), np.cross(r_B, e)
        compliance = 1.0 / A.mass + 1.0 / B.mass
        compliance += arm_A @ inverse_A @ arm_A + arm_B @ inverse_B @ arm_B
        masses.append(float(1.0 / compliance))
        inertias.append(float(1.0 / (e @ (inverse_A + inverse_B) @ e)))
    return masses, inertias
