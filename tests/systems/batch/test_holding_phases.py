"""Which joints may hold in a batch: by release times that are known."""

import dataclasses
import math

import jax
import jax.numpy as jnp
import pytest
from separations import generic_pair

from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.holding_phases import holding_phases
from drakesep.systems.equations.rigid_joints import rigid_joints
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.parameters import parameters


NONE, WELD, HINGE, BOTH = map(frozenset, ((), {0}, {1}, {0, 1}))


def weld_and_hinge(weld, hinge, **changes):
    """Of two bodies: a loop until one has let go.

    Args:
        weld: when it lets go, s.
        hinge: likewise.
        changes: of the hinge.
    """
    separation = generic_pair(release_times=(weld, hinge), joint=Joint(rigid=True))
    first, second = separation.attachments
    joint = Joint(type="revolute", rigid=True)
    second = dataclasses.replace(second, joint=joint, **changes)
    return dataclasses.replace(separation, attachments=(first, second))


def time_of(k, separation):
    return f"{separation.attachments[k].name}.release_time"


@pytest.mark.parametrize(
    ("weld", "hinge", "phases"),
    [
        (0.2, 0.4, [NONE, HINGE, BOTH]),
        (0.2, 0.2, [NONE, BOTH]),
        (0.0, 0.4, [NONE, HINGE]),
        (0.0, 0.0, [NONE]),
    ],
)
def test_a_loop_is_open_once_its_first_joint_has_let_go(weld, hinge, phases):
    separation = weld_and_hinge(weld, hinge)
    assert holding_phases(separation, rigid_joints(separation), []) == phases


def test_a_joint_that_lets_go_at_an_angle_may_hold_for_ever():
    separation = weld_and_hinge(0.2, math.inf, release_angle=0.1)
    phases = holding_phases(separation, rigid_joints(separation), [])
    assert phases == [NONE, HINGE, BOTH]


@pytest.mark.parametrize(
    ("varied", "phases"),
    [
        ([0], [NONE, WELD, BOTH]),
        ([1], [NONE, HINGE, BOTH]),
        ([0, 1], [NONE, BOTH]),
    ],
)
def test_a_release_that_varies_may_come_at_any_time(varied, phases):
    separation = weld_and_hinge(0.2, 0.4)
    names = [time_of(k, separation) for k in varied]
    assert holding_phases(separation, rigid_joints(separation), names) == phases


def test_a_release_that_varies_from_zero_may_come_later():
    separation = weld_and_hinge(0.0, 0.0)
    names = [time_of(1, separation)]
    phases = holding_phases(separation, rigid_joints(separation), names)
    assert phases == [NONE, HINGE]


@pytest.mark.parametrize(
    ("holds", "place"),
    [
        ([[False, False], [False, False]], 0),
        ([[False, False], [False, True]], 1),
        ([[False, True], [False, False]], 2),
        ([[True, False], [False, True]], 2),
    ],
)
def test_a_phase_has_all_that_hold_in_any_lane(holds, place):
    """By attachment and lane; the last is of lanes that are in phases of their own."""
    separation = weld_and_hinge(0.2, 0.4)
    with jax.enable_x64(True):
        equations = BatchEquations(separation)
        _, mode = equations.start(equations.params(parameters(separation), 2))
        released = jnp.where(jnp.array(holds), jnp.inf, 0.1)
        assert equations.phase(mode._replace(released=released)).item() == place
