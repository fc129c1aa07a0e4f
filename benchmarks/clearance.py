"""What a clearance costs: one Drake query, one moment, one run; by pair and triangles.

    python benchmarks/clearance.py

Each pair of VEGA's parts, then a tube of more and more triangles around a capsule
that leaves it. Runs are compared with flying the same run in Drake, side by side in one
process, so that ratios hold on a machine whose speed drifts.
"""

import dataclasses
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

from drakesep import load_case
from drakesep.analysis import ClearanceAnalysis
from drakesep.systems import Simulation
from drakesep.systems.geometry.convex_pieces import pieces_of
from drakesep.systems.geometry.distance import Proximity
from drakesep.systems.geometry.relative_path import Pose
from drakesep.systems.model.parts import Capsule, Mesh, Part
from drakesep.systems.model.separation import Separation


ROUNDS = 3
SECTIONS = (12, 48, 192)


def main() -> None:
    case = load_case("vega")
    simulation = Simulation(case.separation, case.integration)
    run = simulation.run({})
    rows = [
        row(case.separation, pair, simulation, run)
        for pair in ClearanceAnalysis(case.separation).names
    ]
    print(pd.DataFrame(rows).to_string(index=False))
    with tempfile.TemporaryDirectory() as folder:
        rows = [tube_row(case, sections, Path(folder)) for sections in SECTIONS]
    print(pd.DataFrame(rows).to_string(index=False))


def tube_row(case, sections: int, folder: Path) -> dict:
    """The cost with a mesh that is not convex, around a part of the payload."""
    mesh = trimesh.creation.annulus(0.45, 0.5, 1.0, sections=sections)
    mesh.apply_transform(
        trimesh.transformations.rotation_matrix(1.5707963267948966, [0.0, 1.0, 0.0])
    )
    file = folder / f"tube_{sections}.stl"
    mesh.export(file)
    parts = {
        "launch_vehicle": Part(
            name="tube", shape=Mesh(file=file), p_BoGo_B=(-0.5, 0.0, 0.0)
        ),
        "payload": Part(
            name="plug", shape=Capsule(radius=0.2, length=0.4), p_BoGo_B=(-0.4, 0.1, 0)
        ),
    }
    separation = dataclasses.replace(
        case.separation,
        bodies=tuple(
            dataclasses.replace(body, parts=(parts[body.name],))
            for body in case.separation.bodies
        ),
    )
    simulation = Simulation(separation, case.integration)
    run = simulation.run({})
    return {
        "triangles": len(mesh.faces),
        **row(separation, ("tube", "plug"), simulation, run),
    }


def row(separation: Separation, pair, simulation: Simulation, run) -> dict:
    """The cost of one pair."""
    start = time.perf_counter()
    analysis = ClearanceAnalysis(separation, [pair])
    built = time.perf_counter() - start
    samples = run.completed_trajectory.time.size
    flown, whole, moments = [], [], []
    for _ in range(ROUNDS):
        flown.append(seconds(lambda: simulation.run({})))
        whole.append(seconds(lambda: analysis.of(run)))
        moments.append(seconds(lambda: analysis.over_time(run)) / samples)
    parts = {e.name: e for body in separation.bodies for e in body.parts}
    ratio = statistics.median(w / f for w, f in zip(whole, flown, strict=True))
    return {
        "pair": " to ".join(pair),
        "pieces": " x ".join(str(len(pieces_of(parts[name]))) for name in pair),
        "build (ms)": round(1e3 * built, 1),
        "query (us)": round(1e6 * query(separation, pair), 1),
        "moment (us)": round(1e6 * statistics.median(moments), 1),
        "smallest of a run (ms)": round(1e3 * statistics.median(whole), 1),
        "over its run in Drake": round(ratio, 2),
    }


def query(separation: Separation, pair) -> float:
    """Seconds of Drake's query between the roots of two parts."""
    parts = {e.name: e for body in separation.bodies for e in body.parts}
    first, second = (parts[name] for name in pair)
    proximity = Proximity([first], [second])
    p_AoBo_A, still = np.array([5.0, 0.0, 0.0]), np.zeros(3)
    pose = Pose(np.array([1.0, 0.0, 0.0, 0.0]), np.eye(3), p_AoBo_A, still, still)
    roots = proximity.roots[first.name], proximity.roots[second.name]
    return seconds(lambda: [proximity.measure(roots, pose) for _ in range(500)]) / 500


def seconds(work: Callable[[], object]) -> float:
    """Wall time of some work."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


if __name__ == "__main__":
    main()
