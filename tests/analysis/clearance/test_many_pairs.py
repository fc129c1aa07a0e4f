"""The nearest of many pairs on tumbling, curved motions, and what bounds the motion.

Balls on both bodies, whose distances are those of their centres: looked at thousands of
moments and refined, over all pairs and over parts of the run.
"""

import math

import numpy as np
import pytest
from flights import run_of
from tumbling import Tumbling

from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.parts import Part, Sphere


pytestmark = pytest.mark.slow  # compiles programs of its own, for minutes


TIME = np.linspace(0.0, 1.0, 401)
"""Between such samples the cubic misses these motions by 1e-9 m."""
ROUND_OFF = 1e-7
SOLVER = 1e-6
"""Of Drake's distance between balls, m."""
SEEDS = range(6)
RADIUS = 0.01


class Balls:
    """Small balls around both bodies' origins, and how near each pair comes."""

    def __init__(self, seed):
        rng = np.random.default_rng(100 + seed)
        self.motion = Tumbling(seed)
        self.on_A = rng.uniform(-0.3, 0.3, size=(4, 3))
        self.on_B = rng.uniform(-0.3, 0.3, size=(3, 3))
        on_A, on_B = (
            [
                Part(
                    name=f"{side}_{i}",
                    shape=Sphere(radius=RADIUS),
                    p_BoGo_B=tuple(p.tolist()),
                )
                for i, p in enumerate(points)
            ]
            for side, points in (("a", self.on_A), ("b", self.on_B))
        )
        self.run = run_of(self.motion.trajectory(TIME), on_A, on_B)
        self.names = [(a.name, b.name) for a in on_A for b in on_B]

    def distances(self, t):
        """(n, 12) of all pairs in the order of `names`."""
        return np.stack(
            [
                np.linalg.norm(self.motion.points(t, b) - a, axis=1) - 2 * RADIUS
                for a in self.on_A
                for b in self.on_B
            ],
            axis=1,
        )

    def smallest(self, end):
        """(12,) smallest distance of each pair until a time."""
        t = np.linspace(0.0, end, 4001)
        coarse = self.distances(t)
        least = coarse.min(axis=0)
        for k, when in enumerate(t[coarse.argmin(axis=0)]):
            near = np.linspace(when - t[1], when + t[1], 401)
            near = near[(near >= 0.0) & (near <= end)]
            least[k] = min(least[k], self.distances(near)[:, k].min())
        return least


@pytest.fixture(scope="module", params=SEEDS)
def balls(request):
    return Balls(request.param)


@pytest.mark.parametrize("until", [None, 0.35])
def test_the_nearest_of_all(balls, until):
    """The bound, what is found less ACCURACY, is below the truth; that below found."""
    analysis = ClearanceAnalysis(balls.run.separation)
    truth = balls.smallest(1.0 if until is None else until)
    found = analysis.smallest(balls.run, until=until)
    assert (found.first, found.second) in balls.names
    assert found.minimum - ACCURACY <= truth.min() + ROUND_OFF
    assert truth.min() <= found.minimum + ROUND_OFF + SOLVER
    [there] = balls.distances(np.array([found.time]))
    mine = there[balls.names.index((found.first, found.second))]
    assert found.minimum == pytest.approx(mine, abs=SOLVER)
    assert 0.0 <= found.time <= (until or 1.0)


def test_each_pair(balls):
    found = ClearanceAnalysis(balls.run.separation).of(balls.run)
    assert [(one.first, one.second) for one in found] == balls.names
    for one, truth in zip(found, balls.smallest(1.0), strict=True):
        if truth > SOLVER:
            assert one.minimum - ACCURACY <= truth + ROUND_OFF
            assert truth <= one.minimum + ROUND_OFF + SOLVER
        # Points that are nearest lie on their balls, and are that far apart.
        a, b = (int(name[2:]) for name in (one.first, one.second))
        for point, centre in (
            (one.p_AoCa_A, balls.on_A[a]),
            (one.p_BoCb_B, balls.on_B[b]),
        ):
            assert np.linalg.norm(np.subtract(point, centre)) == pytest.approx(
                RADIUS, abs=SOLVER
            )
        [second] = balls.motion.points(np.array([one.time]), np.array(one.p_BoCb_B))
        apart = np.linalg.norm(second - one.p_AoCa_A)
        assert apart == pytest.approx(one.minimum, abs=SOLVER)


def test_nothing_is_nearer_than_the_nearest(balls):
    analysis = ClearanceAnalysis(balls.run.separation)
    least = balls.smallest(1.0).min()
    if least <= SOLVER:
        pytest.skip("these touch")
    assert analysis.smallest(balls.run, than=least - ACCURACY) is None
    nearer = analysis.smallest(balls.run, than=least + 3 * ACCURACY)
    assert nearer.minimum == pytest.approx(least, abs=ACCURACY + SOLVER)


def test_nearest_at_moments(balls):
    times = np.random.default_rng(3).uniform(0.0, 1.0, 40)
    truth = balls.distances(times)
    found = ClearanceAnalysis(balls.run.separation).nearest(balls.run, times.tolist())
    for pair, distances in zip(found, truth, strict=True):
        assert pair.nearest.distance == pytest.approx(distances.min(), abs=SOLVER)
        mine = distances[balls.names.index(pair.names)]
        assert mine == pytest.approx(distances.min(), abs=2 * SOLVER)


@pytest.mark.parametrize("apart", [None, 0.02, 0.1])
def test_while_distances_matter(balls, apart):
    """Until B has first moved so far along A's x axis."""
    t = np.linspace(0.0, 1.0, 200_001)
    x = balls.motion.place(t)[:, 0]
    reached = np.flatnonzero(x - x[0] >= (math.inf if apart is None else apart))
    if apart is not None and not len(reached):
        pytest.skip("it never moves as far")
    end = 1.0 if apart is None else t[reached[0]]
    truth = balls.smallest(end).min()
    objective = LowestClearance(balls.run.separation, until_separation=apart)
    least = -objective(balls.run)
    if truth > SOLVER:
        # It moves by micrometres while the end is told to 5e-6 s.
        assert truth - 1e-4 <= least <= truth + ACCURACY + 1e-4


def test_windows_end_within_some_runs():
    """Else the test above would skip them all."""
    reached = {
        apart: sum(
            (np.diff(Tumbling(seed).place(TIME)[[0, i], 0]) >= apart).any()
            for seed in SEEDS
            for i in [int(Tumbling(seed).place(TIME)[:, 0].argmax())]
        )
        for apart in (0.02, 0.1)
    }
    assert min(reached.values()) >= 3


@pytest.mark.parametrize("seed", SEEDS)
def test_bounds_on_the_motion(seed):
    """No speed and no acceleration in a stretch is larger, and none is much smaller."""
    motion = Tumbling(seed)
    path = RelativePath(motion.trajectory(TIME), "lower", "upper")
    rng = np.random.default_rng(seed)
    h = 1e-5
    for _ in range(20):
        start = rng.uniform(0.0, 0.9)
        end = start + 0.1 * 10.0 ** rng.uniform(-3.0, 0.0)
        bounds = path.bounds(start, end)
        t = np.linspace(start, end, 101)
        R = [motion.turn(t + k * h) for k in (-1, 0, 1)]
        speed = (R[0].inv() * R[2]).magnitude() / (2 * h)
        p = [motion.place(t + k * h) for k in (-1, 0, 1)]
        acceleration = np.linalg.norm(p[0] - 2 * p[1] + p[2], axis=1) / h**2
        matrices = [r.as_matrix() for r in R]
        curving = (matrices[0] - 2 * matrices[1] + matrices[2]) / h**2
        bending = np.linalg.norm(curving, ord=2, axis=(1, 2))
        for bound, true in (
            (bounds.angular_speed, speed),
            (bounds.acceleration, acceleration),
            (bounds.bending, bending),
        ):
            # Of second differences 1e-5 s apart, and of cubics 2.5 ms long.
            room = 2e-4 * max(1.0, true.max())
            assert true.max() <= bound + room
            # Beyond the stretch's samples, and q'' beside q'^2: within some times.
            assert bound <= 4.0 * true.max() + 2.0
