"""What joints that hold cost: rigid, and as springs of some stiffness.

    python benchmarks/rigid_joints.py

The built-in cases of staged releases, in the batch engine and in Drake, in turns with
VEGA on springs by time within one process, so that ratios hold on a machine whose speed
drifts; medians. Errors are the largest of the final rates of the first body that
leaves, against Drake at an accuracy of 1e-10 on the same joints.
"""

import dataclasses
import statistics
import time

import numpy as np

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.case_file.reader import load_case
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.separation import Separation
from drakesep.systems.simulation.simulation import Simulation


ROWS, ROUNDS = 1024, 5
STIFF = Joint(K_F=1e6, D_F=8e3, K_T=2e5, D_T=1.6e3)


def stiff(separation: Separation) -> Separation:
    """Return it on springs in the place of rigid joints."""
    attachments = [
        dataclasses.replace(
            attachment,
            joint=dataclasses.replace(
                STIFF,
                type=attachment.joint.type,
                x_axis_A=attachment.joint.x_axis_A,
                y_axis_A=attachment.joint.y_axis_A,
            ),
        )
        for attachment in separation.attachments
    ]
    return dataclasses.replace(separation, attachments=tuple(attachments))


def rows_of(case: AnalysisCase, count: int) -> np.ndarray:
    u = np.random.default_rng(0).uniform(-0.3, 0.3, size=(count, len(case.box)))
    rows: np.ndarray = case.box.nominal + case.box.tolerance * u
    return rows


def seconds(work, *arguments: object) -> float:
    began = time.perf_counter()
    work(*arguments)
    return time.perf_counter() - began


def report(name: str, case: AnalysisCase, separation: Separation, rows: int) -> None:
    """Print a line on one kind of joints of a case."""
    vega = load_case("vega")
    batches = [
        (Batch(vega.separation, vega.box.names), rows_of(vega, ROWS)),
        (Batch(separation, case.box.names), rows_of(case, rows)),
    ]
    simulations = [Simulation(vega.separation), Simulation(separation)]
    began = time.perf_counter()
    result = batches[1][0].run(batches[1][1])
    first = time.perf_counter() - began
    batches[0][0].run(batches[0][1])
    ratios, drakes = [], []
    for _ in range(ROUNDS):
        of_vega, own = (seconds(b.run, values) / len(values) for b, values in batches)
        ratios.append(of_vega / own)
        drakes.append([seconds(simulation.run) for simulation in simulations])
    values = dict(zip(case.box.names, batches[1][1][0].tolist(), strict=True))
    exact = Simulation(separation, Integration(accuracy=1e-10)).run(values)
    got = result.metrics[[f"final_rate_{axis}" for axis in "xyz"]].iloc[0]
    error = np.abs(got - exact.completed_motion.rate[-1]).max()
    vega_run, run = (statistics.median(each) for each in zip(*drakes, strict=True))
    print(
        f"{name:24} {statistics.median(ratios):8.4f} {np.mean(result.steps):7.1f} "
        f"{first:8.1f} {error:9.1e} {1e3 * run:9.1f} {run / vega_run:7.1f}"
    )


def main() -> None:
    print("batch: runs a second over VEGA's, steps a row, s until the first result,")
    print("error in rad/s; Drake: ms a run, and over VEGA's")
    for name in ("dual_launch", "fairing", "rideshare"):
        case = load_case(name)
        for kind, separation, rows in (
            ("rigid", case.separation, ROWS),
            ("1e6 N/m", stiff(case.separation), 32),
        ):
            report(f"{name}, {kind}", case, separation, rows)


if __name__ == "__main__":
    main()
