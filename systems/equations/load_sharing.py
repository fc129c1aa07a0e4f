"""How rigid joints of two bodies share a load: as equal springs in parallel."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from drakesep.systems.equations.articulated_inertia import shifted_wrench
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.rigid_joints import (
    JointPlace,
    RigidJoints,
    joined,
    joint_equations,
)
from drakesep.systems.model.joints import JointType
from drakesep.systems.vectors import (
    Vector,
    add,
    compose,
    rotate,
    subtract,
    unrotate,
)


_PAD = 0.1
"""Arm of a pad, with which it takes torques, over the radius of the circle of pads."""
_FREE = 1e-10
"""Part of the largest stiffness of all joints below which they are free."""


def circle_of_pads(places: Sequence[Vector]) -> tuple[Vector, float]:
    """Return the centre of pads, and the arm with which one takes torques, m."""
    x, y, z = np.mean(places, axis=0).tolist()
    centre = x, y, z
    radius2 = np.mean([math.dist(place, centre) ** 2 for place in places])
    return centre, _PAD * math.sqrt(radius2) or 1.0


class Pad(NamedTuple):
    """A joint that holds, and where it is in its bodies."""

    type: JointType
    place: JointPlace
    way: float
    """-1 if its A is the second body."""


def joint_shares(
    joints: RigidJoints,
    places: Sequence[JointPlace],
    held: Collection[int],
    bodies: Mapping[int, BodyState],
    wrenches: Mapping[int, tuple[Wrench, Wrench]],
) -> dict[int, Wrench]:
    """Return the loads of attachments with rigid joints that hold, by their indices.

    Args:
        joints: of the separation.
        places: of each attachment's joint.
        held: indices of attachments that hold.
        bodies: by their places among the joined ones.
        wrenches: on A and B of each edge that holds, about their origins, in W.

    Returns:
        Torque about the pad, N m, and force, N, on its B, in its frame.
    """
    pads: dict[int, dict[int, Pad]] = {}
    for joint in joints.joints:
        for i in joint.attachments:
            if i in held:
                pad = Pad(joint.type, places[i], joint.way)
                pads.setdefault(joint.edge, {})[i] = pad
    loads: dict[int, Wrench] = {}
    for edge, mine in pads.items():
        a, b = joints.edges[edge]
        _, on_B = wrenches[edge]
        shares = shared_loads(bodies[a], bodies[b], [*mine.values()], on_B)
        loads |= dict(zip(mine, shares, strict=True))
    return loads


def shared_loads(
    A: BodyState, B: BodyState, pads: Sequence[Pad], wrench: Wrench
) -> list[Wrench]:
    """Return the loads of joints of two bodies that hold with a wrench together.

    That of springs of the same stiffness K in each direction that a joint holds, and
    K r^2 in rotation, as K grows (the limit of Eq. 3-4): r is a tenth of the radius of
    the circle of pads.

    Args:
        A: first body.
        B: second body.
        pads: the joints.
        wrench: of all on B, about its origin, in W.

    Returns:
        Of each the torque about its pad and the force, on its B, in its frame.
    """
    ends = [(A, B) if pad.way > 0.0 else (B, A) for pad in pads]
    places = [
        add(end.p_WBo, rotate(end.R_WB, pad.place.p_BoPad_B))
        for pad, (_, end) in zip(pads, ends, strict=True)
    ]
    centre, arm = circle_of_pads(places)
    equations = [
        joint_equations(pad.type, joined(pad.type, pad.place, *end), centre, arm)
        for pad, end in zip(pads, ends, strict=True)
    ]
    J = np.concatenate(
        [pad.way * np.array(x.J) for pad, x in zip(pads, equations, strict=True)]
    )
    torque, force = shifted_wrench(wrench, subtract(B.p_WBo, centre))
    given = np.linalg.pinv(J.T @ J, rcond=_FREE, hermitian=True) @ [*torque, *force]
    shares = iter((J @ given).tolist())
    loads = []
    for pad, each, place, (first, _) in zip(pads, equations, places, ends, strict=True):
        total = np.sum([next(shares) * np.array(row) for row in each.J], axis=0)
        a, b, c, x, y, z = total.tolist()
        R_WJ = compose(first.R_WB, pad.place.R_AJ)
        arm_W = subtract(centre, place)
        torque, force = shifted_wrench(Wrench((a, b, c), (x, y, z)), arm_W)
        loads.append(Wrench(unrotate(R_WJ, torque), unrotate(R_WJ, force)))
    return loads
