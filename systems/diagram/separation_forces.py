"""Everything of a separation but its bodies, as a Drake diagram."""

import math
from collections.abc import Mapping, Sequence

from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System
from pydrake.systems.primitives import Adder

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.diagram.force_sum import ForceSum
from drakesep.systems.diagram.gravity import Gravity
from drakesep.systems.diagram.joints import CfeBushing
from drakesep.systems.diagram.loads import Loads
from drakesep.systems.diagram.mass_watch import MassWatch
from drakesep.systems.diagram.motion_analysis import MotionAnalysis
from drakesep.systems.diagram.preload import Preload
from drakesep.systems.diagram.release import Release
from drakesep.systems.diagram.rigid_joints import RigidJoints
from drakesep.systems.diagram.springs import Springs
from drakesep.systems.diagram.state_layout import BodyStates, StateLayout
from drakesep.systems.equations.springs import law_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Vector


@typed
class SeparationForces(Diagram):
    """Release, springs, joints, loads, gravity and motion analysis of a separation.

    Built once for the structure of a separation: every number in it is written into a
    Context with `set_separation`, so that a run is varied without a rebuild.

    Subsystems: ``release``, ``springs``, ``cfe_bushing``, ``force_sum``,
    ``motion_analysis``; and ``loads``, ``gravity``, and ``rigid_joints`` with
    ``force_sum_with_joints``, if the separation has loads, an orbit or rigid joints.
    For each other body that leaves there is one more motion analysis, with outputs like
    the last eight that have its name before theirs, as ``satellite_rate``. Bodies that
    are watched have a ``mass_watch``.

    Input ports:
        plant_state: (s,) 1, m, rad/s and m/s in W: state of the plant, in which the
            layout finds the motion of each body.
        plant_acceleration: (6 m,) rad/s^2 and m/s^2 in W: angular acceleration, then
            acceleration of the origin, of each of the m bodies.
        trigger: (1,) 1: commands the release of all attachments where it rises above
            0.5; optional. With it, or the next, the scheduled times are not used.
        triggers: (n,) 1: command the release of each attachment likewise; optional.
            With both, an attachment lets go at the first of the two.
        external_wrenches: (6 m,) N m and N in W: torque about the origin, then force,
            on each of the m bodies, in the order of `Separation.bodies`: thrust,
            disturbances, whatever the surrounding diagram knows of; if asked for.

    Output ports:
        wrenches: (6 m,) N m and N in W: torque about the origin, then force, on each of
            the m bodies.
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
    """

    def __init__(
        self,
        separation: Separation,
        layout: StateLayout,
        *,
        external_wrenches: bool = False,
        motion_analysis: bool = True,
        watched: Mapping[str, Vector] | None = None,
    ):
        """Build the diagram.

        Args:
            separation: the bodies, attachments, springs and loads.
            layout: where `plant_state` holds the motion of each body.
            external_wrenches: whether to have that input port, which must then be
                connected.
            motion_analysis: whether to measure the motion of what leaves: to have the
                input port `plant_acceleration` and the outputs from `rate` on. Momentum
                is integrated with the motion, which costs at every evaluation.
            watched: gravity in W, m/s^2, by the names of bodies on which nothing else
                acts that is not seen here: where these have other mass properties in
                the plant's Context than here, that is told; see `MassWatch`. With
                motion analysis alone.
        """
        super().__init__()
        builder = DiagramBuilder()
        self._release: Release = builder.AddNamedSystem(
            "release", Release(separation, layout)
        )
        self._springs: Springs = builder.AddNamedSystem(
            "springs", Springs(separation, layout)
        )
        self._bushing: CfeBushing = builder.AddNamedSystem(
            "cfe_bushing", CfeBushing(separation, layout)
        )
        # In the order of the pairs, which is that of their states.
        self._motions: dict[str, MotionAnalysis] = {
            pair.B: builder.AddNamedSystem(
                "_".join(["motion_analysis", pair.B][: 1 + (pair.B != separation.B)]),
                MotionAnalysis(separation, layout, pair.B),
            )
            for pair in separation.pairs
            if motion_analysis
        }
        self._loads: Loads | None = None
        self._gravity: Gravity | None = None
        forces: list[System] = [self._springs, self._bushing]
        if separation.loads:
            self._loads = builder.AddNamedSystem("loads", Loads(separation, layout))
            forces.append(self._loads)
        if separation.orbit is not None:
            self._gravity = builder.AddNamedSystem(
                "gravity", Gravity(separation, layout)
            )
            forces.append(self._gravity)
        options = layout, external_wrenches
        sums = [_add_sum(builder, "force_sum", forces, *options)]
        self._preload = builder.AddNamedSystem("preload", Preload(separation))
        loads_of_joints: list[System] = [self._preload, self._bushing]
        self._rigid: RigidJoints | None = None
        if any(attachment.joint.rigid for attachment in separation.attachments):
            # Last: what they do follows from all else.
            self._rigid = builder.AddNamedSystem(
                "rigid_joints", RigidJoints(separation, layout)
            )
            builder.Connect(
                sums[0].GetOutputPort("wrenches"),
                self._rigid.GetInputPort("other_wrenches"),
            )
            forces.append(self._rigid)
            sums.append(_add_sum(builder, "force_sum_with_joints", forces, *options))
            loads_of_joints.append(self._rigid)
        wrenches = sums[-1].GetOutputPort("wrenches")
        if external_wrenches:
            name = "external_wrenches"
            builder.ExportInput(sums[0].GetInputPort(name), name)
            for total in sums[1:]:
                builder.ConnectInput(name, total.GetInputPort(name))
        loads = builder.AddSystem(
            Adder(len(loads_of_joints), 6 * len(separation.attachments))
        )
        for i, system in enumerate(loads_of_joints):
            builder.Connect(system.GetOutputPort("loads"), loads.get_input_port(i))

        released = self._release.GetOutputPort("released")
        reading = self._springs, self._bushing, self._loads, self._rigid, self._preload
        for system in reading:
            if system is not None:
                builder.Connect(released, system.GetInputPort("released"))
        motions = list(self._motions.values())
        self._watch: MassWatch | None = None
        if watched and motion_analysis:
            refuses = self._rigid is not None
            self._watch = builder.AddNamedSystem(
                "mass_watch", MassWatch(separation, layout, watched, refuses=refuses)
            )
            builder.Connect(wrenches, self._watch.GetInputPort("wrenches"))
        watch = [] if self._watch is None else [self._watch]
        readers = (self._release, *forces, *sums, *motions, *watch)
        builder.ExportInput(readers[0].GetInputPort("plant_state"), "plant_state")
        for system in readers[1:]:
            builder.ConnectInput("plant_state", system.GetInputPort("plant_state"))
        for motion in motions:
            builder.Connect(
                self._springs.GetOutputPort("wrenches"),
                motion.GetInputPort("spring_wrenches"),
            )
        name = "plant_acceleration"
        accelerated: list[System] = [*motions, *watch]
        for system in accelerated[:1]:
            builder.ExportInput(system.GetInputPort(name), name)
        for system in accelerated[1:]:
            builder.ConnectInput(name, system.GetInputPort(name))
        for name in ("trigger", "triggers"):
            builder.ExportInput(self._release.GetInputPort(name), name)

        builder.ExportOutput(wrenches, "wrenches")
        builder.ExportOutput(released, "released")
        for output, name in (
            (self._springs.GetOutputPort("forces"), "spring_forces"),
            (self._springs.GetOutputPort("energy"), "spring_energy"),
            (loads.get_output_port(), "joint_loads"),
            (self._preload.GetOutputPort("loads"), "preloads"),
            (self._bushing.GetOutputPort("energy"), "joint_energy"),
        ):
            builder.ExportOutput(output, name)
        for body, motion in self._motions.items():
            for i in range(motion.num_output_ports()):
                output, prefix = motion.get_output_port(i), f"{body}_"
                name = output.get_name()
                builder.ExportOutput(
                    output, name if motion is motions[0] else prefix + name
                )
        builder.BuildInto(self)
        self._structure = _structure(separation)

    def set_separation(self, context: Context, separation: Separation) -> None:
        """Write the numbers of a separation into a Context.

        Args:
            context: of this diagram.
            separation: with the structure that this system was built for.

        Raises:
            ValueError: the separation has other bodies, attachments, joint types or
                axes, springs, profiles or load tables.
        """
        structure = _structure(separation)
        for part, built in self._structure.items():
            if structure[part] != built:
                raise InputError(
                    f"separation must have the {part} that the system was built for, "
                    f"{built}; got {structure[part]}"
                )

        def of(system: System) -> Context:
            return self.GetMutableSubsystemContext(system, context)

        self._release.set_schedule(of(self._release), separation)
        self._springs.set_springs(of(self._springs), separation)
        self._bushing.set_joints(of(self._bushing), separation)
        self._preload.set_pressed(of(self._preload), separation)
        for motion in self._motions.values():
            motion.set_measured(of(motion), separation)
        if self._rigid is not None:
            self._rigid.set_joints(of(self._rigid), separation)
        if self._loads is not None:
            self._loads.set_loads(of(self._loads), separation)
        if self._gravity is not None:
            self._gravity.set_gravity(of(self._gravity), separation)
        if self._watch is not None:
            self._watch.set_bodies(of(self._watch), separation)

    def parameters_read(self, separation: Separation) -> set[str]:
        """Return the names of the parameters that the systems read.

        Args:
            separation: with the structure that this system was built for.
        """
        names: set[str] = set()
        for system in (
            self._release,
            self._springs,
            self._bushing,
            self._loads,
            self._gravity,
            self._rigid,
        ):
            if system is not None:
                names |= system.parameters_read(separation)
        return names

    def time_to_release(self, context: Context) -> float:
        """Return in which time the next attachment lets go by its joint's motion, s.

        As fast as that moves now; 0 if it has moved far enough.

        Args:
            context: of this diagram.
        """
        return self._release.time_left(self.GetSubsystemContext(self._release, context))

    def times_to_kinks(
        self, context: Context, later: BodyStates, moment: float
    ) -> tuple[float, float]:
        """Return in which time the next pad reaches a kink of its spring's force, s.

        See `Springs.times_to_kinks`.

        Args:
            context: of this diagram.
            later: the bodies a moment later.
            moment: s.
        """
        springs = self.GetSubsystemContext(self._springs, context)
        return self._springs.times_to_kinks(springs, later, moment)


def _add_sum(
    builder: DiagramBuilder,
    name: str,
    forces: Sequence[System],
    layout: StateLayout,
    external: bool,
) -> ForceSum:
    """Add a system that sums up what acts by others, and return it."""
    total: ForceSum = builder.AddNamedSystem(
        name, ForceSum(layout, len(forces), external=external)
    )
    for i, system in enumerate(forces):
        builder.Connect(
            system.GetOutputPort("acting"), total.GetInputPort(f"acting_{i}")
        )
    return total


def _structure(separation: Separation) -> dict[str, object]:
    """Return what a diagram is built for, part by part."""
    attachments = separation.attachments
    return {
        "bodies": tuple(body.name for body in separation.bodies),
        "attachments": tuple((a.name, a.A, a.B) for a in attachments),
        "releases by angle": tuple(math.isfinite(a.release_angle) for a in attachments),
        "releases by travel": tuple(
            math.isfinite(a.release_travel) for a in attachments
        ),
        "joints": tuple(
            (a.joint.type, a.joint.rigid, a.joint.x_axis_A, a.joint.y_axis_A)
            for a in attachments
        ),
        "springs": tuple(
            a.spring and (law_of(a.spring), a.spring.name) for a in attachments
        ),
        "loads": tuple(
            (x.name, x.body, x.axes, x.after, x.times, x.forces, x.torques)
            for x in separation.loads
        ),
        "pairs": tuple((pair.A, pair.B) for pair in separation.pairs),
        "recontact": separation.recontact
        and (separation.recontact, tuple(body.parts for body in separation.bodies)),
        "gravity": "of an orbit" if separation.orbit else "none",
    }
