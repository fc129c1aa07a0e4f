"""One separation as a Drake diagram."""

import math

from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RotationalInertia, SpatialInertia
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from drakesep.systems.geometry import mated_motion
from drakesep.systems.model import Body, Separation
from drakesep.systems.separation_elements import SeparationElements
from drakesep.systems.state_layout import state_layout


class SeparationSystem(Diagram):
    """Bodies in free fall, held by joints and pushed apart by springs.

    Built once for the structure of a separation: every number in it is written
    into a Context with `set_separation`, so that a run is varied without a rebuild.

    The plant is continuous and its world is the freely falling W. Subsystems: ``plant``
    and ``elements``, a `SeparationElements`.

    Input ports:
        trigger: (1,) commands the release of all attachments when it rises above 0.5;
            optional. With it, or the next, the scheduled times are not used.
        triggers: (n,) command the release of each of the n attachments; optional.
        external_wrenches: (6 m,), if asked for: torque about the origin, N m, and
            force, N, in W, on each of the m bodies, in the order of
            `Separation.bodies`: thrust, disturbances, whatever the surrounding diagram
            knows of.

    Output ports:
        plant_state: state of the plant; q and v of each body, in the order of
            `Separation.bodies`.
        All of those of `SeparationElements` but ``wrenches``.
    """

    def __init__(self, separation: Separation, *, external_wrenches: bool = False):
        """Build the diagram.

        Args:
            separation: the bodies, attachments, springs and loads.
            external_wrenches: whether to have that input port, which must then be
                connected.
        """
        super().__init__()
        builder = DiagramBuilder()
        plant = builder.AddNamedSystem("plant", make_plant(separation))
        layout = state_layout(plant, [body.name for body in separation.bodies])
        elements = builder.AddNamedSystem(
            "elements",
            SeparationElements(separation, layout, external_wrenches=external_wrenches),
        )
        state = plant.get_state_output_port()
        builder.Connect(state, elements.GetInputPort("plant_state"))
        # The bodies float, in order: their wrenches are the generalized forces, and
        # their accelerations the generalized ones.
        builder.Connect(
            plant.get_generalized_acceleration_output_port(),
            elements.GetInputPort("plant_acceleration"),
        )
        builder.Connect(
            elements.GetOutputPort("wrenches"),
            plant.get_applied_generalized_force_input_port(),
        )
        inputs = ["trigger", "triggers"]
        inputs += ["external_wrenches"] if external_wrenches else []
        for name in inputs:
            builder.ExportInput(elements.GetInputPort(name), name)
        builder.ExportOutput(state, "plant_state")
        for i in range(elements.num_output_ports()):
            port = elements.get_output_port(i)
            if port.get_name() != "wrenches":
                builder.ExportOutput(port, port.get_name())
        builder.BuildInto(self)

        self.plant: MultibodyPlant = plant
        self.elements: SeparationElements = elements
        self.layout = layout

    def set_separation(self, context: Context, separation: Separation) -> None:
        """Write the numbers and the initial state of a separation into a Context.

        Args:
            context: of this diagram.
            separation: with the structure that this system was built for.

        Raises:
            ValueError: the separation has another structure; see `SeparationElements`.
        """
        self.elements.set_separation(
            self.GetMutableSubsystemContext(self.elements, context), separation
        )
        plant_context = self.GetMutableSubsystemContext(self.plant, context)
        set_mass_properties(self.plant, plant_context, separation)
        set_mated_motion(self.plant, plant_context, separation)

    def is_release_due(self, context: Context) -> bool:
        """Return whether an attachment holds that has turned by its release angle."""
        return self.elements.is_release_due(
            self.GetSubsystemContext(self.elements, context)
        )


def spatial_inertia(body: Body) -> SpatialInertia:
    """Return a body's mass properties as Drake takes them, validated by Drake."""
    xx, yy, zz, xy, xz, yz = body.I_BBcm_B
    return SpatialInertia.MakeFromCentralInertia(
        body.mass, body.p_BoBcm_B, RotationalInertia(xx, yy, zz, xy, xz, yz)
    )


def make_plant(separation: Separation) -> MultibodyPlant:
    """Return the continuous plant of a separation's bodies, free in W."""
    plant = MultibodyPlant(time_step=0.0)
    for body in separation.bodies:
        plant.AddRigidBody(body.name, spatial_inertia(body))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    return plant


def set_mass_properties(
    plant: MultibodyPlant, context: Context, separation: Separation
) -> None:
    """Write the bodies' mass properties into a plant's Context.

    Args:
        plant: that has bodies of their names.
        context: of the plant.
        separation: with the bodies.
    """
    for body in separation.bodies:
        plant.GetBodyByName(body.name).SetSpatialInertiaInBodyFrame(
            context, spatial_inertia(body)
        )


def set_mated_motion(
    plant: MultibodyPlant, context: Context, separation: Separation
) -> None:
    """Write the motion of the mated stack into a plant's Context.

    It moves as one rigid body, with A's origin at W's and A's CG at rest.

    Args:
        plant: in which bodies of their names float.
        context: of the plant.
        separation: with the bodies, their mated places and the initial motion.
    """
    initial = separation.initial
    c_A = separation.body(separation.A).p_BoBcm_B
    motions = mated_motion(separation, initial.rpy_WA, initial.w_WA_A, c_A, math)
    for body, (q_WB, p_WBo, w_WB, v_WBo) in zip(
        separation.bodies, motions, strict=True
    ):
        link = plant.GetBodyByName(body.name)
        plant.SetFloatingBaseBodyPoseInWorldFrame(
            context, link, RigidTransform(Quaternion(q_WB), p_WBo)
        )
        plant.SetFreeBodySpatialVelocity(context, link, SpatialVelocity(w_WB, v_WBo))
