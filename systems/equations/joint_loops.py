"""Rigid joints whose bodies form loops: the wrenches that hold them.

By the method of multipliers: in a few rounds with joints that are stiff to
accelerations, each of which begins where the last one has come to. However many joints
hold the same directions, this is well posed, and of all wrenches that hold them it
finds those of equal joints (Carpentier, Budhiraja and Mansard, "Proximal and sparse
resolution of constrained dynamic equations", RSS 2021).

Wrenches and accelerations are about a common point O, in W: six numbers, of which the
first three are of rotation.
"""

from collections.abc import Sequence

from drakesep.systems.equations.block_elimination import (
    Algebra,
    Blocks,
    Factorized,
    Plan,
)


_ROUNDS = 4
"""More than masses ask for: directions that joints nearly share take more of them."""


def holding_wrenches(
    plan: Plan,
    edges: Sequence[tuple[int, int]],
    inertias: Blocks,
    free: Blocks,
    stiffness: Blocks,
    rest: Blocks,
    algebra: Algebra,
) -> Blocks:
    """Return the wrenches that rigid joints give B of each edge; the reverse A.

    Args:
        plan: of the elimination.
        edges: of each two bodies that are joined, A and B.
        inertias: M of each body.
        free: of each body the wrench of all else that acts, less that of its rates.
        stiffness: of each edge the sum of J^T k J of the joints that hold.
        rest: of each edge that of J^T k rest.
        algebra: of the engine.
    """
    nodes = plan.nodes
    A, B = ([edge[k] for edge in edges] for k in range(2))

    def sum_up(blocks: Blocks, sign: float) -> Blocks:
        on_A = algebra.sum_to(blocks, A, nodes)
        return algebra.sum_to(blocks, B, nodes) + sign * on_A

    own = inertias + sum_up(stiffness, 1.0)
    system = Factorized(plan, own, -stiffness, algebra)
    wrenches = 0.0 * rest
    V = system.solve(free - sum_up(rest, -1.0))
    for _ in range(_ROUNDS - 1):
        apart = algebra.pick(V, B) - algebra.pick(V, A)
        gap = rest + algebra.apply(stiffness, apart)
        wrenches = wrenches - gap
        # The next round's solution by what it adds: of round-off, too, that is rid.
        left = free - algebra.apply(inertias, V) + sum_up(wrenches - gap, -1.0)
        V = V + system.solve(left)
    apart = algebra.pick(V, B) - algebra.pick(V, A)
    return wrenches - rest - algebra.apply(stiffness, apart)
