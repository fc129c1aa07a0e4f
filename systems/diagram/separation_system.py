"""One separation as a Drake diagram."""

import math
from collections.abc import Iterator
from typing import Any

from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import RotationalInertia, SpatialInertia
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.diagram.pushing_pieces import thickness_of
from drakesep.systems.diagram.scene import register_contact, register_illustration
from drakesep.systems.diagram.separation_forces import SeparationForces
from drakesep.systems.diagram.state_layout import state_layout
from drakesep.systems.equations.mated_stack import (
    mated_motion,
    mated_places,
    mated_spin,
)
from drakesep.systems.model.parameters import MATED, SPIN, names_of, places_of_parts
from drakesep.systems.model.part_pairs import owners_of
from drakesep.systems.model.separation import Body, Separation
from drakesep.systems.vectors import Vector


_OF_BODIES = ("mass", "p_BoBcm_B", "I_BBcm_B", *MATED, SPIN)
"""Fields of bodies that `spatial_inertia` reads, and `set_mated_motion`."""
_OF_MOTION = ("rpy_WA", "w_WA_A")
"""Fields of the mated stack's motion that `set_mated_motion` reads."""
_MOMENT = 1e-6
"""Over which accelerations are told by how velocities change, s."""


@typed
class SeparationSystem(Diagram):
    """Bodies in free fall, held by joints and pushed apart by springs.

    Built once for the structure of a separation: every number in it is written
    into a Context with `set_separation`, so that a run is varied without a rebuild.

    The plant is continuous and its world is the freely falling W. Subsystems: ``plant``
    and ``forces``, a `SeparationForces`; and, if the separation has recontact or is
    to be seen, ``scene_graph`` with the bodies' geometry.

    A body whose mass properties are changed in the plant's Context alone is told of,
    since all else keeps the old ones; but not with recontact, nor without motion
    analysis.

    Input ports:
        trigger: (1,) 1: commands the release of all attachments where it rises above
            0.5; optional. With it, or the next, the scheduled times are not used.
        triggers: (n,) 1: command the release of each attachment likewise; optional.
            With both, an attachment lets go at the first of the two.
        external_wrenches: (6 m,) N m and N in W: torque about the origin, then force,
            on each of the m bodies, in the order of `Separation.bodies`: thrust,
            disturbances, whatever the surrounding diagram knows of; if asked for.

    Output ports:
        plant_state: (13 m,) 1, m, rad/s and m/s in W: quaternion and position of each
            of the m bodies, in the order of `Separation.bodies`, then angular velocity
            and velocity of the origin of each.
        released: (n,) s: time of each attachment's release; infinite while it holds.
        spring_forces: (k,) N: force of each spring.
        spring_energy: (1,) J: energy that the springs driven by displacement store.
        joint_loads: (6 n,) N m and N in the joints' frames: torque and force of each
            joint on B at its pad; zero after release.
        preloads: (6 n,) N m and N in the joints' frames: the part of `joint_loads` that
            holds against springs that press; zero after release.
        joint_energy: (1,) J: elastic energy of the joints that hold.
        rate: (3,) rad/s in B: angular velocity of B in W.
        relative_rate: (3,) rad/s in B: angular velocity of B in A.
        angle: (3,) rad: roll, pitch and yaw of B in W.
        relative_position: (3,) m in A: B's CG from its mated place.
        relative_velocity: (3,) m/s in A: velocity of B's CG as seen from A; along the
            direction of the pair it is the longitudinal speed.
        acceleration: (3,) m/s^2 in W: acceleration of B's CG in W.
        linear_momentum_change: (3,) N s in B: given to B by the springs (Eq. 6).
        angular_momentum_change: (3,) N m s in B: given to B by the springs about its CG
            (Eq. 7).
        geometry_query: abstract: Drake's QueryObject, for a MeshcatVisualizer say; if
            there is a scene graph.
        contact_results: abstract: Drake's ContactResults; if the separation has
            recontact.
    """

    def __init__(
        self,
        separation: Separation,
        *,
        external_wrenches: bool = False,
        illustrated: bool = False,
        motion_analysis: bool = True,
    ):
        """Build the diagram.

        Args:
            separation: the bodies, attachments, springs and loads.
            external_wrenches: whether to have that input port, which must then be
                connected.
            illustrated: whether the bodies' geometry is to be seen.
            motion_analysis: whether to have the output ports from `rate` to
                `angular_momentum_change`; see `SeparationForces`.

        Raises:
            ValueError: parts that push each other overlap while mated, or a mesh
                cannot be read.
        """
        super().__init__()
        builder = DiagramBuilder()
        plant = builder.AddNamedSystem("plant", plant_of_bodies(separation))
        pushing = separation.recontact is not None
        scene: Any = None
        if illustrated or pushing:
            scene = builder.AddNamedSystem("scene_graph", SceneGraph())
            plant.RegisterAsSourceForSceneGraph(scene)
        if illustrated:
            register_illustration(plant, separation)
        self._part_of = register_contact(plant, scene, separation) if pushing else {}
        self._thickness = {
            geometry: thickness_of(scene.model_inspector().GetShape(geometry))
            for geometry in self._part_of
        }
        plant.Finalize()
        names = [body.name for body in separation.bodies]
        layout = state_layout(plant, names)
        forces = builder.AddNamedSystem(
            "forces",
            SeparationForces(
                separation,
                layout,
                external_wrenches=external_wrenches,
                motion_analysis=motion_analysis,
                # Contact is the plant's own.
                watched={} if pushing else dict.fromkeys(names, (0.0, 0.0, 0.0)),
            ),
        )
        state = plant.get_state_output_port()
        builder.Connect(state, forces.GetInputPort("plant_state"))
        # The bodies float, in order: their wrenches are the generalized forces, and
        # their accelerations the generalized ones.
        if motion_analysis:
            builder.Connect(
                plant.get_generalized_acceleration_output_port(),
                forces.GetInputPort("plant_acceleration"),
            )
        builder.Connect(
            forces.GetOutputPort("wrenches"),
            plant.get_applied_generalized_force_input_port(),
        )
        inputs = ["trigger", "triggers"]
        inputs += ["external_wrenches"] if external_wrenches else []
        for name in inputs:
            builder.ExportInput(forces.GetInputPort(name), name)
        builder.ExportOutput(state, "plant_state")
        for i in range(forces.num_output_ports()):
            port = forces.get_output_port(i)
            if port.get_name() != "wrenches":
                builder.ExportOutput(port, port.get_name())
        if scene is not None:
            poses = scene.get_source_pose_port(plant.get_source_id())
            builder.Connect(plant.get_geometry_pose_output_port(), poses)
            query = scene.get_query_output_port()
            builder.ExportOutput(query, "geometry_query")
            if pushing:
                builder.Connect(query, plant.get_geometry_query_input_port())
                contacts = plant.get_contact_results_output_port()
                builder.ExportOutput(contacts, "contact_results")
        builder.BuildInto(self)

        self.plant: MultibodyPlant = plant
        self.forces: SeparationForces = forces
        self.layout = layout
        self._order = {name: i for i, name in enumerate(owners_of(separation))}
        self._check_mated(separation)

    def set_separation(self, context: Context, separation: Separation) -> None:
        """Write the numbers and the initial state of a separation into a Context.

        Args:
            context: of this diagram.
            separation: with the structure that this system was built for.

        Raises:
            ValueError: the separation has another structure; see `SeparationForces`.
        """
        self.forces.set_separation(
            self.GetMutableSubsystemContext(self.forces, context), separation
        )
        plant_context = self.GetMutableSubsystemContext(self.plant, context)
        set_mass_properties(self.plant, plant_context, separation)
        set_mated_motion(self.plant, plant_context, separation)

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the plant and the forces read.

        And those that go with a run to where it is measured.

        Args:
            separation: with the structure that this system was built for.
        """
        return {
            *self.forces.parameters_read(separation),
            *names_of(separation.bodies, _OF_BODIES),
            *names_of([separation.initial], _OF_MOTION),
            *places_of_parts(separation),
        }

    def contact_forces(self, context: Context) -> dict[tuple[str, str], Vector]:
        """Return the force between each two parts that touch, N, by their names.

        On the second, in W; nothing if the separation has no recontact.

        Args:
            context: of this diagram.
        """
        if not self._part_of:
            return {}
        results = self.GetOutputPort("contact_results").Eval(context)
        forces: dict[tuple[str, str], Vector] = {}
        for id_A, id_B, force in _pushes(results):
            first, second = self._part_of[id_A], self._part_of[id_B]
            if self._order[first] > self._order[second]:
                first, second, force = second, first, -force
            before = forces.get((first, second), (0.0, 0.0, 0.0))
            x, y, z = before + force
            forces[first, second] = (float(x), float(y), float(z))
        return forces

    def check_depths(self, context: Context) -> None:
        """Check that what touches is not pressed in beyond the middle of a part.

        There the law of contact ends: what pushes back grows no more, and a thin wall
        is passed.

        Args:
            context: of this diagram, with recontact.

        Raises:
            RuntimeError: two parts overlap by more than half of the thinner one.
        """
        query = self.GetOutputPort("geometry_query").Eval(context)
        for pair in query.ComputePointPairPenetration():
            ids = (pair.id_A, pair.id_B)
            thin = min(ids, key=self._thickness.__getitem__)
            if pair.depth > 0.5 * self._thickness[thin]:
                first, second = sorted(
                    (self._part_of[one] for one in ids), key=self._order.__getitem__
                )
                raise RuntimeError(
                    f"recontact: {first} and {second} overlap by {pair.depth:.3g} m, "
                    f"more than half of {self._part_of[thin]}, which is "
                    f"{self._thickness[thin]:.3g} m thick there: too soft a stiffness"
                )

    def _check_mated(self, separation: Separation) -> None:
        context = self.CreateDefaultContext()
        self.set_separation(context, separation)
        for first, second in self.contact_forces(context):
            raise InputError(
                f"recontact: {first} and {second} must be apart while mated, or be "
                "listed as touching, which then do not push each other; got an overlap"
            )

    def time_to_release(self, context: Context) -> float:
        """Return in which time the next attachment lets go by its joint's motion, s.

        As fast as that moves now; 0 if it has moved far enough.
        """
        return self.forces.time_to_release(
            self.GetSubsystemContext(self.forces, context)
        )

    def times_to_kinks(self, context: Context) -> tuple[float, float]:
        """Return in which time the next pad reaches a kink of its spring's force, s.

        And in which the next one an end that is a jump; see `Springs.times_to_kinks`.
        """
        x = context.get_continuous_state_vector().CopyToVector()
        slope = self.EvalTimeDerivatives(context).CopyToVector()
        later = self.layout.bodies((x + _MOMENT * slope).tolist())
        return self.forces.times_to_kinks(
            self.GetSubsystemContext(self.forces, context), later, _MOMENT
        )


def _pushes(results: ContactResults) -> Iterator[tuple[Any, Any, Array]]:
    """Yield which two geometries push each other, and the force on the second in W."""
    for k in range(results.num_point_pair_contacts()):
        contact = results.point_pair_contact_info(k)
        pair = contact.point_pair()
        yield pair.id_A, pair.id_B, contact.contact_force()
    for k in range(results.num_hydroelastic_contacts()):
        pressed = results.hydroelastic_contact_info(k)
        surface = pressed.contact_surface()
        yield surface.id_M(), surface.id_N(), -pressed.F_Ac_W().translational()


def spatial_inertia(body: Body) -> SpatialInertia:
    """Return a body's mass properties as Drake takes them, validated by Drake."""
    xx, yy, zz, xy, xz, yz = body.I_BBcm_B
    return SpatialInertia.MakeFromCentralInertia(
        body.mass, body.p_BoBcm_B, RotationalInertia(xx, yy, zz, xy, xz, yz)
    )


def plant_of_bodies(separation: Separation) -> MultibodyPlant:
    """Return the continuous plant of a separation's bodies, free in W; to finalize."""
    plant = MultibodyPlant(time_step=0.0)
    for body in separation.bodies:
        plant.AddRigidBody(body.name, spatial_inertia(body))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    return plant


@typed
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


@typed
def set_mated_motion(
    plant: MultibodyPlant, context: Context, separation: Separation
) -> None:
    """Write the motion of the mated stack into a plant's Context.

    It moves as one rigid body, with A's origin at W's and A's CG at rest, but for what
    spins in it.

    Args:
        plant: in which bodies of their names float.
        context: of the plant.
        separation: with the bodies, their mated places and the initial motion.
    """
    initial = separation.initial
    c_A = separation.body(separation.A).p_BoBcm_B
    places = [*mated_places(separation).values()]
    pads = [attachment.p_AoPad_A for attachment in separation.attachments]
    spins = [
        mated_spin(separation, body, places, pads, body.spin)
        for body in separation.bodies
    ]
    motion = initial.rpy_WA, initial.w_WA_A
    motions = mated_motion(places, *motion, c_A, math, spins)
    for body, (q_WB, p_WBo, w_WB, v_WBo) in zip(
        separation.bodies, motions, strict=True
    ):
        link = plant.GetBodyByName(body.name)
        plant.SetFloatingBaseBodyPoseInWorldFrame(
            context, link, RigidTransform(Quaternion(q_WB), p_WBo)
        )
        plant.SetFreeBodySpatialVelocity(context, link, SpatialVelocity(w_WB, v_WBo))
