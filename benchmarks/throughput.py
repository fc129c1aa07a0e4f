"""Runs a second: Drake, the batch engine and MuJoCo, errors beside speeds.

    pip install -e '.[bench]'
    python benchmarks/throughput.py

All on the VEGA case, in turns within one process, so that ratios hold on a machine
whose speed drifts; speeds are medians. Errors are the largest of the payload's final
rates and, where there is one, of the longitudinal speed, against Drake at an accuracy
of 1e-10. Then what springs by displacement cost beside those by time, ends, corners and
dampers among them; what the Jacobian costs, how cost grows, and how soon the first
result comes. `--springs` prints the springs alone.
"""

import argparse
import dataclasses
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from drakesep.analysis.engines.drake_pool import DrakePool
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.analysis.metrics.requirements import deviation_limits
from drakesep.case_file.reader import load_case
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.profiles import LINEAR, Profile
from drakesep.systems.model.separation import Separation
from drakesep.systems.model.springs import DisplacementSpring


ROUNDS = 5
REFERENCE_ROWS = 16
ROWS_OF_SPRINGS = 4096
ONE_CORNER: Profile = ((0.0, 1.0), (0.5, 0.4), (1.0, 0.0))
TWO_CORNERS: Profile = ((0.0, 1.0), (0.3, 0.8), (0.6, 0.4), (1.0, 0.0))
JUMP: Profile = ((0.0, 1.0), (1.0, 0.3))
FIRST = """
import time
began = time.perf_counter()
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.case_file.reader import load_case
case = load_case("vega")
batch = Batch(case.separation, case.box.names)
batch.run(case.box.nominal[None])
print(time.perf_counter() - began)
"""
MILLION = """
import resource
import numpy as np
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.case_file.reader import load_case
case = load_case("vega")
u = np.random.default_rng(0).uniform(-0.3, 0.3, size=(1_000_000, len(case.box)))
batch = Batch(case.separation, case.box.names)
batch.run(case.box.nominal + case.box.tolerance * u)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20)
"""


class Engine(NamedTuple):
    """Something that flies rows, and how many of them a round."""

    name: str
    rows: int
    fly: Callable[[np.ndarray], np.ndarray]
    """Final rates (n, 3), and the largest longitudinal speed, if it has it."""


def variations(names: tuple[str, ...], rows: np.ndarray) -> list[dict[str, float]]:
    return [dict(zip(names, row, strict=True)) for row in rows.tolist()]


def drake(pool: DrakePool, names: tuple[str, ...]) -> Callable:
    def fly(rows: np.ndarray) -> np.ndarray:
        motions = [run.completed_motion for run in pool.fly(variations(names, rows))]
        speeds = [motion.relative_velocity[:, 0].max() for motion in motions]
        return np.column_stack([[motion.rate[-1] for motion in motions], speeds])

    return fly


def batched(batch: Batch) -> Callable:
    def fly(rows: np.ndarray) -> np.ndarray:
        metrics = batch.run(rows).metrics
        rates = metrics[[f"final_rate_{axis}" for axis in "xyz"]]
        return np.column_stack([rates, metrics["longitudinal_speed_max"]])

    return fly


def mujoco(case, rows: np.ndarray, timestep: float) -> Callable:
    from mujoco_rollout import MujocoRollout  # of [bench], which --springs does without

    flown = variations(case.box.names, rows)
    rollout = MujocoRollout(case.separation, flown, timestep=timestep, threads=2)
    return lambda _: rollout.fly()


def table(rows: np.ndarray, case, engines: list[Engine]) -> None:
    names = case.box.names
    with DrakePool(case.separation, Integration(accuracy=1e-10)) as pool:
        reference = drake(pool, names)(rows[:REFERENCE_ROWS])
    seconds: dict[str, list[float]] = {engine.name: [] for engine in engines}
    errors = {}
    for number in range(ROUNDS + 1):
        for engine in engines:
            began = time.perf_counter()
            results = engine.fly(rows[: engine.rows])
            spent = (time.perf_counter() - began) / engine.rows
            if number:  # the first compiles, and starts workers
                seconds[engine.name].append(spent)
            count = min(REFERENCE_ROWS, engine.rows)
            off = results[:count] - reference[:count, : results.shape[1]]
            errors[engine.name] = np.abs(off).max(axis=0)
    base = seconds[engines[0].name]
    print(f"{'VEGA':34} {'runs/s':>9} {'ratio':>7} {'rad/s':>8} {'m/s':>8}")
    for engine in engines:
        mine = seconds[engine.name]
        ratio = statistics.median(a / b for a, b in zip(base, mine, strict=True))
        error = errors[engine.name]
        speed = f"{error[3]:8.0e}" if len(error) > 3 else f"{'-':>8}"
        print(
            f"{engine.name:34} {1.0 / statistics.median(mine):9.0f} {ratio:7.0f} "
            f"{error[:3].max():8.0e} {speed}"
        )


def rate(batch: Batch, rows: np.ndarray) -> float:
    """Return runs a second, the median."""
    batch.run(rows[:1])
    walls = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        batch.run(rows)
        walls.append(time.perf_counter() - began)
    return len(rows) / statistics.median(walls)


def print_jacobian(batch: Batch, rows: np.ndarray) -> None:
    batch.jacobian(rows[:1])
    ratios = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        batch.run(rows[:8000])
        middle = time.perf_counter()
        batch.jacobian(rows[:1000])
        spent = time.perf_counter() - middle
        ratios.append(8.0 * spent / (middle - began))
    count = len(batch.names)
    print(f"\nJacobian, {count} parameters: {statistics.median(ratios):.0f} runs' cost")


def by_displacement(
    separation: Separation, profile: Profile = LINEAR, damping: float = 0.0
) -> Separation:
    """Return the separation with its springs driven by displacement."""
    attachments = tuple(
        dataclasses.replace(
            a,
            spring=DisplacementSpring(
                name=a.spring.name,
                force_max=a.spring.force_max,
                stroke=a.spring.stroke,
                damping=damping,
                profile=profile,
            ),
        )
        for a in separation.attachments
    )
    return dataclasses.replace(separation, attachments=attachments)


class Pushed(NamedTuple):
    """A separation by springs of some kind."""

    name: str
    batch: Batch
    rows: np.ndarray

    @classmethod
    def of(cls, name: str, case, separation: Separation) -> "Pushed":
        """Return it with rows over the tolerances of a case."""
        u = np.random.default_rng(0).uniform(-1, 1, (ROWS_OF_SPRINGS, len(case.box)))
        tolerances = case.tolerance_set
        batch = Batch(separation, case.box.names, workers=1)
        return cls(name, batch, tolerances.rows(tolerances.draw_back(u)))


def all_pushed() -> list[Pushed]:
    vega, smallsat = load_case("vega"), load_case("smallsat")
    timed, more = vega.separation, with_springs(vega.separation, 8)
    damped = by_displacement(timed, damping=300.0)
    return [
        Pushed.of("VEGA, Eq. 5", vega, timed),
        Pushed.of("VEGA by displacement", vega, by_displacement(timed)),
        Pushed.of("smallsat", smallsat, smallsat.separation),
        Pushed.of("8 springs, Eq. 5", vega, more),
        Pushed.of("8 by displacement", vega, by_displacement(more)),
        Pushed.of("4 with a jump", vega, by_displacement(timed, JUMP)),
        Pushed.of("4 with a corner", vega, by_displacement(timed, ONE_CORNER)),
        Pushed.of("4 with two corners", vega, by_displacement(timed, TWO_CORNERS)),
        Pushed.of("4 with dampers", vega, damped),
    ]


def print_springs() -> None:
    """Print what kinds of springs cost, in CPU time: the machine may be busy.

    Ratios are those of pairs of calls, one after the other, with as many rows.
    """
    every = all_pushed()
    base = every[0]
    print(
        f"{'springs':24} {'steps':>6} {'most':>5} {'us/row':>7} {'ratio':>6} "
        f"{'rad/s':>8} {'m/s':>8}"
    )
    for one in every:
        one.batch.run(one.rows[:1])
        ratios, spent = [], []
        for _ in range(ROUNDS):
            reference = cpu_time(base)
            mine = cpu_time(one)
            ratios.append(reference / mine)
            spent.append(1e6 * mine / len(one.rows))
        steps = one.batch.run(one.rows).steps
        rates, speed = errors(one)
        print(
            f"{one.name:24} {steps.mean():6.1f} {steps.max():5} "
            f"{statistics.median(spent):7.1f} {statistics.median(ratios):6.2f} "
            f"{rates:8.0e} {speed:8.0e}"
        )


def cpu_time(one: Pushed) -> float:
    began = time.process_time()
    one.batch.run(one.rows)
    return time.process_time() - began


def errors(one: Pushed) -> tuple[float, float]:
    """Return those of final rates, rad/s, and of the final speed, m/s."""
    names = [f"final_rate_{axis}" for axis in "xyz"]
    names.append("longitudinal_speed_after_separation")
    rows = one.rows[:REFERENCE_ROWS]
    with DrakePool(one.batch.separation, Integration(accuracy=1e-10)) as pool:
        runs = pool.fly(variations(one.batch.names, rows))
    metrics = [metrics_of_run(run, (np.inf,) * 3) for run in runs]
    expected = np.array([[metric[name] for name in names] for metric in metrics])
    off = np.abs(one.batch.run(rows).metrics[names].to_numpy() - expected)
    return float(off[:, :3].max()), float(off[:, 3].max())


def with_springs(separation: Separation, count: int) -> Separation:
    """Return VEGA with its four springs shared out among more pads."""
    first = separation.attachments
    attachments = []
    for i in range(count):
        a = first[i % len(first)]
        angle = 2.0 * np.pi * i / count
        spring = dataclasses.replace(
            a.spring,
            name=f"spring_{i + 1}",
            force_max=4.0 * a.spring.force_max / count,
            design_mass=4.0 * a.spring.design_mass / count,
        )
        place = (0.0, 0.4685 * np.cos(angle), 0.4685 * np.sin(angle))
        attachments.append(
            dataclasses.replace(
                a, name=f"attachment_{i + 1}", p_AoPad_A=place, spring=spring
            )
        )
    return dataclasses.replace(separation, attachments=tuple(attachments))


def with_bodies(separation: Separation, count: int) -> Separation:
    """Return VEGA with more payloads, in a row, each pushed off by the one before."""
    payload = separation.body(separation.B)
    bodies, attachments = list(separation.bodies), list(separation.attachments)
    for i in range(count - 2):
        place = (5.0 * (i + 1), 0.0, 0.0)
        bodies.append(
            dataclasses.replace(payload, name=f"more_{i}", p_ABo=place, parts=())
        )
        a = separation.attachments[0]
        attachments.append(
            dataclasses.replace(
                a,
                name=f"more_attachment_{i}",
                A=bodies[-2].name if i else separation.B,
                B=bodies[-1].name,
                p_AoPad_A=(5.0, 0.0, 0.0),
                spring=dataclasses.replace(a.spring, name=f"more_spring_{i}"),
            )
        )
    return dataclasses.replace(
        separation, bodies=tuple(bodies), attachments=tuple(attachments)
    )


def print_growth(case, batch: Batch, rows: np.ndarray) -> None:
    print("\nrows at once    runs/s")
    for count in (1, 16, 128, 1024, 16_384):
        print(f"{count:12} {rate(batch, rows[:count]):9.0f}")
    for what, counts, make in (
        ("springs", (4, 8, 16), with_springs),
        ("bodies", (2, 3, 4), with_bodies),
    ):
        print(f"\n{what:12}    runs/s")
        for count in counts:
            separation = make(case.separation, count)
            nominal = parameters(separation)["payload.mass"]
            grown = Batch(separation, ["payload.mass"])
            masses = np.linspace(0.99 * nominal, 1.01 * nominal, 4096)
            print(f"{count:12} {rate(grown, masses[:, None]):9.0f}")


def print_start() -> None:
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"XDG_CACHE_HOME": cache}
        for state in ("cold", "warm"):
            seconds = _run(FIRST, environment)
            print(f"first result, {state}: {seconds:.1f} s")
        print(f"a million runs: {_run(MILLION, environment):.2f} GiB at most")


def _run(code: str, environment: dict[str, str]) -> float:
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    return float(done.stdout)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--springs", action="store_true", help="these alone")
    if parser.parse_args().springs:
        print_springs()
        return
    case = load_case("vega")
    box, tolerances = case.box, case.tolerance_set
    u = np.random.default_rng(0).uniform(-1.0, 1.0, size=(16_384, len(box)))
    rows = tolerances.rows(tolerances.draw_back(u))
    limits = deviation_limits(case.limits)
    batch = Batch(case.separation, box.names, deviation_limits=limits)
    one = Batch(case.separation, box.names, deviation_limits=limits, workers=1)
    with (
        DrakePool(case.separation, case.integration, workers=1) as single,
        DrakePool(case.separation, case.integration) as pool,
    ):
        engines = [
            Engine("Drake, one process", 40, drake(single, box.names)),
            Engine("Drake, all cores", 80, drake(pool, box.names)),
            Engine("batch, one worker", 4096, batched(one)),
            Engine("batch, all cores", 16_384, batched(batch)),
        ]
        for milliseconds in (20, 10, 2):
            fly = mujoco(case, rows[:64], 1e-3 * milliseconds)
            name = f"MuJoCo, two threads, steps of {milliseconds} ms"
            engines.append(Engine(name, 64, fly))
        table(rows, case, engines)
    print()
    print_springs()
    print_jacobian(batch, rows)
    print_growth(case, batch, rows)
    print()
    print_start()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"this benchmark: {peak:.2f} GiB at most")


if __name__ == "__main__":
    main()
