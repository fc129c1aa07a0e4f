"""What is known of pairs of nodes bounds their distances elsewhere."""

import numpy as np
import pytest
from tumbling import Tumbling

from drakesep.analysis.clearance.node_pairs import NodePairs
from drakesep.systems.geometry.bounding_tree import is_leaf, split
from drakesep.systems.geometry.distance import Proximity, certify
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.parts import Cone, Part


TIME = np.linspace(0.0, 1.0, 201)
WALL = Cone(radius_aft=0.1, radius_fore=0.08, length=0.1, thickness=0.01)


@pytest.fixture(scope="module")
def proximity():
    return Proximity([Part(name="a", shape=WALL)], [Part(name="b", shape=WALL)])


@pytest.fixture
def pairs(proximity):
    """More than there is room for to begin with, from the roots downward."""
    pairs = NodePairs((proximity.roots["a"], proximity.roots["b"]))
    for _ in range(100):
        pairs.open(box_in(pairs))
    assert len(pairs) == 101
    return pairs


def box_in(pairs):
    return next(k for k in range(len(pairs)) if not is_leaf(pairs[k]))


def path_of(seed, *, tumbles=True):
    motion = Tumbling(seed, tumbles=tumbles).trajectory(TIME)
    return RelativePath(motion, "lower", "upper")


def distance(proximity, pair, pose):
    bound = proximity.measure(pair, pose)
    return bound if bound.is_certified else certify(pair, pose, bound)


def test_of_what_was_not_measured_nothing_is_known(proximity, pairs):
    pose = path_of(1).at(0.0)
    assert (pairs.lower_bounds(pose) == -np.inf).all()
    k = box_in(pairs)
    bound = distance(proximity, pairs[k], pose)
    pairs.note(k, pose, bound)
    assert pairs.lower_bounds(pose)[k] == pytest.approx(bound.low, abs=1e-12)
    assert np.isfinite(pairs.lower_bounds(pose)).sum() == 1
    first, second = split(pairs[k])
    assert pairs.open(k) == [k, 101]
    assert (pairs[k], pairs[101]) == (first, second)
    assert (pairs.lower_bounds(pose) == -np.inf).all()


@pytest.mark.parametrize("tumbles", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_bounds_hold_elsewhere_and_over_stretches(seed, tumbles, proximity, pairs):
    """Without turning they are all but reached, where B speeds up toward A."""
    path, rng = path_of(seed, tumbles=tumbles), np.random.default_rng(seed)
    useful = 0
    for _ in range(5):
        middle, half = rng.uniform(0.1, 0.9), 0.1 * 10.0 ** rng.uniform(-2.0, 0.0)
        pose = path.at(middle)
        for k in range(len(pairs)):
            pairs.note(k, pose, distance(proximity, pairs[k], pose))
        motion = path.bounds(middle - half, middle + half)
        over_stretch = pairs.lower_bounds(pose) - pairs.motion_within(
            pose, motion, half
        )
        inside = rng.uniform(middle - half, middle + half, 3).tolist()
        for t in (middle - half, *inside, middle + half):
            there = path.at(t)
            truth = [distance(proximity, pairs[k], there) for k in range(len(pairs))]
            truth = np.array([bound.distance for bound in truth])
            assert (pairs.lower_bounds(there) <= truth + 1e-9).all()
            assert (over_stretch <= truth + 1e-9).all()
            useful += (over_stretch > 0.5 * truth).sum()
    # Not by saying nothing.
    assert useful > 500
