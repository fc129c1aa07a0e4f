"""From thrust to coast: a separation inside a larger simulation, under one Simulator.

    python examples/end_to_end.py [PICTURE]

An upper stage under thrust carries a payload on a dual-launch carrier. The engine shuts
down with a tail-off and attitude jets damp the rates; a guidance block waits until they
are within limits, commands the payload's release and, two seconds later, the carrier's.
The stage, its thrust and its control are the user's own: their plant, their forces,
their blocks. `add_separation` puts joints, springs, release and motion analysis beside
them.
"""

import dataclasses
import math
import sys

import numpy as np
from matplotlib.figure import Figure
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce, SpatialVelocity
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder, EventStatus, LeafSystem
from pydrake.systems.primitives import LogVectorOutput

from drakesep.systems import (
    Attachment,
    DisplacementSpring,
    Separation,
    add_separation,
    body_of_plant,
    propose_joint,
)


SHUTDOWN, TAIL_OFF = 1.0, 0.3
"""When the engine is shut down, and the time constant of what it gives after, s."""
THRUST = np.array([2450.0, 10.0, -8.0])
"""In the stage's axes, N; misaligned by a quarter of a degree."""
NOZZLE = np.array([-1.7, 0.0, 0.0])
"""Where it acts, m."""
DAMPING, JET_MAX = 6000.0, 60.0
"""Of the attitude jets: torque over rate, N m s, and the largest torque, N m."""
RATE_LIMIT = math.radians(0.15)
"""Of each axis of the stage, for the payload's release, rad/s."""
SETTLED, STAGING = 0.5, 2.0
"""How long the rates must be within limits, and the time between releases, s."""
END = 8.0


def users_plant(builder: DiagramBuilder) -> MultibodyPlant:
    """Return a plant with the stage, the carrier and the payload, free in space."""
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    for name, mass, radius, length, centre in (
        ("stage", 1350.0, 0.95, 1.7, (-0.85, 0.01, 0.0)),
        ("carrier", 112.0, 0.8, 2.0, (1.0, 0.0, 0.0)),
        ("payload", 1000.0, 0.7, 2.2, (1.1, 0.004, -0.006)),
    ):
        solid = SpatialInertia.SolidCylinderWithMass(mass, radius, length, [1, 0, 0])
        plant.AddRigidBody(name, solid.Shift(-np.array(centre)))
    plant.Finalize()
    return plant


def make_separation(plant: MultibodyPlant) -> Separation:
    """Return the separation of the plant's three bodies: two planes, four pads each."""
    bodies = {
        name: dataclasses.replace(
            body_of_plant(plant, plant.GetBodyByName(name)), p_ABo=(x, 0.0, 0.0)
        )
        for name, x in (("stage", 0.0), ("carrier", 0.0), ("payload", 2.0))
    }
    attachments = []
    for A, B, x, radius, force, stroke in (
        ("carrier", "payload", 2.0, 0.47, 600.0, 0.09),
        ("stage", "carrier", 0.0, 0.85, 150.0, 0.06),
    ):
        for i, angle in enumerate(np.radians([45.0, 135.0, 225.0, 315.0]), start=1):
            pad = (x, radius * math.cos(angle), radius * math.sin(angle))
            joint = propose_joint(
                bodies[A],
                bodies[B],
                pad,
                force=700.0,
                torque=100.0,
                deviation=1e-3,
                rotation=1e-3,
            )
            spring = DisplacementSpring(
                name=f"{B}_spring_{i}",
                force_max=force * (1.0 + 0.01 * i),
                stroke=stroke,
            )
            attachments.append(
                Attachment(
                    name=f"{B}_pad_{i}",
                    A=A,
                    B=B,
                    p_AoPad_A=pad,
                    joint=joint,
                    spring=spring,
                )
            )
    return Separation(
        bodies=tuple(bodies.values()),
        attachments=tuple(attachments),
        A="stage",
        B="payload",
        duration=END,
    )


class Propulsion(LeafSystem):
    """Engine and attitude jets of the stage.

    Input ports: the plant's poses and velocities. Output port: a list with the force.
    """

    def __init__(self, plant: MultibodyPlant):
        super().__init__()
        self._stage = plant.GetBodyByName("stage").index()
        self._poses = self.DeclareAbstractInputPort(
            "poses", AbstractValue.Make([RigidTransform()])
        )
        self._velocities = self.DeclareAbstractInputPort(
            "velocities", AbstractValue.Make([SpatialVelocity()])
        )
        forces = AbstractValue.Make([ExternallyAppliedSpatialForce()])
        self.DeclareAbstractOutputPort("forces", forces.Clone, self._calc_forces)

    def _calc_forces(self, context, output):
        R_WA = self._poses.Eval(context)[int(self._stage)].rotation()
        w_W = self._velocities.Eval(context)[int(self._stage)].rotational()
        jets = np.clip(-DAMPING * (R_WA.inverse() @ w_W), -JET_MAX, JET_MAX)
        force = ExternallyAppliedSpatialForce()
        force.body_index = self._stage
        force.p_BoBq_B = NOZZLE
        force.F_Bq_W = SpatialForce(
            tau=R_WA @ jets, f=R_WA @ (thrust_level(context.get_time()) * THRUST)
        )
        output.set_value([force])


def thrust_level(t: float) -> float:
    """Return the share of the thrust at a time, s."""
    return 1.0 if t < SHUTDOWN else math.exp(-(t - SHUTDOWN) / TAIL_OFF)


class Guidance(LeafSystem):
    """Commands the releases, twenty times a second.

    Input port: the plant's velocities. Output port: a trigger for each of eight pads.
    """

    def __init__(self, plant: MultibodyPlant):
        super().__init__()
        self._stage = int(plant.GetBodyByName("stage").index())
        self._velocities = self.DeclareAbstractInputPort(
            "velocities", AbstractValue.Make([SpatialVelocity()])
        )
        # When the rates last were beyond limits, and when the payload was let go, s.
        self._memory = self.DeclareDiscreteState([0.0, math.inf])
        self._triggers = self.DeclareDiscreteState(8)
        self.DeclareStateOutputPort("triggers", self._triggers)
        self.DeclarePeriodicDiscreteUpdateEvent(0.05, 0.0, self._decide)

    def _decide(self, context, update):
        now = context.get_time()
        beyond_limits_at, released = context.get_discrete_state(self._memory).value()
        rate = np.abs(self._velocities.Eval(context)[self._stage].rotational()).max()
        if rate > RATE_LIMIT or now < SHUTDOWN:
            beyond_limits_at = now
        if math.isinf(released) and now - beyond_limits_at >= SETTLED:
            released = now
        update.set_value(self._memory, [beyond_limits_at, released])
        payload, carrier = now >= released, now >= released + STAGING
        update.set_value(self._triggers, [payload] * 4 + [carrier] * 4)
        return EventStatus.Succeeded()


def main() -> None:
    """Build, fly, print and draw."""
    builder = DiagramBuilder()
    plant = users_plant(builder)
    separation = make_separation(plant)
    propulsion = builder.AddSystem(Propulsion(plant))
    guidance = builder.AddSystem(Guidance(plant))
    velocities = plant.get_body_spatial_velocities_output_port()
    poses = plant.get_body_poses_output_port()
    builder.Connect(poses, propulsion.GetInputPort("poses"))
    builder.Connect(velocities, propulsion.GetInputPort("velocities"))
    builder.Connect(velocities, guidance.get_input_port())
    forces = add_separation(
        builder, plant, separation, other_forces=propulsion.get_output_port()
    )
    builder.Connect(guidance.get_output_port(), forces.GetInputPort("triggers"))
    logs = {
        name: LogVectorOutput(forces.GetOutputPort(name), builder, 0.02)
        for name in ("rate", "relative_rate", "relative_velocity", "joint_loads")
    }
    diagram = builder.Build()

    context = diagram.CreateDefaultContext()
    inner = forces.GetMyMutableContextFromRoot(context)
    forces.set_separation(inner, separation)
    start(plant, plant.GetMyMutableContextFromRoot(context), separation)
    context.SetAccuracy(1e-6)
    simulator = Simulator(diagram, context)
    ApplySimulatorConfig(SimulatorConfig(accuracy=1e-6, max_step_size=0.05), simulator)
    simulator.get_mutable_integrator().request_initial_step_size_target(1e-3)
    simulator.AdvanceTo(END)

    released = forces.GetOutputPort("released").Eval(inner)
    found = {name: log.FindLog(context) for name, log in logs.items()}
    report(released, found)
    draw(released, found, sys.argv[1] if len(sys.argv) > 1 else "end_to_end.png")


def start(plant: MultibodyPlant, context, separation: Separation) -> None:
    """Set the stack off as one body, turning, in a generic attitude."""
    R_WA = RollPitchYaw(0.4, -0.3, 0.8).ToRotationMatrix()
    w_W = R_WA @ np.radians([0.6, -0.5, 0.4])
    for body in separation.bodies:
        link = plant.GetBodyByName(body.name)
        p_WBo = R_WA @ np.array(body.p_ABo)
        pose = RigidTransform(R_WA, p_WBo)
        plant.SetFloatingBaseBodyPoseInWorldFrame(context, link, pose)
        velocity = SpatialVelocity(w_W, np.cross(w_W, p_WBo))
        plant.SetFreeBodySpatialVelocity(context, link, velocity)


def report(released: np.ndarray, logs: dict) -> None:
    """Print what happened when."""
    times = logs["rate"].sample_times()
    rows = [
        ("engine shut down", SHUTDOWN),
        ("payload released", released[0]),
        ("carrier released", released[4]),
        ("end", END),
    ]
    print(
        "event               time (s)   payload rate (deg/s)    speed from stage (m/s)"
    )
    for event, t in rows:
        i = min(np.searchsorted(times, t), len(times) - 1)
        rate = np.degrees(logs["rate"].data()[:, i])
        speed = logs["relative_velocity"].data()[0, i]
        rates = " ".join(f"{r:6.3f}" for r in rate)
        print(f"{event:18} {t:9.3f}   {rates}    {speed:8.3f}")


def draw(released: np.ndarray, logs: dict, picture: str) -> None:
    """Draw rates, speed and what the joints at the payload carry."""
    times = logs["rate"].sample_times()
    loads = logs["joint_loads"].data().reshape(8, 6, -1)
    figure = Figure(figsize=(9, 8), layout="constrained")
    rates, speed, force = figure.subplots(3, 1, sharex=True)
    for i, axis in enumerate("xyz"):
        rates.plot(times, np.degrees(logs["rate"].data()[i]), label=axis)
    rates.set(ylabel="payload rate (deg/s)")
    rates.legend(loc="upper right", ncols=3)
    speed.plot(times, logs["relative_velocity"].data()[0], "k")
    speed.set(ylabel="payload from stage,\nalong its x axis (m/s)")
    for plane, pads in (("payload", slice(0, 4)), ("carrier", slice(4, 8))):
        total = np.linalg.norm(loads[pads, 3:].sum(axis=0), axis=0)
        force.plot(times, total, label=f"under the {plane}")
    force.set(xlabel="time (s)", ylabel="force of the joints (N)")
    force.legend(loc="upper right")
    for axes in (rates, speed, force):
        axes.grid(alpha=0.3)
        for t, label in (
            (SHUTDOWN, "shutdown"),
            (released[0], "payload"),
            (released[4], "carrier"),
        ):
            axes.axvline(t, color="#555555", ls=":", lw=1.0)
            if axes is rates:
                axes.annotate(
                    label,
                    (t, 1.0),
                    xycoords=("data", "axes fraction"),
                    xytext=(3, -12),
                    textcoords="offset points",
                )
    figure.suptitle("Shutdown, wait for quiet rates, payload release, carrier release")
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main()
