"""Planes found at one pose bound the distance at others from below."""

import numpy as np
import pytest
from pydrake.math import RotationMatrix

from drakesep.systems.geometry.bounding_tree import is_leaf, split
from drakesep.systems.geometry.distance import Proximity, certify
from drakesep.systems.geometry.relative_path import Pose
from drakesep.systems.geometry.separating_planes import separating_planes, turned_by
from drakesep.systems.model.parts import Box, Capsule, Cone, Part, Sphere


SHAPES = {
    "box": Box(size=(1.0, 0.8, 0.04)),
    "cylinder": Cone(radius_aft=0.3, radius_fore=0.3, length=0.6),
    "cone": Cone(radius_aft=0.4, radius_fore=0.08, length=0.45),
    "tube": Cone(radius_aft=0.5, radius_fore=0.4, length=0.3, thickness=0.02),
    "capsule": Capsule(radius=0.1, length=0.6),
    "ball": Sphere(radius=0.3),
}
ENOUGH = 0.9
"""m, from which nothing is looked into."""
LOOSE = 1e-4 + 6e-6 + 5e-5
"""Boxes stand for what is in them if that is no more than 0.1 mm farther off; what was
measured is certain to 5 um; and a cylinder is within its polygon by 25 um, to which the
direction of its plane is the same."""


def turned(rng, angle):
    axis = rng.normal(size=3)
    axis *= angle * rng.uniform() / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), axis)
    return np.asarray(
        RotationMatrix.ProjectToRotationMatrix(np.eye(3) - cross).matrix()
    )


def pose(R, p):
    return Pose(np.zeros(4), R, np.asarray(p, float), np.zeros(3), np.zeros(3))


def distance(proximity, roots, at):
    """By all of its pieces that may be nearest, each measured for certain."""
    best, stack = np.inf, [roots]
    while stack:
        pair = stack.pop()
        bound = certify(pair, at, proximity.measure(pair, at))
        if bound.low >= best:
            continue
        if is_leaf(pair):
            best = min(best, bound.distance)
        else:
            stack += split(pair)
    return best


@pytest.mark.parametrize("first", SHAPES)
@pytest.mark.parametrize("second", ["box", "cylinder", "cone", "capsule", "ball"])
def test_they_bound_the_distance_at_other_poses(first, second):
    """As B is moved, turned, and turned more than they are meant for."""
    parts = [Part(name=n, shape=SHAPES[s]) for n, s in (("a", first), ("b", second))]
    proximity = Proximity(parts[:1], parts[1:])
    roots = proximity.roots["a"], proximity.roots["b"]
    rng = np.random.default_rng(len(first) + 10 * len(second))
    R_0, p_0 = turned(rng, 3.0), np.array([1.6, 0.3, -0.2])
    planes = separating_planes(proximity, roots, pose(R_0, p_0), ENOUGH, spread=0.03)
    there = distance(proximity, roots, pose(R_0, p_0))
    [exact] = planes.lower_bounds(R_0[None], p_0[None])
    assert min(there, ENOUGH) - LOOSE <= exact <= there + 1e-9
    R = np.array([turned(rng, angle) @ R_0 for angle in [0.02, 0.2, 1.0] * 4])
    p = p_0 + rng.normal(scale=0.05, size=(len(R), 3))
    bounds = planes.lower_bounds(R, p)
    for k, bound in enumerate(bounds):
        assert bound <= distance(proximity, roots, pose(R[k], p[k])) + 1e-9
    # Where B is hardly turned they are nearly as good.
    small = turned_by(R, R_0) < 0.02
    assert small.any()
    true = [distance(proximity, roots, pose(R[k], p[k])) for k in np.flatnonzero(small)]
    assert np.all(bounds[small] > np.minimum(true, ENOUGH) - 0.02)


def test_in_a_tube_they_tell_as_much_as_on_its_axis():
    """A ball beside the axis of a tube is nearer to the wall by as much."""
    tube = Cone(radius_aft=0.5, radius_fore=0.5, length=1.0, thickness=0.02)
    parts = [Part(name="a", shape=tube), Part(name="b", shape=Sphere(radius=0.3))]
    proximity = Proximity(parts[:1], parts[1:])
    roots = proximity.roots["a"], proximity.roots["b"]
    planes = separating_planes(proximity, roots, pose(np.eye(3), [0, 0, 0]), 1.0, 0.01)
    angles = np.linspace(0.0, 2.0 * np.pi, 17)
    off = 0.05 * np.stack([0.0 * angles, np.cos(angles), np.sin(angles)], axis=1)
    bounds = planes.lower_bounds(np.tile(np.eye(3), (17, 1, 1)), off)
    # The wall's inside is at 0.48 m, and a polygon within 25 um of it, cut into staves
    # of 0.1 mm.
    assert bounds == pytest.approx(0.13, abs=2e-4)
    assert bounds.max() <= 0.13 + 1e-9


def test_where_parts_overlap_they_prove_nothing():
    parts = [Part(name=n, shape=SHAPES["box"]) for n in "ab"]
    proximity = Proximity(parts[:1], parts[1:])
    roots = proximity.roots["a"], proximity.roots["b"]
    planes = separating_planes(proximity, roots, pose(np.eye(3), [0, 0, 0]), 1.0, 0.01)
    assert planes.lower_bounds(np.eye(3)[None], np.zeros((1, 3))) <= 0.0
