"""Which joints may hold in a batch, from those that hold last to all.

What no longer holds in any lane need not be computed. Each phase is a program of its
own, so there are few: none, all, and where rigid joints form loops, what is left once
these are open.
"""

import math
from collections.abc import Collection, Sequence
from typing import TypeAlias

from drakesep.systems.equations.joint_tree import plan_tree
from drakesep.systems.equations.rigid_joints import RigidJoint, RigidJoints
from drakesep.systems.model.parameters import names_of
from drakesep.systems.model.separation import Separation


Phase: TypeAlias = frozenset[int]
"""Indices of the attachments that may hold."""


def holding_phases(
    separation: Separation, joints: RigidJoints, varied: Collection[str]
) -> list[Phase]:
    """Return the phases of a separation, each with all that the one before has.

    Args:
        separation: whose joints they are.
        joints: those of them that are rigid.
        varied: names of the parameters that vary.
    """
    times = {
        i: math.inf if name in varied else attachment.release_time
        for i, attachment in enumerate(separation.attachments)
        for name in names_of([attachment], ["release_time"])
    }
    every = frozenset(i for i, time in times.items() if time > 0.0)
    if not every:
        return [every]
    none: Phase = frozenset()
    if has_loops(joints, every):
        for opens in sorted({times[i] for i in every if math.isfinite(times[i])}):
            rest = frozenset(i for i in every if times[i] > opens)
            if rest and not has_loops(joints, rest):
                return [none, rest, every]
    return [none, every]


def has_loops(joints: RigidJoints, phase: Phase) -> bool:
    """Return whether rigid joints form loops in a phase."""
    # Whatever the masses are.
    return bool(
        plan_tree(rigid_in(joints, phase), [0.0] * len(joints.bodies), alone=True).loops
    )


def rigid_in(joints: RigidJoints, phase: Phase) -> Sequence[RigidJoint]:
    """Return the rigid joints that may hold in a phase."""
    return [j for j in joints.joints if not phase.isdisjoint(j.attachments)]
