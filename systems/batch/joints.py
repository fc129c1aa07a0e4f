"""The joints of a batch that are springs, on lanes."""

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from drakesep.systems import vectors
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode, pick
from drakesep.systems.batch.mated_places import BatchPlaces
from drakesep.systems.batch.wrenches import WrenchSum
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.joints import NO_TURN, HeldJoint
from drakesep.systems.equations.mated_stack import axis_on_A, held_joint
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.model.joints import holds_all_rotations
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


class _Joints(NamedTuple):
    """Joints of one type and orientation between the same bodies."""

    attachments: list[int]
    joint: HeldJoint
    """Gains and axis of (j, 1); its places are parameters."""
    axis_A: Vector
    """Its axis as it is fixed in A."""


class BatchJoints:
    """The wrenches of a separation's joints that are springs, on lanes."""

    def __init__(self, separation: Separation, places: BatchPlaces):
        """Prepare.

        Args:
            separation: whose joints they are.
            places: of its bodies while mated.
        """
        self._places = places
        self._pairs = _group_joints(separation)

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._pairs)

    def wrenches(
        self, bodies: BodyState, params: BatchParameters, mode: Mode
    ) -> Wrench:
        """Return the wrenches of the joints that hold.

        Args:
            bodies: of (..., m, n).
            params: of the batch.
            mode: what has happened.
        """
        total = WrenchSum(bodies)
        held = jnp.isinf(mode.released)
        for (a, b), groups in self._pairs.items():
            A, B = pick(bodies, a), pick(bodies, b)
            motion = motion_laws.pair_state(A, B)
            turn = NO_TURN
            if any(holds_all_rotations(group.joint.type) for group in groups):
                q_AB = self._places.orientation(a, b, params)
                turn = joint_laws.rotation_deviation(A, B, q_AB, motion.w_AB, jnp)
            force = torque = moment = (0.0, 0.0, 0.0)
            for group in groups:
                index = jnp.array(group.attachments)
                joint = group.joint._replace(
                    p_AoPad_A=pick(params.p_AoPad_A, index),
                    p_BoPad_B=pick(params.p_BoPad_B, index),
                )
                if self._places.vary:
                    q_AB = self._places.orientation(a, b, params)
                    axis_B = vectors.unrotate(
                        vectors.rotation_matrix(q_AB), group.axis_A
                    )
                    joint = joint._replace(axis_B=axis_B)
                pull = joint_laws.pull_at_origin(
                    joint, *joint_laws.joint_pull(joint, motion, turn, jnp)
                )
                force, torque, moment = (
                    vectors.add(before, tuple(_sum_held(x, held[index]) for x in each))
                    for before, each in zip((force, torque, moment), pull, strict=True)
                )
            torque = vectors.add(torque, joint_laws.turning_torque(turn, moment))
            on_A, on_B = motion_laws.wrenches_at_origin(A, motion.p_AoBo, force, torque)
            total.add(a, on_A)
            total.add(b, on_B)
        return total.wrench


def _group_joints(separation: Separation) -> dict[tuple[int, int], list[_Joints]]:
    """Return the joints between each pair of bodies, by the bodies' indices."""
    alike: dict[Any, list[int]] = {}
    for i, attachment in enumerate(separation.attachments):
        joint = attachment.joint
        if joint.rigid:
            continue
        key = separation.ends(attachment), joint.type, joint.R_AJ_if_turned
        alike.setdefault(key, []).append(i)
    pairs: dict[tuple[int, int], list[_Joints]] = {}
    for (ends, joint_type, R_AJ), indices in alike.items():
        attachments = [separation.attachments[i] for i in indices]
        gains = np.array([a.joint.held_gains() for a in attachments])
        axes = np.array([held_joint(separation, a).axis_B for a in attachments])
        K_F, D_F, K_T, D_T = (
            tuple(gains[:, c].T[..., None]) for c in range(gains.shape[1])
        )
        held = HeldJoint(
            type=joint_type,
            R_AJ=R_AJ,
            K_F=K_F,
            D_F=D_F,
            K_T=K_T,
            D_T=D_T,
            p_AoPad_A=(),  # type: ignore[arg-type]
            p_BoPad_B=(),  # type: ignore[arg-type]
            axis_B=tuple(axes.T[..., None]),
        )
        axis_A = axis_on_A(attachments[0].joint)
        pairs.setdefault(ends, []).append(_Joints(indices, held, axis_A))
    return pairs


def _sum_held(values: Lanes, held: Lanes) -> Lanes:
    return jnp.where(held, values, 0.0).sum(axis=0)
