"""Diagrams under a plain Simulator, as somebody else would fly them."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, Diagram

from drakesep.systems.diagram.separation_system import SeparationSystem, plant_of_bodies
from drakesep.systems.model.separation import Separation


def start(
    separation: Separation, accuracy: float, **options: bool
) -> tuple[SeparationSystem, Context, Simulator]:
    """The diagram of a separation, its Context, and a simulator at its start."""
    system = SeparationSystem(separation, **options)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    return system, context, simulator_of(system, context, accuracy)


def simulator_of(diagram: Diagram, context: Context, accuracy: float) -> Simulator:
    context.SetAccuracy(accuracy)
    simulator = Simulator(diagram, context)
    config = SimulatorConfig(
        integration_scheme="runge_kutta3",
        accuracy=accuracy,
        start_time=context.get_time(),
    )
    ApplySimulatorConfig(config, simulator)
    simulator.get_mutable_integrator().request_initial_step_size_target(1e-4)
    return simulator


def momentum(system: SeparationSystem, context: Context) -> np.ndarray:
    """Linear and angular momentum of all bodies about W's origin, (6,)."""
    plant = system.plant
    total = plant.CalcSpatialMomentumInWorldAboutPoint(
        plant.GetMyContextFromRoot(context), np.zeros(3)
    )
    return np.append(total.translational(), total.rotational())


def plant_of(separation: Separation) -> MultibodyPlant:
    """The finalized plant of a separation's bodies, free in W."""
    plant = plant_of_bodies(separation)
    plant.Finalize()
    return plant
