"""Whether any random sample of VEGA's tolerances comes nearer than the worst clearance.

Each sample is flown on the batch engine and held against planes between the parts of
the nominal run, which prove how near it comes at least. Samples that this does not
settle are measured. Prints what the search found and after how long, how many samples
were measured, and the nearest of them.

    python benchmarks/worst_clearance.py [--samples 100000]
"""

import argparse
import time

import numpy as np

from drakesep import load_case, worst_case
from drakesep.analysis.campaigns.screens import TRIED, BatchScreens, measured_in
from drakesep.analysis.engines.jax.batch import Batch


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
    batch = Batch(case.separation, case.box.names)
    tolerances = case.tolerance_set
    rng = np.random.default_rng(asked.seed)
    start = time.perf_counter()
    rows = tolerances.rows(tolerances.draw(TRIED, rng))
    screens = BatchScreens(batch, [objective], rows)
    measured, nearest, beyond, least = 0, np.inf, 0, np.inf
    for first in range(0, asked.samples, 1024):
        count = min(1024, asked.samples - first)
        rows = tolerances.rows(tolerances.draw(count, rng))
        bounds = screens.at_least(rows)[:, 0]
        least = min(least, bounds.min())
        for row in np.flatnonzero(bounds < -worst.value):
            [run] = batch.runs(rows[row : row + 1])
            distance = measured_in(run, objective, bounds[row])
            measured, nearest = measured + 1, min(nearest, distance)
            beyond += distance < -worst.value
        print(
            f"\r{first + count} samples, all proven above {1e3 * least:.3f} mm; "
            f"{measured} measured, nearest {1e3 * nearest:.3f} mm, "
            f"{beyond} nearer than the worst, {time.perf_counter() - start:.0f} s",
            end="",
            flush=True,
        )
    print()


if __name__ == "__main__":
    main()
