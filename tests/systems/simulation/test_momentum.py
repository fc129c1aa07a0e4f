"""Momentum of the whole system is conserved, whatever acts between its bodies."""

import dataclasses

import numpy as np
import pytest
from flying import momentum, start
from pydrake.multibody.math import SpatialVelocity
from separations import FREE, GENERIC, generic_pair

from drakesep.systems.model.joints import JOINT_TYPES, Joint
from drakesep.systems.model.separation import Separation
from drakesep.systems.model.springs import DisplacementSpring


ACCURACY = 1e-8
SPAN = 0.3
HELD, AT_START = (0.9,) * 4, (0.0,) * 4
STAGED = (0.0, 0.1, 0.101, 0.102)
BEFORE_START = (0.01, 0.02, 0.03, 0.04)
LINEAR = {"stroke": 0.5, "damping": 200.0}
TABLE = {"stroke": 0.5, "profile": ((0.0, 0.7), (0.1, 1.0), (0.6, 0.4), (1.0, 0.2))}


def held_by(joint_type):
    """Soft enough to swing, in a frame of its own."""
    return Joint(
        type=joint_type,
        K_F=(2e4, 3e4, 4e4),
        D_F=(2e2, 3e2, 1e2),
        K_T=(5e3, 9e3, 7e3),
        D_T=(1e2, 2e2, 3e2),
        x_axis_A=(0.36, 0.48, 0.8),
        y_axis_A=(0.8, -0.6, 0.0),
    )


def pair(release_times, joint=FREE, law=None, springs=True) -> Separation:
    """Turning fast in a generic attitude, with one body askew in the stack."""
    separation = generic_pair(
        release_times=release_times,
        joint=joint,
        springs=springs,
        initial=dataclasses.replace(GENERIC, w_WA_A=(1.2, -0.9, 1.3)),
    )
    lower, upper = separation.bodies
    upper = dataclasses.replace(
        upper, p_ABo=(0.2, 0.03, -0.05), rpy_AB=(0.3, -0.2, 0.4)
    )
    attachments = separation.attachments
    if law is not None:
        attachments = tuple(
            dataclasses.replace(
                a, spring=DisplacementSpring(name=a.spring.name, force_max=1e3, **law)
            )
            for a in attachments
        )
    return dataclasses.replace(
        separation, bodies=(lower, upper), attachments=attachments
    )


CASES = {
    **{f"{t} joint": (pair(HELD, held_by(t), springs=False), 0.0) for t in JOINT_TYPES},
    "time": (pair(AT_START), 0.0),
    "linear": (pair(AT_START, law=LINEAR), 0.0),
    "table": (pair(AT_START, law=TABLE), 0.0),
    "staged, time": (pair(STAGED, held_by("fixed")), 0.0),
    "staged, linear": (pair(STAGED, held_by("spherical"), LINEAR), 0.0),
    "staged, table": (pair(STAGED, held_by("revolute"), TABLE), 0.0),
    "scheduled before the start": (pair(BEFORE_START, law=LINEAR), 0.05),
}
"""Separations, and the times of their start, s."""


@pytest.mark.parametrize(("separation", "begin"), CASES.values(), ids=CASES)
def test_momentum_is_conserved(separation, begin):
    """Linear, and angular about the world's origin."""
    system, context, simulator = start(separation, ACCURACY)
    context.SetTime(begin)
    plant = system.plant
    plant_context = plant.GetMyMutableContextFromRoot(context)
    plant.SetFreeBodySpatialVelocity(  # off the stack's motion
        plant_context,
        plant.GetBodyByName("upper"),
        SpatialVelocity([1.5, -1.0, 2.0], [0.5, 1.0, -0.5]),
    )
    before = momentum(system, context)
    energy = plant.CalcKineticEnergy(plant_context)
    simulator.AdvanceTo(begin + SPAN)
    # The forces cancel to round-off at every instant. Neither momentum is linear in the
    # state, which holds the velocities of origins, not of CGs: both are kept to the
    # integration's 1e-8 m/s and rad/s of one step, on a ton and a ton m^2.
    assert momentum(system, context) == pytest.approx(before, abs=ACCURACY * 1000.0)

    # Something did act, of some 1e4 J in all, after the releases of the case.
    assert abs(plant.CalcKineticEnergy(plant_context) - energy) > 100.0
    released = np.isfinite(system.GetOutputPort("released").Eval(context))
    due = [a.release_time < begin + SPAN for a in separation.attachments]
    assert released.tolist() == due
