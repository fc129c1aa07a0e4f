"""Clearances and their bounds against brute force, on curved and tumbling motions.

Distances have closed forms here, and are taken at thousands of moments: nothing but the
description of parts and motion is shared with what is tested. Polygons stand for round
walls: they make a clearance smaller by `FACET` at most, and never larger.
"""

import itertools

import numpy as np
import pytest
import trimesh
from flights import run_of
from tumbling import Tumbling

from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.systems.geometry.convex_pieces import FACET
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Part, Sphere


TIME = np.linspace(0.0, 1.0, 401)
"""Between such samples the cubic misses these motions by 1e-9 m, in h^4 / 384 times the
fourth power of the rates."""
ROUND_OFF = 1e-7
"""Of that, and of dense sampling after it is refined."""
SOLVER = 5e-6
"""By which Drake's distance may miss the true one where it is let pass, m."""
TOUCHING = 1e-6
"""What counts as contact, m."""
MOTIONS = range(12)
BALL, ROD = 0.07, 0.3
AT = np.array([0.1, -0.05, 0.2])
YAW = 0.5
"""Of the part in B."""


# Closed forms: (n,) distances, m, from (n, 3) points in A.


def to_point(p):
    return np.linalg.norm(p, axis=1)


def to_segment(p, a, b):
    along = np.clip(
        ((p - a) * (b - a)).sum(axis=-1) / ((b - a) ** 2).sum(axis=-1), 0, 1
    )
    return np.linalg.norm(p - a - along[:, None] * (b - a), axis=1)


def between_segments(a, b, c, d):
    """From a to b and from c to d: at an end of one, or across both."""
    u, v, w = b - a, d - c, a - c
    normal = np.cross(u, v)
    across = (normal**2).sum(axis=1)
    s = -(np.cross(w, v) * normal).sum(axis=1) / across
    t = -(np.cross(w, u) * normal).sum(axis=1) / across
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    crossing = np.abs((w * normal).sum(axis=1)) / np.sqrt(across)
    ends = [to_segment(x, c, d) for x in (a, b)] + [to_segment(x, a, b) for x in (c, d)]
    return np.where(inside, crossing, np.min(ends, axis=0))


def to_box(p, half):
    beyond = np.abs(p) - half
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return outside + np.minimum(beyond.max(axis=1), 0.0)


def to_ring(p, inner, outer, half):
    """A tube along x, in the half-plane of x and the distance from the axis."""
    r = np.hypot(p[:, 1], p[:, 2])
    beyond = np.maximum(np.maximum(inner - r, r - outer), 0.0)
    return np.hypot(beyond, np.maximum(np.abs(p[:, 0]) - half, 0.0))


def to_frustum(p, aft, fore, half):
    """A solid cone along x, in the half-plane of x and the distance from the axis."""
    flat = np.stack([p[:, 0], np.hypot(p[:, 1], p[:, 2])], axis=1)
    profile = np.array([(-half, 0.0), (-half, aft), (half, fore), (half, 0.0)])
    edges = [to_segment(flat, a, b) for a, b in itertools.pairwise(profile)]
    wall = aft + (fore - aft) * (flat[:, 0] + half) / (2.0 * half)
    inside = (np.abs(flat[:, 0]) < half) & (flat[:, 1] < wall)
    return np.where(inside, -np.min(edges, axis=0), np.min(edges, axis=0))


def to_triangles(p, triangles):
    return np.min(
        [
            np.linalg.norm(
                trimesh.triangles.closest_point(np.tile(each, (len(p), 1, 1)), p) - p,
                axis=1,
            )
            for each in triangles
        ],
        axis=0,
    )


class Scene:
    """A part on A, a ball or a rod on B, and how far apart they are in truth."""

    def __init__(self, on_A, distance, facets=0, *, rod=False, places=1.0):
        self.on_A, self._distance, self.rod = on_A, distance, rod
        self.smaller = facets * FACET
        self.places = places
        shape = Capsule(radius=BALL, length=ROD) if rod else Sphere(radius=BALL)
        self.on_B = Part(
            name="moving", shape=shape, p_BoGo_B=tuple(AT), rpy_BG=(0.0, 0.0, YAW)
        )

    def distance(self, motion, t):
        if not self.rod:
            return self._distance(motion.points(t, AT)) - BALL
        end = 0.5 * ROD * np.array([np.cos(YAW), np.sin(YAW), 0.0])
        return self._distance(*(motion.points(t, AT + x) for x in (-end, end))) - BALL

    def smallest(self, motion, start, end):
        """The smallest distance, at thousands of moments and as many near the best."""
        t = np.linspace(start, end, 2001)
        distances = self.distance(motion, t)
        step = t[1] - t[0]
        near = t[np.argsort(distances)[:4]]
        fine = np.concatenate([np.linspace(x - step, x + step, 501) for x in near])
        fine = fine[(fine >= start) & (fine <= end)]
        return min(distances.min(), self.distance(motion, fine).min())


def notched(folder):
    """A plate with a notch, as triangles."""
    outline = [
        (0, 0),
        (0.6, 0),
        (0.6, 0.6),
        (0.35, 0.6),
        (0.3, 0.15),
        (0.2, 0.6),
        (0, 0.6),
    ]
    corners = np.array([(x, y, z) for z in (0.0, 0.1) for x, y in outline])
    n = len(outline)
    cap = [(0, 4, 5), (0, 5, 6), (0, 1, 4), (1, 3, 4), (1, 2, 3)]
    faces = [tuple(reversed(f)) for f in cap]
    faces += [tuple(k + n for k in f) for f in cap]
    for k in range(n):
        m = (k + 1) % n
        faces += [(k, m, m + n), (k, m + n, k + n)]
    mesh = trimesh.Trimesh(corners, faces)
    mesh.export(folder / "notched.stl")
    # The file has single precision.
    return folder / "notched.stl", trimesh.load_mesh(folder / "notched.stl").triangles


def scenes(folder):
    part = {"name": "standing"}
    ring = Cone(radius_aft=0.6, radius_fore=0.6, length=0.3, thickness=0.05)
    frustum = Cone(radius_aft=0.4, radius_fore=0.15, length=0.6)
    file, triangles = notched(folder)
    half = np.array([0.3, 0.2, 0.1])
    bar = np.array([[-0.25, 0.0, 0.0], [0.25, 0.0, 0.0]])
    return {
        "balls": Scene(
            Part(**part, shape=Sphere(radius=0.2)), lambda p: to_point(p) - 0.2
        ),
        "rods": Scene(
            Part(**part, shape=Capsule(radius=0.1, length=0.5)),
            lambda c, d: between_segments(*bar, c, d) - 0.1,
            rod=True,
        ),
        "box": Scene(
            Part(**part, shape=Box(size=tuple(2.0 * half))), lambda p: to_box(p, half)
        ),
        "ring": Scene(
            Part(**part, shape=ring),
            lambda p: to_ring(p, 0.55, 0.6, 0.15),
            1,
            places=0.4,
        ),
        "frustum": Scene(
            Part(**part, shape=frustum), lambda p: to_frustum(p, 0.4, 0.15, 0.3), 1
        ),
        "mesh": Scene(
            Part(**part, shape=Mesh(file=file)), lambda p: to_triangles(p, triangles)
        ),
    }


NAMES = ("balls", "rods", "box", "ring", "frustum", "mesh")


@pytest.fixture(params=NAMES)
def scene(request, tmp_path):
    return scenes(tmp_path)[request.param]


def motions(scene):
    """Those in which the parts are apart at the start, and runs of them."""
    for seed in MOTIONS:
        motion = Tumbling(seed, distance=scene.places)
        if scene.distance(motion, np.zeros(1))[0] > 1e-3:
            yield motion, run_of(motion.trajectory(TIME), [scene.on_A], [scene.on_B])


def test_smallest_distances(scene):
    """The bound, what is found less ACCURACY, is below the truth; that below found."""
    touched = 0
    for motion, run in motions(scene):
        [found] = ClearanceAnalysis(run.separation).of(run)
        truth = scene.smallest(motion, 0.0, 1.0)
        if truth > scene.smaller + TOUCHING + ROUND_OFF:
            assert found.contact is None
            assert found.minimum - ACCURACY <= truth + ROUND_OFF
            assert truth <= found.minimum + scene.smaller + ROUND_OFF
            [there] = scene.distance(motion, np.array([found.time]))
            assert abs(found.minimum - there) <= SOLVER + scene.smaller
        elif truth < -ROUND_OFF:
            touched += 1
            assert found.minimum == 0.0
            # Polygons touch first, and what Drake says is as near as TOUCHING does.
            level = scene.smaller + TOUCHING + SOLVER
            assert first_below(scene, motion, level) - 1e-6 <= found.contact.time
            assert found.contact.time <= first_below(scene, motion, 0.0) + 1e-6
    assert 0 < touched < len(MOTIONS)


def first_below(scene, motion, level):
    """When a distance first is that small, to 1e-7 s."""
    start, end = 0.0, 1.0
    for _ in range(3):
        t = np.linspace(start, end, 4001)
        k = int(np.argmax(scene.distance(motion, t) <= level))
        start, end = t[max(k - 1, 0)], t[k]
        if end - start < 1e-7:
            break
    return end


def test_bounds_over_stretches_of_time(scene):
    """What is said to stay apart does, and what comes nearer is never said to."""
    rng = np.random.default_rng(1)
    said = {True: 0, False: 0}
    for motion, run in itertools.islice(motions(scene), 4):
        [parts] = ClearanceAnalysis(run.separation)._along_run(run)
        for _ in range(20):
            start = rng.uniform(0.0, 0.9)
            end = start + 0.1 * 10.0 ** rng.uniform(-3.0, 0.0)
            truth = scene.smallest(motion, start, end)
            limit = max(truth + 0.03 * rng.normal(), TOUCHING)
            nearest = parts.may_come_below(start, end, limit)
            said[nearest is None] += 1
            if nearest is None:
                assert limit <= truth + ROUND_OFF
            elif start < end:
                middle = np.array([0.5 * (start + end)])
                # Of pieces, or of boxes around them, which are nearer.
                assert nearest.distance <= scene.distance(motion, middle)[0] + SOLVER
    assert min(said.values()) > 10


def test_distances_at_moments(scene):
    rng = np.random.default_rng(2)
    for motion, run in itertools.islice(motions(scene), 3):
        times = rng.uniform(0.0, 1.0, 60)
        [found] = ClearanceAnalysis(run.separation).at_times(run, times).T
        truth = scene.distance(motion, times)
        apart = truth > scene.smaller + TOUCHING
        assert apart.sum() > 20
        short = (truth - found)[apart]
        assert (short <= scene.smaller + ROUND_OFF).all()
        assert (short >= -SOLVER).all()
