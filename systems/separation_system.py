"""One separation as a Drake diagram."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RotationalInertia, SpatialInertia
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System
from pydrake.systems.primitives import Adder

from drakesep.systems.cfe_bushing import CfeBushing
from drakesep.systems.checks import InputError
from drakesep.systems.geometry import place_in_stack
from drakesep.systems.gravity import Gravity
from drakesep.systems.model import Body, Separation
from drakesep.systems.motion_analysis import MotionAnalysis
from drakesep.systems.release import Release
from drakesep.systems.springs import Springs
from drakesep.systems.state_layout import state_layout


def spatial_inertia(body: Body) -> SpatialInertia:
    """Return a body's mass properties as Drake takes them, validated by Drake."""
    xx, yy, zz, xy, xz, yz = body.I_BBcm_B
    return SpatialInertia.MakeFromCentralInertia(
        body.mass, body.p_BoBcm_B, RotationalInertia(xx, yy, zz, xy, xz, yz)
    )


class SeparationSystem(Diagram):
    """Bodies in free fall, held by joints and pushed apart by springs.

    Built once for the structure of a separation: every number in it is written
    into a Context with `set_separation`, so that a run is varied without a rebuild.

    The plant is continuous and its world is the freely falling W. Subsystems:
    ``plant``, ``release``, ``springs``, ``cfe_bushing``, ``gravity``,
    ``motion_analysis``.

    Input port, if asked for with `external_wrenches`:
        external_wrenches: (6 m,) torque about the origin, N m, and force, N, in W, on
            each of the m bodies, in the order of `Separation.bodies`: thrust,
            disturbances, whatever the surrounding diagram knows of.

    Output ports:
        plant_state: state of the plant; q and v of each body, in the order of
            `Separation.bodies`.
        released: see `Release`.
        spring_forces, spring_energy: see `Springs`.
        joint_energy: see `CfeBushing`.
        rate, relative_rate, angle, relative_position, relative_velocity,
        acceleration, linear_momentum_change, angular_momentum_change: see
            `MotionAnalysis`.
    """

    def __init__(self, separation: Separation, *, external_wrenches: bool = False):
        """Build the diagram.

        Args:
            separation: the bodies, attachments and springs.
            external_wrenches: whether to have that input port, which must then be
                connected.
        """
        super().__init__()
        builder = DiagramBuilder()
        plant = builder.AddNamedSystem("plant", make_plant(separation))
        names = [body.name for body in separation.bodies]
        layout = state_layout(plant, names)
        release = builder.AddNamedSystem(
            "release", Release(len(separation.attachments))
        )
        springs = builder.AddNamedSystem("springs", Springs(separation, layout))
        bushing = builder.AddNamedSystem("cfe_bushing", CfeBushing(separation, layout))
        gravity = builder.AddNamedSystem("gravity", Gravity(separation, layout))
        motion = builder.AddNamedSystem(
            "motion_analysis", MotionAnalysis(separation, layout)
        )
        forces = (springs, bushing, gravity)
        sums = len(forces) + external_wrenches
        total = builder.AddNamedSystem("wrenches", Adder(sums, 6 * len(names)))
        if external_wrenches:
            last = total.get_input_port(len(forces))
            builder.ExportInput(last, "external_wrenches")

        state = plant.get_state_output_port()
        released = release.GetOutputPort("released")
        for i, system in enumerate(forces):
            builder.Connect(state, system.GetInputPort("plant_state"))
            builder.Connect(system.GetOutputPort("wrenches"), total.get_input_port(i))
        for system in (springs, bushing):
            builder.Connect(released, system.GetInputPort("released"))
        # The bodies float, in order: their wrenches are the generalized forces.
        builder.Connect(
            total.get_output_port(), plant.get_applied_generalized_force_input_port()
        )
        builder.Connect(state, motion.GetInputPort("plant_state"))
        builder.Connect(
            plant.get_generalized_acceleration_output_port(),
            motion.GetInputPort("plant_acceleration"),
        )
        builder.Connect(
            springs.GetOutputPort("wrenches"), motion.GetInputPort("spring_wrenches")
        )

        builder.ExportOutput(state, "plant_state")
        builder.ExportOutput(released, "released")
        builder.ExportOutput(springs.GetOutputPort("forces"), "spring_forces")
        builder.ExportOutput(springs.GetOutputPort("energy"), "spring_energy")
        builder.ExportOutput(bushing.GetOutputPort("energy"), "joint_energy")
        for i in range(motion.num_output_ports()):
            port = motion.get_output_port(i)
            builder.ExportOutput(port, port.get_name())
        builder.BuildInto(self)

        self.plant: MultibodyPlant = plant
        self.layout = layout
        self._structure = _structure(separation)
        self._release: Release = release
        self._springs: Springs = springs
        self._bushing: CfeBushing = bushing
        self._gravity: Gravity = gravity
        self._motion: MotionAnalysis = motion

    def set_separation(self, context: Context, separation: Separation) -> None:
        """Write the numbers and the initial state of a separation into a Context.

        Args:
            context: of this diagram.
            separation: with the bodies, attachments and springs that this system
                was built for.

        Raises:
            ValueError: the separation has other bodies, attachments or springs.
        """
        if _structure(separation) != self._structure:
            raise InputError(
                "separation must have the bodies, attachments and springs that the "
                f"system was built for, {self._structure}; got {_structure(separation)}"
            )

        def of(system: System) -> Context:
            return self.GetMutableSubsystemContext(system, context)

        for body in separation.bodies:
            self.plant.GetBodyByName(body.name).SetSpatialInertiaInBodyFrame(
                of(self.plant), spatial_inertia(body)
            )
        self._release.set_schedule(of(self._release), separation)
        self._springs.set_springs(of(self._springs), separation)
        self._bushing.set_joints(of(self._bushing), separation)
        self._gravity.set_gravity(of(self._gravity), separation)
        self._motion.set_measured(of(self._motion), separation)
        set_mated_motion(self.plant, of(self.plant), separation)


def _structure(separation: Separation) -> tuple[object, ...]:
    return (
        tuple(body.name for body in separation.bodies),
        tuple(
            (a.name, a.A, a.B, a.spring and a.spring.name, type(a.spring))
            for a in separation.attachments
        ),
        (separation.A, separation.B),
    )


def make_plant(separation: Separation) -> MultibodyPlant:
    """Return the continuous plant of a separation's bodies, free in W."""
    plant = MultibodyPlant(time_step=0.0)
    for body in separation.bodies:
        plant.AddRigidBody(body.name, spatial_inertia(body))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    return plant


def set_mated_motion(
    plant: MultibodyPlant, context: Context, separation: Separation
) -> None:
    """Write the motion of the mated stack into the plant's Context.

    It moves as one rigid body, with A's origin at W's and A's CG at rest.
    """
    initial = separation.initial
    A = separation.body(separation.A)
    R_WA = RotationMatrix(RollPitchYaw(initial.rpy_WA))
    w_W = R_WA.multiply(np.array(initial.w_WA_A))
    p_AoAcm_A = np.array(place_in_stack(A, A.p_BoBcm_B))
    for body in separation.bodies:
        link = plant.GetBodyByName(body.name)
        R_WB = R_WA.multiply(RotationMatrix(RollPitchYaw(body.rpy_AB)))
        p_WBo = R_WA.multiply(np.array(body.p_ABo))
        v_WBo = np.cross(w_W, p_WBo - R_WA.multiply(p_AoAcm_A))
        plant.SetFloatingBaseBodyPoseInWorldFrame(
            context, link, RigidTransform(R_WB, p_WBo)
        )
        plant.SetFreeBodySpatialVelocity(context, link, SpatialVelocity(w_W, v_WBo))
