"""The rigid joints of a batch, on lanes."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from drakesep.systems import vectors
from drakesep.systems.batch.lanes import BatchParameters, Lanes, Mode, pick
from drakesep.systems.batch.mated_places import BatchPlaces
from drakesep.systems.batch.wrenches import WrenchSum
from drakesep.systems.equations import rigid_joints as laws
from drakesep.systems.equations.mated_stack import held_joint
from drakesep.systems.equations.relative_motion import BodyState, Wrench
from drakesep.systems.equations.rigid_body import inverse
from drakesep.systems.model.joints import JointType
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Rotation, Vector


class _Group(NamedTuple):
    """Joints of one type, on an axis of lanes."""

    joints: list[laws.RigidJoint]
    type: JointType
    R_AJ: Rotation
    """Of (g, 1)."""
    axis_A: Vector
    """y axis of a universal joint, fixed in A at first, of (g, 1)."""
    axis_B: Vector
    """The same in B, of (g, 1)."""


class BatchRigidJoints:
    """The wrenches of a separation's rigid joints, on lanes."""

    def __init__(self, separation: Separation, places: BatchPlaces):
        """Prepare.

        Args:
            separation: whose joints they are.
            places: of its bodies while mated.
        """
        self._places = places
        self._joints = laws.rigid_joints(separation)
        self._groups = _groups(separation, self._joints)

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._groups)

    def wrenches(
        self, bodies: BodyState, others: Wrench, params: BatchParameters, mode: Mode
    ) -> Wrench:
        """Return the wrenches of the rigid joints that hold.

        Args:
            bodies: of (m, n).
            others: all else that acts on them.
            params: of the batch.
            mode: what has happened.
        """
        joints = self._joints
        index = np.array(joints.bodies)
        joined, acting = pick(bodies, index), pick(others, index)
        p_WO = pick(joined.p_WBo, slice(0, 1))
        massive = laws.Massive(
            *pick((params.mass, params.p_BoBcm_B, params.I_BBcm_B), index)
        )
        M, h = laws.spatial_inertia(joined, massive, p_WO)
        arm = vectors.subtract(joined.p_WBo, p_WO)
        torque, force = laws.moved(acting, arm)
        free = _rows([*torque, *force]) - _rows(h)
        stiffness, rest = self._equations(joined, p_WO, params, mode)
        found = laws.holding_wrenches(
            joints, _rows(M), free, stiffness, rest, LaneBlocks()
        )
        edges = [
            Wrench(tuple(found[:3, k]), tuple(found[3:, k]))
            for k in range(len(joints.edges))
        ]
        each = [pick(joined, k) for k in range(len(joints.bodies))]
        total, origin = WrenchSum(bodies), pick(p_WO, 0)
        for b, wrench in zip(
            joints.bodies,
            laws.wrenches_on_bodies(joints, edges, origin, each),
            strict=True,
        ):
            total.add(b, wrench)
        return total.wrench

    def _equations(
        self, joined: BodyState, p_WO: Vector, params: BatchParameters, mode: Mode
    ) -> tuple[Lanes, Lanes]:
        """Return (6, 6, e, n) stiffness of the edges, and (6, e, n) the rest."""
        count = len(self._joints.edges)
        stiffness: Any = 0.0
        rest: Any = 0.0
        held = jnp.isinf(mode.released)
        for group in self._groups:
            edges = [joint.edge for joint in group.joints]
            members = [joint.attachments for joint in group.joints]
            x, y, z = (
                jnp.stack([entry[np.array(i)].mean(axis=0) for i in members])
                for entry in params.p_BoPad_B
            )
            J, beside = laws.joint_equations(
                group.type,
                group.R_AJ,
                pick(joined, np.array([joint.a for joint in group.joints])),
                pick(joined, np.array([joint.b for joint in group.joints])),
                (x, y, z),
                self._axis_B(group, params),
                p_WO,
                self._joints.arm[edges][:, None],
            )
            ways = np.array([joint.way for joint in group.joints])[:, None]
            holds = jnp.stack([held[np.array(i)].any(axis=0) for i in members])
            k = jnp.where(holds, self._joints.stiffness[edges][:, None], 0.0)
            rows, lanes = _rows(J), LaneBlocks()
            blocks = lanes.multiply(lanes.transpose(k * rows), rows)
            forces = lanes.apply(lanes.transpose(rows), k * ways * _rows(beside))
            stiffness = stiffness + lanes.sum_to(blocks, edges, count)
            rest = rest + lanes.sum_to(forces, edges, count)
        return stiffness, rest

    def _axis_B(self, group: _Group, params: BatchParameters) -> Vector:
        if group.type != "universal" or not self._places.vary:
            return group.axis_B
        axes = []
        for k, joint in enumerate(group.joints):
            a, b = (self._joints.bodies[end] for end in (joint.a, joint.b))
            q_AB = self._places.orientation(a, b, params)
            axis_A = tuple(x[k] for x in group.axis_A)
            axes.append(vectors.unrotate(vectors.rotation_matrix(q_AB), axis_A))
        x, y, z = (jnp.stack(entries) for entries in zip(*axes, strict=True))
        return x, y, z


class LaneBlocks:
    """Blocks as arrays (6, 6, k, n), and vectors (6, k, n)."""

    def pick(self, blocks: Lanes, index: Sequence[int]) -> Lanes:
        """Return some of the blocks, or vectors."""
        if list(index) == list(range(blocks.shape[-2])):
            return blocks
        return blocks[..., np.array(index, dtype=int), :]

    def sum_to(self, blocks: Lanes, index: Sequence[int], count: int) -> Lanes:
        """Return as many sums of the blocks, or vectors: of each where it goes."""
        if list(index) == list(range(count)):
            return blocks
        sums = []
        for k in range(count):
            mine = [i for i, target in enumerate(index) if target == k]
            sums.append(self.pick(blocks, mine).sum(axis=-2))
        return jnp.stack(sums, axis=-2)

    def inverse(self, D: Lanes) -> Lanes:
        """Return the inverses of symmetric positive definite blocks, by their halves.

        Row by row XLA computes the same again and again, and takes ten times as long.
        """
        P, Q, R = D[:3, :3], D[:3, 3:], D[3:, 3:]
        R = _inverse3(R)
        QR = self.multiply(Q, R)
        P = _inverse3(P - self.multiply(QR, self.transpose(Q)))
        Q = -self.multiply(P, QR)
        R = R - self.multiply(self.transpose(QR), Q)
        upper = jnp.concatenate([P, Q], axis=1)
        lower = jnp.concatenate([self.transpose(Q), R], axis=1)
        return jnp.concatenate([upper, lower])

    def multiply(self, A: Lanes, B: Lanes) -> Lanes:
        """Return A B, block by block."""
        # Entry by entry: as a sum over an axis XLA takes five times as long.
        inner = range(B.shape[0])
        return _rows(
            [
                [sum(A[i, k] * B[k, j] for k in inner) for j in range(B.shape[1])]
                for i in range(A.shape[0])
            ]
        )

    def apply(self, A: Lanes, x: Lanes) -> Lanes:
        """Return A x, block by block."""
        return sum(A[:, k] * x[k] for k in range(x.shape[0]))

    def transpose(self, A: Lanes) -> Lanes:
        """Return A^T, block by block."""
        return A.swapaxes(0, 1)


def _inverse3(S: Lanes) -> Lanes:
    """Return the inverses of symmetric 3 by 3 blocks."""
    xx, yy, zz, xy, xz, yz = inverse(
        (S[0, 0], S[1, 1], S[2, 2], S[0, 1], S[0, 2], S[1, 2])
    )
    return _rows([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _rows(values: Sequence[Any]) -> Lanes:
    """Return (r, ..., k, n) of r lanes (k, n), or of r such sequences."""
    return jnp.stack([_rows(x) if isinstance(x, list) else x for x in values])


def _groups(separation: Separation, joints: laws.RigidJoints) -> list[_Group]:
    """Return the joints by their types."""
    groups = []
    for kind in dict.fromkeys(joint.type for joint in joints.joints):
        mine = [joint for joint in joints.joints if joint.type == kind]
        first = [separation.attachments[joint.attachments[0]] for joint in mine]
        held = [held_joint(separation, attachment) for attachment in first]
        axes = (
            [joint.R_AJ for joint in mine],
            [attachment.joint.y_axis_A for attachment in first],
            [joint.axis_B for joint in held],
        )
        lanes = [tuple(np.array(values).T[..., None]) for values in axes]
        groups.append(_Group(mine, kind, *lanes))
    return groups
