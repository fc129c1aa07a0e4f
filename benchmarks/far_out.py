"""A probability of VEGA's far out: subset simulation beside counting.

    python benchmarks/far_out.py [RUNS]

The rate of the payload about y after separation, over Table 2's tolerances, all of them
uniform. Runs are those that counting takes, 1e7 if not given.
"""

import sys
import time

import numpy as np
from scipy.stats import binomtest

from drakesep.analysis.campaigns.draws import Draws
from drakesep.analysis.campaigns.of_case import probability_beyond
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.case_file.reader import load_case


RATE = "rate_after_separation_y"
BEYOND = 0.00735
"""rad/s; the worst case is 0.0077."""
AT_ONCE = 200_000


def main() -> None:
    """Print both, with their errors and what they take."""
    runs = int(float(sys.argv[1])) if len(sys.argv) > 1 else 10_000_000
    case = load_case("vega").in_si()
    paper = {metric.stem for metric in registered_metrics() if metric.objective}
    batch = Batch(case.separation, case.tolerance_set.names, without=paper)

    def rates(values: np.ndarray) -> np.ndarray:
        return batch.run(values).metrics[RATE].to_numpy()

    draws, beyond = Draws(case, 1), 0
    rates(draws.at(range(AT_ONCE)).values)  # compiles
    start = time.perf_counter()
    for first in range(0, runs, AT_ONCE):
        found = rates(draws.at(range(first, min(first + AT_ONCE, runs))).values)
        beyond += int((found > BEYOND).sum())
    took = time.perf_counter() - start
    low, high = binomtest(beyond, runs).proportion_ci(0.95)
    print(
        f"counting: {beyond} of {runs:.3g} runs, {beyond / runs:.3g} "
        f"({low:.3g} to {high:.3g}), {took:.0f} s"
    )
    for seed in range(3):
        start = time.perf_counter()
        one = probability_beyond(case, rates, BEYOND, seed=seed)
        took = time.perf_counter() - start
        value, low, high = one.within(0.95)
        print(
            f"subset simulation, seed {seed}: {one.runs} runs, {value:.3g} ({low:.3g} "
            f"to {high:.3g}), variation {one.variation:.1%}, {took:.0f} s"
        )


if __name__ == "__main__":
    main()
