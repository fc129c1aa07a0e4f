"""Rigid joints by which bodies hang on one another: the wrenches that hold them.

Featherstone's articulated bodies ("Rigid Body Dynamics Algorithms", 2008, chapter 7):
from outboard bodies to the inboard ones that carry them goes what a joint transmits of
their inertia and of all else that acts, back the acceleration. The work grows with the
number of bodies, no equation is solved but that of each inboard body, and a weld is
exact. What is left where no body hangs by a single joint is for `joint_loops`.

Bodies of one kind are a group, so that an engine of lanes computes them at once: the
roots, and the outboard bodies of each branch.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, TypeAlias

from drakesep.systems.equations.articulated_inertia import (
    Acceleration,
    Inertia,
    Massive,
    acceleration_by,
    inertia_of_body,
    shifted_acceleration,
    shifted_inertia,
    shifted_wrench,
    sum_of_inertias,
    without_direction,
    wrench_for,
)
from drakesep.systems.equations.relative_motion import (
    BodyState,
    Wrench,
    add_wrenches,
    reaction,
    subtract_wrenches,
)
from drakesep.systems.equations.rigid_joints import (
    Joined,
    JointPlace,
    RigidJoint,
    held_turns,
    joined,
)
from drakesep.systems.equations.straight_line import straight_line
from drakesep.systems.model.joints import CONSTRAINTS, JointType
from drakesep.systems.vectors import (
    Vector,
    add,
    cross,
    dot,
    scale,
    subtract,
)


# In which order.


class Branch(NamedTuple):
    """Joints of one type, and their outboard bodies."""

    joints: list[RigidJoint]
    group: int
    """Of the outboard bodies, one for each joint."""
    inboard: int
    """Group of their inboard bodies."""
    rows: list[int]
    """Of each joint the place of its inboard body in that group."""
    to_B: bool
    """Whether the outboard bodies are their joints' B."""


class JointTree(NamedTuple):
    """How bodies hang on one another, and what is left."""

    groups: list[list[int]]
    """Places of bodies among the joined ones: roots first."""
    roots: int
    """How many groups are of roots."""
    branches: list[Branch]
    """Inboard ones first."""
    loops: list[RigidJoint]
    """Joints of which no body hangs by one alone."""


def plan_tree(
    joints: Sequence[RigidJoint], masses: Sequence[float], *, alone: bool
) -> JointTree:
    """Return how bodies hang on one another.

    Args:
        joints: that may hold.
        masses: of the joined bodies, kg.
        alone: whether each body is a group of its own.
    """
    left = {body: _around(body, joints) for each in joints for body in (each.a, each.b)}
    hanging: dict[int, list[tuple[int, RigidJoint]]] = {}
    while leaves := [body for body, mine in left.items() if len(mine) == 1]:
        # The lightest, so that the heaviest body of a tree is its root: to a light one,
        # what a heavy one transmits along free directions is not small: round-off.
        body = min(leaves, key=lambda leaf: (masses[leaf], -leaf))
        [joint] = left.pop(body)
        inboard = joint.a if joint.b == body else joint.b
        hanging.setdefault(inboard, []).append((body, joint))
        left[inboard].remove(joint)
    roots = sorted(left)
    groups = [[body] for body in roots] if alone else [roots]
    tree = JointTree(groups, len(groups), [], [])
    for inboard, group in enumerate(groups):  # that grows
        for kind, members in _kinds(group, hanging, alone).items():
            rows, bodies, mine = (list(x) for x in zip(*members, strict=True))
            tree.branches.append(Branch(mine, len(groups), inboard, rows, kind[1]))
            groups.append(bodies)
    hang = [joint.first for branch in tree.branches for joint in branch.joints]
    tree.loops.extend(joint for joint in joints if joint.first not in hang)
    return tree


def _around(body: int, joints: Sequence[RigidJoint]) -> list[RigidJoint]:
    return [joint for joint in joints if body in (joint.a, joint.b)]


def _kinds(
    group: list[int], hanging: dict[int, list[tuple[int, RigidJoint]]], alone: bool
) -> dict[Any, list[tuple[int, int, RigidJoint]]]:
    """Return what hangs on a group's bodies by kind: its row there, body and joint."""
    kinds: dict[Any, list[tuple[int, int, RigidJoint]]] = {}
    for row, inboard in enumerate(group):
        for body, joint in hanging.get(inboard, []):
            kind = joint.type, joint.b == body, body if alone else None
            kinds.setdefault(kind, []).append((row, body, joint))
    return kinds


# What holds.


class Rows(Protocol):
    """What an engine does with what it keeps of the bodies of a group."""

    def outward(self, values: Any, branch: Branch) -> Any:
        """Return what inboard bodies have, for each outboard body of a branch."""

    def inward(self, branch: Branch, count: int) -> Callable[[Any], Any]:
        """Return how outboard bodies give something to so many inboard ones.

        Summed for each, where the joints of the branch hold.
        """

    def held(self, values: Any, branch: Branch) -> Any:
        """Return values where a joint of a branch holds, and zero elsewhere."""

    def settled(self, values: Any) -> Any:
        """Return values that are used several times: to be computed once."""

    def law(self, law: Callable[..., Any], *fixed: Any) -> Callable[..., Any]:
        """Return a law, some of whose first arguments are fixed, to be computed."""


def _as_they_are(values: Any) -> Any:
    return values


class Alone:
    """Of bodies each of which is a group of its own, whose joints all hold."""

    def outward(self, values: Any, branch: Branch) -> Any:
        """Return them."""
        return values

    def inward(self, branch: Branch, count: int) -> Callable[[Any], Any]:
        """Return that they give it as it is."""
        return _as_they_are

    def held(self, values: Any, branch: Branch) -> Any:
        """Return them."""
        return values

    settled = staticmethod(_as_they_are)
    law = staticmethod(straight_line)


class Group(NamedTuple):
    """The bodies of a group."""

    bodies: BodyState
    massive: Massive
    others: Wrench
    """All else that acts on them, about their origins."""


class Carried(NamedTuple):
    """What is to be accelerated: bodies, and what they carry."""

    inertia: Inertia
    wrench: Wrench
    """That acts, less what their rates take."""


Ends: TypeAlias = tuple[Wrench, Wrench]
"""On the outboard and on the inboard body of a joint, each about its origin."""
LoopsLaw: TypeAlias = Callable[[list[Carried]], tuple[list[Wrench], Any]]
"""From each group of roots to the wrenches that joints of loops give it, and whatever
an engine wants to know of them beside."""


def hold_tree(
    tree: JointTree,
    groups: Sequence[Group],
    places: Sequence[JointPlace],
    rows: Rows,
    hold_loops: LoopsLaw,
) -> tuple[list[Ends], Any]:
    """Return the wrenches of each branch on its bodies.

    Args:
        tree: of the joints.
        groups: of bodies.
        places: of each branch's joints.
        rows: of the engine.
        hold_loops: law of the joints of loops.

    Returns:
        Beside them, what `hold_loops` does.
    """
    carrying = {*range(tree.roots), *(branch.inboard for branch in tree.branches)}
    alone = rows.law(_alone)
    carried = {k: rows.settled(alone(groups[k])) for k in carrying}
    links = []
    for branch in tree.branches:
        inboard = rows.outward(groups[branch.inboard].bodies, branch)
        links.append(_Link(branch, inboard, groups[branch.group]))
    transmitted = _towards_roots(tree, links, places, carried, rows)
    on_roots, loops = hold_loops([carried[k] for k in range(tree.roots)])
    for k, wrench in enumerate(on_roots):
        carried[k] = Carried(
            carried[k].inertia, add_wrenches(carried[k].wrench, wrench)
        )
    return _from_roots(links, transmitted, carried, rows), loops


class _Link(NamedTuple):
    """The bodies of a branch."""

    branch: Branch
    inboard: BodyState
    outboard: Group


def _towards_roots(
    tree: JointTree,
    links: Sequence[_Link],
    places: Sequence[JointPlace],
    carried: dict[int, Carried],
    rows: Rows,
) -> list[Carried]:
    """Give to each inboard body what its branches transmit, and return that of each."""
    transmitted = []
    for (branch, *ends), place in reversed(list(zip(links, places, strict=True))):
        inward = rows.inward(branch, len(tree.groups[branch.inboard]))
        fixed = rows.settled, inward, branch.joints[0].type, branch.to_B
        more = [carried[branch.group]] if branch.group in carried else []
        law = rows.law(_with_more if more else _with_one, *fixed)
        own, carried[branch.inboard] = law(*ends, place, carried[branch.inboard], *more)
        transmitted.append(own)
    return transmitted[::-1]


def _from_roots(
    links: Sequence[_Link],
    transmitted: Sequence[Carried],
    carried: Mapping[int, Carried],
    rows: Rows,
) -> list[Ends]:
    """Return the wrenches that accelerate outboard bodies with inboard ones."""
    wrenches = {k: each.wrench for k, each in carried.items()}
    accelerations: dict[int, Acceleration] = {}
    found = []
    accelerated, needed = rows.law(acceleration_by), rows.law(_needed)
    for (branch, inboard, outboard), own in zip(links, transmitted, strict=True):
        k, group = branch.inboard, branch.group
        if k not in accelerations:
            accelerations[k] = rows.settled(
                accelerated(carried[k].inertia, wrenches[k])
            )
        V = rows.outward(accelerations[k], branch)
        ends = rows.held(needed(inboard, outboard.bodies, own, V), branch)
        if group in wrenches:
            wrenches[group] = add_wrenches(wrenches[group], ends[0])
        found.append(ends)
    return found


def _alone(group: Group) -> Carried:
    """Return bodies that carry nothing."""
    D, of_rates = inertia_of_body(group.bodies, group.massive)
    return Carried(D, subtract_wrenches(group.others, of_rates))


def _with_one(
    settled: Callable[[Any], Any],
    inward: Callable[[Any], Any],
    type: JointType,
    to_B: bool,
    inboard: BodyState,
    outboard: Group,
    place: JointPlace,
    carried: Carried,
) -> tuple[Carried, Carried]:
    """Return what the joint of an outboard body transmits that carries nothing.

    And what its inboard body carries with it.
    """
    fixed = settled, inward, type, to_B
    alone = settled(_alone(outboard))
    return _with_more(*fixed, inboard, outboard, place, carried, alone)


def _with_more(
    settled: Callable[[Any], Any],
    inward: Callable[[Any], Any],
    type: JointType,
    to_B: bool,
    inboard: BodyState,
    outboard: Group,
    place: JointPlace,
    carried: Carried,
    more: Carried,
) -> tuple[Carried, Carried]:
    """Return the same of one that carries more than itself."""
    own, given = _through(settled, type, to_B, inboard, outboard.bodies, place, more)
    return own, settled(_together(carried, inward(given)))


def _through(
    settled: Callable[[Any], Any],
    type: JointType,
    to_B: bool,
    inboard: BodyState,
    outboard: BodyState,
    place: JointPlace,
    carried: Carried,
) -> tuple[Carried, Carried]:
    """Return what a joint transmits of what its outboard body carries.

    About the origins of both bodies, the outboard one first.
    """
    ends = (inboard, outboard) if to_B else (outboard, inboard)
    motion = settled(joined(type, place, *ends))
    r = subtract(motion.p_WPad, outboard.p_WBo)
    D, wrench = carried
    for S in _free_directions(type, motion, r):
        D, wrench = settled(without_direction(D, wrench, S))
    needed = wrench_for(D, _given(type, motion, r, 1.0 if to_B else -1.0))
    D, wrench = settled((D, subtract_wrenches(wrench, needed)))
    arm = subtract(outboard.p_WBo, inboard.p_WBo)
    given = Carried(shifted_inertia(D, arm), shifted_wrench(wrench, arm))
    return Carried(D, wrench), given


def _together(first: Carried, second: Carried) -> Carried:
    """Return what two things that are carried are together, about the same point."""
    D = sum_of_inertias(first.inertia, second.inertia)
    return Carried(D, add_wrenches(first.wrench, second.wrench))


def _needed(
    inboard: BodyState, outboard: BodyState, own: Carried, V: Acceleration
) -> Ends:
    """Return the wrenches that accelerate an outboard body with the inboard one.

    Args:
        inboard: the body that holds it.
        outboard: the body.
        own: what the joint transmits, about its origin.
        V: of the inboard body.
    """
    arm = subtract(outboard.p_WBo, inboard.p_WBo)
    wrench = wrench_for(own.inertia, shifted_acceleration(V, arm))
    wrench = subtract_wrenches(wrench, own.wrench)
    return wrench, reaction(shifted_wrench(wrench, arm))


def _free_directions(type: JointType, motion: Joined, r: Vector) -> list[Acceleration]:
    """Return how a body may move whose joint is at r from its origin."""
    translation, rotation = CONSTRAINTS[type]
    free = [
        Acceleration(scale(0.0, e), e)
        for e, held in zip(motion.axes, translation, strict=True)
        if not held
    ]
    for k, held in enumerate(rotation):
        if not held:
            e = motion.axes[k]
            if k == 1 and motion.hinge is not None:
                e = motion.hinge
            free.append(Acceleration(e, cross(r, e)))
    return free


def _given(type: JointType, motion: Joined, r: Vector, sign: float) -> Acceleration:
    """Return what a joint gives of the acceleration of a body, whatever acts.

    Args:
        type: of the joint.
        motion: of its B from A.
        r: its place from the body's origin, m.
        sign: 1 of B, as its A has it; -1 of A, as its B has it.
    """
    a = _along(motion.axes, CONSTRAINTS[type].translation, motion.a)
    if all(CONSTRAINTS[type].rotation):
        alpha = motion.alpha
    else:
        alpha = scale(0.0, motion.alpha)
        for e, beside in held_turns(type, motion):
            alpha = add(alpha, scale(beside / dot(e, e), e))
    alpha, a = scale(-sign, alpha), scale(-sign, a)
    return Acceleration(alpha, add(a, cross(r, alpha)))


def _along(axes: Sequence[Vector], which: Sequence[bool], v: Vector) -> Vector:
    """Return the part of a vector along some of three axes."""
    if all(which):
        return v
    part = scale(0.0, v)
    for e, held in zip(axes, which, strict=True):
        if held:
            part = add(part, scale(dot(e, v), e))
    return part
