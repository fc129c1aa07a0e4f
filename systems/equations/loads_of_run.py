"""What joints carry over a run, from the motion of its bodies.

A run keeps its motion; the load of a joint that is a spring follows from it by its law.
That of a rigid one follows from all else that acts on its bodies at the same moment.
"""

from collections.abc import Iterable

import numpy as np

from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.equations import joints as joint_laws
from drakesep.systems.equations.articulated_inertia import Massive
from drakesep.systems.equations.forces_of_run import spring_force_over, states_of
from drakesep.systems.equations.gravity import gravity_wrench
from drakesep.systems.equations.holding_joints import HoldingJoints, joints_that_hold
from drakesep.systems.equations.kepler import ellipse_of, orbit_position
from drakesep.systems.equations.load_sharing import joint_shares
from drakesep.systems.equations.loads import load_wrench
from drakesep.systems.equations.mated_stack import (
    held_joint,
    mated_ends,
    mated_orientation,
)
from drakesep.systems.equations.preload import preloads
from drakesep.systems.equations.pushers import push_place, push_wrenches
from drakesep.systems.equations.relative_motion import (
    BodyState,
    Wrench,
    body_state,
    pair_state,
    wrenches_at_origin,
)
from drakesep.systems.equations.rigid_joints import joint_places, rigid_joints
from drakesep.systems.model.joints import holds_all_rotations
from drakesep.systems.model.loads import Load
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Attachment
from drakesep.systems.vectors import Vector, add, cross


@typed
def joint_loads(run: Run) -> dict[str, Array]:
    """Return the loads of each joint at the times of a run's trajectory.

    Args:
        run: a completed run.

    Returns:
        By the attachments' names (n, 6): torque about B's pad, N m, and force, N, on B,
        in the joint's frame, fixed in A, as the port `joint_loads` has them: what the
        motion asks of the joint, and its preload; zero from the release on.

    Raises:
        RuntimeError: the run failed.
    """
    attachments = run.separation.attachments
    springs = [each for each in attachments if not each.joint.rigid]
    loads = {each.name: _load_of_spring(run, each) for each in springs}
    if len(springs) < len(attachments):
        loads |= _loads_of_rigid(run)
    pressed = preloads_of_run(run)
    return {each.name: loads[each.name] + pressed[each.name] for each in attachments}


def largest_loads(loads: Iterable[Array]) -> tuple[float, float]:
    """Return the largest force, N, and torque, N m, among loads (n, 6) of joints."""
    every = np.concatenate([*loads])
    force, torque = (
        float(np.linalg.norm(part, axis=1).max())
        for part in (every[:, 3:], every[:, :3])
    )
    return force, torque


@typed
def preloads_of_run(run: Run) -> dict[str, Array]:
    """Return what springs press each joint with while it holds; see `preload`.

    Args:
        run: a completed run.

    Returns:
        By the attachments' names (n, 6), as those of `joint_loads`, of which they are a
        part that moves nothing.

    Raises:
        RuntimeError: the run failed.
    """
    attachments, time = run.separation.attachments, run.completed_trajectory.time
    holds = np.array([time < run.releases[each.name] for each in attachments])
    loads = {each.name: np.zeros((len(time), 6)) for each in attachments}
    for together in np.unique(holds, axis=1).T:
        now = (holds == together[:, None]).all(axis=0)
        shares = preloads(run.separation, np.flatnonzero(together).tolist())
        for i, (torque, force) in shares.items():
            loads[attachments[i].name][now] = [*torque, *force]
    return loads


def _load_of_spring(run: Run, attachment: Attachment) -> Array:
    time = run.completed_trajectory.time
    separation = run.separation
    joint = held_joint(separation, attachment)
    A, B = (states_of(run, name) for name in (attachment.A, attachment.B))
    motion, turn = pair_state(A, B), joint_laws.NO_TURN
    if holds_all_rotations(joint.type):
        q_AB = mated_orientation(*mated_ends(separation, attachment))
        turn = joint_laws.rotation_deviation(A, B, q_AB, motion.w_AB, np)
    _, pull = joint_laws.joint_pull(joint, motion, turn, np)
    load = _rows(joint_laws.joint_load(joint, turn, pull), len(time))
    return np.where((time < run.releases[attachment.name])[:, None], load, 0.0)


def _loads_of_rigid(run: Run) -> dict[str, Array]:
    """Return the loads of the attachments with rigid joints."""
    separation, trajectory = run.separation, run.completed_trajectory
    joints, time = rigid_joints(separation), trajectory.time
    attachments = separation.attachments
    places = joint_places(separation)
    bodies = [separation.bodies[i] for i in joints.bodies]
    massive = [Massive(b.mass, b.p_BoBcm_B, b.I_BBcm_B) for b in bodies]
    acting = _other_wrenches(run)
    holds = np.array([time < run.releases[a.name] for a in attachments])
    rigid = [i for joint in joints.joints for i in joint.attachments]
    loads = {attachments[i].name: np.zeros((len(time), 6)) for i in rigid}
    laws: dict[tuple[int, ...], HoldingJoints] = {}
    for k in np.flatnonzero(holds[rigid].any(axis=0)):
        held = tuple(np.flatnonzero(holds[:, k]).tolist())
        if held not in laws:
            found = joints_that_hold(joints, places, held)
            laws[held] = HoldingJoints(joints, massive, found)
        names = {i: bodies[i].name for i in laws[held].bodies}
        now = {
            i: body_state(trajectory.of(name)[k].tolist(), 0, 7)
            for i, name in names.items()
        }
        others = {i: _wrench(acting[name][k].tolist()) for i, name in names.items()}
        edges = laws[held].wrenches(now, others)
        shares = joint_shares(joints, places, held, now, edges)
        for i, (torque, force) in shares.items():
            loads[attachments[i].name][k] = [*torque, *force]
    return loads


def _other_wrenches(run: Run) -> dict[str, Array]:
    """Return all that acts on each body but rigid joints, (n, 6), about its origin."""
    separation, time = run.separation, run.completed_trajectory.time
    states = {body.name: states_of(run, body.name) for body in separation.bodies}
    total = {name: np.zeros((len(time), 6)) for name in states}

    def add_pair(attachment: Attachment, pair: tuple[Wrench, Wrench]) -> None:
        for name, wrench in zip((attachment.A, attachment.B), pair, strict=True):
            total[name] += _rows(wrench, len(time))

    for attachment, spring in separation.pushing:
        A, B = states[attachment.A], states[attachment.B]
        place = push_place(separation, attachment, spring)
        push = spring_force_over(run, attachment), place.p_BoPad_B, place.axis_A
        add_pair(attachment, push_wrenches(A, B, [push]))
    for attachment in separation.attachments:
        if not attachment.joint.rigid:
            A, B = states[attachment.A], states[attachment.B]
            load = _load_of_spring(run, attachment)
            add_pair(attachment, _wrenches_of_spring(run, attachment, A, B, load))
    for each in separation.loads:
        wrench = _wrench_of_load(run, each, states[each.body])
        total[each.body] += _rows(wrench, len(time))
    if separation.orbit is not None:
        orbit = separation.orbit
        r_W = orbit_position(time, ellipse_of(orbit), np)
        for b in separation.bodies:
            wrench = gravity_wrench(
                states[b.name], b.mass, b.p_BoBcm_B, b.I_BBcm_B, r_W, orbit.mu, np
            )
            total[b.name] += _rows(wrench, len(time))
    return total


def _wrenches_of_spring(
    run: Run, attachment: Attachment, A: BodyState, B: BodyState, load: Array
) -> tuple[Wrench, Wrench]:
    """Return what a joint that is a spring does to its bodies, from its load."""
    joint, motion = held_joint(run.separation, attachment), pair_state(A, B)
    torque_A, force_A = (joint.in_A(tuple(x.T)) for x in np.split(load, 2, axis=1))
    _, r_A = joint_laws.translation_deviation(motion, joint.p_AoPad_A, joint.p_BoPad_B)
    torque = add(torque_A, cross(r_A, force_A))
    return wrenches_at_origin(A, motion.p_AoBo, force_A, torque)


def _wrench_of_load(run: Run, load: Load, B: BodyState) -> Wrench:
    time = run.completed_trajectory.time
    begin = load.start + (0.0 if load.after is None else run.releases[load.after])
    inside = (time >= begin + load.times[0]) & (time < begin + load.times[-1])

    def between(rows: tuple[Vector, ...]) -> Vector:
        x, y, z = (
            load.factor * inside * np.interp(time - begin, load.times, column)
            for column in zip(*rows, strict=True)
        )
        return x, y, z

    force, torque = between(load.forces), between(load.torques)
    return load_wrench(B, load.p_BoQ_B, force, torque, load.axes == "body")


def _rows(parts: tuple[Vector, Vector], count: int) -> Array:
    """Return (n, 6) of two vectors of n lanes, or of numbers."""
    entries = [np.broadcast_to(x, count) for part in parts for x in part]
    return np.stack(entries, axis=1)


def _wrench(entries: list[float]) -> Wrench:
    a, b, c, x, y, z = entries
    return Wrench((a, b, c), (x, y, z))
