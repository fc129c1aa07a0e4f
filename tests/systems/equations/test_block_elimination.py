"""Block elimination against numpy's dense solution."""

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drakesep.systems.batch.lane_blocks import LaneBlocks
from drakesep.systems.equations.block_elimination import (
    Factorized,
    Matrices,
    plan_elimination,
)


STAR = [(0, k) for k in range(1, 8)]
CHAIN = [(k, k + 1) for k in range(7)]
LOOPS = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0), (2, 5), (6, 7)]


def system(edges, seed):
    """Blocks of a positive definite system, and the same as one matrix."""
    rng = np.random.default_rng(seed)
    nodes = 1 + max(map(max, edges))
    own = np.array([square(rng) + np.eye(6) for _ in range(nodes)])
    couplings = -np.array([square(rng) for _ in edges])
    dense = np.zeros((nodes, 6, nodes, 6))
    for (a, b), block in zip(edges, couplings, strict=True):
        own[a] -= block
        own[b] -= block
        dense[a, :, b] += block
        dense[b, :, a] += block
    for node in range(nodes):
        dense[node, :, node] = own[node]
    return own, couplings, dense.reshape(6 * nodes, 6 * nodes), rng


def square(rng):
    root = rng.normal(size=(6, 6))
    return root @ root.T


def assert_solved(edges, seed, allowed):
    own, couplings, dense, rng = system(edges, seed)
    right = rng.normal(size=(len(own), 6))
    plan = plan_elimination(len(own), edges)
    got = Factorized(plan, own, couplings, Matrices()).solve(right)
    expected = np.linalg.solve(dense, right.ravel()).reshape(right.shape)
    assert got == pytest.approx(expected, abs=allowed)


@pytest.mark.parametrize("edges", [STAR, CHAIN, LOOPS], ids=["star", "chain", "loops"])
def test_solution_is_that_of_the_whole_matrix(edges):
    # Round-off by a condition of some 1e3.
    assert_solved(edges, seed=1, allowed=1e-12)


@pytest.mark.parametrize("edges", [STAR, CHAIN, LOOPS], ids=["star", "chain", "loops"])
def test_lanes_are_systems_of_their_own(edges):
    systems = [system(edges, seed) for seed in (2, 3, 4)]
    plan = plan_elimination(len(systems[0][0]), edges)
    own, couplings = (
        np.stack([np.moveaxis(each[i], 0, -1) for each in systems], axis=-1)
        for i in (0, 1)
    )
    right = np.random.default_rng(0).normal(size=own.shape[1:])
    with jax.enable_x64(True):
        got = np.array(
            Factorized(plan, own, couplings, LaneBlocks(right[0, 0])).solve(right)
        )
    for lane, (_, _, dense, _) in enumerate(systems):
        expected = np.linalg.solve(dense, right[..., lane].T.ravel())
        assert got[..., lane].T.ravel() == pytest.approx(expected, abs=1e-12)


def test_a_star_and_a_chain_fill_in_nothing():
    """So that the work grows with bodies and edges."""
    for edges in (STAR, CHAIN):
        assert plan_elimination(8, edges).couplings == len(edges)


@given(st.sets(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=1))
def test_any_graph(pairs):
    edges = sorted({(min(p), max(p)) for p in pairs if p[0] != p[1]})
    if not edges:
        return
    assert_solved(edges, seed=5, allowed=1e-11)
