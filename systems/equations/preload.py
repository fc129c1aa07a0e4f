"""What springs press joints with while these hold: their preload, shared by statics.

A spring presses on its pad as long as its attachment holds. That moves nothing: the
joints between the same two bodies carry it, in the mated stack, which is where they are
without deviation, beside what the motion asks of them. They share it as springs in
parallel do, by their stiffness; rigid ones as equal springs (see `load_sharing`).
"""

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.equations.load_sharing import circle_of_pads
from drakesep.systems.equations.mated_stack import Place, mated_places, place_in_stack
from drakesep.systems.equations.pushers import push_axis
from drakesep.systems.equations.relative_motion import Wrench
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.separation import Attachment, Separation
from drakesep.systems.vectors import (
    Vector,
    compose,
    rotate,
    rotation_matrix,
    scale,
    subtract,
)


_RIGID = 1e6
"""Stiffness of a rigid joint over that of others."""
_FREE = 1e-10
"""Part of the largest stiffness of all joints below which they are free."""


class Pressed(NamedTuple):
    """An attachment, and what presses on it while it holds."""

    p_AoPad_A: Vector
    """m."""
    force: float
    """N; 0 without a spring."""
    axis_A: Vector
    """Along which it presses B from A."""


def pressed_at(attachment: Attachment) -> Pressed:
    """Return what presses on an attachment while it holds."""
    spring = attachment.spring
    if spring is None:
        return Pressed(attachment.p_AoPad_A, 0.0, (1.0, 0.0, 0.0))
    axis = push_axis(spring.axis_A, spring.tilt_y, spring.tilt_z, math)
    return Pressed(attachment.p_AoPad_A, law_of(spring).preload(spring), axis)


def preloads(
    separation: Separation,
    held: Collection[int],
    places: Sequence[Place] | None = None,
    pressed: Sequence[Pressed] | None = None,
) -> dict[int, Wrench]:
    """Return the preloads of attachments that hold, by their indices.

    Args:
        separation: whose bodies and joints they are.
        held: indices of attachments that hold.
        places: of its bodies while mated; its own if None.
        pressed: of its attachments; its own if None.

    Returns:
        Torque about the pad, N m, and force, N, on its B, in its frame.
    """
    if places is None:
        places = [*mated_places(separation).values()]
    if pressed is None:
        pressed = [pressed_at(attachment) for attachment in separation.attachments]
    ends = [separation.ends(attachment) for attachment in separation.attachments]
    pairs: dict[tuple[int, int], list[int]] = {}
    for i in sorted(held):
        a, b = sorted(ends[i])
        pairs.setdefault((a, b), []).append(i)
    loads: dict[int, Wrench] = {}
    for (_, b), mine in pairs.items():
        joints = [
            _joint(
                separation.attachments[i].joint,
                places[ends[i][0]],
                pressed[i],
                1.0 if ends[i][1] == b else -1.0,
            )
            for i in mine
        ]
        loads |= dict(zip(mine, _shared(joints), strict=True))
    return loads


class _PressedJoint(NamedTuple):
    """A joint that holds, and its spring, in the mated stack's frame."""

    pad: Vector
    """m."""
    R_SJ: Array
    """(3, 3) orientation of its frame."""
    push: Array
    """(3,) force of its spring on the second body, N."""
    way: float
    """-1 if its B is the first body."""
    rigid: bool
    K_F: Array
    """(3,) along the axes of its frame, N/m; 1 where a rigid one holds."""
    K_T: Array
    """(3,) N m/rad; likewise."""


def _joint(joint: Joint, A: Place, pressed: Pressed, way: float) -> _PressedJoint:
    R_SA = rotation_matrix(A.q_SB)
    K_F, _, K_T, _ = joint.held_gains()
    if joint.rigid:
        K_F, K_T = joint.constraints
    return _PressedJoint(
        place_in_stack(A, pressed.p_AoPad_A),
        np.reshape(compose(R_SA, joint.R_AJ), (3, 3)),
        way * np.array(rotate(R_SA, scale(pressed.force, pressed.axis_A))),
        way,
        joint.rigid,
        np.array(K_F, float),
        np.array(K_T, float),
    )


def _shared(joints: Sequence[_PressedJoint]) -> list[Wrench]:
    """Return what joints of two bodies carry of what presses on them."""
    centre, arm = circle_of_pads([joint.pad for joint in joints])
    soft = max((joint.K_F.max() for joint in joints if not joint.rigid), default=0.0)
    total, stiffness, each = np.zeros(6), np.zeros((6, 6)), []
    for joint in joints:
        r = np.array(subtract(joint.pad, centre))
        total += [*np.cross(r, joint.push), *joint.push]
        # Of translations and rotations at the pad, from those at the centre.
        J = np.zeros((6, 6))
        J[:3, :3] = J[3:, 3:] = joint.R_SJ.T
        J[3:, :3] = joint.R_SJ.T @ np.cross(np.eye(3), r).T  # theta x r
        K = np.append(joint.K_T, joint.K_F)
        if joint.rigid:
            K *= _RIGID * (soft or 1.0) * np.repeat([arm * arm, 1.0], 3)
        stiffness += J.T @ (K[:, None] * J)
        each.append(K[:, None] * J)
    # Arms make all of one unit: the smallest that counts is then one.
    unit = np.repeat([1.0 / arm, 1.0], 3)
    scaled = unit[:, None] * stiffness * unit
    given = unit * (
        np.linalg.pinv(scaled, rcond=_FREE, hermitian=True) @ (unit * total)
    )
    loads = []
    for joint, of in zip(joints, each, strict=True):
        a, b, c, x, y, z = (-joint.way * (of @ given)).tolist()
        loads.append(Wrench((a, b, c), (x, y, z)))
    return loads
