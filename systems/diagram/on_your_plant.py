"""A separation on somebody else's plant.

The plant may hold more than the bodies of the separation, in any order, with joints,
gravity and forces of its own. Two adapters stand between it and the separation's
forces: one reads the bodies' motion from the plant's ports, one turns wrenches into its
spatial forces; a third shows the separation what else acts on its bodies.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialAcceleration, SpatialForce, SpatialVelocity
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
)

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.design.mass_properties import mass_properties_of
from drakesep.systems.diagram.separation_forces import SeparationForces
from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.diagram.unseen_forces import (
    all_is_seen,
    check_all_is_seen,
    gravity_on,
)
from drakesep.systems.equations.rigid_joints import rigid_joints
from drakesep.systems.model.separation import Body, Separation


_Q, _V = 7, 6
"""Of a floating body: its quaternion and position, and its spatial velocity."""


@typed
def add_separation(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    separation: Separation,
    *,
    bodies: Sequence[RigidBody] | None = None,
    other_forces: OutputPort | None = None,
    name: str = "separation",
) -> SeparationForces:
    """Add release, springs, joints, loads and motion analysis to a plant of one's own.

    The plant stays in charge of its bodies: their mass properties, their initial motion
    and gravity are its own. Its world takes the place of W; a separation with an orbit
    adds the differential gravity of a freely falling world.

    Args:
        builder: that holds the plant.
        plant: finalized and continuous.
        separation: its bodies' names and mass properties are those of the plant's
            bodies; see `body_of_plant`.
        bodies: those of the plant, in the order of `Separation.bodies`; by default
            those of their names.
        other_forces: output port with a list of ExternallyAppliedSpatialForce of one's
            own; the plant's input port is taken by the separation. Rigid joints must
            know all forces: what is not here, or is not known before accelerations
            are, cannot act on their bodies.
        name: of the system that is added.

    Returns:
        The system that was added, whose ports `SeparationForces` lists; those for
        motion and wrenches are connected. Write the separation's numbers into its
        Context with `SeparationForces.set_separation`; where they vary the bodies,
        write these into the plant's with `set_mass_properties`. What is done afterwards
        shows in the accelerations, and is an error where joints are rigid, else a
        warning: other mass properties in the plant's Context alone, a body that is
        locked, generalized forces connected later. Of bodies with joints, contact or
        force elements of the plant it is not known.

    Raises:
        ValueError: the plant is discrete or not finalized, has no such body or one of
            another mass, its input port for spatial forces is taken, the separation
            has recontact, or rigid joints on bodies on which something acts that is not
            seen: contact, joints and force elements of the plant.
    """
    _check_plant(builder, plant)
    if separation.recontact is not None:
        raise InputError(
            "recontact: must be None here: contact is the plant's own; before it is "
            "finalized, register_contact gives it the geometry, and then "
            "dataclasses.replace(separation, recontact=None) goes here"
        )
    found = list(bodies or (_find(plant, body.name) for body in separation.bodies))
    _check_bodies(plant, found, separation)
    joined = [found[i] for i in rigid_joints(separation).bodies]
    check_all_is_seen(builder, plant, joined)
    seen = other_forces is not None
    watched = {
        description.name: gravity_on(plant, body)
        for body, description in zip(found, separation.bodies, strict=True)
        if all_is_seen(builder, plant, body)
    }
    count = len(found)
    layout = StateLayout(
        count * (_Q + _V),
        tuple((_Q * i, _Q * count + _V * i) for i in range(count)),
    )
    separation_forces: SeparationForces = builder.AddNamedSystem(
        name,
        SeparationForces(separation, layout, external_wrenches=seen, watched=watched),
    )
    motion = builder.AddNamedSystem(f"{name}_motion", _BodyMotion(found))
    forces = builder.AddNamedSystem(f"{name}_forces", _SpatialForces(found))
    for source, target in (
        (plant.get_body_poses_output_port(), motion.GetInputPort("poses")),
        (
            plant.get_body_spatial_velocities_output_port(),
            motion.GetInputPort("velocities"),
        ),
        (
            plant.get_body_spatial_accelerations_output_port(),
            motion.GetInputPort("accelerations"),
        ),
        (motion.GetOutputPort("state"), separation_forces.GetInputPort("plant_state")),
        (
            motion.GetOutputPort("acceleration"),
            separation_forces.GetInputPort("plant_acceleration"),
        ),
        (separation_forces.GetOutputPort("wrenches"), forces.GetInputPort("wrenches")),
        (forces.get_output_port(), plant.get_applied_spatial_force_input_port()),
    ):
        builder.Connect(source, target)
    if other_forces is not None:
        builder.Connect(other_forces, forces.GetInputPort("other_forces"))
        others = builder.AddNamedSystem(f"{name}_other_forces", _OtherWrenches(found))
        poses = plant.get_body_poses_output_port()
        builder.Connect(poses, others.GetInputPort("poses"))
        builder.Connect(other_forces, others.GetInputPort("other_forces"))
        external = separation_forces.GetInputPort("external_wrenches")
        builder.Connect(others.get_output_port(), external)
    return separation_forces


@typed
def body_of_plant(plant: MultibodyPlant, body: RigidBody) -> Body:
    """Return the description of a plant's body, with its default mass properties.

    Its mated place is the origin; `dataclasses.replace` gives it another.

    Args:
        plant: finalized.
        body: of the plant.
    """
    M = body.CalcSpatialInertiaInBodyFrame(plant.CreateDefaultContext())
    return Body(name=body.name(), **mass_properties_of(M)._asdict())


def _check_plant(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    if not plant.is_finalized():
        raise InputError("plant must be finalized before a separation is added to it")
    if plant.time_step() > 0.0:
        raise InputError(
            "plant must be continuous: stiff joints are wrong in a discrete one; "
            f"got a time step of {plant.time_step():g} s"
        )
    if builder.IsConnectedOrExported(plant.get_applied_spatial_force_input_port()):
        raise InputError(
            "plant's applied_spatial_force input port must be free; hand the port that "
            "it is connected to over as other_forces"
        )


def _find(plant: MultibodyPlant, name: str) -> RigidBody:
    indices = map(BodyIndex, range(plant.num_bodies()))
    names = [plant.get_body(index).name() for index in indices]
    if names.count(name) > 1:
        raise InputError(
            f"plant: must have one body named {name!r}, got {names.count(name)}; hand "
            "the right ones over as bodies"
        )
    if name not in names:
        raise InputError(f"plant: {unknown('body', name, names)}")
    return plant.GetBodyByName(name)


def _check_bodies(
    plant: MultibodyPlant, bodies: Sequence[RigidBody], separation: Separation
) -> None:
    wanted = separation.bodies
    if len(bodies) != len(wanted):
        raise InputError(
            f"bodies must be the {len(wanted)} of the separation, got {len(bodies)}"
        )
    if len({int(body.index()) for body in bodies}) != len(bodies):
        raise InputError("bodies must differ, got one twice")
    for body, description in zip(bodies, wanted, strict=True):
        if body.GetParentPlant() is not plant:
            raise InputError(f"{description.name}: must be a body of the plant")
        own = body_of_plant(plant, body)
        for quantity, got, of_plant in (
            ("mass", (description.mass,), (own.mass,)),
            ("CG", description.p_BoBcm_B, own.p_BoBcm_B),
            ("inertia", description.I_BBcm_B, own.I_BBcm_B),
        ):
            largest = max(map(abs, of_plant))
            if not np.allclose(got, of_plant, rtol=0.0, atol=1e-6 * largest):
                raise InputError(
                    f"{description.name}: {quantity} must be that of the plant's body, "
                    f"{of_plant}, got {got}; see body_of_plant"
                )


class _BodyMotion(LeafSystem):
    """Reads bodies' motion from a plant's ports, as if they floated in its world.

    Input ports:
        poses: abstract: the plant's, by body.
        velocities: abstract: the plant's, by body.
        accelerations: abstract: the plant's, by body.

    Output ports:
        state: (13 m,) 1, m, rad/s and m/s in W: quaternion and position of each of the
            m bodies, then angular velocity and velocity of the origin of each.
        acceleration: (6 m,) rad/s^2 and m/s^2 in W: angular acceleration, then
            acceleration of the origin, of each of the m bodies.
    """

    def __init__(self, bodies: Sequence[RigidBody]):
        super().__init__()
        self._indices = [int(body.index()) for body in bodies]

        def declare(name: str, kind: type) -> InputPort:
            return self.DeclareAbstractInputPort(name, AbstractValue.Make([kind()]))

        self._poses = declare("poses", RigidTransform)
        self._velocities = declare("velocities", SpatialVelocity)
        self._accelerations = declare("accelerations", SpatialAcceleration)
        self.DeclareVectorOutputPort(
            "state",
            (_Q + _V) * len(bodies),
            self._calc_state,
            {self._poses.ticket(), self._velocities.ticket()},
        )
        self.DeclareVectorOutputPort(
            "acceleration",
            _V * len(bodies),
            self._calc_acceleration,
            {self._accelerations.ticket()},
        )

    def _calc_state(self, context: Context, output: BasicVector) -> None:
        poses, velocities = self._poses.Eval(context), self._velocities.Eval(context)
        entries: list[float] = []
        for i in self._indices:
            entries += poses[i].rotation().ToQuaternion().wxyz().tolist()
            entries += poses[i].translation().tolist()
        for i in self._indices:
            entries += velocities[i].get_coeffs().tolist()
        output.SetFromVector(entries)

    def _calc_acceleration(self, context: Context, output: BasicVector) -> None:
        accelerations = self._accelerations.Eval(context)
        entries: list[float] = []
        for i in self._indices:
            entries += accelerations[i].get_coeffs().tolist()
        output.SetFromVector(entries)


class _SpatialForces(LeafSystem):
    """Turns wrenches about bodies' origins into a plant's external forces.

    Input ports:
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.
        other_forces: abstract: list of ExternallyAppliedSpatialForce; optional. The
            wrenches have those on their bodies, those on others are passed on.

    Output ports:
        spatial_forces: abstract: list of ExternallyAppliedSpatialForce.
    """

    def __init__(self, bodies: Sequence[RigidBody]):
        super().__init__()
        self._indices = [body.index() for body in bodies]
        self._wrenches = self.DeclareVectorInputPort("wrenches", 6 * len(bodies))
        no_forces = AbstractValue.Make([ExternallyAppliedSpatialForce()])
        self._others = self.DeclareAbstractInputPort("other_forces", no_forces)
        self.DeclareAbstractOutputPort(
            "spatial_forces", lambda: no_forces.Clone(), self._calc_forces
        )

    def _calc_forces(self, context: Context, output: AbstractValue) -> None:
        wrenches = self._wrenches.Eval(context)
        forces = []
        for k, index in enumerate(self._indices):
            force = ExternallyAppliedSpatialForce()
            force.body_index = index
            force.F_Bq_W = SpatialForce(
                tau=wrenches[6 * k : 6 * k + 3], f=wrenches[6 * k + 3 : 6 * k + 6]
            )
            forces.append(force)
        if self._others.HasValue(context):
            for other in self._others.Eval(context):
                if other.body_index not in self._indices:
                    forces.append(other)
        output.set_value(forces)


class _OtherWrenches(LeafSystem):
    """Sums up forces of one's own on the bodies of a separation.

    Input ports:
        other_forces: abstract: list of ExternallyAppliedSpatialForce.
        poses: abstract: the plant's, by body.

    Output ports:
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.
    """

    def __init__(self, bodies: Sequence[RigidBody]):
        super().__init__()
        self._indices = [int(body.index()) for body in bodies]
        self._forces = self.DeclareAbstractInputPort(
            "other_forces", AbstractValue.Make([ExternallyAppliedSpatialForce()])
        )
        self._poses = self.DeclareAbstractInputPort(
            "poses", AbstractValue.Make([RigidTransform()])
        )
        self.DeclareVectorOutputPort("wrenches", 6 * len(bodies), self._calc_wrenches)

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        poses = self._poses.Eval(context)
        sums = np.zeros((len(self._indices), 6))
        for force in self._forces.Eval(context):
            index = int(force.body_index)
            if index in self._indices:
                arm = poses[index].rotation().multiply(force.p_BoBq_B)
                at_origin = force.F_Bq_W.Shift(-arm)
                sums[self._indices.index(index)] += at_origin.get_coeffs()
        output.SetFromVector(sums.ravel())
