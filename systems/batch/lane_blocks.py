"""Blocks of linear systems on lanes, for `block_elimination`."""

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np

from drakesep.systems.batch.lanes import Lanes, Settler
from drakesep.systems.equations.rigid_body import inverse


class LaneBlocks(Settler):
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
        R = self.settled(_inverse3(R))
        QR = self.multiply(Q, R)
        P = self.settled(_inverse3(P - self.multiply(QR, self.transpose(Q))))
        Q = -self.multiply(P, QR)
        R = R - self.multiply(self.transpose(QR), Q)
        upper = jnp.concatenate([P, Q], axis=1)
        lower = jnp.concatenate([self.transpose(Q), R], axis=1)
        return self.settled(jnp.concatenate([upper, lower]))

    def multiply(self, A: Lanes, B: Lanes) -> Lanes:
        """Return A B, block by block."""
        # Entry by entry: as a sum over an axis XLA takes five times as long.
        inner = range(B.shape[0])
        product = [
            [sum(A[i, k] * B[k, j] for k in inner) for j in range(B.shape[1])]
            for i in range(A.shape[0])
        ]
        return self.settled(lane_rows(product))

    def apply(self, A: Lanes, x: Lanes) -> Lanes:
        """Return A x, block by block."""
        return self.settled(sum(A[:, k] * x[k] for k in range(x.shape[0])))

    def transpose(self, A: Lanes) -> Lanes:
        """Return A^T, block by block."""
        return A.swapaxes(0, 1)


def _inverse3(S: Lanes) -> Lanes:
    """Return the inverses of symmetric 3 by 3 blocks."""
    xx, yy, zz, xy, xz, yz = inverse(
        (S[0, 0], S[1, 1], S[2, 2], S[0, 1], S[0, 2], S[1, 2])
    )
    return lane_rows([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def lane_rows(values: Sequence[Any]) -> Lanes:
    """Return (r, ..., k, n) of r lanes (k, n), or of r such sequences."""
    return jnp.stack([lane_rows(x) if isinstance(x, list) else x for x in values])
