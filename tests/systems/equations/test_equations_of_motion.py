"""The equations of motion with every force element active, against Pinocchio.

At random states of three bodies. The oracle shares no code with drakesep, only the
description of the separation: forces are written in numpy from the paper's equations,
the torques of joints are derived from their angles by complex steps, and Pinocchio's
articulated-body algorithm makes accelerations of them.
"""

import functools
import math
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pinocchio
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from separations import inertia_of_points

from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.lanes import Mode
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.equations.pushers import push_displacement, push_place
from drakesep.systems.equations.relative_motion import body_state
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Attachment, Body, Separation
from drakesep.systems.model.springs import DisplacementSpring, Spring


NOW = 0.2
SEEDS = range(10)
PAIRS = (("lower", "middle"), ("upper", "lower"), ("middle", "upper"))
ROTATION = {
    "fixed": "all",
    "prismatic": "all",
    "revolute": "swing",
    "cylindrical": "swing",
    "planar": "swing",
    "universal": "universal",
    "spherical": "none",
}
"""Which rotations each type of joint holds."""
TRANSLATION = dict.fromkeys(ROTATION, (1, 1, 1))
TRANSLATION |= {"prismatic": (0, 1, 1), "cylindrical": (0, 1, 1), "planar": (1, 0, 0)}
LINEAR = ((0.0, 3.0), (2000.0, 0.0))
TABLE = ((0.0, 0.2, 0.6, 2.0), (1300.0, 1500.0, 800.0, 300.0))
"""Displacements, m, and forces, N, of the springs driven by displacement."""
RELEASED = (
    (
        0.05,
        Spring(
            name="timed",
            force_max=1500.0,
            stroke=0.5,
            design_mass=100.0,
            tilt_y=0.2,
            tilt_z=-0.1,
        ),
    ),
    (
        0.0,
        DisplacementSpring(
            name="linear",
            force_max=2000.0,
            stroke=3.0,
            damping=150.0,
            axis_A=(-0.48, 0.6, 0.64),
            tilt_y=-0.15,
            tilt_z=0.25,
        ),
    ),
    (
        0.02,
        DisplacementSpring.from_table(
            name="table",
            displacements=TABLE[0],
            forces=TABLE[1],
            damping=40.0,
            axis_A=(-1.0, 0.0, 0.0),
        ),
    ),
)
"""Release times, s, and springs of the attachments that have let go."""
WAITING = Spring(name="waiting", force_max=1e3, stroke=0.4, design_mass=100.0)
"""Of an attachment that still holds."""


def triple(rng, size):
    return tuple(rng.uniform(-size, size, size=3).tolist())


def make_body(rng, name, mass):
    base = name == "lower"  # the stack is placed in its frame
    return Body(
        name=name,
        mass=mass,
        p_BoBcm_B=triple(rng, 0.5),
        I_BBcm_B=inertia_of_points(int(mass), mass),
        p_ABo=triple(rng, 0.0 if base else 0.6),
        rpy_AB=triple(rng, 0.0 if base else 1.0),
    )


def make_joint(rng, joint_type):
    axes = random_orientation(rng).T.tolist()
    gains = {
        name: tuple(rng.uniform(0.3 * size, size, size=3).tolist())
        for name, size in (("K_F", 8e3), ("D_F", 5e2), ("K_T", 2e3), ("D_T", 4e2))
    }
    return Joint(
        type=joint_type, x_axis_A=tuple(axes[0]), y_axis_A=tuple(axes[1]), **gains
    )


def make_attachments(rng):
    """A joint of each type that holds, and three that have let go."""
    held = [(joint_type, 0.5, None) for joint_type in ROTATION]
    held[0] = ("fixed", 0.5, WAITING)
    types = ("fixed", "revolute", "universal")
    let_go = [(t, *row) for t, row in zip(types, RELEASED, strict=True)]
    return tuple(
        Attachment(
            name=f"attachment_{i}",
            A=PAIRS[i % 3][0],
            B=PAIRS[i % 3][1],
            p_AoPad_A=triple(rng, 0.5),
            joint=make_joint(rng, joint_type),
            spring=spring,
            release_time=release_time,
        )
        for i, (joint_type, release_time, spring) in enumerate([*held, *let_go])
    )


def make_load(rng, name, body, **how):
    rows = [triple(rng, 1e3) for _ in range(6)]
    return Load(
        name=name,
        body=body,
        p_BoQ_B=triple(rng, 0.5),
        times=(0.0, 0.1, 0.4),
        forces=tuple(rows[:3]),
        torques=tuple(rows[3:]),
        **how,
    )


def every_force() -> Separation:
    """Three bodies under every force that drakesep knows."""
    rng = np.random.default_rng(1)
    masses = {"lower": 700.0, "middle": 400.0, "upper": 900.0}
    return Separation(
        bodies=tuple(make_body(rng, name, mass) for name, mass in masses.items()),
        attachments=make_attachments(rng),
        A="lower",
        B="upper",
        loads=(
            make_load(rng, "in_body", "lower", axes="body", start=0.03),
            make_load(rng, "in_world", "middle", axes="world", factor=-0.7),
            # started by a release, and by one that is still to come
            make_load(rng, "started", "upper", start=0.01, after="attachment_7"),
            make_load(rng, "to_start", "upper", after="attachment_3"),
        ),
        # So small a planet that its field varies over the stack, as strong as springs.
        orbit=Orbit(radius=50.0, mu=1e5, horizontal_speed=52.0, climb_rate=-17.0),
        duration=2.0,
    )


def random_orientation(rng):
    return Rotation.from_quat(rng.normal(size=4)).as_matrix()


SEPARATION = every_force()


class Motion(NamedTuple):
    """Of a body in W: pose of its origin and axes, angular velocity and velocity."""

    R: np.ndarray
    p: np.ndarray
    w: np.ndarray
    v: np.ndarray


def mated_place(body: Body) -> tuple[np.ndarray, np.ndarray]:
    return Rotation.from_euler("xyz", body.rpy_AB).as_matrix(), np.array(body.p_ABo)


def random_motions(rng) -> dict[str, Motion]:
    """The stack anywhere, its bodies up to 0.1 m and 1 rad from their mated places."""
    R_WS = random_orientation(rng)
    p_WS = rng.normal(size=3)
    motions = {}
    for body in SEPARATION.bodies:
        R_SB, p_SB = mated_place(body)
        turn = Rotation.from_rotvec(rng.uniform(-0.55, 0.55, size=3)).as_matrix()
        motions[body.name] = Motion(
            R_WS @ turn @ R_SB,
            p_WS + R_WS @ (p_SB + rng.uniform(-0.1, 0.1, size=3)),
            rng.uniform(-1.0, 1.0, size=3),
            rng.uniform(-1.0, 1.0, size=3),
        )
    return motions


def system_at(motions, external):
    """The diagram and its Context in this motion, at a time after three releases."""
    system = SeparationSystem(SEPARATION, external_wrenches=True)
    context = system.CreateDefaultContext()
    system.set_separation(context, SEPARATION)
    context.SetAccuracy(1e-6)
    system.GetInputPort("external_wrenches").FixValue(context, external)
    # What is due at the start lets go, then what was since, then loads that follow.
    for t in (0.0, NOW, NOW):
        context.SetTime(t)
        system.ExecuteInitializationEvents(context)
    plant = system.plant
    plant_context = plant.GetMyMutableContextFromRoot(context)
    for name, motion in motions.items():
        body = plant.GetBodyByName(name)
        plant.SetFloatingBaseBodyPoseInWorldFrame(
            plant_context, body, RigidTransform(RotationMatrix(motion.R), motion.p)
        )
        plant.SetFreeBodySpatialVelocity(
            plant_context, body, SpatialVelocity(motion.w, motion.v)
        )
    return system, context


class Relative(NamedTuple):
    """Motion of B as an attachment's A sees it."""

    pad: np.ndarray
    """Place of B's pad, in W, m."""
    dx: np.ndarray
    """Of the pad from its mated place in A, m."""
    rate: np.ndarray
    """Of dx, m/s."""
    turn: np.ndarray
    """Rotation of B from its mated orientation, in A."""
    w: np.ndarray
    """Angular velocity of B in A, in A, rad/s."""


def relative_motion(attachment, motions) -> Relative:
    A, B = motions[attachment.A], motions[attachment.B]
    R_SA, p_SA = mated_place(SEPARATION.body(attachment.A))
    R_SB, p_SB = mated_place(SEPARATION.body(attachment.B))
    p_A = np.array(attachment.p_AoPad_A)
    p_B = R_SB.T @ (p_SA + R_SA @ p_A - p_SB)
    pad = B.p + B.R @ p_B
    rate = B.v + np.cross(B.w, pad - B.p) - A.v - np.cross(A.w, pad - A.p)
    return Relative(
        pad,
        A.R.T @ (pad - A.p) - p_A,
        A.R.T @ rate,
        A.R.T @ B.R @ R_SB.T @ R_SA,
        A.R.T @ (B.w - A.w),
    )


def joint_frame(joint):
    x, y = np.array(joint.x_axis_A), np.array(joint.y_axis_A)
    return np.column_stack([x, y, np.cross(x, y)])


def angle_times(sine_axis, cosine):
    """An angle below 180 deg times its axis, from sine times axis, and cosine.

    Analytic in both, and exact to round-off, unlike an arccosine of small angles.
    """
    sine = np.sqrt(sine_axis @ sine_axis)
    return 2.0 * np.arctan(sine / (1.0 + cosine)) / sine * sine_axis


def joint_angles(joint_type, E):
    """Deviations of a joint whose axes on B have turned by E, analytic in E.

    Axes on A are those of the joint's frame, and axes on B are E's columns.
    """
    kind = ROTATION[joint_type]
    if kind == "all":  # rotation vector
        sine_axis = [E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]]
        return angle_times(0.5 * np.array(sine_axis), 0.5 * (np.trace(E) - 1.0))
    if kind == "swing":  # of the x axis, about the normal of both
        x, y, z = E[:, 0]
        return angle_times(np.array([0.0, -z, y]), x)
    if kind == "universal":  # by which A's x and B's y axis miss the right angle
        return np.array([0.0, 0.0, -np.arcsin(E[0, 1])])
    return np.zeros(3)


def joint_pull(attachment, seen: Relative):
    """Torque and force of a joint on B at its pad, in its frame J, and its energy."""
    joint = attachment.joint
    R_AJ = joint_frame(joint)
    K_F, D_F, K_T, D_T = map(np.array, (joint.K_F, joint.D_F, joint.K_T, joint.D_T))
    held = np.array(TRANSLATION[joint.type])
    dx, rate, w = R_AJ.T @ seen.dx, R_AJ.T @ seen.rate, R_AJ.T @ seen.w
    force = -held * (K_F * dx + D_F * rate)  # Eq. 1, 3 and 4
    E = R_AJ.T @ seen.turn @ R_AJ
    angles = joint_angles(joint.type, E)
    # d angles / d rotation: a complex step has no round-off of a difference
    h = 1e-30
    G = np.column_stack(
        [
            joint_angles(joint.type, E + 1j * h * np.cross(e, E.T).T).imag / h
            for e in np.eye(3)
        ]
    )
    torque = -G.T @ (K_T * angles + D_T * (G @ w))  # Eq. 2 to 4
    energy = 0.5 * (held * K_F) @ dx**2 + 0.5 * K_T @ angles**2
    return torque, force, energy


def spring_push(spring, elapsed, seen: Relative):
    if isinstance(spring, Spring):
        w = math.sqrt(spring.force_max / (spring.design_mass * spring.stroke))
        return spring.force_max * math.cos(w * elapsed)  # Eq. 5
    x, force = LINEAR if spring.name == "linear" else TABLE
    displacement, speed = seen.dx @ push_axis(spring), seen.rate @ push_axis(spring)
    # A pad that is pressed in is pushed along the first line.
    pressed = min(displacement, 0.0) * (force[1] - force[0]) / (x[1] - x[0])
    return np.interp(displacement, x, force) + pressed - spring.damping * speed


def push_axis(spring):
    """In A: about the fixed y axis, then about z; then as x is turned to the axis."""
    tilts = [spring.tilt_y, spring.tilt_z]
    tilted = Rotation.from_euler("yz", tilts).apply([1.0, 0.0, 0.0])
    x, axis = np.array([1.0, 0.0, 0.0]), np.array(spring.axis_A)
    normal, angle = np.cross(x, axis), np.arccos(x @ axis)
    if not normal.any():
        normal = np.array([0.0, 0.0, 1.0])
    return Rotation.from_rotvec(angle * normal / np.linalg.norm(normal)).apply(tilted)


def load_now(load):
    """Force and torque of a load, in its axes."""
    start = load.start
    if load.after is not None:
        [start_of] = [a for a in SEPARATION.attachments if a.name == load.after]
        start += start_of.release_time
    rows = np.hstack([load.forces, load.torques])
    now = [np.interp(NOW - start, load.times, c, left=0.0, right=0.0) for c in rows.T]
    return load.factor * np.array(now[:3]), load.factor * np.array(now[3:])


def gravity(body, motion):
    """Force at the CG in a field that W's origin falls in, and the gradient's torque.

    The plain difference of two fields keeps its digits near so small a planet.
    """
    mu, origin = SEPARATION.orbit.mu, reference_position()
    r = origin + motion.p + motion.R @ body.p_BoBcm_B
    distance = np.linalg.norm(r)
    field = -mu * r / distance**3 + mu * origin / np.linalg.norm(origin) ** 3
    I_W = motion.R @ inertia_matrix(body) @ motion.R.T
    return body.mass * field, 3.0 * mu / distance**5 * np.cross(r, I_W @ r)


@functools.cache
def reference_position():
    """W's origin now, integrated from its state at t = 0."""
    orbit = SEPARATION.orbit

    def fall(_, state):
        r, v = state[:3], state[3:]
        return np.concatenate([v, -orbit.mu * r / np.linalg.norm(r) ** 3])

    speed = orbit.horizontal_speed
    start = [0.0, 0.0, -orbit.radius, speed, 0.0, -orbit.climb_rate]
    how = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    return solve_ivp(fall, (0.0, NOW), start, **how).y[:3, -1]


def inertia_matrix(body):
    xx, yy, zz, xy, xz, yz = body.I_BBcm_B
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class Expected(NamedTuple):
    """What the oracle says of a motion."""

    wrenches: dict[str, np.ndarray]
    """Torque about each body's origin, and force, in W."""
    joint_loads: list[np.ndarray]
    joint_energy: float
    spring_forces: list[float]


def forces_of(motions, external) -> Expected:
    names = [body.name for body in SEPARATION.bodies]
    wrenches = dict(zip(names, external.reshape(3, 6).copy(), strict=True))

    def act(name, point, force, torque):
        moment = torque + np.cross(point - motions[name].p, force)
        wrenches[name] += np.concatenate([moment, force])

    joint_loads, joint_energy, spring_forces = [], 0.0, []
    for a in SEPARATION.attachments:
        seen = relative_motion(a, motions)
        elapsed = NOW - a.release_time
        if elapsed < 0.0:
            torque_J, force_J, energy = joint_pull(a, seen)
            R_WJ = motions[a.A].R @ joint_frame(a.joint)
            force, torque = R_WJ @ force_J, R_WJ @ torque_J
            joint_loads.append(np.concatenate([torque_J, force_J]))
            joint_energy += energy
            push = 0.0
        else:
            push = spring_push(a.spring, elapsed, seen)
            force, torque = push * motions[a.A].R @ push_axis(a.spring), np.zeros(3)
            joint_loads.append(np.zeros(6))
        if a.spring is not None:
            spring_forces.append(push)
        act(a.B, seen.pad, force, torque)
        act(a.A, seen.pad, -force, -torque)  # at the same point in space
    for load in SEPARATION.loads:
        motion = motions[load.body]
        axes = motion.R if load.axes == "body" else np.eye(3)
        force, torque = (axes @ value for value in load_now(load))
        act(load.body, motion.p + motion.R @ load.p_BoQ_B, force, torque)
    for body in SEPARATION.bodies:
        motion = motions[body.name]
        centre = motion.p + motion.R @ body.p_BoBcm_B
        act(body.name, centre, *gravity(body, motion))
    return Expected(wrenches, joint_loads, joint_energy, spring_forces)


def pinocchio_acceleration(body, motion, wrench):
    """Angular acceleration, and acceleration of the origin, in W, (6,)."""
    model = pinocchio.Model()
    joint = model.addJoint(
        0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), body.name
    )
    inertia = pinocchio.Inertia(
        body.mass, np.array(body.p_BoBcm_B), inertia_matrix(body)
    )
    model.appendBodyToJoint(joint, inertia, pinocchio.SE3.Identity())
    model.gravity.setZero()
    # Linear before angular, and in the body's axes: so velocity, force, acceleration.
    R, w_B, v_B = motion.R, motion.R.T @ motion.w, motion.R.T @ motion.v
    q = np.concatenate([motion.p, Rotation.from_matrix(R).as_quat()])
    force_B, torque_B = R.T @ wrench[3:], R.T @ wrench[:3]
    a = pinocchio.aba(
        model,
        model.createData(),
        q,
        np.concatenate([v_B, w_B]),
        np.concatenate([force_B, torque_B]),
    )
    # The rate of v_B's entries in turning axes, to the acceleration of the point.
    return np.concatenate([R @ a[3:], R @ (a[:3] + np.cross(w_B, v_B))])


def random_case(seed):
    rng = np.random.default_rng(seed)
    motions = random_motions(rng)
    external = rng.uniform(-1e3, 1e3, size=18)
    return *system_at(motions, external), motions, forces_of(motions, external)


@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_of_all_bodies(seed):
    system, context, motions, expected = random_case(seed)
    assert min(expected.spring_forces[1:]) > 100.0  # those after the waiting one push
    port = system.plant.get_generalized_acceleration_output_port()
    got = port.Eval(system.plant.GetMyContextFromRoot(context))
    oracle = np.concatenate(
        [
            pinocchio_acceleration(
                body, motions[body.name], expected.wrenches[body.name]
            )
            for body in SEPARATION.bodies
        ]
    )
    # Round-off of some hundred operations leaves 4e-15.
    assert got == pytest.approx(oracle, abs=1e-10 * np.abs(oracle).max())


def corners_passed(x):
    """Whether each corner of a spring's force is passed: which piece of it acts.

    Args:
        x: (13, m, n) states of the bodies.
    """
    passed = []
    for attachment, spring in SEPARATION.pushing:
        for part in law_of(spring).corners:
            a, b = SEPARATION.ends(attachment)
            A, B = (body_state(x[:, body], 0, 7) for body in (a, b))
            place = push_place(SEPARATION, attachment, spring)
            passed.append(push_displacement(A, B, *place)[0] > part * spring.stroke)
    return passed


def test_accelerations_of_the_batch_engine():
    """All random states at once, against the same oracle."""
    equations = BatchEquations(SEPARATION)
    none = np.zeros(6 * len(SEPARATION.bodies))
    cases = [random_motions(np.random.default_rng(seed)) for seed in SEEDS]
    oracle = [
        [
            pinocchio_acceleration(body, motions[body.name], wrenches[body.name])
            for body in SEPARATION.bodies
        ]
        for motions, wrenches in ((m, forces_of(m, none).wrenches) for m in cases)
    ]
    states = [
        [batch_state(motions[body.name]) for body in SEPARATION.bodies]
        for motions in cases
    ]
    x = np.transpose(states, (2, 1, 0))
    n = len(SEEDS)
    released = [
        a.release_time if a.release_time <= NOW else np.inf
        for a in SEPARATION.attachments
    ]
    with jax.enable_x64(True):
        numbers = equations.params(parameters(SEPARATION), n)
        none = jnp.full((len(SEPARATION.springs), n), False)
        mode = Mode(
            released=jnp.tile(jnp.array(released)[:, None], n),
            spent=none,
            corners=jnp.array(corners_passed(x)).reshape(-1, n),
            lifted=none,
            passed=jnp.zeros(0),
        )
        mode = mode._replace(passed=equations.row_times(numbers, mode) <= NOW)
        now, last = jnp.full(n, NOW), len(equations.phases) - 1
        timed = equations.at_times(now, numbers, mode)
        got = np.array(equations.derivative(last, timed, jnp.array(x), numbers, mode))
    expected = np.transpose(oracle, (2, 1, 0))
    # round-off, as above
    assert got[7:] == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())
    assert got[4:7] == pytest.approx(x[10:])
    dt = 1e-6
    for i in np.ndindex(x.shape[1:]):
        q, w = x[:4, *i], x[7:10, *i]
        start = Rotation.from_quat(q, scalar_first=True)
        moved = (Rotation.from_rotvec(dt * w) * start).as_quat(scalar_first=True)
        moved *= np.sign(moved @ q)
        # first order in dt: (rates of 2 rad/s times dt)^2
        assert q + dt * got[:4, *i] == pytest.approx(moved, abs=1e-11)


def batch_state(motion: Motion) -> np.ndarray:
    quaternion = Rotation.from_matrix(motion.R).as_quat(scalar_first=True)
    return np.concatenate([quaternion, motion.p, motion.w, motion.v])


@pytest.mark.parametrize("seed", SEEDS)
def test_loads_and_energy_of_joints_and_forces_of_springs(seed):
    """Held joints have the oracle's, and released ones none."""
    system, context, _, expected = random_case(seed)
    loads, preloads = (
        system.GetOutputPort(name).Eval(context).reshape(-1, 6)
        for name in ("joint_loads", "preloads")
    )
    loads -= preloads
    energy = system.GetOutputPort("joint_energy").Eval(context)
    forces = system.GetOutputPort("spring_forces").Eval(context)
    # round-off, as above
    largest = np.abs(expected.joint_loads).max()
    assert loads == pytest.approx(np.array(expected.joint_loads), abs=1e-10 * largest)
    assert np.abs(preloads).max() > 100.0
    assert energy == pytest.approx([expected.joint_energy], rel=1e-10)
    assert forces == pytest.approx(expected.spring_forces, rel=1e-10)
    released = [a.release_time <= NOW for a in SEPARATION.attachments]
    assert (loads[released] == 0.0).all()
    assert np.abs(loads[np.logical_not(released)]).max(axis=1).min() > 1.0
