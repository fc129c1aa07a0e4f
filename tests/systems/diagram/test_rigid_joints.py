"""Rigid joints in Drake: conservation, loads, loops, and what is refused."""

import dataclasses
import math

import numpy as np
import pinocchio
import pytest
from flying import momentum, start
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw
from separations import generic_pair

from drakesep.systems.checks import InputError
from drakesep.systems.equations.loads_of_run import joint_loads
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import JOINT_TYPES, Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parts import Part, Sphere
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.model.separation import Attachment, Body
from drakesep.systems.simulation.simulation import Simulation


RIGID = Joint(rigid=True)
PUSH = Load(
    name="push",
    body="upper",
    p_BoQ_B=(0.5, 0.2, -0.1),
    times=(0.0, 2.0),
    forces=((300.0, -200.0, 100.0), (300.0, -200.0, 100.0)),
    torques=((20.0, 30.0, -40.0), (20.0, 30.0, -40.0)),
)
RATIO = 1e-10
"""What rounds and round-off leave, see `test_joints_against_drake`."""


def staged(joint=RIGID, releases=(0.1, 0.2, 0.3, 0.4), **changes):
    pair = generic_pair(release_times=releases, joint=joint, duration=0.8)
    return dataclasses.replace(pair, loads=(PUSH,), **changes)


def moving_loads(system, context):
    """Loads of joints, less what springs press with, which moves nothing."""
    loads, preloads = (
        system.GetOutputPort(name).Eval(context) for name in ("joint_loads", "preloads")
    )
    return loads - preloads


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_nothing_is_lost_to_joints(type):
    """Linear and angular momentum, from before the releases to after the push."""
    separation = dataclasses.replace(staged(Joint(type=type, rigid=True)), loads=())
    system, context, simulator = start(separation, 1e-8)
    before = momentum(system, context)
    for t in (0.05, 0.25, 0.8):
        simulator.AdvanceTo(t)
        # Round-off of a thousand steps; quaternions are off by what steps may be.
        assert momentum(system, context) == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_joints_do_no_work(type):
    """The energy that springs and load have given is the bodies' own, while held.

    Nothing but the load acts then. Its power is that of a force at a point.
    """
    separation = staged(Joint(type=type, rigid=True), (0.5,) * 4)
    system, context, simulator = start(separation, 1e-8)
    plant = system.plant
    own = plant.GetMyContextFromRoot(context)
    upper = plant.GetBodyByName("upper")

    def energy_and_power():
        X, V = upper.EvalPoseInWorld(own), upper.EvalSpatialVelocityInWorld(own)
        R = X.rotation().matrix()
        force, torque = R @ PUSH.forces[0], R @ PUSH.torques[0]
        at = V.Shift(R @ np.array(PUSH.p_BoQ_B))
        power = force @ at.translational() + torque @ at.rotational()
        return plant.CalcKineticEnergy(own), power

    times, values = np.linspace(0.0, 0.4, 81), []
    for t in times:
        simulator.AdvanceTo(t)
        values.append(energy_and_power())
    energy, power = np.array(values).T
    h = times[1]
    weights = np.array([1.0, *([4.0, 2.0] * 40)[:-1], 1.0]) * h / 3.0  # Simpson
    assert energy[-1] - energy[0] == pytest.approx(weights @ power, rel=1e-6)
    assert system.GetOutputPort("joint_energy").Eval(context) == [0.0]


def test_loads_of_a_run_are_those_of_the_port():
    """From the motion alone, at times while all, some and none hold."""
    separation = staged()
    run = Simulation(separation, Integration(accuracy=1e-9)).run()
    loads, time = joint_loads(run), run.completed_trajectory.time
    system, context, simulator = start(separation, 1e-9)
    for t in (0.05, 0.15, 0.35, 0.5):
        simulator.AdvanceTo(t)
        port = system.GetOutputPort("joint_loads").Eval(context).reshape(-1, 6)
        for name, expected in zip(loads, port, strict=True):
            got = [np.interp(t, time, column) for column in loads[name].T]
            # Straight lines between samples a hundredth of the run apart.
            assert got == pytest.approx(expected, abs=1e-3 * (1.0 + np.abs(port).max()))


def test_load_of_a_weld_is_newtons_and_eulers():
    """Before any release: what it takes to move the upper body with the stack."""
    separation = staged()
    system, context, simulator = start(separation, 1e-8)
    simulator.AdvanceTo(0.05)
    plant, own = system.plant, system.plant.GetMyContextFromRoot(context)
    lower, upper = (plant.GetBodyByName(name) for name in ("lower", "upper"))
    loads = moving_loads(system, context).reshape(-1, 6)
    R_WA = lower.EvalPoseInWorld(own).rotation().matrix()
    force = R_WA @ loads[:, 3:].sum(axis=0)
    A = upper.EvalSpatialAccelerationInWorld(own)
    X = upper.EvalPoseInWorld(own)
    w = upper.EvalSpatialVelocityInWorld(own).rotational()
    r = X.rotation().matrix() @ np.array(separation.bodies[1].p_BoBcm_B)
    a = A.translational() + np.cross(A.rotational(), r) + np.cross(w, np.cross(w, r))
    push = X.rotation().matrix() @ PUSH.forces[0]
    expected = separation.bodies[1].mass * a - push
    assert force == pytest.approx(expected, abs=RATIO * np.abs(push).max() * 10.0)


def test_pads_share_a_load_as_equal_springs():
    """As 1 / K: the loads of four penalty joints of the same stiffness tend to it."""
    separation = staged(releases=(0.5,) * 4)
    late, late_context, late_simulator = start(separation, 1e-8)
    late_simulator.AdvanceTo(0.45)
    rigid = moving_loads(late, late_context)
    arm2 = (0.1 * 0.5) ** 2
    """Square of a tenth of the radius of the pads' circle."""
    errors = []
    for K in (1e5, 1e6):
        D = 2.0 * math.sqrt(K * 442.0)
        soft = Joint(K_F=K, D_F=D, K_T=K * arm2, D_T=D * arm2)
        system, context, simulator = start(staged(soft, (0.5,) * 4), 1e-8)
        simulator.AdvanceTo(0.45)  # the transient is over
        loads = moving_loads(system, context)
        errors.append(np.abs(loads - rigid).max())
    # A stiffer joint's load is lost in what the integrator leaves, times its damping.
    assert errors[1] < 1e-4 * np.abs(rigid).max()
    assert errors[1] < 0.2 * errors[0]


def test_a_loop_of_bodies_is_pinocchios():
    """Three bodies: A welded to B, B on a ball to C, C on a ball to A."""
    separation = loop()
    system, context, simulator = start(separation, 1e-8)
    simulator.AdvanceTo(0.05)
    plant, own = system.plant, system.plant.GetMyContextFromRoot(context)
    expected = pinocchios_accelerations(system, context, separation)
    scale = max(np.abs(a).max() for a in expected)
    for body, a in zip(separation.bodies, expected, strict=True):
        got = plant.GetBodyByName(body.name).EvalSpatialAccelerationInWorld(own)
        # Pinocchio's proximal solver is at 1e-10 itself.
        assert got.get_coeffs() == pytest.approx(a, abs=1e-8 * scale)


def loop():
    pair = staged(releases=(0.5,))
    third = Body(
        name="third",
        mass=300.0,
        p_BoBcm_B=(0.2, 0.1, 0.3),
        I_BBcm_B=(60.0, 70.0, 80.0, 3.0, -4.0, 5.0),
        p_ABo=(0.5, 1.0, 0.4),
        rpy_AB=(0.3, -0.4, 0.5),
    )
    ball = Joint(type="spherical", rigid=True)
    more = (
        Attachment(
            name="ball_1",
            A="upper",
            B="third",
            p_AoPad_A=(0.7, 0.6, 0.3),
            joint=ball,
            release_time=0.5,
        ),
        Attachment(
            name="ball_2",
            A="third",
            B="lower",
            p_AoPad_A=(-0.4, -0.5, -0.3),
            joint=ball,
            release_time=0.5,
        ),
    )
    return dataclasses.replace(
        pair,
        bodies=(*pair.bodies, third),
        attachments=(*pair.attachments, *more),
    )


def pinocchios_accelerations(system, context, separation):
    """Spatial accelerations in W of each body, as Drake gives them."""
    plant, own = system.plant, system.plant.GetMyContextFromRoot(context)
    model, q, v, tau = pinocchio.Model(), [], [], []
    for body in separation.bodies:
        joint = model.addJoint(
            0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), body.name
        )
        xx, yy, zz, xy, xz, yz = body.I_BBcm_B
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        own_inertia = pinocchio.Inertia(body.mass, np.array(body.p_BoBcm_B), inertia)
        model.appendBodyToJoint(joint, own_inertia, pinocchio.SE3.Identity())
        link = plant.GetBodyByName(body.name)
        X, V = link.EvalPoseInWorld(own), link.EvalSpatialVelocityInWorld(own)
        R = X.rotation().matrix()
        wxyz = X.rotation().ToQuaternion().wxyz()
        q += [*X.translation(), *wxyz[1:], wxyz[0]]
        v += [*(R.T @ V.translational()), *(R.T @ V.rotational())]
        force, torque = np.zeros(3), np.zeros(3)
        if body.name == PUSH.body:
            force, torque = np.array(PUSH.forces[0]), np.array(PUSH.torques[0])
            torque = torque + np.cross(PUSH.p_BoQ_B, force)
        tau += [*force, *torque]
    model.gravity.setZero()
    constraints = pinocchio.StdVec_RigidConstraintModel()
    for attachment in separation.attachments:
        a, b = (model.getJointId(name) for name in (attachment.A, attachment.B))
        X_WA, X_WB = (
            plant.GetBodyByName(name).EvalPoseInWorld(own)
            for name in (attachment.A, attachment.B)
        )
        pad = np.array(attachment.p_AoPad_A)
        X_BA = X_WB.inverse() @ X_WA
        in_A = pinocchio.SE3(np.eye(3), pad)
        in_B = pinocchio.SE3(X_BA.rotation().matrix(), X_BA @ pad)
        kind = (
            pinocchio.ContactType.CONTACT_6D
            if attachment.joint.type == "fixed"
            else pinocchio.ContactType.CONTACT_3D
        )
        constraints.append(
            pinocchio.RigidConstraintModel(
                kind, model, a, in_A, b, in_B, pinocchio.ReferenceFrame.LOCAL
            )
        )
    data = model.createData()
    datas = pinocchio.StdVec_RigidConstraintData()
    for constraint in constraints:
        datas.append(constraint.createData())
    pinocchio.initConstraintDynamics(model, data, constraints, datas)
    settings = pinocchio.ProximalSettings(1e-12, 1e-10, 50)
    state = (np.array(values) for values in (q, v, tau))
    a = pinocchio.constraintDynamics(model, data, *state, constraints, datas, settings)
    found = []
    for k, body in enumerate(separation.bodies):
        link = plant.GetBodyByName(body.name)
        R = link.EvalPoseInWorld(own).rotation().matrix()
        V = link.EvalSpatialVelocityInWorld(own)
        linear, angular = a[6 * k : 6 * k + 3], a[6 * k + 3 : 6 * k + 6]
        # Spatial acceleration to that of a point: plus w x v.
        point = R @ linear + np.cross(V.rotational(), V.translational())
        found.append(np.append(R @ angular, point))
    return found


def held_turning(type, rate, apart):
    """A stack of two bodies that turns, their origins so far apart; m and rad/s."""
    pair = staged(Joint(type=type, rigid=True), (0.5,), duration=700.0)
    [attachment] = pair.attachments
    late = dataclasses.replace(attachment, release_time=650.0)
    separation = dataclasses.replace(pair, attachments=(late,))
    lower, upper = separation.bodies
    upper = dataclasses.replace(upper, p_ABo=(apart, 0.0, 0.0))
    w = np.array(separation.initial.w_WA_A)
    w_WA_A = tuple((rate / np.linalg.norm(w) * w).tolist())
    initial = dataclasses.replace(separation.initial, w_WA_A=w_WA_A)
    return dataclasses.replace(
        separation, bodies=(lower, upper), initial=initial, loads=()
    )


def drift_of(separation, accuracy, seconds):
    """How far the joint has let the bodies drift, m and rad."""
    system, context, simulator = start(separation, accuracy)
    simulator.AdvanceTo(seconds)
    plant, own = system.plant, system.plant.GetMyContextFromRoot(context)
    X_WA, X_WB = (
        plant.GetBodyByName(body.name).EvalPoseInWorld(own)
        for body in separation.bodies
    )
    return drift_between(separation, X_WA, X_WB)


def drift_between(separation, X_WA, X_WB):
    """How far bodies are from where the joint holds them, m and rad."""
    [attachment] = separation.attachments
    X_AB, pad_A = X_WA.inverse() @ X_WB, np.array(attachment.p_AoPad_A)
    moved = X_AB @ (pad_A - separation.bodies[1].p_ABo) - pad_A
    turned = X_AB.rotation().ToAngleAxis()
    if attachment.joint.type == "revolute":  # about A's x axis
        return np.linalg.norm(moved), math.hypot(*X_AB.rotation().matrix()[1:, 0])
    return np.linalg.norm(moved), turned.angle()


@pytest.mark.parametrize("type", ["fixed", "revolute"])
def test_held_for_a_minute(type):
    """Unstabilised it would be 3e-5 m, and more with the square of time."""
    assert max(drift_of(held_turning(type, 0.38, 1.0), 1e-6, 60.0)) <= 1e-6


@pytest.mark.parametrize("type", ["fixed", "revolute"])
def test_held_for_a_minute_of_a_simulation(type):
    """By its own scheme, where long steps might let go of more."""
    separation = held_turning(type, 0.38, 3.0)
    [attachment] = separation.attachments
    separation = dataclasses.replace(
        separation,
        attachments=(dataclasses.replace(attachment, release_time=60.0),),
        duration=61.0,
    )
    trajectory = Simulation(separation).run().trajectory
    held = trajectory.states[trajectory.time <= 60.0]
    poses = (
        [
            RigidTransform(Quaternion(q / np.linalg.norm(q)), p)
            for q, p in ((body[:4], body[4:7]) for body in state)
        ]
        for state in held[::20]
    )
    assert max(max(drift_between(separation, *pair)) for pair in poses) <= 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.1, 0.38])
def test_held_for_ten_minutes(rate):
    for accuracy in (1e-6, 1e-7):
        # Local errors and the pace at which they are made good leave most of that.
        drift = drift_of(held_turning("fixed", rate, 3.0), accuracy, 600.0)
        assert max(drift) <= accuracy


@pytest.mark.parametrize(
    ("type", "displaced", "message"),
    [
        ("fixed", RigidTransform([0.0, 3e-3, 4e-3]), "0.005 m and .* deg away"),
        ("spherical", RigidTransform([0.0, 2e-3, 0.0]), "0.002 m and 0 deg away"),
        # Its axis in B falls together with that in A: it is locked.
        (
            "universal",
            RigidTransform(RollPitchYaw(0.0, 0.0, -math.pi / 2), np.zeros(3)),
            "m and 90 deg away",
        ),
    ],
)
def test_bodies_that_are_not_where_joints_hold_them(type, displaced, message):
    separation = staged(Joint(type=type, rigid=True), (0.5,))
    system, context, simulator = start(separation, 1e-6)
    plant, own = system.plant, system.plant.GetMyMutableContextFromRoot(context)
    upper = plant.GetBodyByName("upper")
    X_WB = upper.EvalPoseInWorld(own) @ displaced
    plant.SetFloatingBaseBodyPoseInWorldFrame(own, upper, X_WB)
    with pytest.raises(InputError, match=f"attachment_1: .* {message}"):
        simulator.Initialize()


@pytest.mark.parametrize("name", ["K_F", "D_F", "K_T", "D_T"])
def test_gains_are_missing_or_too_many(name):
    gains = dict.fromkeys(("K_F", "D_F", "K_T", "D_T"), 1.0)
    with pytest.raises(InputError, match=f"{name}: a rigid joint has none, got 1"):
        Joint(rigid=True, **{name: 1.0})
    del gains[name]
    with pytest.raises(InputError, match=f"{name}: missing, and the joint is not"):
        Joint(**gains)


def test_what_rigid_joints_cannot_see_is_refused():
    separation = staged()
    ball = Part(name="ball", shape=Sphere(radius=0.1))
    bodies = tuple(
        dataclasses.replace(
            body, parts=(dataclasses.replace(ball, name=f"ball_of_{body.name}"),)
        )
        for body in separation.bodies
    )
    contact = Recontact(stiffness=1e5)
    with pytest.raises(InputError, match="recontact: attachment_1 must not be rigid"):
        dataclasses.replace(separation, bodies=bodies, recontact=contact)
