"""Forces where bodies touch again, against closed forms."""

import dataclasses
import math

import numpy as np
import pytest
import trimesh
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder
from scipy.optimize import brentq
from separations import coaxial, generic_pair

from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.systems.diagram.on_your_plant import add_separation
from drakesep.systems.diagram.scene import register_contact
from drakesep.systems.diagram.separation_system import (
    SeparationSystem,
    set_mated_motion,
    spatial_inertia,
)
from drakesep.systems.geometry.convex_pieces import FACET
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parts import Box, Cone, Mesh, Part, Sphere
from drakesep.systems.model.recontact import Recontact
from drakesep.systems.model.run import RunStatus
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.sampling import NANOSECOND
from drakesep.systems.simulation.simulation import Simulation


STIFFNESS = 4e5
GAP = 0.05
FINE = Integration(accuracy=1e-9, max_step=2e-3)
"""A contact lasts 0.1 s."""
LOWER = Part(name="lower_ball", shape=Sphere(radius=0.1))
UPPER = Part(name="upper_ball", shape=Sphere(radius=0.1), p_BoGo_B=(0.25, 0.0, 0.0))


def pair(on_lower, on_upper, load=(-400.0, 0.0, 0.0), **contact):
    """Bodies that let go at once, without springs; a load pushes the upper back."""
    apart = coaxial(generic_pair(springs=False, initial=InitialMotion()))
    lower, upper = apart.bodies
    return dataclasses.replace(
        apart,
        bodies=(
            dataclasses.replace(lower, parts=tuple(on_lower)),
            dataclasses.replace(upper, parts=tuple(on_upper)),
        ),
        loads=(
            Load(
                name="thruster",
                body="upper",
                p_BoQ_B=upper.p_BoBcm_B,
                times=(0.0, 0.2),
                forces=(load, load),
            ),
        ),
        initial=InitialMotion(),
        recontact=Recontact(stiffness=STIFFNESS, **contact) if contact else None,
        duration=2.0,
    )


def fly(separation, integration=FINE):
    run = Simulation(separation, integration).run()
    assert run.status is RunStatus.COMPLETED, run.message
    return run


@pytest.mark.parametrize("dissipation", [0.0, 3.0])
def test_bounce(dissipation):
    separation = pair([LOWER], [UPPER], dissipation=dissipation)
    run = fly(separation)
    motion = run.motion
    m = [body.mass for body in separation.bodies]
    reduced = m[0] * m[1] / (m[0] + m[1])
    speed = 400.0 / m[1] * 0.2
    x, v = motion.relative_position[:, 0], motion.relative_velocity[:, 0]
    before = (motion.time > 0.25) & (x > -GAP)
    towards = before & (v < 0.0)
    assert v[towards] == pytest.approx(-speed, rel=1e-7)

    # m x'' = -k x (1 + d x'), integrated over x on the way in and out.
    def spent(dv):
        return dv - math.log1p(dv)

    d = dissipation
    left = speed
    if d > 0.0:
        left = brentq(lambda u: spent(-d * u) - spent(d * speed), 0.0, 0.999 / d)
        assert left < 0.9 * speed
    assert v[-1] == pytest.approx(left, rel=1e-4)  # onset and end within steps
    # The impulse, from the step before the contact to that after it.
    [contact] = run.contacts
    assert not contact.force[[0, -1]].any()
    impulse = np.trapezoid(contact.force[:, 0], contact.time)
    assert impulse == pytest.approx(reduced * (speed + v[-1]), rel=1e-3)
    # No sample stands twice, but for round-off.
    assert np.diff(motion.time).min() > NANOSECOND
    if d == 0.0:
        # Half a sine of 104 ms, sampled every 10.
        depth = speed * math.sqrt(reduced / STIFFNESS)
        assert -GAP - x.min() == pytest.approx(depth, rel=0.012)
        # At steps: 2 ms of 104.
        assert (contact.first, contact.second) == ("lower_ball", "upper_ball")
        peak = speed * math.sqrt(reduced * STIFFNESS)
        assert contact.force[:, 0].max() == pytest.approx(peak, rel=1e-3)
        assert np.ptp(contact.time) == pytest.approx(
            math.pi * math.sqrt(reduced / STIFFNESS), abs=4e-3
        )
    # What one body gains the other loses: the CG of both moves as the load says.
    trajectory = run.trajectory
    momentum = sum(
        body.mass * trajectory.of(body.name)[-1, 10] for body in separation.bodies
    )
    assert momentum == pytest.approx(-400.0 * 0.2, rel=1e-7)


def test_forces_are_told_and_slide_with_friction():
    plate = Part(name="plate", shape=Box(size=(0.2, 4.0, 4.0)))
    separation = pair([plate], [UPPER], friction=0.3)
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    assert system.contact_forces(context) == {}
    plant = system.plant
    own = plant.GetMyMutableContextFromRoot(context)
    upper = plant.GetBodyByName("upper")
    deep = 1e-3
    plant.SetFloatingBaseBodyPoseInWorldFrame(
        own, upper, RigidTransform([-GAP - deep, 0.0, 0.0])
    )
    plant.SetFreeBodySpatialVelocity(
        own, upper, SpatialVelocity(np.zeros(3), np.array([0.0, 0.5, 0.0]))
    )
    forces = system.contact_forces(context)
    normal = STIFFNESS * deep
    assert forces[("plate", "upper_ball")] == pytest.approx(
        (normal, -0.3 * normal, 0.0), rel=1e-9
    )


def test_inside_a_tube_there_is_room():
    """A ball in a tube whose hull it would overlap by its whole width."""
    wall = Cone(radius_aft=0.3, radius_fore=0.3, length=2.0, thickness=0.05)
    tube = Part(name="tube", shape=wall)
    ball = Part(name="ball", shape=Sphere(radius=0.1))
    sideways = (0.0, 900.0, 0.0)
    separation = pair([tube], [ball], load=sideways, friction=0.0)
    # Each of many staves has its kink: more accurate takes minutes.
    rough = Integration()
    free = fly(dataclasses.replace(separation, recontact=None), rough).motion
    held = fly(separation, rough).motion
    gap = 0.25 - 0.1
    assert free.relative_position[:, 1].max() > 1.2 * gap
    apart = free.relative_position[:, 1] < 0.95 * gap
    early = apart & (free.time < free.time[~apart][0])
    same = np.isin(held.time, free.time[early])
    np.testing.assert_allclose(
        held.relative_position[same], free.relative_position[early], atol=1e-6
    )
    assert held.relative_velocity[-1, 1] < 0.0
    # As deep as one wall's spring lets it: several staves only make it stiffer.
    m = [body.mass for body in separation.bodies]
    speed = 900.0 / m[1] * 0.2
    depth = speed * math.sqrt(m[0] * m[1] / sum(m) / STIFFNESS)
    assert gap < held.relative_position[:, 1].max() < gap + depth + FACET


def test_a_mesh_pushes_if_it_is_convex(tmp_path):
    """In the surface of a dented one Drake finds depths of any size."""
    solid, hollow = tmp_path / "solid.stl", tmp_path / "hollow.stl"
    trimesh.creation.box(extents=[0.2, 0.2, 0.2]).export(solid)
    trimesh.creation.annulus(0.05, 0.1, 0.2, sections=12).export(hollow)
    block = Part(name="block", shape=Mesh(file=solid))
    motion = fly(pair([block], [UPPER], friction=0.0), Integration()).motion
    assert motion.relative_position[:, 0].min() > -GAP - 0.01
    assert motion.relative_velocity[-1, 0] > 0.0
    pipe = Part(name="pipe", shape=Mesh(file=hollow))
    with pytest.raises(ValueError, match="pipe: a mesh that pushes must be convex"):
        SeparationSystem(pair([pipe], [UPPER], friction=0.0))


def test_a_short_blow_in_a_long_run_is_a_contact():
    """It lasts 21 ms, and samples are 100 ms apart."""
    separation = dataclasses.replace(
        pair([LOWER], [UPPER], friction=0.0),
        recontact=Recontact(stiffness=1e7),
        duration=30.0,
    )
    run = fly(separation, Integration())
    [found] = ClearanceAnalysis(separation).of(run)
    [blow] = run.contacts
    assert found.contact is not None
    # A step is 10 ms, in which the gap closes by 0.7 mm.
    assert found.contact.time == pytest.approx(blow.time[0], abs=11e-3)
    assert found.contact.closing_speed == pytest.approx(400.0 / 1200.0 * 0.2, rel=1e-3)


def test_contact_on_a_plant_of_ones_own():
    separation = pair([LOWER], [UPPER], friction=0.0)
    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    for body in separation.bodies:
        plant.AddRigidBody(body.name, spatial_inertia(body))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    register_contact(plant, scene, separation)
    plant.Finalize()
    with pytest.raises(ValueError, match="recontact: must be None here"):
        add_separation(builder, plant, separation)
    free = dataclasses.replace(separation, recontact=None)
    parts = add_separation(builder, plant, free)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    parts.set_separation(parts.GetMyMutableContextFromRoot(context), free)
    set_mated_motion(plant, plant.GetMyMutableContextFromRoot(context), free)
    context.SetAccuracy(1e-6)
    simulator = Simulator(diagram, context)
    ApplySimulatorConfig(SimulatorConfig(max_step_size=5e-3, accuracy=1e-6), simulator)
    simulator.AdvanceTo(2.0)
    velocity = parts.GetOutputPort("relative_velocity").Eval(
        parts.GetMyContextFromRoot(context)
    )
    assert velocity[0] == pytest.approx(400.0 / 1200.0 * 0.2, rel=1e-3)


WALL = Part(name="wall", shape=Box(size=(0.02, 0.6, 0.6)), p_BoGo_B=(0.0, 0.0, 0.0))
CUBE = Part(name="cube", shape=Box(size=(0.2, 0.2, 0.2)), p_BoGo_B=(0.16, 0.0, 0.0))


@pytest.mark.parametrize("depth", [0.009, 0.011, 0.1])
def test_what_is_pressed_beyond_the_middle_of_a_thin_wall_has_failed(depth):
    """A foundation of s A takes up the energy of m v^2 / 2 by a depth of v (m/sA)^1/2.

    10 mm are half of the wall.
    """
    separation = pair([WALL], [CUBE], dissipation=0.0)
    m = [body.mass for body in separation.bodies]
    energy = m[0] * m[1] / (m[0] + m[1]) * (400.0 / m[1] * 0.2) ** 2
    stiffness = energy / (0.2**2 * depth**2)
    soft = dataclasses.replace(separation.recontact, face_stiffness=stiffness)
    run = Simulation(dataclasses.replace(separation, recontact=soft), FINE).run()
    if depth < 0.01:
        assert run.status is RunStatus.COMPLETED
        assert run.motion.relative_velocity[-1, 0] > 0.0
        return
    assert run.status is RunStatus.FAILED
    assert "recontact: wall and cube overlap by 0.01" in run.message
    assert "more than half of wall, which is 0.02 m thick there" in run.message


def test_without_recontact_bodies_pass_through_each_other():
    separation = dataclasses.replace(pair([LOWER], [UPPER]), recontact=None)
    assert fly(separation).motion.relative_position[-1, 0] < -0.1


def test_pairs_that_are_left_out_do_not_push():
    overlapping = dataclasses.replace(UPPER, p_BoGo_B=(0.15, 0.0, 0.0))
    names = (LOWER.name, overlapping.name)
    with pytest.raises(ValueError, match="lower_ball and upper_ball must be apart"):
        SeparationSystem(pair([LOWER], [overlapping], dissipation=0.0))
    left_out = pair([LOWER], [overlapping], without=(names,))
    assert fly(left_out).motion.relative_position[-1, 0] < -0.1
    with pytest.raises(ValueError, match="unknown part 'bal'"):
        SeparationSystem(pair([LOWER], [UPPER], without=(("bal", "upper_ball"),)))


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("stiffness", 0.0, "recontact: stiffness must be > 0"),
        ("stiffness", math.nan, "recontact: stiffness"),
        ("dissipation", -1.0, "recontact: dissipation must be >= 0"),
        ("friction", -0.1, "recontact: friction must be >= 0"),
    ],
)
def test_bad_numbers(field, value, message):
    with pytest.raises(ValueError, match=message):
        Recontact(**{"stiffness": STIFFNESS, field: value})


def test_where_there_is_none():
    with pytest.raises(ValueError, match="recontact: needs geometry on two bodies"):
        pair([LOWER], [], friction=0.1)
    separation = pair([LOWER], [UPPER], friction=0.1)
    with pytest.raises(ValueError, match="recontact: the batch engine knows no"):
        Batch(separation, ["upper.mass"])
    system = SeparationSystem(separation)
    moved = dataclasses.replace(UPPER, p_BoGo_B=(0.3, 0.0, 0.0))
    with pytest.raises(ValueError, match="must have the recontact"):
        system.set_separation(
            system.CreateDefaultContext(), pair([LOWER], [moved], friction=0.1)
        )
