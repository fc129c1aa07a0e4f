"""What springs press the joints with that hold: by statics."""

import dataclasses
import math

import numpy as np
import pytest
from flying import start
from scipy.spatial.transform import Rotation
from separations import FREE, GENERIC, STIFF, by_displacement, generic_pair, on_axis

from drakesep.analysis.metrics.of_run import metric_of_run
from drakesep.systems.equations.loads_of_run import joint_loads, preloads_of_run
from drakesep.systems.equations.mated_stack import mated_places, place_in_A
from drakesep.systems.equations.preload import preloads
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.parameters import with_values
from drakesep.systems.simulation.simulation import Simulation


RIGID = Joint(rigid=True)
LATE = (0.1, 0.2, 0.3, 0.4)


def turned_joint(joint):
    """In a frame that is not A's."""
    x, y, _ = Rotation.from_euler("xyz", (0.4, -0.7, 1.1)).as_matrix().T
    return dataclasses.replace(joint, x_axis_A=tuple(x), y_axis_A=tuple(y))


def in_A(separation, loads):
    """Forces and torques about A's origin of loads at pads, in A, (n, 6)."""
    totals = []
    places = mated_places(separation)
    for i, (torque, force) in loads.items():
        a = separation.attachments[i]
        R_AJ = np.reshape(a.joint.R_AJ, (3, 3))
        force, torque = R_AJ @ force, R_AJ @ torque
        pad = place_in_A(places[a.A], places[a.A], a.p_AoPad_A)
        totals.append([*(torque + np.cross(pad, force)), *force])
    return np.array(totals)


@pytest.mark.parametrize("joint", [STIFF, RIGID, turned_joint(STIFF)])
def test_equal_springs_on_equal_pads(joint):
    """Six of 300 N: each pad carries its own spring, and no torque."""
    pair = generic_pair(release_times=(0.1,) * 6, joint=joint)
    pair = by_displacement(pair)
    pair = with_values(pair, {f"{s.name}.force_max": 300.0 for s in pair.springs})
    loads = in_A(pair, preloads(pair, range(6)))
    pads = np.array([a.p_AoPad_A for a in pair.attachments])
    force = np.array([300.0, 0.0, 0.0])
    # Round-off of a pseudo-inverse.
    assert loads[:, 3:] == pytest.approx(np.tile(-force, (6, 1)), abs=1e-9)
    assert loads[:, :3] == pytest.approx(np.cross(pads, -force), abs=1e-9)
    run = Simulation(dataclasses.replace(pair, bodies=on_axis(pair))).run()
    told = metric_of_run(run, "attachment_2.joint_force_at_release", (math.inf,) * 3)
    # And what the stack's rate asks of it.
    assert told == pytest.approx(300.0, rel=0.05)


def generic_springs(joint=STIFF, **changes):
    """Unequal springs of both laws, tilted, on pads beside one another."""
    pair = generic_pair(release_times=LATE, joint=joint, **changes)
    profile = ((0.0, 0.6), (0.5, 1.0), (1.0, 0.2))
    wound = by_displacement(pair, profile, damping=30.0).attachments
    attachments = [
        dataclasses.replace(
            a, spring=dataclasses.replace(a.spring, tilt_y=0.1 * i, tilt_z=-0.15 * i)
        )
        for i, a in enumerate((*pair.attachments[:2], *wound[2:]))
    ]
    return dataclasses.replace(pair, attachments=tuple(attachments))


@pytest.mark.parametrize("held", [(0, 1, 2, 3), (1, 3), (2,)])
@pytest.mark.parametrize("joint", [STIFF, turned_joint(RIGID)])
def test_forces_and_moments_are_in_balance(joint, held):
    pair = generic_springs(joint)
    total = np.zeros(6)
    for i in held:
        a = pair.attachments[i]
        spring = a.spring
        turn = Rotation.from_euler("yz", (spring.tilt_y, spring.tilt_z))
        largest = spring.force_max * (1.0 if i < 2 else 0.6)
        push = largest * turn.apply([1.0, 0.0, 0.0])
        total += [*np.cross(a.p_AoPad_A, push), *push]
    loads = preloads(pair, held)
    assert sorted(loads) == sorted(held)
    balance = in_A(pair, loads).sum(axis=0) + total
    assert balance == pytest.approx(np.zeros(6), abs=1e-9)


def test_a_direction_that_is_free_carries_nothing():
    """Along it nothing holds the spring: that is for what does."""
    slide = Joint(type="prismatic", K_F=1e6, D_F=1e3, K_T=1e5, D_T=1e3)
    pair = generic_pair(release_times=(0.1, 0.1), joint=slide)
    for torque, force in preloads(pair, (0, 1)).values():
        assert force[0] == pytest.approx(0.0, abs=1e-9)
        assert torque == pytest.approx((0.0, 0.0, 0.0), abs=1e3)


def test_joints_share_it_by_their_stiffness():
    """As 1 to 3; one without stiffness carries nothing, and a rigid one all."""
    soft = Joint(type="spherical", K_F=1e5, D_F=0.0, K_T=0.0, D_T=0.0)
    stiff = dataclasses.replace(soft, K_F=3e5)
    rigid = Joint(type="spherical", rigid=True)
    pair = generic_pair(release_times=(0.1, 0.1, 0.1))
    pads = [dataclasses.replace(a, p_AoPad_A=(0.0, 0.0, 0.0)) for a in pair.attachments]
    total = sum(spring.force_max for spring in pair.springs)
    for joints, shares in (
        ((soft, stiff, FREE), (0.25, 0.75, 0.0)),
        ((soft, rigid, FREE), (0.0, 1.0, 0.0)),
        ((FREE, FREE, FREE), (0.0, 0.0, 0.0)),
    ):
        attachments = [
            dataclasses.replace(a, joint=joint)
            for a, joint in zip(pads, joints, strict=True)
        ]
        one = dataclasses.replace(pair, attachments=tuple(attachments))
        forces = [force[0] for _, force in preloads(one, (0, 1, 2)).values()]
        # A rigid joint is a million times as stiff as others.
        assert forces == pytest.approx([-total * x for x in shares], abs=2e-6 * total)


def test_the_other_way_round():
    """A and B of an attachment changed about: the same loads, on the other body."""
    pair = generic_pair(release_times=(0.1, 0.1, 0.1))
    turned = [
        dataclasses.replace(a, A="upper", B="lower", spring=s)
        for a, s in zip(
            pair.attachments,
            [dataclasses.replace(s, axis_A=(-1.0, 0.0, 0.0)) for s in pair.springs],
            strict=True,
        )
    ]
    mixed = dataclasses.replace(pair, attachments=(pair.attachments[0], *turned[1:]))
    loads, other = (preloads(p, (0, 1, 2)) for p in (pair, mixed))
    for i, sign in enumerate((1.0, -1.0, -1.0)):
        for one, same in zip(loads[i], other[i], strict=True):
            assert np.array(same) == pytest.approx(sign * np.array(one), abs=1e-9)


def test_rigid_joints_carry_as_much_after_the_first_release():
    """What moves nothing is carried: before as preload, then against the spring.

    Stack at rest, springs by displacement: 4 F in all, whichever is released.
    """
    pair = by_displacement(generic_springs(RIGID))
    pair = dataclasses.replace(
        pair, initial=dataclasses.replace(GENERIC, w_WA_A=(0, 0, 0))
    )
    run = Simulation(pair, Integration(accuracy=1e-8)).run()
    total = sum(spring.force_max for spring in pair.springs)
    loads = np.sum([*joint_loads(run).values()], axis=0)
    held = run.trajectory.time < run.releases["attachment_4"]
    # Round-off of the motion, and the drift of a rigid joint's steps.
    assert loads[held, 3] == pytest.approx(-total, rel=1e-6)
    pressed = np.sum([*preloads_of_run(run).values()], axis=0)[:, 3]
    for i, release in enumerate((0.0, *LATE[:-1])):
        rest = sum(spring.force_max for spring in pair.springs[i:])
        k = np.searchsorted(run.trajectory.time, release + 0.01)
        assert pressed[k] == pytest.approx(-rest)


def test_port_and_run_tell_the_same():
    pair = generic_springs()
    run = Simulation(pair, Integration(accuracy=1e-9)).run()
    system, context, simulator = start(pair, 1e-9)
    values = {"spring_1.force_max": 1500.0, "attachment_2.position_y": 0.3}
    for t in (0.05, 0.15, 0.35, 0.45):
        simulator.AdvanceTo(t)
        port = system.GetOutputPort("preloads").Eval(context).reshape(-1, 6)
        k = np.searchsorted(run.trajectory.time, t)
        for load, expected in zip(preloads_of_run(run).values(), port, strict=True):
            assert load[k] == pytest.approx(expected, abs=1e-9)
    # The numbers are those of the Context.
    other = with_values(pair, values)
    fresh = system.CreateDefaultContext()
    system.set_separation(fresh, other)
    port = system.GetOutputPort("preloads").Eval(fresh).reshape(-1, 6)
    wanted = preloads(other, range(4))
    for i, (torque, force) in wanted.items():
        assert port[i] == pytest.approx([*torque, *force], abs=1e-9)
