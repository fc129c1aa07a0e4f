"""What holding the bodies costs, against Drake's bushing with the same gains.

    python benchmarks/attached_phase.py

VEGA before its release: the same bodies on the same joints, as a `SeparationSystem` and
as a plant with LinearBushingRollPitchYaw elements, which is C++ and does nothing else.
Both are flown in turns within one process, so that ratios hold on a machine whose speed
drifts. In orbit, ours computes gravity too. Then one evaluation of the time
derivatives, system by system.
"""

import dataclasses
import statistics
import time

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, LinearBushingRollPitchYaw
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, System
from single_run import STAGES, Evaluation, time_in_turns, whole, with_forces

from drakesep.case_file.reader import load_case
from drakesep.systems.diagram.separation_system import (
    SeparationSystem,
    set_mated_motion,
    spatial_inertia,
)
from drakesep.systems.model.separation import Separation


ACCURACY, FLOWN, ROUNDS = 1e-6, 1.0, 9
"""Of the integration, a step; seconds simulated; runs of each."""
RELEASE = 2.0 * FLOWN


def held_vega(attachments: int, with_orbit: bool) -> Separation:
    """Return VEGA, which does not let go while it is flown."""
    vega = load_case("vega").separation
    return dataclasses.replace(
        vega,
        attachments=tuple(
            dataclasses.replace(a, release_time=RELEASE)
            for a in vega.attachments[:attachments]
        ),
        orbit=vega.orbit if with_orbit else None,
        duration=2.0 * RELEASE,
    )


def on_drakes_bushings(separation: Separation) -> tuple[MultibodyPlant, Context]:
    """Return the bodies on Drake's bushings. Mated, VEGA's body frames coincide."""
    plant = MultibodyPlant(time_step=0.0)
    for body in separation.bodies:
        plant.AddRigidBody(body.name, spatial_inertia(body))
    for a in separation.attachments:
        X = RigidTransform(np.array(a.p_AoPad_A))
        on_A, on_B = (
            plant.AddFrame(
                FixedOffsetFrame(f"{a.name}_{name}", plant.GetFrameByName(name), X)
            )
            for name in (a.A, a.B)
        )
        gains = (a.joint.K_T, a.joint.D_T, a.joint.K_F, a.joint.D_F)
        plant.AddForceElement(
            LinearBushingRollPitchYaw(on_A, on_B, *(list(gain) for gain in gains))
        )
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    context = plant.CreateDefaultContext()
    set_mated_motion(plant, context, separation)
    return plant, context


def ours(separation: Separation) -> tuple[SeparationSystem, Context]:
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    return system, context


def fly(system: System, start: Context) -> tuple[float, int, int]:
    """Return the seconds that a run takes, its steps and its evaluations."""
    context = start.Clone()
    context.SetAccuracy(ACCURACY)
    simulator = Simulator(system, context)
    ApplySimulatorConfig(
        SimulatorConfig(integration_scheme="runge_kutta3", accuracy=ACCURACY), simulator
    )
    simulator.get_mutable_integrator().request_initial_step_size_target(1e-3)
    simulator.Initialize()
    began = time.perf_counter()
    simulator.AdvanceTo(FLOWN)
    seconds = time.perf_counter() - began
    integrator = simulator.get_integrator()
    return (
        seconds,
        integrator.get_num_steps_taken(),
        integrator.get_num_derivative_evaluations(),
    )


def compare_runs(name: str, separation: Separation) -> None:
    """Fly both in turns, and print a row for each."""
    systems = {
        "Drake's bushing": on_drakes_bushings(separation),
        "SeparationSystem": ours(separation),
    }
    runs = {of: [] for of in systems}
    for _ in range(ROUNDS):
        for of, (system, context) in systems.items():
            runs[of].append(fly(system, context))
    medians = {
        of: statistics.median(seconds for seconds, *_ in rows)
        for of, rows in runs.items()
    }
    for of, median in medians.items():
        _, steps, evaluations = runs[of][0]
        ratio = median / medians["Drake's bushing"]
        print(
            f"  {name:27} {of:17} {steps:6d} {evaluations:11d} "
            f"{1e3 * median / FLOWN:9.1f}  {ratio:5.2f}"
        )


def compare_evaluations(attachments: int) -> None:
    """Time one evaluation of the time derivatives of each, and of ours in stages."""
    separation = held_vega(attachments, with_orbit=True)
    evaluators = {"Drake's bushing": Evaluation(*on_drakes_bushings(separation))}
    evaluators |= {name: with_forces(separation, i) for i, name in enumerate(STAGES)}
    evaluators["SeparationSystem, orbit"] = whole(separation)
    evaluators["SeparationSystem"] = whole(held_vega(attachments, with_orbit=False))
    times = time_in_turns(evaluators, start=0.5)
    for name, values in times.items():
        pairs = zip(values, times["Drake's bushing"], strict=True)
        ratio = statistics.median(a / b for a, b in pairs)
        print(f"  {name:23} {1e6 * statistics.median(values):6.1f} us  {ratio:5.2f}")


def main() -> None:
    print("a simulated second: medians, and ratios to Drake's bushing")
    print(f"  {'case':27} {'system':17}  steps evaluations   ms / s  ratio")
    for attachments in (1, 4):
        for with_orbit in (False, True):
            name = f"{attachments} held, {'in' if with_orbit else 'without'} orbit"
            compare_runs(name, held_vega(attachments, with_orbit))
    for attachments in (1, 4):
        print(f"one evaluation with {attachments} held: median, and ratio to Drake's")
        compare_evaluations(attachments)


if __name__ == "__main__":
    main()
