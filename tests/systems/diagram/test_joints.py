"""The joint by constraint forces: against Drake's bushing, and against no joint."""

import dataclasses

import numpy as np
import pytest
from flying import start
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, LinearBushingRollPitchYaw
from pydrake.systems.analysis import Simulator
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from separations import GENERIC, generic_pair

from drakesep.systems.diagram.separation_system import SeparationSystem, spatial_inertia
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.simulation.simulation import Simulation


JOINT = Joint(K_F=1e5, D_F=1e3, K_T=2e4, D_T=3e2)


def held_pair(attachments, joint=JOINT):
    separation = generic_pair(
        release_times=(0.9,) * attachments, joint=joint, springs=False
    )
    # One body stands askew in the stack, to tell the frames apart.
    lower, upper = separation.bodies
    upper = dataclasses.replace(
        upper, p_ABo=(0.2, 0.03, -0.05), rpy_AB=(0.3, -0.2, 0.4)
    )
    return dataclasses.replace(separation, bodies=(lower, upper))


def plant_with_drakes_bushing(separation):
    plant = MultibodyPlant(0.0)
    for body in separation.bodies:
        plant.AddRigidBody(body.name, spatial_inertia(body))
    upper = separation.body("upper")
    X_AB = RigidTransform(RollPitchYaw(np.array(upper.rpy_AB)), upper.p_ABo)
    for a in separation.attachments:
        X_APad = RigidTransform(np.array(a.p_AoPad_A))
        X_BPad = X_AB.inverse() @ X_APad
        on_A = plant.AddFrame(
            FixedOffsetFrame(f"{a.name}_A", plant.GetFrameByName(a.A), X_APad)
        )
        on_B = plant.AddFrame(
            FixedOffsetFrame(f"{a.name}_B", plant.GetFrameByName(a.B), X_BPad)
        )
        plant.AddForceElement(
            LinearBushingRollPitchYaw(
                on_A,
                on_B,
                list(a.joint.K_T),
                list(a.joint.D_T),
                list(a.joint.K_F),
                list(a.joint.D_F),
            )
        )
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    return plant


@pytest.mark.parametrize("attachments", [1, 4])
@pytest.mark.parametrize("size", [1e-3, 1e-4])
def test_against_drakes_bushing_at_small_angles(attachments, size):
    """Accelerations agree to the first order in the deviation, in generic motion.

    Drake acts half way between the frames, with gimbal angles, and differentiates in
    the frame half way: differences of the second order in the deviation.
    """
    separation = held_pair(attachments)
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    drake = plant_with_drakes_bushing(separation)
    drake_context = drake.CreateDefaultContext()

    rng = np.random.default_rng(8)
    ours = system.plant.GetMyMutableContextFromRoot(context)
    lower, upper = (system.plant.GetBodyByName(n) for n in ("lower", "upper"))
    X_WA = RigidTransform(RollPitchYaw(0.7, -0.5, 1.9), [0.3, 0.2, -0.1])
    B = separation.body("upper")
    X_AB = RigidTransform(RollPitchYaw(np.array(B.rpy_AB)), B.p_ABo)
    deviation = RigidTransform(
        RollPitchYaw(size * rng.normal(size=3)), size * rng.normal(size=3)
    )
    system.plant.SetFloatingBaseBodyPoseInWorldFrame(ours, lower, X_WA)
    system.plant.SetFloatingBaseBodyPoseInWorldFrame(
        ours, upper, X_WA @ deviation @ X_AB
    )
    for body in (lower, upper):
        velocity = SpatialVelocity(size * rng.normal(size=3), size * rng.normal(size=3))
        system.plant.SetFreeBodySpatialVelocity(ours, body, velocity)
    drake.SetPositionsAndVelocities(
        drake_context, system.plant.GetPositionsAndVelocities(ours)
    )

    nv = drake.num_velocities()
    got = system.plant.EvalTimeDerivatives(ours).CopyToVector()[-nv:]
    expected = drake.EvalTimeDerivatives(drake_context).CopyToVector()[-nv:]
    scale = np.abs(expected).max()
    assert got == pytest.approx(expected, abs=5.0 * size * scale)
    assert not np.allclose(got, expected, atol=1e-3 * size * scale)  # not the same code


def test_mated_bodies_move_as_the_composite_body():
    """Attitude and place of a held pair against one rigid body's Euler equations."""
    joint = Joint(K_F=1e8, D_F=5e5, K_T=1e7, D_T=5e4)
    separation = held_pair(4, joint)
    times = np.linspace(0.0, 0.85, 18)
    system, context, simulator = start(separation, 1e-8)
    poses = []
    for t in times:
        simulator.AdvanceTo(t)
        plant_context = system.plant.GetMyContextFromRoot(context)
        body = system.plant.GetBodyByName("lower")
        poses.append(system.plant.EvalBodyPoseInWorld(plant_context, body))

    expected_R, expected_p = composite_motion(separation, times)
    # A joint gives by (force or torque) / K: 1e3 N over 4e8 N/m, and as much over
    # its arm in angle.
    for pose, R, p in zip(poses, expected_R, expected_p, strict=True):
        turned = Rotation.from_matrix(R.T @ pose.rotation().matrix()).magnitude()
        assert turned < 1e-6
        assert pose.translation() == pytest.approx(p, abs=1e-6)


def composite_motion(separation, times):
    """Orientation and origin of A as a part of one rigid body."""
    lower, upper = separation.bodies
    R_AB = Rotation.from_euler("xyz", upper.rpy_AB).as_matrix()
    c_lower = np.array(lower.p_BoBcm_B)
    c_upper = np.array(upper.p_ABo) + R_AB @ upper.p_BoBcm_B
    M = lower.mass + upper.mass
    c = (lower.mass * c_lower + upper.mass * c_upper) / M

    def about_c(mass, I_cm, r):
        return I_cm + mass * (r @ r * np.eye(3) - np.outer(r, r))

    inertia = about_c(lower.mass, inertia_matrix(lower.I_BBcm_B), c_lower - c)
    inertia += about_c(
        upper.mass, R_AB @ inertia_matrix(upper.I_BBcm_B) @ R_AB.T, c_upper - c
    )

    def derivative(_, y):
        q, w = y[:4], y[4:]
        qdot = 0.5 * np.append(q[3] * w + np.cross(q[:3], w), -q[:3] @ w)
        return np.append(qdot, np.linalg.solve(inertia, -np.cross(w, inertia @ w)))

    R0 = Rotation.from_euler("xyz", GENERIC.rpy_WA)
    w0 = np.array(GENERIC.w_WA_A)
    y = solve_ivp(
        derivative,
        (0.0, times[-1]),
        np.append(R0.as_quat(), w0),
        t_eval=times,
        rtol=1e-11,
        atol=1e-13,
        method="DOP853",
    ).y
    rotations = Rotation.from_quat(y[:4].T).as_matrix()
    # A's CG is at rest at the start: the composite's moves at w x (c - c_lower).
    v_c = R0.apply(np.cross(w0, c - c_lower))
    origins = [
        R0.apply(c) + v_c * t - R @ c for t, R in zip(times, rotations, strict=True)
    ]
    return rotations, origins


def test_energy_of_an_undamped_joint():
    """Kinetic and elastic energy together are constant while it swings widely."""
    separation = held_pair(1, Joint(K_F=2e3, D_F=0.0, K_T=8e2, D_T=0.0))
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    context.SetAccuracy(1e-9)
    plant_context = system.plant.GetMyMutableContextFromRoot(context)
    system.plant.SetFreeBodySpatialVelocity(
        plant_context,
        system.plant.GetBodyByName("upper"),
        SpatialVelocity([1.5, -1.0, 2.0], [0.5, 1.0, -0.5]),
    )
    simulator = Simulator(system, context)
    simulator.get_mutable_integrator().set_target_accuracy(1e-9)
    simulator.Initialize()
    energies, elastic = [], []
    for t in np.linspace(0.0, 0.85, 9):
        simulator.AdvanceTo(t)
        [held] = system.GetOutputPort("joint_energy").Eval(context)
        elastic.append(held)
        energies.append(system.plant.CalcKineticEnergy(plant_context) + held)
    assert max(elastic) > 0.1 * energies[0]  # it does take part
    # 1e-9 a step over the hundreds of steps of the swing
    assert energies == pytest.approx([energies[0]] * 9, rel=1e-7)


def test_stiffer_joints_give_less():
    """The deviation of the mated pair under its own rotation falls as 1 / K."""
    deviations = []
    for K in (1e5, 1e6, 1e7):
        joint = Joint(K_F=K, D_F=2e-2 * K, K_T=0.1 * K, D_T=2e-3 * K)
        run = Simulation(held_pair(4, joint), Integration(accuracy=1e-8)).run()
        late = (run.motion.time > 0.6) & (run.motion.time < 0.9)
        deviations.append(
            np.linalg.norm(run.motion.relative_position[late], axis=1).mean()
        )
    ratios = np.divide(deviations[:-1], deviations[1:])
    assert ratios == pytest.approx(10.0, rel=0.02)
