"""Runs a second on whatever accelerator JAX finds, for batches of 1e3 to 1e7.

    pip install -e . 'jax[cuda12]'
    python benchmarks/gpu.py

VEGA, all metrics of every run, in double precision, the compilation left out. On a CPU
the larger batches take minutes, and are left out.
"""

import time

import jax
import numpy as np

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.case_file.reader import load_case


LARGEST = {"cpu": 10**5}
CHUNKS = (2**14, 2**16, 2**18)
"""Rows at once: the more, the better used the device, until its memory ends."""
SEED = 0
TIMES = 3


def rows(case, count: int) -> np.ndarray:
    """Return values well inside the box, where every inertia is possible."""
    u = np.random.default_rng(SEED).uniform(-0.3, 0.3, size=(count, len(case.box)))
    return case.box.nominal + case.box.tolerance * u


def best_rate(batch: Batch, values: np.ndarray) -> float:
    walls = []
    for _ in range(TIMES):
        began = time.perf_counter()
        result = batch.run(values)
        walls.append(time.perf_counter() - began)
        assert not result.failures
    return len(values) / min(walls)


def main() -> None:
    case = load_case("vega")
    platform = jax.default_backend()
    print(f"{jax.devices()[0].device_kind} ({platform})")
    largest = LARGEST.get(platform, 10**7)
    print(f"{'chunk':>9} {'rows':>10} {'runs/s':>12}")
    for chunk in (128,) if platform == "cpu" else CHUNKS:
        batch = Batch(case.separation, case.box.names, chunk=chunk)
        batch.run(rows(case, 1))
        for count in (10**3, 10**4, 10**5, 10**6, 10**7):
            if count <= largest:
                rate = best_rate(batch, rows(case, count))
                print(f"{chunk:9} {count:10} {rate:12.0f}")


if __name__ == "__main__":
    main()
