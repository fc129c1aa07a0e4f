"""Mass properties that are changed in a plant's Context alone are told of."""

import dataclasses

import numpy as np
import pytest
from flying import plant_of, simulator_of, start
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from separations import generic_pair

from drakesep.systems.checks import InputError
from drakesep.systems.diagram.mass_watch import OtherMotion
from drakesep.systems.diagram.on_your_plant import add_separation
from drakesep.systems.diagram.separation_system import (
    set_mass_properties,
    set_mated_motion,
    spatial_inertia,
)
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.parameters import with_values


SEPARATION = generic_pair(release_times=(0.0, 0.0, 0.1, 0.101))
RIGID = generic_pair(release_times=(0.05,) * 4, joint=Joint(rigid=True))
SAID = "upper: must move as its mass properties in the separation"


def heavier(body, context):
    body.SetMass(context, 1.001 * body.get_mass(context))


def aside(body, context):
    """The CG, by 1 mm."""
    moved = np.add(body.CalcCenterOfMassInBodyFrame(context), [0.0, 1e-3, 0.0])
    body.SetCenterOfMassInBodyFrame(context, moved)


def larger(body, context):
    """The inertia about the CG, by a thousandth."""
    upper = SEPARATION.body("upper")
    inertia = tuple(1.001 * x for x in upper.I_BBcm_B)
    changed = dataclasses.replace(upper, I_BBcm_B=inertia)
    body.SetSpatialInertiaInBodyFrame(context, spatial_inertia(changed))


def fly(separation, change=None, duration=0.2):
    system, context, simulator = start(separation, 1e-6)
    if change is not None:
        plant_context = system.plant.GetMyMutableContextFromRoot(context)
        change(system.plant.GetBodyByName("upper"), plant_context)
    simulator.AdvanceTo(duration)


@pytest.mark.parametrize("change", [heavier, aside, larger])
def test_what_is_changed_in_the_plant_alone_is_told_of(change):
    with pytest.warns(OtherMotion, match=SAID):
        fly(SEPARATION, change)
    with pytest.raises(InputError, match=f"{SAID}.*rigid joints must know"):
        fly(RIGID, change)


@pytest.mark.parametrize(
    "separation",
    [
        SEPARATION,
        RIGID,
        dataclasses.replace(SEPARATION, orbit=Orbit(radius=7.078e6)),
        with_values(SEPARATION, {"upper.mass": 1e-3 * 1200.0}),
    ],
)
def test_what_is_as_it_was_is_not(separation):
    """Warnings are errors here."""
    fly(separation, duration=separation.duration)


def on_a_plant(change, separation=SEPARATION, connect=None):
    """With gravity."""
    builder = DiagramBuilder()
    plant = plant_of(SEPARATION)
    plant.mutable_gravity_field().set_gravity_vector([1.0, -2.0, -9.0])
    builder.AddSystem(plant)
    forces = add_separation(builder, plant, SEPARATION)
    if connect is not None:
        connect(builder, plant)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    forces.set_separation(forces.GetMyMutableContextFromRoot(context), separation)
    plant_context = plant.GetMyMutableContextFromRoot(context)
    set_mated_motion(plant, plant_context, separation)
    change(plant, plant_context)
    simulator_of(diagram, context, 1e-6).AdvanceTo(0.2)


def test_on_a_plant_of_ones_own():
    lighter = with_values(SEPARATION, {"upper.mass": 1100.0})
    on_a_plant(lambda plant, context: None)
    on_a_plant(
        lambda plant, context: set_mass_properties(plant, context, lighter), lighter
    )
    with pytest.warns(OtherMotion, match=SAID):  # in the separation's Context alone
        on_a_plant(lambda plant, context: None, lighter)
    with pytest.warns(OtherMotion, match=SAID):  # in the plant's
        on_a_plant(lambda p, context: heavier(p.GetBodyByName("upper"), context))


def test_what_is_connected_later_is_told_of():
    def connect(builder, plant):
        push = np.zeros(plant.num_velocities())
        push[plant.GetBodyByName("upper").floating_velocities_start_in_v() + 3] = 50.0
        source = builder.AddSystem(ConstantVectorSource(push))
        port = plant.get_applied_generalized_force_input_port()
        builder.Connect(source.get_output_port(), port)

    with pytest.warns(OtherMotion, match="something acts on it that was connected"):
        on_a_plant(lambda plant, context: None, connect=connect)
