"""What stiff joints buy, and what they cost.

    python benchmarks/joint_gains.py [PICTURE]

VEGA's bodies turn and slide on one joint, held by constraint forces, and on Drake's own
joint, which does not give. Prints and draws, over the stiffness, how far B's CG is from
its place on Drake's joint, and what the run takes. Two minutes.

The error falls as 1 / K at either accuracy: integration is not what limits it. Stages
of an explicit step of length h leave the path of a moving joint by h^2, so that its
error control keeps K h^3, and steps go as K^(1/3); a joint at rest, or one at a coarse
accuracy, is held to the limit of stability, and steps go as K^(1/2).
"""

import dataclasses
import math
import sys
import time
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    FixedOffsetFrame,
    PrismaticJoint,
    RevoluteJoint,
    WeldJoint,
)
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, System

from drakesep.case_file.reader import load_case
from drakesep.systems.diagram.separation_system import SeparationSystem, spatial_inertia
from drakesep.systems.model.joints import Joint, JointType
from drakesep.systems.model.separation import InitialMotion, Separation


RATES: dict[JointType, list[float]] = {
    "revolute": [1.0],
    "spherical": [0.8, -0.5, 0.6],
    "prismatic": [1.0],
    "fixed": [],
}
"""Of the joint at the start, rad/s and m/s."""
RPY_WA = (0.5, -0.4, 1.1)
X_WA = RigidTransform(RollPitchYaw(np.array(RPY_WA)), np.zeros(3))
V_WA = SpatialVelocity([0.3, 0.2, -0.25], [0.1, 0.3, -0.2])
"""Faster than VEGA: the joint has something to hold."""
STYLES: dict[JointType, tuple[str, str]] = {
    "revolute": ("#0072B2", "o"),
    "spherical": ("#D55E00", "s"),
    "prismatic": ("#009E73", "^"),
    "fixed": ("#000000", "D"),
}
"""Colours that the colour-blind tell apart, and markers."""
STIFFNESSES = [10.0**i for i in range(3, 10)]
"""N/m, and as many N m/rad."""
DAMPING_RATIO = 0.7
ACCURACIES, ACCURACY_IDEAL = (1e-8, 1e-6), 1e-11
DURATION = 2.0
LATE = np.linspace(0.75, 1.0, 6) * DURATION
"""When the motion is compared: the joint has taken up its load."""


def jointed_vega(joint_type: JointType, K: float) -> Separation:
    """Return VEGA's bodies, held at the first of its four places."""
    vega = load_case("vega").separation
    mass = 1.0 / sum(1.0 / body.mass for body in vega.bodies)
    D = 2.0 * DAMPING_RATIO * math.sqrt(K * mass)
    attachment = dataclasses.replace(
        vega.attachments[0],
        joint=Joint(type=joint_type, K_F=K, D_F=D, K_T=K, D_T=D),
        spring=None,
        release_time=1.5 * DURATION,  # later than the run
    )
    return dataclasses.replace(
        vega,
        attachments=(attachment,),
        initial=InitialMotion(rpy_WA=RPY_WA),
        orbit=None,
        duration=2.0 * DURATION,
    )


def ideal_plant(separation: Separation) -> MultibodyPlant:
    """Return the bodies on Drake's joint. Mated, VEGA's body frames coincide."""
    plant = MultibodyPlant(time_step=0.0)
    [attachment] = separation.attachments
    X = RigidTransform(np.array(attachment.p_AoPad_A))
    on_A, on_B = (
        plant.AddFrame(
            FixedOffsetFrame(
                f"{body.name}_pad",
                plant.AddRigidBody(body.name, spatial_inertia(body)).body_frame(),
                X,
            )
        )
        for body in separation.bodies
    )
    joint_type = attachment.joint.type
    if joint_type == "fixed":
        joint = WeldJoint("joint", on_A, on_B, RigidTransform())
    elif joint_type == "spherical":
        joint = BallRpyJoint("joint", on_A, on_B)
    else:
        of_type = RevoluteJoint if joint_type == "revolute" else PrismaticJoint
        joint = of_type("joint", on_A, on_B, [1.0, 0.0, 0.0])
    plant.AddJoint(joint)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    return plant


def fly(
    separation: Separation,
    system: System,
    context: Context,
    plant: MultibodyPlant,
    accuracy: float,
) -> tuple[np.ndarray, int, float]:
    """Return B's CG as seen from A, at the late times, m; steps; and seconds taken."""
    context.SetAccuracy(accuracy)
    simulator = Simulator(system, context)
    ApplySimulatorConfig(
        SimulatorConfig(integration_scheme="runge_kutta3", accuracy=accuracy), simulator
    )
    # Drake's own first step is too long for the stiffest joints.
    simulator.get_mutable_integrator().request_initial_step_size_target(1e-5)
    plant_context = plant.GetMyContextFromRoot(context)
    p_BoBcm_B = np.array(separation.body(separation.B).p_BoBcm_B)
    began = time.perf_counter()
    places = []
    for t in LATE:
        simulator.AdvanceTo(t)
        X_WA, X_WB = (
            plant.EvalBodyPoseInWorld(plant_context, plant.GetBodyByName(name))
            for name in (separation.A, separation.B)
        )
        places.append(X_WA.inverse() @ X_WB @ p_BoBcm_B)
    seconds = time.perf_counter() - began
    return np.array(places), simulator.get_integrator().get_num_steps_taken(), seconds


def fly_ideal(joint_type: JointType) -> tuple[np.ndarray, SpatialVelocity]:
    """Return the places of B's CG on Drake's joint, and B's velocity at the start."""
    separation = jointed_vega(joint_type, K=0.0)
    plant = ideal_plant(separation)
    context = plant.CreateDefaultContext()
    A, B = (plant.GetBodyByName(name) for name in (separation.A, separation.B))
    plant.SetFloatingBaseBodyPoseInWorldFrame(context, A, X_WA)
    rates = RATES[joint_type]
    plant.SetVelocities(context, np.concatenate([V_WA.get_coeffs(), rates]))
    V_WB = plant.EvalBodySpatialVelocityInWorld(context, B)
    places, *_ = fly(separation, plant, context, plant, ACCURACY_IDEAL)
    return places, V_WB


class Result(NamedTuple):
    """Of one stiffness and accuracy."""

    error: float
    """Largest distance of B's CG from its place on Drake's joint, m."""
    steps: int
    seconds: float


def compare(
    joint_type: JointType,
    K: float,
    accuracy: float,
    ideal_places: np.ndarray,
    V_WB: SpatialVelocity,
) -> Result:
    """Fly on the joint by constraint forces, from the same start."""
    separation = jointed_vega(joint_type, K)
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    plant = system.plant
    plant_context = plant.GetMyMutableContextFromRoot(context)
    for name, V in ((separation.A, V_WA), (separation.B, V_WB)):
        plant.SetFreeBodySpatialVelocity(plant_context, plant.GetBodyByName(name), V)
    places, steps, seconds = fly(separation, system, context, plant, accuracy)
    error = float(np.linalg.norm(places - ideal_places, axis=1).max())
    return Result(error, steps, seconds)


def draw(results: dict[tuple[JointType, float], list[Result]], path: str) -> None:
    figure = Figure(figsize=(10, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for (joint_type, accuracy), rows in results.items():
        colour, marker = STYLES[joint_type]
        # Both accuracies give the same error: a ring around a dot.
        tight = accuracy == min(ACCURACIES)
        look = {
            "color": colour,
            "marker": marker,
            "ls": "-" if tight else "--",
            "markersize": 5 if tight else 9,
            "fillstyle": "full" if tight else "none",
        }
        label = joint_type if tight else None
        left.plot(STIFFNESSES, [row.error for row in rows], label=label, **look)
        right.plot(STIFFNESSES, [row.seconds for row in rows], **look)
    K = np.array(STIFFNESSES)
    left.plot(K, 5e3 / K, "k:", label="slope of 1 / K")
    right.plot([], [], "o-", color="grey", markersize=5, label="accuracy 1e-8")
    right.plot(
        [], [], "o--", color="grey", markersize=9, mfc="none", label="accuracy 1e-6"
    )
    right.plot(K, 0.04 * np.cbrt(K), "k:", label="slope of $K^{1/3}$")
    right.plot(K[-4:], 1e-5 * np.sqrt(K[-4:]), "k-.", label="slope of $K^{1/2}$")
    left.set(ylabel="largest error of B's CG (m)")
    right.set(ylabel=f"run time for {DURATION:g} s of flight (s)")
    for axes in (left, right):
        axes.set(xscale="log", yscale="log", xlabel="stiffness K (N/m and N m/rad)")
        axes.grid(alpha=0.3)
        axes.legend()
    figure.suptitle(
        "VEGA's bodies on one joint: by constraint forces against Drake's ideal joint"
    )
    figure.savefig(path, dpi=110)


def main() -> None:
    results: dict[tuple[JointType, float], list[Result]] = {}
    print("joint       accuracy   K (N/m)   error (m)     steps   run time (s)")
    for joint_type in RATES:
        ideal = fly_ideal(joint_type)
        for accuracy in ACCURACIES:
            rows = results[joint_type, accuracy] = []
            for K in STIFFNESSES:
                row = compare(joint_type, K, accuracy, *ideal)
                rows.append(row)
                print(
                    f"{joint_type:10} {accuracy:9.0e} {K:9.0e} "
                    f"{row.error:11.2e} {row.steps:9d} {row.seconds:14.2f}"
                )
    draw(results, sys.argv[1] if len(sys.argv) > 1 else "joint_gains.png")


if __name__ == "__main__":
    main()
