"""What one VEGA run costs, and which system costs what.

    python benchmarks/single_run.py

Times one evaluation of the time derivatives of the plant alone, with what acts added
one by one, and of whole diagrams, in turns within one process, so that the ratios hold
on a machine whose speed drifts; then whole runs.
"""

import statistics
import time

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder

from drakesep.case_file.reader import load_case
from drakesep.systems.diagram.force_sum import ForceSum
from drakesep.systems.diagram.gravity import Gravity
from drakesep.systems.diagram.joints import CfeBushing
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
SETTERS = {
    Release: Release.set_schedule,
    Springs: Springs.set_springs,
    CfeBushing: CfeBushing.set_joints,
    Gravity: Gravity.set_gravity,
}
FORCES = (Springs, CfeBushing, Gravity)
STAGES = ("plant alone", "+ springs", "+ joints", "+ gravity")


class Evaluation:
    """One evaluation of the time derivatives of a diagram."""

    def __init__(self, diagram: Diagram, context: Context):
        context.SetAccuracy(1e-6)
        self._diagram, self._context = diagram, context

    def advance(self, start: float) -> None:
        """Fly there: releases happen, and springs let go of their pads."""
        simulator = Simulator(self._diagram, self._context)
        simulator.AdvanceTo(start)
        simulator.AdvancePendingEvents()
        self._state = self._context.get_continuous_state_vector().CopyToVector()

    def evaluate(self, t: float) -> None:
        """Evaluate the derivatives at a time, at the state that was flown to."""
        self._context.SetTimeAndContinuousState(t, self._state)
        self._diagram.EvalTimeDerivatives(self._context)


def with_forces(separation: Separation, count: int, summed: bool = True) -> Evaluation:
    """Return how to evaluate the plant with the first of the force systems.

    Args:
        separation: to fly.
        count: of force systems.
        summed: whether they are evaluated at once, or each by itself.
    """
    builder = DiagramBuilder()
    plant = builder.AddSystem(plant_of_bodies(separation))
    plant.Finalize()
    layout = state_layout(plant, [body.name for body in separation.bodies])
    state = plant.get_state_output_port()
    release = builder.AddSystem(Release(separation, layout))
    builder.Connect(state, release.GetInputPort("plant_state"))
    forces = [builder.AddSystem(kind(separation, layout)) for kind in FORCES[:count]]
    for system in forces:
        builder.Connect(state, system.GetInputPort("plant_state"))
        if system.HasInputPort("released"):
            builder.Connect(release.get_output_port(), system.GetInputPort("released"))
    if forces:
        if summed:
            total = builder.AddSystem(ForceSum(layout, count))
            builder.Connect(state, total.GetInputPort("plant_state"))
            inputs = [total.GetInputPort(f"acting_{i}") for i in range(count)]
            wrenches = total.GetOutputPort("wrenches")
        else:
            total = builder.AddSystem(Adder(count, 6 * len(separation.bodies)))
            inputs = [total.get_input_port(i) for i in range(count)]
            wrenches = total.get_output_port()
        name = "acting" if summed else "wrenches"
        for system, port in zip(forces, inputs, strict=True):
            builder.Connect(system.GetOutputPort(name), port)
        builder.Connect(wrenches, plant.get_applied_generalized_force_input_port())
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    for system in (release, *forces):
        setter = SETTERS[type(system)]
        setter(system, system.GetMyMutableContextFromRoot(context), separation)
    set_mated_motion(plant, plant.GetMyMutableContextFromRoot(context), separation)
    return Evaluation(diagram, context)


def whole(separation: Separation, **options: bool) -> Evaluation:
    system = SeparationSystem(separation, **options)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    return Evaluation(system, context)


def time_in_turns(evaluators: dict[str, Evaluation], start: float) -> dict[str, list]:
    """Return the seconds of one evaluation, for each round."""
    for each in evaluators.values():
        each.advance(start)
    times = {name: [] for name in evaluators}
    for _ in range(ROUNDS):
        for name, each in evaluators.items():
            began = time.perf_counter()
            for i in range(EVALUATIONS):
                each.evaluate(start + 1e-6 * i)
            times[name].append((time.perf_counter() - began) / EVALUATIONS)
    return times


def main() -> None:
    case = load_case("vega")
    separation = case.separation
    evaluators = {name: with_forces(separation, i) for i, name in enumerate(STAGES)}
    evaluators["each by itself"] = with_forces(separation, len(FORCES), summed=False)
    evaluators["as Simulation flies it"] = whole(separation, motion_analysis=False)
    evaluators["SeparationSystem"] = whole(separation)
    for phase, start in (("push", 0.05), ("coast", 1.0)):
        times = time_in_turns(evaluators, start)
        print(f"one evaluation in the {phase}: median, and ratio to the plant alone")
        for name, values in times.items():
            pairs = zip(values, times[STAGES[0]], strict=True)
            ratio = statistics.median(a / b for a, b in pairs)
            print(
                f"  {name:22} {1e6 * statistics.median(values):6.1f} us  {ratio:5.2f}"
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
