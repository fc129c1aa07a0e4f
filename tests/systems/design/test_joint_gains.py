"""The gains that are proposed give what was wanted."""

import dataclasses
import math

import numpy as np
import pytest
from flying import simulator_of
from separations import coaxial, generic_pair

from drakesep.systems.design.joint_gains import propose_joint
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.separation import InitialMotion


WANTED = {"force": 800.0, "torque": 300.0, "deviation": 1e-4, "rotation": 2e-4}


def held(separation, joint):
    [attachment] = separation.attachments
    return dataclasses.replace(
        separation, attachments=(dataclasses.replace(attachment, joint=joint),)
    )


def one_attachment(**options):
    separation = generic_pair(release_times=(0.9,), springs=False, **options)
    lower, upper = separation.bodies
    upper = dataclasses.replace(upper, p_ABo=(0.2, 0.1, 0.0), rpy_AB=(0.3, -0.2, 0.4))
    return dataclasses.replace(separation, bodies=(lower, upper))


def test_joint_gives_as_much_as_wanted():
    """Under the load, on B at the pad and on A against it, once it has settled."""
    separation = one_attachment(initial=InitialMotion())
    lower, upper = separation.bodies
    [attachment] = separation.attachments
    pad = attachment.p_AoPad_A
    joint = propose_joint(lower, upper, pad, damping_ratio=1.0, **WANTED)
    separation = held(separation, joint)
    system = SeparationSystem(separation, external_wrenches=True)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    force, torque = np.array([0.0, 800.0, 0.0]), np.array([0.0, 0.0, 300.0])
    lever = np.array(pad) - upper.p_ABo
    wrenches = [
        *-(torque + np.cross(pad, force)),
        *-force,
        *(torque + np.cross(lever, force)),
        *force,
    ]
    system.GetInputPort("external_wrenches").FixValue(context, wrenches)
    simulator_of(system, context, 1e-8).AdvanceTo(0.3)
    loads = system.GetOutputPort("joint_loads").Eval(context)
    # The pair of loads does not move the stack: the joint carries all of it, less
    # what its lag of the 1e-4 m takes.
    assert loads == pytest.approx([0, 0, -300, 0, -800, 0], abs=1.0)
    [energy] = system.GetOutputPort("joint_energy").Eval(context)
    assert energy == pytest.approx(0.5 * (800 * 1e-4 + 300 * 2e-4), rel=2e-3)


def test_damping_ratio_of_uncoupled_oscillations():
    """Along and about the axis of a coaxial pair: the eigenvalues of its motion."""
    separation = coaxial(
        generic_pair(release_times=(0.9,), springs=False, initial=InitialMotion())
    )
    [attachment] = separation.attachments
    attachment = dataclasses.replace(attachment, p_AoPad_A=(0.1, 0.0, 0.0))
    separation = dataclasses.replace(
        separation, attachments=(attachment,), initial=InitialMotion()
    )
    joint = propose_joint(
        *separation.bodies, attachment.p_AoPad_A, damping_ratio=0.4, **WANTED
    )
    separation = held(separation, joint)
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    eigenvalues = np.linalg.eigvals(linearised(system, context))
    mu = 700.0 * 1200.0 / 1900.0
    I_A, I_B = (body.I_BBcm_B[0] for body in separation.bodies)
    J = I_A * I_B / (I_A + I_B)
    for w in (math.sqrt(800.0 / 1e-4 / mu), math.sqrt(300.0 / 2e-4 / J)):
        expected = w * complex(-0.4, math.sqrt(1.0 - 0.4**2))
        # central differences over 1e-6 of an analytic function
        assert np.abs(eigenvalues - expected).min() < 1e-5 * w


def linearised(system, context):
    x0 = context.get_continuous_state_vector().CopyToVector()
    columns = []
    for i in range(26):  # of the plant
        derivatives = []
        for step in (-1e-6, 1e-6):
            x = x0.copy()
            x[i] += step
            context.SetContinuousState(x)
            derivatives.append(system.EvalTimeDerivatives(context).CopyToVector()[:26])
        columns.append((derivatives[1] - derivatives[0]) / 2e-6)
    return np.array(columns).T


def test_effective_mass_at_a_pad_off_the_axis():
    """A generic joint: the acceleration that it gives to a unit of deviation."""
    separation = one_attachment(initial=InitialMotion())
    lower, upper = separation.bodies
    [attachment] = separation.attachments
    axes = {"x_axis_A": (0.6, 0.8, 0.0), "y_axis_A": (0.0, 0.0, 1.0)}
    joint = propose_joint(lower, upper, attachment.p_AoPad_A, **WANTED, **axes)
    mass = (joint.D_F[1] / (2.0 * 0.7)) ** 2 / joint.K_F[1]
    system = SeparationSystem(held(separation, joint), external_wrenches=True)
    context = system.CreateDefaultContext()
    system.set_separation(context, held(separation, joint))
    force, lever = np.array([0, 0, 1.0]), attachment.p_AoPad_A - np.array(upper.p_ABo)
    pad = np.array(attachment.p_AoPad_A)
    wrenches = [*-np.cross(pad, force), *-force, *np.cross(lever, force), *force]
    system.GetInputPort("external_wrenches").FixValue(context, wrenches)
    rates = system.EvalTimeDerivatives(context).CopyToVector()[14:26].reshape(4, 3)
    alpha_A, a_A, alpha_B, a_B = rates
    apart = a_B + np.cross(alpha_B, lever) - a_A - np.cross(alpha_A, pad)
    assert apart @ force == pytest.approx(1.0 / mass, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"force": 0.0}, "joint: force must be > 0, got 0"),
        ({"deviation": -1e-4}, "joint: deviation must be > 0, got -0.0001"),
        ({"rotation": math.nan}, "joint: rotation must be finite, got nan"),
        ({"damping_ratio": -0.1}, "joint: damping ratio must be >= 0, got -0.1"),
        ({"type": "hinge"}, "joint: unknown type 'hinge'"),
    ],
)
def test_bad_wishes(change, message):
    with pytest.raises(ValueError, match=message):
        propose_joint(*generic_pair().bodies, (0, 0, 0), **(WANTED | change))
