"""Rigid joints beside a plant of one's own: a body welded for real, and refusals."""

import numpy as np
import pytest
from flying import plant_of, simulator_of
from pydrake.common.value import AbstractValue
from pydrake.geometry import SceneGraph, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import (
    LinearSpringDamper,
    RevoluteJoint,
    SpatialInertia,
    WeldJoint,
)
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
from separations import generic_pair

from drakesep.systems.checks import InputError
from drakesep.systems.diagram.on_your_plant import add_separation
from drakesep.systems.diagram.separation_system import (
    set_mated_motion,
    spatial_inertia,
)
from drakesep.systems.model.joints import Joint


SEPARATION = generic_pair(
    release_times=(0.6, 0.6, 0.7, 0.7), joint=Joint(rigid=True), duration=1.0
)
GRAVITY = np.array([1.0, -2.0, -9.0])
THRUST, AT = np.array([300.0, -200.0, 100.0]), np.array([0.5, 0.2, -0.1])
"""On the upper body, in its axes, N and m."""


class Thruster(LeafSystem):
    """Turns with its body, and pushes a body of the user's too."""

    def __init__(self, plant):
        super().__init__()
        self._plant = plant
        self._poses = self.DeclareAbstractInputPort(
            "poses", AbstractValue.Make([RigidTransform()])
        )
        none = AbstractValue.Make([ExternallyAppliedSpatialForce()])
        self.DeclareAbstractOutputPort("forces", none.Clone, self._calc)

    def _calc(self, context, output):
        forces = []
        for name in ("upper", "debris"):
            body = self._plant.GetBodyByName(name)
            force = ExternallyAppliedSpatialForce()
            force.body_index, force.p_BoBq_B = body.index(), AT
            R = self._poses.Eval(context)[int(body.index())].rotation()
            force.F_Bq_W = SpatialForce(tau=np.zeros(3), f=R.multiply(THRUST))
            forces.append(force)
        output.set_value(forces)


def users_plant(change=lambda plant: None, welded=False):
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(GRAVITY)
    plant.AddRigidBody("debris", SpatialInertia.SolidSphereWithMass(30.0, 0.4))
    lower, upper = (
        plant.AddRigidBody(body.name, spatial_inertia(body))
        for body in SEPARATION.bodies
    )
    if welded:
        place = SEPARATION.body("upper")
        X_AB = RigidTransform(RollPitchYaw(place.rpy_AB), place.p_ABo)
        plant.AddJoint(WeldJoint("weld", lower.body_frame(), upper.body_frame(), X_AB))
    change(plant)
    plant.Finalize()
    return plant


def poses_at(welded, time):
    """Of the upper body and of the user's own, with a thruster on both."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(users_plant(welded=welded))
    thruster = builder.AddSystem(Thruster(plant))
    builder.Connect(plant.get_body_poses_output_port(), thruster.get_input_port())
    source = thruster.get_output_port()
    if welded:
        builder.Connect(source, plant.get_applied_spatial_force_input_port())
    else:
        forces = add_separation(builder, plant, SEPARATION, other_forces=source)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    inner = plant.GetMyMutableContextFromRoot(context)
    if welded:
        name = SEPARATION.bodies[0].name
        own = plant_of(SEPARATION)
        at = own.CreateDefaultContext()
        set_mated_motion(own, at, SEPARATION)
        of, link = own.GetBodyByName(name), plant.GetBodyByName(name)
        plant.SetFreeBodyPose(inner, link, of.EvalPoseInWorld(at))
        velocity = of.EvalSpatialVelocityInWorld(at)
        plant.SetFreeBodySpatialVelocity(inner, link, velocity)
    else:
        forces.set_separation(forces.GetMyMutableContextFromRoot(context), SEPARATION)
        set_mated_motion(plant, inner, SEPARATION)
    simulator_of(diagram, context, 1e-9).AdvanceTo(time)
    return [
        plant.GetBodyByName(name).EvalPoseInWorld(inner) for name in ("upper", "debris")
    ]


def test_a_thruster_moves_the_stack_as_if_it_were_welded():
    got, expected = (poses_at(welded, 0.5) for welded in (False, True))
    for ours, theirs in zip(got, expected, strict=True):
        # Both at 1e-9 a step, of some hundred steps.
        matrix = theirs.GetAsMatrix34()
        assert ours.GetAsMatrix34() == pytest.approx(matrix, abs=1e-7)
    moved = 0.5**2 / 2.0 * np.linalg.norm(GRAVITY)
    assert np.linalg.norm(got[0].translation()) > 0.5 * moved


def hinge_a_panel(plant):
    panel = plant.AddRigidBody("panel", SpatialInertia.SolidSphereWithMass(3.0, 0.1))
    frame = plant.GetBodyByName("upper").body_frame()
    plant.AddJoint(RevoluteJoint("hinge", frame, panel.body_frame(), [0.0, 0.0, 1.0]))


def hang_up(plant):
    frame = plant.GetBodyByName("lower").body_frame()
    plant.AddJoint(RevoluteJoint("hinge", plant.world_frame(), frame, [0.0, 0.0, 1.0]))


def tie(plant):
    lower, debris = (plant.GetBodyByName(name) for name in ("lower", "debris"))
    zero = np.zeros(3)
    plant.AddForceElement(LinearSpringDamper(lower, zero, debris, zero, 1.0, 10.0, 1.0))


def weightless(plant):
    body = SEPARATION.bodies[0]
    instance = plant.AddModelInstance("weightless")
    plant.set_gravity_enabled(instance, False)
    plant.AddRigidBody("another", instance, spatial_inertia(body))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (hinge_a_panel, "upper: must carry no joint of the plant, got 'hinge'"),
        (hang_up, "lower: must float, got a joint or weld of the plant"),
        (tie, "plant must have no force elements, got 1 beside gravity"),
    ],
)
def test_what_acts_unseen_is_refused(change, message):
    builder = DiagramBuilder()
    plant = builder.AddSystem(users_plant(change))
    with pytest.raises(InputError, match=f"{message}.*give their joints stiffness"):
        add_separation(builder, plant, SEPARATION)


def test_contact_is_refused():
    builder = DiagramBuilder()
    plant = MultibodyPlant(0.0)
    plant.RegisterAsSourceForSceneGraph(builder.AddSystem(SceneGraph()))
    for body in SEPARATION.bodies:
        link = plant.AddRigidBody(body.name, spatial_inertia(body))
    plant.RegisterCollisionGeometry(
        link, RigidTransform(), Sphere(0.1), "ball", CoulombFriction(0.5, 0.5)
    )
    plant.Finalize()
    builder.AddSystem(plant)
    with pytest.raises(InputError, match="upper: must have no collision geometry"):
        add_separation(builder, plant, SEPARATION)


def test_gravity_of_some_is_refused():
    builder = DiagramBuilder()
    plant = builder.AddSystem(users_plant(weightless))
    names = ("another", "upper")
    bodies = [plant.GetBodyByName(name) for name in names]
    with pytest.raises(InputError, match="gravity must be on for all bodies or none"):
        add_separation(builder, plant, SEPARATION, bodies=bodies)


def test_generalized_forces_are_refused():
    builder = DiagramBuilder()
    plant = builder.AddSystem(users_plant())
    source = builder.AddSystem(ConstantVectorSource(np.zeros(plant.num_velocities())))
    builder.Connect(
        source.get_output_port(), plant.get_applied_generalized_force_input_port()
    )
    with pytest.raises(InputError, match="applied_generalized_force input port must"):
        add_separation(builder, plant, SEPARATION)
