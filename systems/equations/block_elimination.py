"""Symmetric linear systems of 6 by 6 blocks on a graph: a block Cholesky.

A body is a node and has six unknowns; what joins two bodies is an edge. Nodes are
eliminated level by level, those of a level at once, as no edge joins two of them. A
star or a chain of bodies fills in nothing: the work grows with bodies and edges.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from drakesep.systems.arrays import Array


Blocks: TypeAlias = Any
"""Some 6 by 6 blocks, or as many vectors of 6, as an engine keeps them."""
Index: TypeAlias = Sequence[int]


class Algebra(Protocol):
    """What an engine does with blocks and vectors."""

    def pick(self, blocks: Blocks, index: Index) -> Blocks:
        """Return some of the blocks, or vectors."""

    def sum_to(self, blocks: Blocks, index: Index, count: int) -> Blocks:
        """Return as many sums of the blocks, or vectors: of each where it goes."""

    def inverse(self, D: Blocks) -> Blocks:
        """Return the inverses of symmetric positive definite blocks."""

    def multiply(self, A: Blocks, B: Blocks) -> Blocks:
        """Return A B, block by block."""

    def apply(self, A: Blocks, x: Blocks) -> Blocks:
        """Return A x, block by block."""

    def transpose(self, A: Blocks) -> Blocks:
        """Return A^T, block by block."""


class Matrices:
    """Blocks as matrices: arrays (k, 6, 6), and vectors (k, 6)."""

    def pick(self, blocks: Array, index: Index) -> Array:
        """Return some of the blocks, or vectors."""
        some: Array = blocks[np.array(index, dtype=int)]
        return some

    def sum_to(self, blocks: Array, index: Index, count: int) -> Array:
        """Return as many sums of the blocks, or vectors: of each where it goes."""
        sums: Array = np.zeros((count, *blocks.shape[1:]))
        np.add.at(sums, np.array(index, dtype=int), blocks)
        return sums

    def inverse(self, D: Array) -> Array:
        """Return the inverses of symmetric positive definite blocks."""
        return np.asarray(np.linalg.inv(D), dtype=float)

    def multiply(self, A: Array, B: Array) -> Array:
        """Return A B, block by block."""
        return A @ B

    def apply(self, A: Array, x: Array) -> Array:
        """Return A x, block by block."""
        return (A @ x[..., None])[..., 0]

    def transpose(self, A: Array) -> Array:
        """Return A^T, block by block."""
        return A.swapaxes(1, 2)


class Level(NamedTuple):
    """Nodes that are eliminated at once, and what that leaves.

    Its arcs are the couplings of its nodes with neighbours that are left: rows of the
    node, columns of the neighbour. Couplings are numbered: those of the edges, then
    what fills in.
    """

    nodes: list[int]
    own: list[int]
    """Of each arc the place of its node in `nodes`."""
    neighbours: list[int]
    """Of each arc."""
    couplings: list[int]
    """Of each arc."""
    fill: list[tuple[int, int, int]]
    """Of each two arcs of a node, and the coupling of their neighbours."""


class Plan(NamedTuple):
    """In which order a system is eliminated."""

    nodes: int
    edges: int
    couplings: int
    """How many there come to be."""
    levels: list[Level]


def plan_elimination(nodes: int, edges: Sequence[tuple[int, int]]) -> Plan:
    """Return in which order to eliminate: nodes with the fewest neighbours first.

    Args:
        nodes: how many there are.
        edges: pairs of them, each once.
    """
    around: dict[int, set[int]] = {node: set() for node in range(nodes)}
    for a, b in edges:
        around[a].add(b)
        around[b].add(a)
    chosen, left = [], []
    while around:
        fewest = min(map(len, around.values()))
        level: list[int] = []
        for node, others in around.items():
            if len(others) == fewest and not others.intersection(level):
                level.append(node)
        chosen.append(level)
        left.append({node: around.pop(node) for node in level})
        for node, others in left[-1].items():
            for other in others:
                around[other] = (around[other] | others) - {other, node}
    order = [node for level in chosen for node in level]
    number = {_ordered(edge, order): k for k, edge in enumerate(edges)}
    levels = []
    for level, neighbours in zip(chosen, left, strict=True):
        arcs = [
            (i, number[node, other], other)
            for i, node in enumerate(level)
            for other in sorted(neighbours[node], key=order.index)
        ]
        fill = [
            (x, y, number.setdefault((a, b), len(number)))
            for x, (i, _, a) in enumerate(arcs)
            for y, (j, _, b) in enumerate(arcs)
            if i == j and x < y
        ]
        own, couplings, beside = ([arc[k] for arc in arcs] for k in range(3))
        levels.append(Level(level, own, beside, couplings, fill))
    return Plan(nodes, len(edges), len(number), levels)


def _ordered(edge: tuple[int, int], order: list[int]) -> tuple[int, int]:
    a, b = edge
    return (a, b) if order.index(a) < order.index(b) else (b, a)


class Factorized:
    """A symmetric positive definite system, factorized."""

    def __init__(self, plan: Plan, own: Blocks, couplings: Blocks, algebra: Algebra):
        """Factorize.

        Args:
            plan: of the elimination.
            own: of each node its block.
            couplings: of each edge its block, a symmetric one.
            algebra: of the engine.
        """
        self._plan, self._algebra = plan, algebra
        self._inverses: list[Blocks] = []
        self._arcs: list[Blocks] = []
        if plan.couplings > plan.edges:
            edges = list(range(plan.edges))
            couplings = algebra.sum_to(couplings, edges, plan.couplings)
        for level in plan.levels:
            inverse = algebra.inverse(algebra.pick(own, level.nodes))
            self._inverses.append(inverse)
            if not level.own:
                self._arcs.append(None)
                continue
            arcs = algebra.pick(couplings, level.couplings)
            self._arcs.append(arcs)
            gone = algebra.multiply(algebra.pick(inverse, level.own), arcs)
            left = algebra.multiply(algebra.transpose(arcs), gone)
            own = own - algebra.sum_to(left, level.neighbours, plan.nodes)
            if level.fill:
                first, second, target = (list(x) for x in zip(*level.fill, strict=True))
                across = algebra.multiply(
                    algebra.transpose(algebra.pick(arcs, first)),
                    algebra.pick(gone, second),
                )
                filled = algebra.sum_to(across, target, plan.couplings)
                couplings = couplings - filled

    def solve(self, right: Blocks) -> Blocks:
        """Return the solution of a right-hand side: vectors of the nodes."""
        algebra, nodes = self._algebra, self._plan.nodes
        partial = []
        steps = list(zip(self._plan.levels, self._inverses, self._arcs, strict=True))
        for level, inverse, arcs in steps:
            y = algebra.apply(inverse, algebra.pick(right, level.nodes))
            partial.append(y)
            if level.own:
                mine = algebra.pick(y, level.own)
                gone = algebra.apply(algebra.transpose(arcs), mine)
                right = right - algebra.sum_to(gone, level.neighbours, nodes)
        x = 0.0 * right
        for (level, inverse, arcs), y in zip(
            reversed(steps), reversed(partial), strict=True
        ):
            if level.own:
                coupled = algebra.apply(arcs, algebra.pick(x, level.neighbours))
                sums = algebra.sum_to(coupled, level.own, len(level.nodes))
                y = y - algebra.apply(inverse, sums)
            x = x + algebra.sum_to(y, level.nodes, nodes)
        return x
