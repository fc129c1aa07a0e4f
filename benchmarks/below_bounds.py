"""Whether any sample of VEGA's tolerances is beyond what is proven.

Bounds of all that VEGA requires, and of the paper's objectives, as `drakesep prove`
finds them; then samples on the batch engine: half of them drawn uniformly from the
tolerances, half corners of the box, of which those with inertias that no body can have
are drawn back to such as it can have. Prints for each bound the farthest sample, and
how many samples are beyond it by more than the batch engine may be off. Exits with 1 if
one is.

    python benchmarks/below_bounds.py [SAMPLES]
"""

import sys
import time
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from drakesep import load_case
from drakesep.analysis import Batch, deviation_limits
from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.bounds.proving import Bound, prove_bounds


SAMPLES, AT_ONCE = 10_000_000, 65_536
OFF = 1e-8
"""By how much a metric of the batch engine may be off, relative and in SI."""


def rows_of(case: AnalysisCase, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return values (count, n) of parameters: samples, then corners."""
    tolerances = case.tolerance_set
    drawn = tolerances.draw(count - count // 2, rng)
    corners = rng.choice((-1.0, 1.0), (count // 2, len(tolerances)))
    points = np.concatenate([drawn, tolerances.draw_back(corners)])
    return np.asarray(tolerances.rows(points))


class Farthest:
    """The farthest samples of each claim, and how many are beyond its bound."""

    def __init__(self, proven: Mapping[str, Bound]):
        self._proven = proven
        self.samples = self.failed = 0
        self.values = dict.fromkeys(proven, -np.inf)
        self.beyond = dict.fromkeys(proven, 0)

    def add(self, metrics: pd.DataFrame, failed: int) -> None:
        """Take note of samples."""
        self.samples, self.failed = self.samples + len(metrics), self.failed + failed
        for name, bound in self._proven.items():
            side = 1.0 if bound.claim.side == "highest" else -1.0
            values = side * metrics[bound.claim.metric].to_numpy()
            most = side * bound.value
            self.values[name] = max(self.values[name], float(np.nanmax(values)))
            self.beyond[name] += int((values > most + OFF * (1.0 + abs(most))).sum())

    @property
    def table(self) -> pd.DataFrame:
        """A row for each claim, in SI."""
        rows = []
        for name, bound in self._proven.items():
            side = 1.0 if bound.claim.side == "highest" else -1.0
            farthest = side * self.values[name]
            rows.append(
                {
                    "claim": name,
                    "bound": bound.value,
                    "attained": bound.found,
                    "farthest sample": farthest,
                    "within, %": 100.0 * abs(bound.value - farthest) / abs(bound.value),
                    "beyond": self.beyond[name],
                }
            )
        return pd.DataFrame(rows)


def main(arguments: Sequence[str]) -> int:
    """Prove, then fly."""
    count = int(float(arguments[0])) if arguments else SAMPLES
    case = load_case("vega").in_si()
    began = time.process_time()
    bounds = prove_bounds(case)
    print(f"{len(bounds.proven)} bounds, {time.process_time() - began:.0f} s of CPU")
    limits = deviation_limits(case.requirements)
    batch = Batch(case.separation, case.tolerance_set.names, deviation_limits=limits)
    rng, found = np.random.default_rng(1), Farthest(bounds.proven)
    start, cpu = time.perf_counter(), time.process_time()
    while found.samples < count:
        rows = rows_of(case, min(AT_ONCE, count - found.samples), rng)
        result = batch.run(rows)
        found.add(result.metrics, len(result.failures))
        seconds = time.perf_counter() - start
        if sys.stderr.isatty():
            print(
                f"\r{found.samples} samples, {seconds:.0f} s", end="", file=sys.stderr
            )
    print(
        f"\n{found.samples} samples, {found.failed} failed, "
        f"{time.perf_counter() - start:.0f} s, {time.process_time() - cpu:.0f} s of CPU"
    )
    print(found.table.to_string(index=False, float_format="{:.7g}".format))
    return int(any(found.beyond.values()) or found.failed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
