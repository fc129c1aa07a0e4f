"""Distances between pieces: certain, and the same whoever asks, whenever."""

import itertools
import math
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from drakesep.systems.geometry.bounding_tree import (
    nodes_of,
    support,
    support_point,
)
from drakesep.systems.geometry.convex_pieces import pieces_of
from drakesep.systems.geometry.distance import (
    TOUCHING,
    Proximity,
    certify,
    nearest_of,
)
from drakesep.systems.geometry.proximity_scenes import ProximityScenes
from drakesep.systems.geometry.relative_path import Pose
from drakesep.systems.model.parts import Box, Capsule, Cone, Part, Sphere


SHAPES = {
    "box": Box(size=(1.0, 0.8, 0.04)),
    "cylinder": Cone(radius_aft=0.5, radius_fore=0.5, length=1.0),
    "cone": Cone(radius_aft=0.4, radius_fore=0.08, length=0.45),
    "capsule": Capsule(radius=0.1, length=0.6),
    "ball": Sphere(radius=0.3),
}


def pose_of(rpy, place):
    """B at rest there."""
    rotation = RollPitchYaw(*rpy)
    q, R = rotation.ToQuaternion().wxyz(), rotation.ToRotationMatrix().matrix()
    return Pose(q, R, np.array(place), np.zeros(3), np.zeros(3))


def measured(first, second, rpy, place):
    parts = [Part(name=n, shape=s) for n, s in (("a", first), ("b", second))]
    proximity = Proximity(parts[:1], parts[1:])
    pose = pose_of(rpy, place)
    pair = proximity.roots["a"], proximity.roots["b"]
    bound = proximity.measure(pair, pose)
    return pair, bound if bound.is_certified else certify(pair, pose, bound), pose.R_AB


@settings(max_examples=300, deadline=None)
@given(
    names=st.tuples(st.sampled_from(list(SHAPES)), st.sampled_from(list(SHAPES))),
    rpy=st.tuples(*[st.floats(-0.1, 0.1)] * 3),
    heading=st.tuples(st.floats(0.0, math.pi), st.floats(0.0, 2.0 * math.pi)),
    apart=st.floats(0.7, 2.0),
)
def test_distances_are_certain(names, rpy, heading, apart):
    """A plane between the pieces proves them, and the points are as far apart."""
    polar, around = heading
    place = apart * np.array(
        [
            math.cos(polar),
            math.sin(polar) * math.cos(around),
            math.sin(polar) * math.sin(around),
        ]
    )
    pair, bound, R_AB = measured(*(SHAPES[name] for name in names), rpy, place)
    if bound.distance <= TOUCHING:
        return
    # 5 um let pass, and the round-off of points a metre away.
    assert bound.low <= bound.distance + 1e-9
    assert bound.distance - bound.low <= 5.1e-6
    nearest = nearest_of(pair, bound)
    between = R_AB @ nearest.p_BoCb_B + place - nearest.p_AoCa_A
    assert np.linalg.norm(between) == pytest.approx(bound.distance, abs=1e-6)


def test_pose_at_which_drake_ends_early():
    """Drake 1.51.1 says 0.14708 m; bounded least squares over both boxes 0.14662."""
    box = SHAPES["box"]
    _, bound, _ = measured(
        box,
        box,
        (math.pi / 2.0, 1e-3, 1e-3),
        (-0.08465616944689719, -0.5671229915926608, 0.4200356296874088),
    )
    assert bound.distance == pytest.approx(0.14662, abs=1e-5)


def tube(name, radius, length):
    shape = Cone(radius_aft=radius, radius_fore=radius, length=length, thickness=0.02)
    return Part(name=name, shape=shape)


def bits(bound):
    return [np.asarray(each).tobytes() for each in bound]


@pytest.mark.parametrize("lengths", [(0.5, 0.0), (0.0, 0.5)])
def test_distances_do_not_depend_on_what_was_measured_before(lengths):
    """Bit for bit, with more nodes on A and on B; Drake's own depend on the order."""
    parts = [
        [tube("a", 0.3, 0.5), *([tube("more", 0.3, lengths[0])] if lengths[0] else [])],
        [tube("b", 0.2, 0.6), *([tube("more", 0.3, lengths[1])] if lengths[1] else [])],
    ]
    poses = [pose_of((0.1, 0.3 * k, 0.2), (0.4 + 0.3 * k, 0.3, 0.1)) for k in range(3)]

    def measure(order):
        proximity = Proximity(*parts)
        # Every 59th: boxes and pieces of both.
        ends = (list(nodes_of(proximity.roots[name]))[::59] for name in ("a", "b"))
        pairs = list(itertools.product(*ends))
        asked = list(itertools.product(range(len(pairs)), range(len(poses))))
        order(asked)
        return {(k, i): bits(proximity.measure(pairs[k], poses[i])) for k, i in asked}

    straight = measure(lambda asked: None)
    assert len(straight) > 150
    for seed in (1, 2):
        assert measure(random.Random(seed).shuffle) == straight


@pytest.mark.parametrize("name", list(SHAPES))
@pytest.mark.parametrize("more", ["on A", "on B"])
def test_normals_point_from_the_first_to_the_second(name, more):
    """Whichever body has more nodes, which Drake takes second."""
    first, second = (
        Part(name="a", shape=SHAPES[name]),
        Part(name="b", shape=Sphere(radius=0.1)),
    )
    on_A, on_B = [first], [second]
    (on_A if more == "on A" else on_B).append(tube("more", 0.2, 0.5))
    proximity = Proximity(on_A, on_B)
    pair, pose = (
        (proximity.roots["a"], proximity.roots["b"]),
        pose_of((0, 0, 0), (3, 0, 0)),
    )
    bound = proximity.measure(pair, pose)
    nearest = nearest_of(pair, bound)
    between = nearest.p_BoCb_B + pose.p_AoBo_A - nearest.p_AoCa_A
    # Across: Drake finds the nearest points of curved shapes to a millimetre or so.
    assert bound.n_A == pytest.approx((1.0, 0.0, 0.0), abs=1e-3)
    assert between @ bound.n_A == pytest.approx(bound.distance, abs=1e-6)


def surface(shape, rng):
    """(n, 3) points of a shape that it is all but the hull of, in its frame."""
    if isinstance(shape, Box):
        return np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * shape.size
    if isinstance(shape, Cone):
        angles = np.linspace(0.0, 2.0 * np.pi, 2000)
        ring = np.stack([0.0 * angles, np.cos(angles), np.sin(angles)], axis=1)
        x = np.array([0.5 * shape.length, 0.0, 0.0])
        return np.concatenate(
            [shape.radius_aft * ring - x, shape.radius_fore * ring + x]
        )
    ball = rng.normal(size=(20_000, 3))
    ball *= shape.radius / np.linalg.norm(ball, axis=1, keepdims=True)
    x = np.array([0.5 * getattr(shape, "length", 0.0), 0.0, 0.0])
    return np.concatenate([ball - x, ball + x])


@pytest.mark.parametrize("name", list(SHAPES))
def test_support_points_are_the_farthest_of_the_shape(name):
    """Against many points of the surface, given by its own equation."""
    part = Part(
        name="part", shape=SHAPES[name], rpy_BG=(0.4, -0.7, 1.1), p_BoGo_B=(1, 2, 3)
    )
    [node] = Proximity([part], []).roots["part"].leaves
    rng = np.random.default_rng(1)
    R = RollPitchYaw(*part.rpy_BG).ToRotationMatrix().matrix()
    points = surface(part.shape, rng) @ R.T + np.array(part.p_BoGo_B)
    for n in rng.normal(size=(50, 3)):
        n /= np.linalg.norm(n)
        p = support_point(node, n)
        assert support(node, n) == pytest.approx(p @ n, abs=1e-12)
        far = (points @ n).max()
        # A cone's polygon lies up to FACET outside; sampling misses 1 mm at most.
        assert far <= p @ n + 1e-9
        assert p @ n <= far + 1e-3


def test_boxes_hold_the_pieces_below_them():
    root = Proximity([tube("tube", 0.3, 0.5)], []).roots["tube"]
    directions = np.random.default_rng(1).normal(size=(50, 3))
    for node in nodes_of(root):
        for leaf in node.leaves:
            far = (leaf.corners @ directions.T).max(axis=0)
            assert (far <= [support(node, n) + 1e-12 for n in directions]).all()
            corners = leaf.corners - np.array(node.centre)
            assert (np.linalg.norm(corners, axis=1) <= node.radius + 1e-12).all()
    assert len(root.leaves) == len(pieces_of(tube("tube", 0.3, 0.5)))


@pytest.mark.parametrize("apart", [0.02, 0.0, -0.1])
def test_where_drake_gives_up_it_is_measured_all_the_same(apart, monkeypatch):
    """Boxes above each other; of those that overlap just that they do."""

    def give_up(*_):
        raise RuntimeError("The origin is outside of the polytope")

    monkeypatch.setattr(ProximityScenes, "measure", give_up)
    pair, bound, _ = measured(
        Box(size=(1.0, 0.8, 0.04)),
        Box(size=(0.5, 0.3, 0.06)),
        (0.0, 0.0, 0.4),
        (0.1, -0.05, 0.05 + apart),
    )
    assert bound.is_certified
    assert bound.distance == pytest.approx(max(apart, 0.0), abs=1e-9)
    assert bound.low == (pytest.approx(apart, abs=1e-9) if apart > 0.0 else -math.inf)
    if apart > 0.0:
        nearest = nearest_of(pair, bound)
        assert nearest.p_AoCa_A[2] == pytest.approx(0.02, abs=1e-9)
        assert nearest.p_BoCb_B[2] == pytest.approx(-0.03, abs=1e-9)
