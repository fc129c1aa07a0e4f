"""Whether any random sample of VEGA's tolerances comes nearer than the worst clearance.

Each sample is flown on the batch engine, and held against the nominal run at the same
place along A's x axis: bodies are rigid, so that a pair is at least as near as there,
less the way that any point of B has moved. Samples that this does not settle are
measured. Prints what the search found and after how long, how many samples were
measured, and the nearest of them.

    python benchmarks/worst_clearance.py [--samples 100000]
"""

import argparse
import itertools
import time

import numpy as np

from drakesep import Case, load_case, worst_case
from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.registry import find_metric
from drakesep.systems.arrays import Array
from drakesep.systems.geometry.convex_pieces import pieces_of
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.run import Run


STEP = 1e-3
"""Between places of the nominal run that samples are held against, m."""
SLACK = 1e-3
"""What interpolation between places and between samples may miss, m. In time it is of
second order, 0.1 mm with 6 m/s^2 and steps of 10 ms; a distance of 34 mm to an edge
bends by 0.5 mm over the 12 mm that B moves between samples."""


class Screen:
    """Lower bounds on how near a run comes, from how near the nominal one does."""

    def __init__(self, nominal: Run, case: Case, until: float):
        separation = nominal.separation
        self._A, self._B, self._until = separation.A, separation.B, until
        path = RelativePath(nominal.completed_trajectory, self._A, self._B)
        end = path.time_apart(until + 0.05)
        times = np.linspace(0.0, end, int((until + 0.05) / STEP))
        self._R, self._p = path.places(times)
        self._x = self._p[:, 0]
        parts = {e.name: e for b in separation.bodies for e in b.parts}
        analysis = ClearanceAnalysis(separation, case.clearance.pairs)
        self.bounds: dict[str, tuple[Array, Array]] = {}
        for pair in analysis._along(nominal):
            distances = np.array([pair.at(t).distance for t in times.tolist()])
            part = parts[pair.names[1]]
            points = np.concatenate([piece.points for piece in pieces_of(part)])
            low, high = points.min(axis=0), points.max(axis=0)
            corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
            self.bounds[" to ".join(pair.names)] = distances, corners

    def __call__(self, run: Run) -> float:
        """Return what the smallest distance is at least, m."""
        trajectory = run.completed_trajectory
        path = RelativePath(trajectory, self._A, self._B)
        end = path.time_apart(self._until)
        times = np.append(trajectory.time[trajectory.time < end], end)
        R, p = path.places(times)
        at = np.interp(p[:, 0], self._x, np.arange(len(self._x)))
        i = np.minimum(at.astype(int), len(self._x) - 2)
        part = at - i
        p_0 = self._p[i] + part[:, None] * (self._p[i + 1] - self._p[i])
        R_0 = self._R[i] + part[:, None, None] * (self._R[i + 1] - self._R[i])
        least = np.inf
        for distances, corners in self.bounds.values():
            moved = (p - p_0)[:, None] + np.einsum("tij,cj->tci", R - R_0, corners)
            way = np.linalg.norm(moved, axis=2).max(axis=1)
            there = distances[i] + part * (distances[i + 1] - distances[i])
            least = min(least, float((there - way).min()))
        return least - SLACK


def main() -> None:
    """Search, then draw."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    case = load_case("vega")
    start = time.perf_counter()
    required = next(r.metric for r in case.limits if r.measured_apart)
    study = worst_case(case, [f"lowest_{required}"])
    [worst] = study.worst
    print(
        f"worst clearance {-1e3 * worst.value:.4f} mm, found by {worst.search}, "
        f"confirmed in Drake, after {time.perf_counter() - start:.1f} s"
    )
    objective = case.lowest_clearance(required)
    assert isinstance(objective, LowestClearance)
    batch = Batch(case.separation, case.box.names)
    [nominal] = batch.runs(batch.nominal[None])
    metric, _ = find_metric(required) or (None, "")
    assert metric is not None and metric.until_separation is not None
    screen = Screen(nominal, case, metric.until_separation)
    tolerances = case.tolerance_set
    rng = np.random.default_rng(asked.seed)
    measured, nearest, beyond, least = 0, np.inf, 0, np.inf
    start = time.perf_counter()
    for first in range(0, asked.samples, 1000):
        count = min(1000, asked.samples - first)
        for run in batch.runs(tolerances.rows(tolerances.draw(count, rng))):
            bound = screen(run)
            least = min(least, bound)
            if bound > -worst.value:
                continue
            distance = objective.nearest(run).minimum
            measured, nearest = measured + 1, min(nearest, distance)
            beyond += distance < -worst.value
        print(
            f"\r{first + count} samples, none below {1e3 * least:.3f} mm by how far "
            f"it strays; {measured} measured, nearest {1e3 * nearest:.3f} mm, "
            f"{beyond} nearer than the worst, {time.perf_counter() - start:.0f} s",
            end="",
            flush=True,
        )
    print()


if __name__ == "__main__":
    main()
