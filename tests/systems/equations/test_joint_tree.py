"""Rigid joints of many bodies against all equations of motion solved at once."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.equations.articulated_inertia import Massive
from drakesep.systems.equations.holding_joints import (
    HoldingJoints,
    joints_that_hold,
)
from drakesep.systems.equations.joint_tree import plan_tree
from drakesep.systems.equations.relative_motion import Wrench, body_state
from drakesep.systems.equations.rigid_joints import (
    joined,
    joint_equations,
    joint_places,
    rigid_joints,
)
from drakesep.systems.model.joints import JOINT_TYPES, Joint
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Attachment, Body, Separation


def unit(rng, size):
    x = rng.normal(size=size)
    return x / np.linalg.norm(x)


def random_body(rng, name, base):
    size = rng.uniform(0.5, 2.0, size=3) ** 2
    mass = rng.uniform(10.0, 1000.0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    I = turn @ np.diag(mass * (size.sum() - size)) @ turn.T / 12.0  # noqa: E741
    moments = I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]
    return Body(
        name=name,
        mass=mass,
        p_BoBcm_B=tuple(rng.uniform(-0.5, 0.5, size=3)),
        I_BBcm_B=moments,
        p_ABo=tuple(0.0 if base else x for x in rng.uniform(-2.0, 2.0, size=3)),
        rpy_AB=tuple(0.0 if base else x for x in rng.uniform(-1.0, 1.0, size=3)),
    )


def stack(rng, links):
    """Bodies on rigid joints.

    Args:
        rng: of all numbers.
        links: (A, B, type) of each attachment, with bodies by number.
    """
    count = 1 + max(max(a, b) for a, b, _ in links)
    attachments = []
    for i, (a, b, type) in enumerate(links):
        x = unit(rng, 3)
        y = np.cross(x, unit(rng, 3))
        joint = Joint(
            type=type,
            rigid=True,
            x_axis_A=tuple(x),
            y_axis_A=tuple(y / np.linalg.norm(y)),
        )
        attachment = Attachment(
            name=f"joint_{i}",
            A=f"body_{a}",
            B=f"body_{b}",
            p_AoPad_A=tuple(rng.uniform(-1.0, 1.0, size=3)),
            joint=joint,
            release_time=1.0,
        )
        attachments.append(attachment)
    first = attachments[0]
    names = [f"body_{i}" for i in range(count)]
    return Separation(
        A=first.A,
        B=first.B,
        bodies=tuple(random_body(rng, name, name == first.A) for name in names),
        attachments=tuple(attachments),
        duration=2.0,
    )


def weighing(separation, masses):
    """The same bodies, of other masses."""
    bodies = []
    for body, mass in zip(separation.bodies, masses, strict=True):
        inertia = tuple(mass / body.mass * x for x in body.I_BBcm_B)
        bodies.append(dataclasses.replace(body, mass=mass, I_BBcm_B=inertia))
    return dataclasses.replace(separation, bodies=tuple(bodies))


def random_states(rng, count):
    """(m, 13) of bodies anywhere, at any rates: the equations hold there, too."""
    return np.array(
        [
            [*unit(rng, 4), *rng.uniform(-1.0, 1.0, 3), *rng.uniform(-2.0, 2.0, 6)]
            for _ in range(count)
        ]
    )


def mated_states(rng, separation):
    """(m, 13) of bodies that move as one: joints of a loop agree."""
    R_WS, w = Rotation.random(random_state=rng), rng.uniform(-2.0, 2.0, size=3)
    states = []
    for body in separation.bodies:
        R_SB = Rotation.from_euler("xyz", body.rpy_AB)
        p = R_WS.apply(body.p_ABo)
        q = (R_WS * R_SB).as_quat(scalar_first=True)
        states.append([*q, *p, *w, *np.cross(w, p)])
    return np.array(states)


def newton_and_euler(separation, states, others):
    """M and f of M V = f + what joints do, of all bodies, each about its origin."""
    m = len(states)
    M, free = np.zeros((6 * m, 6 * m)), np.zeros(6 * m)
    for i, (body, state) in enumerate(zip(separation.bodies, states, strict=True)):
        B = body_state(state, 0, 7)
        R, w = np.reshape(B.R_WB, (3, 3)), np.array(B.w_WB)
        xx, yy, zz, xy, xz, yz = body.I_BBcm_B
        I = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T  # noqa: E741
        c = R @ body.p_BoBcm_B
        to_cm = np.eye(6)
        to_cm[3:, :3] = np.cross(np.eye(3), c).T
        at_cm = np.zeros((6, 6))
        at_cm[:3, :3], at_cm[3:, 3:] = I, body.mass * np.eye(3)
        rates = np.append(np.cross(w, I @ w), body.mass * np.cross(w, np.cross(w, c)))
        rows = slice(6 * i, 6 * i + 6)
        M[rows, rows] = to_cm.T @ at_cm @ to_cm
        free[rows] = others[i] - to_cm.T @ rates
    return M, free


def at_once(separation, states, others, held):
    """Accelerations (m, 6) of all bodies: Newton, Euler and Eq. 1-2, by least squares.

    Each attachment has its equations, welds of several pads all of theirs.
    """
    M, free = newton_and_euler(separation, states, others)
    m = len(states)
    J, rest = [], []
    places = joint_places(separation)
    for k in held:
        attachment = separation.attachments[k]
        a, b = separation.ends(attachment)
        A, B = (body_state(states[i].tolist(), 0, 7) for i in (a, b))
        joint = attachment.joint
        motion = joined(joint.type, places[k], A, B)
        for end, sign in ((a, -1.0), (b, 1.0)):
            origin = tuple(states[end][4:7])
            own = joint_equations(joint.type, motion, origin, 1.0)
            blocks = [np.zeros((len(own.rest), 6)) for _ in range(m)]
            blocks[end] = sign * np.array(own.J)
            if sign < 0.0:
                J.append(np.hstack(blocks))
                rest += own.rest
            else:
                J[-1] = J[-1] + np.hstack(blocks)
    J = np.vstack(J)
    zero = np.zeros((len(J), len(J)))
    whole = np.block([[M, -J.T], [J, zero]])
    right = np.concatenate([free, -np.array(rest)])
    # Equations of rotation and translation, of masses and of lengths: by their size.
    size = 1.0 / np.sqrt(np.abs(whole).max(axis=1))
    scaled = whole * size * size[:, None]
    found = size * np.linalg.lstsq(scaled, size * right, rcond=1e-13)[0]
    return found[: 6 * m].reshape(m, 6)


def accelerations(separation, states, others, held):
    """The same by the wrenches of the joints."""
    M, free = newton_and_euler(separation, states, others)
    wrenches = by_tree(separation, states, others, held)
    return np.linalg.solve(M, free + wrenches.ravel()).reshape(-1, 6)


def by_tree(separation, states, others, held):
    """Wrenches (m, 6) on the bodies."""
    joints = rigid_joints(separation)
    massive = [
        Massive(b.mass, b.p_BoBcm_B, b.I_BBcm_B)
        for b in (separation.bodies[i] for i in joints.bodies)
    ]
    holding = HoldingJoints(
        joints, massive, joints_that_hold(joints, joint_places(separation), held)
    )
    index = {body: joints.bodies[body] for body in holding.bodies}
    bodies = {k: body_state(states[i].tolist(), 0, 7) for k, i in index.items()}
    acting = {
        k: Wrench(tuple(others[i][:3]), tuple(others[i][3:])) for k, i in index.items()
    }
    found = np.zeros((len(states), 6))
    for edge, on_ends in holding.wrenches(bodies, acting).items():
        for k, (torque, force) in zip(joints.edges[edge], on_ends, strict=True):
            found[index[k]] += [*torque, *force]
    return found


def assert_held(separation, states, others, held):
    expected = at_once(separation, states, others, held)
    got = accelerations(separation, states, others, held)
    # Rounds leave 1e-12 of the error, and directions that hardly differ lose digits.
    assert got == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())


types = st.sampled_from(JOINT_TYPES)


@st.composite
def trees(draw):
    """A is inboard or outboard, and bodies hang on bodies that hang."""
    links = []
    for body in range(1, draw(st.integers(2, 6))):
        ends = [draw(st.integers(0, body - 1)), body]
        links.append((*draw(st.permutations(ends)), draw(types)))
    return links


@settings(max_examples=60)
@given(trees(), st.integers(0, 1000))
def test_bodies_that_hang_on_one_another(links, seed):
    rng = np.random.default_rng(seed)
    separation = stack(rng, links)
    count = len(separation.bodies)
    states = random_states(rng, count)
    others = rng.uniform(-1e3, 1e3, size=(count, 6))
    joints = rigid_joints(separation)
    masses = [separation.bodies[i].mass for i in joints.bodies]
    tree = plan_tree(joints.joints, masses, alone=True)
    assert not tree.loops
    assert len(tree.branches) == count - 1
    assert_held(separation, states, others, range(count - 1))


LOOPS = {
    "a weld beside a hinge": [(0, 1, "fixed"), (0, 1, "revolute")],
    "two hinges": [(0, 1, "revolute"), (1, 0, "spherical")],
    "three bodies": [(0, 1, "fixed"), (1, 2, "spherical"), (2, 0, "spherical")],
    "a body on a loop": [
        (0, 1, "spherical"),
        (1, 2, "fixed"),
        (2, 0, "spherical"),
        (3, 2, "prismatic"),
        (3, 4, "fixed"),
    ],
}


@pytest.mark.parametrize("name", LOOPS)
def test_loops_and_what_hangs_on_them(name):
    rng = np.random.default_rng(3)
    separation = stack(rng, LOOPS[name])
    states = mated_states(rng, separation)
    others = rng.uniform(-1e3, 1e3, size=(len(states), 6))
    assert_held(separation, states, others, range(len(separation.attachments)))


@pytest.mark.parametrize("type", JOINT_TYPES)
@pytest.mark.parametrize("masses", [(0.1, 1e5), (1e5, 0.1)])
def test_a_light_body_that_holds_a_heavy_one(type, masses):
    """Either is A: what holds the heavy one would move the light one by round-off."""
    rng = np.random.default_rng(0)
    separation = weighing(stack(rng, [(0, 1, type)]), masses)
    others = rng.uniform(-1.0, 1.0, size=(2, 6)) * np.array(masses)[:, None]
    assert_held(separation, random_states(rng, 2), others, [0])


@pytest.mark.parametrize("mass", [1.0, 30.0, 1000.0])
def test_a_strut_of_a_loop_carries_heavy_bodies(mass):
    """A payload on a stage by a weld to a strut and two balls; a body hangs on it."""
    rng = np.random.default_rng(3)
    separation = stack(rng, [*LOOPS["three bodies"], (1, 3, "revolute")])
    separation = weighing(separation, (3000.0, mass, 2000.0, 500.0))
    states = mated_states(rng, separation)
    others = rng.uniform(-1e3, 1e3, size=(4, 6))
    assert_held(separation, states, others, range(4))


def test_a_weld_needs_no_other_joint():
    separation = stack(np.random.default_rng(0), LOOPS["a weld beside a hinge"])
    joints = rigid_joints(separation)
    held = joints_that_hold(joints, joint_places(separation), {0, 1})
    assert [each.joint.type for each in held] == ["fixed"]


HELD = {
    "fixed": [0, 1, 2, 3, 4, 5],
    "revolute": [0, 1, 2, 4, 5],
    "universal": [0, 1, 2, 5],
    "spherical": [0, 1, 2],
    "prismatic": [1, 2, 3, 4, 5],
    "cylindrical": [1, 2, 4, 5],
    "planar": [0, 4, 5],
}
"""Which gaps a type closes: along x, y, z of its frame, and about them."""


@pytest.mark.parametrize("type", JOINT_TYPES)
def test_what_has_drifted_comes_back(type):
    """Each gap g by g'' + 2 w g' + w^2 g = 0, w^2 = w_A^2 + w_B^2."""
    rng = np.random.default_rng(1)
    separation = stack(rng, [(0, 1, type)])
    [attachment] = separation.attachments
    a, b = separation.ends(attachment)
    states, size = mated_states(rng, separation), 1e-4
    turn = Rotation.from_rotvec(size * rng.normal(size=3))
    q = turn * Rotation.from_quat(states[b, :4], scalar_first=True)
    states[b] += [0.0] * 4 + [*(size * rng.normal(size=9))]
    states[b, :4] = q.as_quat(scalar_first=True)
    others = rng.uniform(-1.0, 1.0, size=(2, 6))
    V = accelerations(separation, states, others, [0])
    mated = [Rotation.from_euler("xyz", body.rpy_AB) for body in separation.bodies]
    pads = [
        R.inv().apply(mated[a].apply(attachment.p_AoPad_A) + p_a - body.p_ABo)
        for R, body in zip(mated, separation.bodies, strict=True)
        for p_a in [np.array(separation.bodies[a].p_ABo)]
    ]
    R_AJ = Rotation.from_matrix(np.reshape(attachment.joint.R_AJ, (3, 3)))

    def gaps(t):
        """Along and about the axes of the joint's frame, after so long."""
        R, p = [], []
        for state, (alpha, acceleration) in zip(
            states, V.reshape(2, 2, 3), strict=True
        ):
            w, v = state[7:10], state[10:]
            by = Rotation.from_rotvec(w * t + 0.5 * alpha * t * t)
            R.append(by * Rotation.from_quat(state[:4], scalar_first=True))
            p.append(state[4:7] + v * t + 0.5 * acceleration * t * t)
        R_WJ = R[a] * R_AJ
        moved = p[b] + R[b].apply(pads[b]) - p[a] - R[a].apply(pads[a])
        turned = R[b] * mated[b].inv() * mated[a] * R[a].inv()
        return np.concatenate(
            [R_WJ.inv().apply(x) for x in (moved, turned.as_rotvec())]
        )

    h = 3e-4
    before, now, after = (gaps(t)[HELD[type]] for t in (-h, 0.0, h))
    first, second = (after - before) / (2.0 * h), (after - 2.0 * now + before) / h**2
    w2 = (states[:, 7:10] ** 2).sum()
    expected = -2.0 * np.sqrt(w2) * first - w2 * now
    # What is of second order in gaps, and of the second in h over gaps.
    assert second == pytest.approx(expected, abs=1e-2 * np.abs(expected).max())


MANY = [
    (0, 1, "fixed"),
    (0, 2, "fixed"),
    (3, 0, "fixed"),
    (1, 4, "universal"),
    (1, 5, "cylindrical"),
    (5, 6, "planar"),
    (4, 7, "prismatic"),
    (8, 2, "revolute"),
    (3, 9, "spherical"),
    (2, 10, "universal"),
]
"""From body 0 outward two of a kind hang on bodies of a group."""


@pytest.mark.parametrize(
    "links",
    [MANY, LOOPS["a body on a loop"], LOOPS["two hinges"]],
    ids=["tree", "loop", "reversed"],
)
def test_lanes_hold_what_each_holds(links):
    """Of lanes of which each holds other joints, each is as that on floats."""
    rng = np.random.default_rng(5)
    separation = stack(rng, links)
    count, n = len(separation.bodies), 12
    separation = weighing(separation, np.linspace(2e3, 1e2, count).tolist())
    states = np.array([mated_states(rng, separation) for _ in range(n)])
    states += 1e-6 * rng.normal(size=states.shape)  # that has drifted
    held = rng.random((len(links), n)) < 0.7
    held[:, 0], held[:, 1] = True, False
    with jax.enable_x64(True):
        equations = BatchEquations(separation)
        numbers = equations.params(parameters(separation), n)
        _, mode = equations.start(numbers)
        mode = mode._replace(released=jnp.where(held, jnp.inf, 0.5))
        timed = equations.at_times(jnp.full(n, 0.7), numbers, mode)
        x = jnp.array(np.transpose(states, (2, 1, 0)))
        last = len(equations.phases) - 1
        got = np.array(equations.derivative(last, timed, x, numbers, mode))[7:]
    nothing = np.zeros((count, 6))
    for lane in range(n):
        mine = np.flatnonzero(held[:, lane])
        expected = accelerations(separation, states[lane], nothing, mine)
        # Round-off, more where loops' directions hardly differ.
        allowed = 1e-9 * np.abs(expected).max()
        assert got[..., lane].T == pytest.approx(expected, abs=allowed)
