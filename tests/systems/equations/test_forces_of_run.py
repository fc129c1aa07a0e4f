"""Loads and forces over a run, against Newton's and Euler's laws and closed forms.

The motion comes from Drake. What is held against it does not ask the laws of joints and
springs: a body's momentum must change as loads and forces say.
"""

import dataclasses
import math

import numpy as np
import pytest
from separations import GENERIC, STIFF, generic_pair

from drakesep.systems.equations.forces_of_run import spring_forces
from drakesep.systems.equations.loads_of_run import joint_loads, preloads_of_run
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.separation import Attachment, InitialMotion
from drakesep.systems.model.springs import DisplacementSpring
from drakesep.systems.simulation.simulation import Simulation
from drakesep.systems.vectors import rotation_matrix


TIGHT = Integration(accuracy=1e-9)


@pytest.fixture(scope="module")
def held():
    """Two bodies that turn while two pads hold them; the pads let go one by one."""
    pair = generic_pair(duration=0.6)
    pads = [
        Attachment(
            name=f"pad_{i}",
            A=pair.A,
            B=pair.B,
            p_AoPad_A=(0.05, y, -0.2),
            joint=dataclasses.replace(STIFF, x_axis_A=x, y_axis_A=(0.0, 1.0, 0.0)),
            spring=DisplacementSpring(
                name=f"push_{i}", force_max=900.0, stroke=0.02, damping=30.0
            ),
            release_time=t,
        )
        for i, (y, t, x) in enumerate(
            [(0.4, 0.2, (0.6, 0.0, 0.8)), (-0.3, 0.3, (1.0, 0.0, 0.0))]
        )
    ]
    separation = dataclasses.replace(
        pair,
        attachments=tuple(pads),
        orbit=None,
        initial=InitialMotion(rpy_WA=GENERIC.rpy_WA, w_WA_A=(0.5, -0.3, 0.8)),
    )
    return Simulation(separation, TIGHT).run()


def rotations(states):
    q = states[:, :4].T
    return np.moveaxis(np.array(rotation_matrix(tuple(q))).reshape(3, 3, -1), -1, 0)


def test_loads_and_forces_are_what_changes_the_momentum_of_b(held):
    """Newton: their sum is B's mass by the acceleration of its CG, at every sample."""
    separation, motion = held.separation, held.motion
    R_WA = rotations(held.trajectory.of(separation.A))
    total = np.zeros((len(motion.time), 3))
    for attachment in separation.attachments:
        R_AJ = np.array(attachment.joint.R_AJ).reshape(3, 3)
        # What springs press with while they are held moves nothing.
        pressed = preloads_of_run(held)[attachment.name]
        force_J = (joint_loads(held)[attachment.name] - pressed)[:, 3:]
        total += np.einsum("nij,jk,nk->ni", R_WA, R_AJ, force_J)
        push = spring_forces(held)[attachment.spring.name]
        total += push[:, None] * R_WA[:, :, 0]  # along A's x axis
    expected = separation.body(separation.B).mass * motion.acceleration
    # Accelerations are slopes of cubics through the steps of stiff joints: they are
    # told to some thousandths of the largest.
    largest = np.abs(expected).max()
    assert largest > 100.0
    assert np.median(np.abs(total - expected)) < 1e-4 * largest
    near = np.abs(motion.time[:, None] - np.array(held.breaks)).min(axis=1) < 2e-3
    assert np.abs(total - expected)[~near].max() < 5e-3 * largest


def test_nothing_holds_or_pushes_when_it_should_not(held):
    time = held.trajectory.time
    for attachment in held.separation.attachments:
        released, end = (
            attachment.release_time,
            held.stroke_ends[attachment.spring.name],
        )
        load = np.abs(joint_loads(held)[attachment.name]).sum(axis=1)
        assert (load[time >= released] == 0.0).all()
        assert (load[(0.0 < time) & (time < released)] > 0.0).all()
        push = spring_forces(held)[attachment.spring.name]
        assert (push[(time < released) | (time >= end)] == 0.0).all()
        assert (push[(time > released) & (time < end - 1e-3)] > 0.0).all()


def test_force_of_equation_5():
    """F cos(w t) until w t = pi/2, with w from force, stroke and design mass."""
    run = Simulation(generic_pair(duration=0.6)).run()
    time = run.trajectory.time
    for attachment, spring in run.separation.pushing:
        w = math.sqrt(spring.force_max / (spring.design_mass * spring.stroke))
        age = time - attachment.release_time
        pushes = (age >= 0.0) & (w * age < 0.5 * math.pi)
        expected = np.where(pushes, spring.force_max * np.cos(w * age), 0.0)
        # Round-off of the largest force; the last sample is the end of the stroke.
        assert spring_forces(run)[spring.name] == pytest.approx(
            expected, abs=1e-9 * spring.force_max
        )
