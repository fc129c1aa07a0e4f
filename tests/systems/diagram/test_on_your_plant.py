"""A separation on a plant that somebody else has built."""

import dataclasses

import numpy as np
import pytest
from flying import plant_of, simulator_of, start
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import BodyIndex, RevoluteJoint, SpatialInertia
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource
from separations import generic_pair

from drakesep.systems.diagram.on_your_plant import add_separation, body_of_plant
from drakesep.systems.diagram.separation_system import (
    set_mass_properties,
    set_mated_motion,
    spatial_inertia,
)
from drakesep.systems.model.parameters import with_values
from drakesep.systems.simulation.simulation import Simulation


SEPARATION = generic_pair(release_times=(0.0, 0.0, 0.1, 0.101))
GRAVITY = np.array([1.0, -2.0, -9.0])


def users_plant(builder):
    """Gravity, a body in front of ours, ours in the other order, and a hinged panel."""
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    plant.mutable_gravity_field().set_gravity_vector(GRAVITY)
    sphere = SpatialInertia.SolidSphereWithMass(3.0, 0.1)
    plant.AddRigidBody("debris", sphere)
    for body in reversed(SEPARATION.bodies):
        plant.AddRigidBody(body.name, spatial_inertia(body))
    panel = plant.AddRigidBody("panel", sphere)
    plant.AddJoint(
        RevoluteJoint(
            "panel",
            plant.GetBodyByName("upper").body_frame(),
            panel.body_frame(),
            [0.0, 0.0, 1.0],
        )
    )
    plant.Finalize()
    return plant


def own_plant(builder):
    return builder.AddSystem(plant_of(SEPARATION))


def in_a_diagram(add_plant, separation=SEPARATION, **options):
    builder = DiagramBuilder()
    plant = add_plant(builder)
    if "other_forces" in options:
        options["other_forces"] = builder.AddSystem(
            options["other_forces"]
        ).get_output_port()
    forces = add_separation(builder, plant, separation, **options)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    inner = forces.GetMyMutableContextFromRoot(context)
    forces.set_separation(inner, separation)
    plant_context = plant.GetMyMutableContextFromRoot(context)
    set_mated_motion(plant, plant_context, separation)
    return diagram, context, forces, inner, plant, plant_context


def test_same_motion_as_stand_alone():
    diagram, context, forces, inner, *_ = in_a_diagram(own_plant)
    simulator_of(diagram, context, 1e-8).AdvanceTo(SEPARATION.duration)
    system, alone, simulator = start(SEPARATION, 1e-8)
    simulator.AdvanceTo(SEPARATION.duration)
    for i in range(forces.num_output_ports()):
        name = forces.get_output_port(i).get_name()
        if name != "wrenches":
            ours = forces.GetOutputPort(name).Eval(inner)
            expected = system.GetOutputPort(name).Eval(alone)
            # The round-off of other ways through Drake changes steps of joints that
            # ring, and they are accurate to 1e-8; momenta are in hundreds of N s.
            assert ours == pytest.approx(expected, abs=1e-8, rel=1e-8), name


def momenta(plant, context):
    """Linear momentum of ours and of their panel in the world, and their mass."""
    bodies = [plant.GetBodyByName(name) for name in ("lower", "upper", "panel")]
    indices = [body.index() for body in bodies]
    about = plant.CalcSpatialMomentumInWorldAboutPoint(
        context, [plant.GetModelInstanceByName("DefaultModelInstance")], np.zeros(3)
    )
    debris = plant.GetBodyByName("debris")
    v = debris.EvalSpatialVelocityInWorld(context).translational()
    mass = sum(plant.get_body(i).get_mass(context) for i in indices)
    return about.translational() - 3.0 * v, mass


def test_plant_with_gravity_other_bodies_and_a_panel():
    """Momentum grows by weight alone; the panel feels the push and swings."""
    diagram, context, forces, inner, plant, at = in_a_diagram(users_plant)
    before, mass = momenta(plant, at)
    simulator_of(diagram, context, 1e-8).AdvanceTo(0.5)
    after, _ = momenta(plant, at)
    # kg m/s of thousands: round-off of a few hundred steps
    assert after - before == pytest.approx(0.5 * mass * GRAVITY, abs=1e-7)
    assert forces.GetOutputPort("relative_velocity").Eval(inner)[0] > 0.3
    assert abs(plant.GetJointByName("panel").get_angular_rate(at)) > 0.005


def test_other_forces_on_the_plant_pass_through():
    """A thrust of one's own on a body that is not part of the separation."""
    thrust = ExternallyAppliedSpatialForce()
    thrust.body_index = BodyIndex(1)  # the first after the world
    thrust.F_Bq_W = SpatialForce(tau=np.zeros(3), f=np.array([6.0, 0.0, 0.0]))
    source = ConstantValueSource(AbstractValue.Make([thrust]))
    diagram, context, _, _, plant, plant_context = in_a_diagram(
        users_plant, other_forces=source
    )
    simulator_of(diagram, context, 1e-8).AdvanceTo(0.5)
    debris = plant.GetBodyByName("debris")
    velocity = debris.EvalSpatialVelocityInWorld(plant_context).translational()
    expected = 0.5 * (GRAVITY + np.array([2.0, 0.0, 0.0]))
    assert velocity == pytest.approx(expected, abs=1e-9)


def test_a_run_is_varied_by_the_context():
    """Other times and masses, nothing rebuilt, and back again: the same bits."""
    diagram, _, forces, _, plant, _ = in_a_diagram(own_plant)
    attachments = tuple(
        dataclasses.replace(a, release_time=0.2) for a in SEPARATION.attachments
    )
    later = dataclasses.replace(SEPARATION, attachments=attachments)
    lighter = with_values(SEPARATION, {"upper.mass": 1000.0})
    speeds = []
    for separation in (SEPARATION, later, lighter, SEPARATION):
        context = diagram.CreateDefaultContext()
        inner = forces.GetMyMutableContextFromRoot(context)
        forces.set_separation(inner, separation)
        plant_context = plant.GetMyMutableContextFromRoot(context)
        set_mass_properties(plant, plant_context, separation)
        set_mated_motion(plant, plant_context, separation)
        simulator_of(diagram, context, 1e-6).AdvanceTo(0.5)
        speeds.append(forces.GetOutputPort("relative_velocity").Eval(inner).tolist())
    assert speeds[0] == speeds[3]
    assert speeds[1] != speeds[0] != speeds[2]
    run = Simulation(lighter).run()
    assert speeds[2] == pytest.approx(
        run.motion.relative_velocity[run.motion.time.searchsorted(0.5)], abs=1e-4
    )


def test_bodies_by_hand():
    """Two plants' bodies may share a name: they are then handed over."""
    plant = MultibodyPlant(time_step=0.0)
    for model in ("first", "second"):
        instance = plant.AddModelInstance(model)
        for body in SEPARATION.bodies:
            plant.AddRigidBody(body.name, instance, spatial_inertia(body))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    second = plant.GetModelInstanceByName("second")
    bodies = [plant.GetBodyByName(b.name, second) for b in SEPARATION.bodies]
    builder = DiagramBuilder()
    builder.AddSystem(plant)
    forces = add_separation(builder, plant, SEPARATION, bodies=bodies)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    inner = forces.GetMyMutableContextFromRoot(context)
    forces.set_separation(inner, SEPARATION)
    simulator_of(diagram, context, 1e-6).AdvanceTo(0.3)
    plant_context = plant.GetMyContextFromRoot(context)
    for body in SEPARATION.bodies:
        other = plant.GetBodyByName(
            body.name, plant.GetModelInstanceByName("first")
        ).EvalPoseInWorld(plant_context)
        assert other.IsExactlyEqualTo(RigidTransform())
    assert forces.GetOutputPort("relative_velocity").Eval(inner)[0] > 0.1


def test_description_with_negative_entries_only():
    """Round-off of a CG behind the origin is no other mass."""
    behind = with_values(
        SEPARATION, {f"lower.cg_{axis}": -0.1 / 3 for axis in ("x", "y", "z")}
    )
    *_, plant, _ = in_a_diagram(
        lambda builder: builder.AddSystem(plant_of(behind)),
        dataclasses.replace(
            behind,
            bodies=tuple(
                dataclasses.replace(
                    body, p_BoBcm_B=tuple(c * (1.0 + 1e-12) for c in body.p_BoBcm_B)
                )
                for body in behind.bodies
            ),
        ),
    )
    assert plant.num_bodies() == 3


def test_description_of_a_plants_body():
    plant = plant_of(SEPARATION)
    for body in SEPARATION.bodies:
        described = body_of_plant(plant, plant.GetBodyByName(body.name))
        assert described.name == body.name
        assert described.mass == body.mass
        assert described.p_BoBcm_B == pytest.approx(body.p_BoBcm_B)
        assert described.I_BBcm_B == pytest.approx(body.I_BBcm_B)


def test_bad_plants():
    def refuse(plant, message, **options):
        builder = DiagramBuilder()
        builder.AddSystem(plant)
        with pytest.raises(ValueError, match=message):
            add_separation(builder, plant, SEPARATION, **options)

    refuse(MultibodyPlant(time_step=0.0), "plant must be finalized")
    discrete = MultibodyPlant(time_step=1e-3)
    discrete.Finalize()
    refuse(discrete, r"must be continuous: .*; got a time step of 0.001 s")
    empty = MultibodyPlant(time_step=0.0)
    empty.Finalize()
    refuse(empty, "plant: unknown body 'lower'")
    plant = plant_of(SEPARATION)
    lower, upper = (plant.GetBodyByName(name) for name in ("lower", "upper"))
    refuse(plant, "of the separation, got 1", bodies=[lower])
    plant = plant_of(SEPARATION)
    lower = plant.GetBodyByName("lower")
    refuse(plant, "bodies must differ, got one twice", bodies=[lower, lower])
    refuse(plant_of(SEPARATION), "must be a body of the plant", bodies=[lower, upper])
    lighter = with_values(SEPARATION, {"upper.mass": 1000.0})
    refuse(plant_of(lighter), r"upper: mass must be that of .* got \(1200.0,\)")
    plant = plant_of(SEPARATION)
    builder = DiagramBuilder()
    builder.AddSystem(plant)
    add_separation(builder, plant, SEPARATION)
    with pytest.raises(ValueError, match="input port must be free"):
        add_separation(builder, plant, SEPARATION, name="twice")
