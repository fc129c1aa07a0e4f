"""What one VEGA run costs, and which system costs what.

    python benchmarks/single_run.py

Times one evaluation of the time derivatives of the plant alone and with each
LeafSystem added, in turns within one process, so that the ratios hold on a machine
whose speed drifts; then whole runs.
"""

import statistics
import time
from collections.abc import Callable

from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Adder

from drakesep.case_file.reader import load_case
from drakesep.systems.diagram.gravity import Gravity
from drakesep.systems.diagram.joints import CfeBushing
from drakesep.systems.diagram.motion_analysis import MotionAnalysis
from drakesep.systems.diagram.release import Release
from drakesep.systems.diagram.separation_system import (
    SeparationSystem,
    plant_of_bodies,
    set_mated_motion,
)
from drakesep.systems.diagram.springs import Springs
from drakesep.systems.diagram.state_layout import state_layout
from drakesep.systems.model.separation import Separation
from drakesep.systems.simulation.simulation import Simulation


ROUNDS, EVALUATIONS = 60, 60
STAGES = ("plant alone", "+ springs", "+ joints", "+ gravity", "+ motion analysis")


def with_systems(separation: Separation, count: int) -> tuple[Callable, Context]:
    """Return how to evaluate the plant with the first `count` systems."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(plant_of_bodies(separation))
    plant.Finalize()
    names = [body.name for body in separation.bodies]
    layout = state_layout(plant, names)
    state = plant.get_state_output_port()
    setters = []

    def add(system: LeafSystem, setter: Callable) -> LeafSystem:
        builder.AddSystem(system)
        setters.append((system, setter))
        return system

    if count:
        release = Release(separation, layout)
        add(release, release.set_schedule)
        builder.Connect(state, release.GetInputPort("plant_state"))
    forces = []
    if count >= 1:
        springs = Springs(separation, layout)
        forces.append(add(springs, springs.set_springs))
    if count >= 2:
        bushing = CfeBushing(separation, layout)
        forces.append(add(bushing, bushing.set_joints))
    if count >= 3:
        gravity = Gravity(separation, layout)
        forces.append(add(gravity, gravity.set_gravity))
    if forces:
        total = builder.AddSystem(Adder(len(forces), 6 * len(names)))
        builder.Connect(
            total.get_output_port(), plant.get_applied_generalized_force_input_port()
        )
    for i, system in enumerate(forces):
        builder.Connect(state, system.GetInputPort("plant_state"))
        builder.Connect(system.GetOutputPort("wrenches"), total.get_input_port(i))
        if system.HasInputPort("released"):
            builder.Connect(release.get_output_port(), system.GetInputPort("released"))
    if count >= 4:
        motion = MotionAnalysis(separation, layout)
        add(motion, motion.set_measured)
        for port, source in {
            "plant_state": state,
            "plant_acceleration": plant.get_generalized_acceleration_output_port(),
            "spring_wrenches": springs.GetOutputPort("wrenches"),
        }.items():
            builder.Connect(source, motion.GetInputPort(port))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    for system, setter in setters:
        setter(system.GetMyMutableContextFromRoot(context), separation)
    set_mated_motion(plant, plant.GetMyMutableContextFromRoot(context), separation)
    return _evaluator(diagram, context), context


def whole(separation: Separation) -> tuple[Callable, Context]:
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    return _evaluator(system, context), context


def _evaluator(diagram, context) -> Callable:
    # As the simulator's start does: releases that are due happen.
    context.SetAccuracy(1e-6)
    diagram.ExecuteInitializationEvents(context)
    x = context.get_continuous_state_vector().CopyToVector()

    def evaluate(t: float) -> None:
        context.SetTimeAndContinuousState(t, x)
        diagram.EvalTimeDerivatives(context)

    return evaluate


def time_in_turns(evaluators: dict[str, Callable], start: float) -> dict[str, list]:
    """Return the seconds of one evaluation, for each round."""
    times = {name: [] for name in evaluators}
    for _ in range(ROUNDS):
        for name, evaluate in evaluators.items():
            began = time.perf_counter()
            for i in range(EVALUATIONS):
                evaluate(start + 1e-6 * i)
            times[name].append((time.perf_counter() - began) / EVALUATIONS)
    return times


def main() -> None:
    case = load_case("vega")
    separation = case.separation
    evaluators = {name: with_systems(separation, i)[0] for i, name in enumerate(STAGES)}
    evaluators["SeparationSystem"] = whole(separation)[0]
    for phase, start in (("push", 0.05), ("coast", 1.0)):
        times = time_in_turns(evaluators, start)
        print(f"one evaluation in the {phase}: median, and ratio to the plant alone")
        for name, values in times.items():
            pairs = zip(values, times[STAGES[0]], strict=True)
            ratio = statistics.median(a / b for a, b in pairs)
            print(
                f"  {name:18} {1e6 * statistics.median(values):6.1f} us  {ratio:5.2f}"
            )

    simulation = Simulation(separation, case.integration)
    simulation.run()
    walls = []
    for _ in range(40):
        began = time.perf_counter()
        run = simulation.run()
        walls.append(time.perf_counter() - began)
    print(
        f"one run: {run.steps} steps, {run.evaluations} evaluations, "
        f"{1e3 * statistics.median(walls):.1f} ms (median of {len(walls)})"
    )


if __name__ == "__main__":
    main()
