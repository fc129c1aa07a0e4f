"""Joints by constraint forces against Drake's own joints, which do not give.

A joint held by springs gives by its load over its stiffness, so that its motion and its
load tend to those of the ideal joint as 1 / K.
"""

import dataclasses
import math

import numpy as np
import pytest
from flying import simulator_of, start
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    FixedOffsetFrame,
    PlanarJoint,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UniversalJoint,
    WeldJoint,
)
from separations import GENERIC, generic_pair

from drakesep.systems.diagram.separation_system import spatial_inertia
from drakesep.systems.model.joints import JOINT_TYPES, Joint


RATES = {
    "fixed": [],
    "revolute": [1.0],
    "universal": [0.7, -0.8],
    "spherical": [0.8, -0.5, 0.6],
    "prismatic": [0.7],
    "cylindrical": [0.9, 0.7],
    "planar": [0.5, -0.4, 0.8],
}
"""Of Drake's joint at the start, rad/s and m/s. In half a second the gimbal angles of
the ball and of the universal joint stay far from 90 deg."""
X_WA = RigidTransform(RollPitchYaw(np.array(GENERIC.rpy_WA)), np.zeros(3))
V_WA = SpatialVelocity([0.2, -0.3, 0.25], [0.1, 0.3, -0.2])
R_AJ = RotationMatrix(RollPitchYaw(0.6, -0.9, 1.3))
"""Axes of the joint: along none of a body's."""
MASS = 442.0
"""Of the pair, reduced, kg."""
ACCURACY = 1e-6
"""Of our flights, a step. They are better by far at a thousand steps a flight; even so
the least difference, 2e-7 in m and rad, is seen to be a tenth of the one before."""
STIFFNESSES = (1e6, 1e7, 1e8, 1e9)
LATE, RELEASE = (0.3, 0.4, 0.5), 0.6
"""The joint takes up its load in a transient, which is over by then: the softest one
is past exp(-10)."""


EXACT = 1e-10
"""Relative, of what a rigid joint does. Its rounds leave 1e-12, and round-off times its
stiffness to accelerations 1e-12 or so."""


def damping(K):
    return 2.0 * math.sqrt(K * MASS)


def jointed_pair(type, K):
    D = damping(K)
    joint = Joint(type=type, K_F=K, D_F=D, K_T=K, D_T=D, **axes_of_joint())
    return pair_on(joint)


def axes_of_joint():
    x, y = (tuple(R_AJ.col(i).tolist()) for i in (0, 1))
    return {"x_axis_A": x, "y_axis_A": y}


def pair_on(joint):
    """Two generic bodies, one askew, on one joint away from both CGs."""
    separation = generic_pair(release_times=(RELEASE,), joint=joint, springs=False)
    lower, upper = separation.bodies
    upper = dataclasses.replace(
        upper, p_ABo=(0.2, 0.03, -0.05), rpy_AB=(0.3, -0.2, 0.4)
    )
    return dataclasses.replace(separation, bodies=(lower, upper))


def make_drakes_joint(plant, type, on_A, on_B):
    x = [1.0, 0.0, 0.0]
    if type == "fixed":
        return WeldJoint("joint", on_A, on_B, RigidTransform())
    if type == "revolute":
        return RevoluteJoint("joint", on_A, on_B, x)
    if type == "universal":
        return UniversalJoint("joint", on_A, on_B)
    if type == "spherical":
        return BallRpyJoint("joint", on_A, on_B)
    if type == "prismatic":
        return PrismaticJoint("joint", on_A, on_B, x)
    if type == "cylindrical":
        between = plant.AddRigidBody("between", SpatialInertia.Zero()).body_frame()
        plant.AddJoint(RevoluteJoint("turning", on_A, between, x))
        return PrismaticJoint("joint", between, on_B, x)
    return PlanarJoint("joint", on_A, on_B)


def make_ideal_plant(separation):
    """Return the bodies on Drake's joint, as a plant, and the joint's place in B."""
    plant = MultibodyPlant(0.0)
    A, B = separation.bodies
    [attachment] = separation.attachments
    type = attachment.joint.type
    # Drake's planar joint turns about its z axis, ours about its x axis.
    R_AM = RotationMatrix(R_AJ.matrix()[:, [1, 2, 0]]) if type == "planar" else R_AJ
    X_AM = RigidTransform(R_AM, attachment.p_AoPad_A)
    X_AB = RigidTransform(RollPitchYaw(np.array(B.rpy_AB)), B.p_ABo)
    X_BM = X_AB.inverse() @ X_AM
    frames = []
    for body, X in ((A, X_AM), (B, X_BM)):
        frame = plant.AddRigidBody(body.name, spatial_inertia(body)).body_frame()
        frames.append(plant.AddFrame(FixedOffsetFrame(f"on_{body.name}", frame, X)))
    plant.AddJoint(make_drakes_joint(plant, type, *frames))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    return plant, X_BM


def fly(plant, context, simulator, get_load_W):
    """Return X_WA, X_AB, and the load on B at its pad in W, at the late times."""
    rows = []
    for t in LATE:
        simulator.AdvanceTo(t)
        X_WA, X_WB = (
            plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(name))
            for name in ("lower", "upper")
        )
        rows.append((X_WA, X_WA.inverse() @ X_WB, get_load_W(X_WA, X_WB)))
    return rows


def fly_ideal(separation):
    """Return the flight on Drake's joint, and the velocity of B at its start."""
    plant, X_BM = make_ideal_plant(separation)
    context = plant.CreateDefaultContext()
    lower = plant.GetBodyByName("lower")
    plant.SetFloatingBaseBodyPoseInWorldFrame(context, lower, X_WA)
    rates = RATES[separation.attachments[0].joint.type]
    plant.SetVelocities(context, np.concatenate([V_WA.get_coeffs(), rates]))
    upper = plant.GetBodyByName("upper")
    V_WB = plant.EvalBodySpatialVelocityInWorld(context, upper)
    index = int(plant.GetJointByName("joint").index())

    def get_load_W(X_WA, X_WB):
        load_M = plant.get_reaction_forces_output_port().Eval(context)[index]
        R_WM = (X_WB @ X_BM).rotation().matrix()
        return np.append(R_WM @ load_M.rotational(), R_WM @ load_M.translational())

    # Far below the least deviation, 1e-9 of the fixed joint.
    simulator = simulator_of(plant, context, 1e-11)
    return fly(plant, context, simulator, get_load_W), V_WB


def fly_ours(separation, V_WB):
    system, context, simulator = start(separation, ACCURACY)
    plant = system.plant
    plant_context = plant.GetMyMutableContextFromRoot(context)
    for name, V in (("lower", V_WA), ("upper", V_WB)):
        plant.SetFreeBodySpatialVelocity(plant_context, plant.GetBodyByName(name), V)

    def get_load_W(X_WA, X_WB):
        load_J = system.GetOutputPort("joint_loads").Eval(context)
        R_WJ = (X_WA.rotation() @ R_AJ).matrix()
        return np.append(R_WJ @ load_J[:3], R_WJ @ load_J[3:])

    return fly(plant, plant_context, simulator, get_load_W)


def motion_difference(got, expected):
    """Return how far the poses of A in W and of B in A are off, in m and rad."""
    parts = []
    for X, X_ideal in zip(got[:2], expected[:2], strict=True):
        off = X_ideal.inverse() @ X
        parts += [*off.translation(), off.rotation().ToAngleAxis().angle()]
    return np.linalg.norm(parts)


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_motion_tends_to_that_of_the_ideal_joint(type):
    """Ten times the stiffness, a tenth of the difference."""
    ideal, V_WB = fly_ideal(jointed_pair(type, K=1.0))
    differences = []
    for K in STIFFNESSES:
        flown = fly_ours(jointed_pair(type, K), V_WB)
        pairs = zip(flown, ideal, strict=True)
        differences.append(max(motion_difference(*pair) for pair in pairs))
    for i, K in enumerate(STIFFNESSES[:-1]):
        # The next term is the damper's: D / K, in s, by the rate at which the load
        # changes, of the order of 1 rad/s as the motion. It falls as 1 / sqrt(K).
        assert differences[i] / differences[i + 1] == pytest.approx(
            10.0, rel=damping(K) / K
        )


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_load_is_that_of_the_ideal_joint(type):
    """Force and torque on B at its pad against Drake's reaction."""
    K = 1e7
    separation = jointed_pair(type, K)
    ideal, V_WB = fly_ideal(separation)
    for ours, drakes in zip(fly_ours(separation, V_WB), ideal, strict=True):
        assert np.linalg.norm(drakes[2]) > 100.0
        # The damper makes a load of 0.13 of what the integrator may leave in the rates,
        # and the joint gives by 1e-4, at loads up to 1300 N.
        assert ours[2] == pytest.approx(
            drakes[2], abs=ACCURACY * damping(K) + 1e-4 * 1300.0
        )


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_rigid_joint_is_the_ideal_joint(type):
    """Accelerations of both bodies and the load, where the ideal flight comes by."""
    separation = pair_on(Joint(type=type, rigid=True, **axes_of_joint()))
    plant, X_BM = make_ideal_plant(separation)
    context = plant.CreateDefaultContext()
    lower, upper = (plant.GetBodyByName(name) for name in ("lower", "upper"))
    plant.SetFloatingBaseBodyPoseInWorldFrame(context, lower, X_WA)
    plant.SetVelocities(context, np.concatenate([V_WA.get_coeffs(), RATES[type]]))
    simulator_of(plant, context, 1e-11).AdvanceTo(LATE[0])

    system, ours, _ = start(separation, ACCURACY)
    own = system.plant.GetMyMutableContextFromRoot(ours)
    for body in (lower, upper):
        mine = system.plant.GetBodyByName(body.name())
        X = plant.EvalBodyPoseInWorld(context, body)
        V = plant.EvalBodySpatialVelocityInWorld(context, body)
        system.plant.SetFloatingBaseBodyPoseInWorldFrame(own, mine, X)
        system.plant.SetFreeBodySpatialVelocity(own, mine, V)

    accelerations = []
    for body in (lower, upper):
        expected = plant.EvalBodySpatialAccelerationInWorld(context, body).get_coeffs()
        mine = system.plant.GetBodyByName(body.name())
        got = system.plant.EvalBodySpatialAccelerationInWorld(own, mine).get_coeffs()
        accelerations.append((got, expected))
    got, expected = np.array(accelerations).transpose(1, 0, 2)
    assert np.abs(expected).max() > 0.05
    assert got == pytest.approx(expected, abs=EXACT * np.abs(expected).max())

    load_M = plant.get_reaction_forces_output_port().Eval(context)[
        int(plant.GetJointByName("joint").index())
    ]
    R_JM = (
        R_AJ.inverse()
        @ plant.EvalBodyPoseInWorld(context, lower).rotation().inverse()
        @ plant.EvalBodyPoseInWorld(context, upper).rotation()
        @ X_BM.rotation()
    ).matrix()
    expected = np.append(R_JM @ load_M.rotational(), R_JM @ load_M.translational())
    load = system.GetOutputPort("joint_loads").Eval(ours)
    assert load == pytest.approx(expected, abs=EXACT * np.abs(expected).max())


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_motion_on_a_rigid_joint_is_that_of_the_ideal_one(type):
    separation = pair_on(Joint(type=type, rigid=True, **axes_of_joint()))
    ideal, V_WB = fly_ideal(separation)
    for flown, expected in zip(fly_ours(separation, V_WB), ideal, strict=True):
        # What the integrator leaves in half a second, see ACCURACY.
        assert motion_difference(flown, expected) < 2e-7
