"""The same separation told in other words moves the same, in both engines.

Other frames of its bodies, another order of its lists, another direction in space, and
its mirror image across the plane of the orbit: nothing may change but the components
in which a vector is told. A mistake of a sign, an axis or a frame shows here, wherever
it is, and without an oracle.
"""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from separations import staged_pair
from tumbling import Tumbling, quaternion, times

from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.systems.equations.relative_motion import body_state, relative_motion
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parts import Box, Cone, Part
from drakesep.systems.model.run import Run, RunStatus, Trajectory
from drakesep.systems.model.separation import Separation
from drakesep.systems.simulation.simulation import Simulation


pytestmark = pytest.mark.slow  # compiles programs of its own, for minutes


POLAR, AXIAL = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
"""What a mirror across the plane of x and z makes of a vector's components."""
ROOM = 3e-7
"""What both runs err by, in SI: their steps differ, as error control sees the
components. Of momentum, which is hundreds of N s, as a part of it."""


def rpy(R) -> tuple[float, ...]:
    """Of a rotation matrix: about the fixed x, y and z axes, one after the other."""
    return tuple(Rotation.from_matrix(R).as_euler("xyz").tolist())


def matrix(angles) -> np.ndarray:
    return Rotation.from_euler("xyz", angles).as_matrix()


def turn(R, vector) -> tuple[float, ...]:
    return tuple((np.asarray(R) @ vector).tolist())


def turned_inertia(R, entries) -> tuple[float, ...]:
    """Of axes in which a vector v is R v."""
    xx, yy, zz, xy, xz, yz = entries
    I = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T  # noqa: E741
    return I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]


def with_body(separation: Separation, name: str, **changes) -> Separation:
    bodies = [
        dataclasses.replace(body, **changes) if body.name == name else body
        for body in separation.bodies
    ]
    return dataclasses.replace(separation, bodies=tuple(bodies))


def with_parts(separation: Separation) -> Separation:
    """Parts that come near each other, off the axis and askew."""
    ring = Part(
        name="ring",
        shape=Cone(radius_aft=0.6, radius_fore=0.55, length=0.3, thickness=0.02),
        p_BoGo_B=(0.05, 0.02, -0.01),
        rpy_BG=(0.1, -0.05, 0.02),
    )
    box = Part(
        name="box",
        shape=Box(size=(0.3, 0.2, 0.4)),
        p_BoGo_B=(0.1, -0.1, 0.05),
        rpy_BG=(0.4, 0.3, -0.2),
    )
    separation = with_body(separation, "lower", parts=(ring,))
    return with_body(separation, "upper", parts=(box,))


BASE = with_parts(staged_pair())
FREE_OF_GRAVITY = dataclasses.replace(BASE, orbit=None)


# Other words for the same.


def body_told_anew(separation, name, R, d):
    """The body's axes turned and its origin moved: v of old is R (v - d) for points."""
    body = separation.body(name)

    def point(p):
        return turn(R, np.subtract(p, d))

    parts = tuple(
        dataclasses.replace(
            part, p_BoGo_B=point(part.p_BoGo_B), rpy_BG=rpy(R @ matrix(part.rpy_BG))
        )
        for part in body.parts
    )
    loads = []
    for load in separation.loads:
        if load.body == name:
            load = dataclasses.replace(load, p_BoQ_B=point(load.p_BoQ_B))
            if load.axes == "body":
                load = dataclasses.replace(
                    load,
                    forces=tuple(turn(R, f) for f in load.forces),
                    torques=tuple(turn(R, f) for f in load.torques),
                )
        loads.append(load)
    separation = dataclasses.replace(separation, loads=tuple(loads))
    return with_body(
        separation,
        name,
        p_BoBcm_B=point(body.p_BoBcm_B),
        I_BBcm_B=turned_inertia(R, body.I_BBcm_B),
        parts=parts,
    )


def told_in_other_axes_of_B(separation, R, d):
    """B's own frame: its mated place in A says where that is now."""
    B = separation.body(separation.B)
    R_AB = matrix(B.rpy_AB)
    p_ABo = np.add(B.p_ABo, R_AB @ d)
    separation = body_told_anew(separation, B.name, R, d)
    return with_body(
        separation, B.name, p_ABo=tuple(p_ABo.tolist()), rpy_AB=rpy(R_AB @ R.T)
    )


def told_in_other_axes_of_A(separation, R, d):
    """A's own frame, in which joints, springs and the mated stack are told too."""
    A, B = separation.body(separation.A), separation.body(separation.B)
    separation = body_told_anew(separation, A.name, R, d)
    separation = with_body(
        separation,
        B.name,
        p_ABo=turn(R, np.subtract(B.p_ABo, d)),
        rpy_AB=rpy(R @ matrix(B.rpy_AB)),
    )
    attachments = []
    for a in separation.attachments:
        spring = a.spring
        push = Rotation.from_euler("yz", [spring.tilt_y, spring.tilt_z]).apply(
            [1, 0, 0]
        )
        x, y, z = turn(R, push)
        attachments.append(
            dataclasses.replace(
                a,
                p_AoPad_A=turn(R, np.subtract(a.p_AoPad_A, d)),
                joint=dataclasses.replace(
                    a.joint,
                    x_axis_A=turn(R, a.joint.x_axis_A),
                    y_axis_A=turn(R, a.joint.y_axis_A),
                ),
                spring=dataclasses.replace(
                    spring,
                    tilt_y=float(-np.arcsin(z)),
                    tilt_z=float(np.arctan2(y, x)),
                ),
            )
        )
    initial = dataclasses.replace(
        separation.initial,
        rpy_WA=rpy(matrix(separation.initial.rpy_WA) @ R.T),
        w_WA_A=turn(R, separation.initial.w_WA_A),
    )
    return dataclasses.replace(
        separation, attachments=tuple(attachments), initial=initial
    )


def listed_the_other_way_round(separation):
    return dataclasses.replace(
        separation,
        bodies=separation.bodies[::-1],
        attachments=separation.attachments[::-1],
        loads=separation.loads[::-1],
    )


def elsewhere_in_space(separation, Q):
    """All of it turned in W, where there is no gravity."""
    loads = tuple(
        dataclasses.replace(
            load,
            forces=tuple(turn(Q, f) for f in load.forces),
            torques=tuple(turn(Q, f) for f in load.torques),
        )
        if load.axes == "world"
        else load
        for load in separation.loads
    )
    initial = dataclasses.replace(
        separation.initial, rpy_WA=rpy(Q @ matrix(separation.initial.rpy_WA))
    )
    return dataclasses.replace(separation, loads=loads, initial=initial)


def mirrored(separation):
    """Across the plane of the orbit: all that is to the left is to the right."""

    def polar(v):
        return tuple((POLAR * v).tolist())

    def axial(v):
        return tuple((AXIAL * v).tolist())

    bodies = []
    for body in separation.bodies:
        xx, yy, zz, xy, xz, yz = body.I_BBcm_B
        parts = tuple(
            dataclasses.replace(
                part, p_BoGo_B=polar(part.p_BoGo_B), rpy_BG=axial(part.rpy_BG)
            )
            for part in body.parts
        )
        bodies.append(
            dataclasses.replace(
                body,
                p_BoBcm_B=polar(body.p_BoBcm_B),
                I_BBcm_B=(xx, yy, zz, -xy, xz, -yz),
                p_ABo=polar(body.p_ABo),
                rpy_AB=axial(body.rpy_AB),
                parts=parts,
            )
        )
    attachments = tuple(
        dataclasses.replace(
            a,
            p_AoPad_A=polar(a.p_AoPad_A),
            # Its z axis points the other way: gains do not know.
            joint=dataclasses.replace(
                a.joint,
                x_axis_A=polar(a.joint.x_axis_A),
                y_axis_A=polar(a.joint.y_axis_A),
            ),
            spring=dataclasses.replace(a.spring, tilt_z=-a.spring.tilt_z),
        )
        for a in separation.attachments
    )
    loads = tuple(
        dataclasses.replace(
            load,
            p_BoQ_B=polar(load.p_BoQ_B),
            forces=tuple(map(polar, load.forces)),
            torques=tuple(map(axial, load.torques)),
        )
        for load in separation.loads
    )
    initial = dataclasses.replace(
        separation.initial,
        rpy_WA=axial(separation.initial.rpy_WA),
        w_WA_A=axial(separation.initial.w_WA_A),
    )
    return dataclasses.replace(
        separation,
        bodies=tuple(bodies),
        attachments=attachments,
        loads=loads,
        initial=initial,
    )


# What becomes of the motion.

IN_B = ("rate", "relative_rate", "linear_momentum_change", "angular_momentum_change")
IN_A = ("relative_position", "relative_velocity")
SAME = np.eye(3)
R_A, D_A = matrix((0.5, -0.3, 0.4)), np.array([0.2, -0.3, 0.25])
R_B, D_B = matrix((-1.1, 0.7, 2.0)), np.array([-0.4, 0.15, 0.3])
Q = matrix((-0.8, 0.6, -2.3))


def in_other_axes(of_A=SAME, of_B=SAME, of_W=SAME):
    """Matrices of each quantity; angles are told of frames, and compared as such."""
    matrices = {name: of_B for name in IN_B} | {name: of_A for name in IN_A}
    return matrices | {"acceleration": of_W, "angle": (of_W, of_B)}


MIRROR = {
    "rate": np.diag(AXIAL),
    "relative_rate": np.diag(AXIAL),
    "angular_momentum_change": np.diag(AXIAL),
    "linear_momentum_change": np.diag(POLAR),
    "relative_position": np.diag(POLAR),
    "relative_velocity": np.diag(POLAR),
    "acceleration": np.diag(POLAR),
    "angle": (np.diag(POLAR), np.diag(POLAR)),
}
TOLD_ANEW = {
    "B": (told_in_other_axes_of_B(BASE, R_B, D_B), in_other_axes(of_B=R_B), BASE),
    # W begins in A's origin: the field there is another by 1e-6 m/s^2.
    "A": (
        told_in_other_axes_of_A(FREE_OF_GRAVITY, R_A, D_A),
        in_other_axes(of_A=R_A),
        FREE_OF_GRAVITY,
    ),
    "order": (listed_the_other_way_round(BASE), in_other_axes(), BASE),
    "space": (
        elsewhere_in_space(FREE_OF_GRAVITY, Q),
        in_other_axes(of_W=Q),
        FREE_OF_GRAVITY,
    ),
    "mirror": (mirrored(BASE), MIRROR, BASE),
    "all": (
        mirrored(
            listed_the_other_way_round(
                told_in_other_axes_of_B(
                    told_in_other_axes_of_A(BASE, R_A, np.zeros(3)), R_B, D_B
                )
            )
        ),
        {
            name: tuple(M @ R for M, R in zip(MIRROR["angle"], turned, strict=True))
            if name == "angle"
            else MIRROR[name] @ turned
            for name, turned in in_other_axes(R_A, R_B).items()
        },
        BASE,
    ),
}


def flown_by_drake(separation):
    return Simulation(separation, Integration(accuracy=1e-9)).run()


@pytest.fixture(scope="module")
def told_first():
    """Drake's runs of the bases."""
    runs = {}

    def run(separation):
        if separation.orbit not in runs:
            runs[separation.orbit] = flown_by_drake(separation)
        return runs[separation.orbit]

    return run


@pytest.mark.parametrize("what", TOLD_ANEW)
def test_drake(what, told_first):
    separation, matrices, base = TOLD_ANEW[what]
    got, expected = flown_by_drake(separation), told_first(base)
    assert_same_motion(got, expected, matrices)
    assert_same_clearance(got, expected)


def test_batch(told_first):
    """All at once, one program, against what Drake made of the first words."""
    separation, matrices, base = TOLD_ANEW["all"]
    batch = Batch(separation, ["upper.mass"], tolerance=1e-9)
    [got] = batch.runs([[separation.body("upper").mass]])
    assert got.status is RunStatus.COMPLETED, got.message
    assert_same_motion(got, told_first(base), matrices)


def assert_same_motion(got: Run, expected: Run, matrices):
    assert got.releases == pytest.approx(dict(expected.releases), abs=ROOM)
    assert got.stroke_ends == pytest.approx(dict(expected.stroke_ends), abs=ROOM)
    ours, theirs = got.motion, expected.motion
    assert len(ours.time) == len(theirs.time)
    assert ours.time == pytest.approx(theirs.time, abs=ROOM)
    # Where a force jumps, a sample is on either side of it.
    from_kink = np.abs(theirs.time[:, None] - expected.breaks).min(axis=1)
    for name, wanted in matrices.items():
        mine, reference = getattr(ours, name), getattr(theirs, name)
        if name == "angle":
            left, right = wanted
            R = left @ Rotation.from_euler("xyz", reference).as_matrix() @ right.T
            mine = Rotation.from_euler("xyz", mine).as_matrix().reshape(-1, 9)
            reference = R.reshape(-1, 9)
        else:
            reference = reference @ wanted.T
        if name == "acceleration":
            mine, reference = mine[from_kink > ROOM], reference[from_kink > ROOM]
        size = max(1.0, np.abs(reference).max())
        # Drake's acceleration is the derivative of what its steps are made of.
        allowed = 3e-5 if name == "acceleration" else ROOM
        apart = np.abs(mine - reference).max()
        assert apart <= allowed * size, (name, apart / size)


def assert_same_clearance(got, expected):
    [mine], [reference] = (
        ClearanceAnalysis(run.separation).of(run) for run in (got, expected)
    )
    assert reference.minimum > 0.01
    # Each is within ACCURACY of the truth, and found between samples of its own.
    assert mine.minimum == pytest.approx(reference.minimum, abs=ACCURACY)
    assert mine.time == pytest.approx(reference.time, abs=1e-3)


def test_metrics_of_the_mirror_image(told_first):
    """Magnitudes stay; what is largest in one direction is smallest in the other."""
    limits = (0.8, 0.6, 2.1)
    got = metrics_of_run(flown_by_drake(mirrored(BASE)), limits)
    expected = metrics_of_run(told_first(BASE), limits)
    flipped = {
        "x": True,
        "y": False,
        "z": True,
        "roll": True,
        "pitch": False,
        "yaw": True,
    }
    for name, value in expected.items():
        stem, _, axis = name.rpartition("_")
        other = name
        if stem in ("final_rate", "angle_at_separation") and flipped[axis]:
            value = -value
        if stem.startswith(("rate_min", "rate_max")) and flipped[axis]:
            other = name.replace("min", "MAX").replace("max", "min").lower()
            value = -value
        assert got[other] == pytest.approx(value, abs=ROOM), name


# The same relative motion on another A.


def carried(trajectory: Trajectory, w, v) -> Trajectory:
    """Seen from where W turns at w and moves at v: of every body alike."""
    t = trajectory.time
    rate = np.linalg.norm(w)
    R = Rotation.from_rotvec(t[:, None] * w)
    q = quaternion(rate * t, np.asarray(w) / rate)
    states = np.empty_like(trajectory.states)
    for k in range(states.shape[1]):
        old = trajectory.states[:, k]
        p = R.apply(old[:, 4:7])
        states[:, k] = np.concatenate(
            [
                times(q, old[:, :4]),
                p + t[:, None] * v,
                R.apply(old[:, 7:10]) + w,
                R.apply(old[:, 10:13]) + np.cross(w, p) + v,
            ],
            axis=1,
        )
    return dataclasses.replace(trajectory, states=states)


@pytest.mark.parametrize("seed", range(3))
def test_relative_motion_is_as_seen_from_a_moving_turning_A(seed):
    rng = np.random.default_rng(seed)
    still = Tumbling(seed).trajectory(np.linspace(0.0, 1.0, 201))
    moving = carried(still, 4.0 * rng.normal(size=3), 30.0 * rng.normal(size=3))
    cg, mated = tuple(rng.normal(size=3)), tuple(rng.normal(size=3))

    def seen(motion):
        A, B = (body_state(motion.of(name).T, 0, 7) for name in ("lower", "upper"))
        found = relative_motion(A, B, cg, mated, np)
        names = ("relative_rate", "relative_position", "relative_velocity")
        return np.array([getattr(found, name) for name in names])

    # Round-off of velocities of 100 m/s.
    assert seen(moving) == pytest.approx(seen(still), abs=1e-12)
    paths = [RelativePath(motion, "lower", "upper") for motion in (still, moving)]
    for t in rng.uniform(0.0, 1.0, 20):
        poses = [path.at(t) for path in paths]
        for mine, other in zip(*poses, strict=True):
            assert mine == pytest.approx(other, abs=1e-11)
        bounds = [path.bounds(t, min(t + 0.05, 1.0)) for path in paths]
        # Second derivatives of cubics 5 ms long have fewer digits.
        assert bounds[0] == pytest.approx(bounds[1], rel=1e-6)
