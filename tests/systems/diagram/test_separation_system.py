"""The diagram inside somebody else's."""

import dataclasses

import numpy as np
import pytest
from flying import momentum, simulator_of, start
from pydrake.geometry import Meshcat, MeshcatVisualizer, Role
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Gain, Integrator
from separations import FREE, generic_pair

from drakesep.systems.diagram.separation_system import SeparationSystem, spatial_inertia
from drakesep.systems.model.inertia import inertia_matrix
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parts import Capsule, Cone, Part, Sphere
from drakesep.systems.model.separation import Body, InitialMotion
from drakesep.systems.simulation.simulation import Simulation


SEPARATION = generic_pair(release_times=(0.0, 0.0, 0.1, 0.1))


@pytest.mark.parametrize("scheme", ["runge_kutta3", "bogacki_shampine3"])
def test_inside_a_parent_diagram(scheme):
    """With another's state beside it, another integrator, and only AdvanceTo."""
    builder = DiagramBuilder()
    system = builder.AddNamedSystem("separation", SeparationSystem(SEPARATION))
    angle = builder.AddSystem(Integrator(3))  # what a gyro of the payload would add up
    builder.Connect(system.GetOutputPort("rate"), angle.get_input_port())
    parent = builder.Build()

    context = parent.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, SEPARATION)
    context.SetAccuracy(1e-8)
    simulator = Simulator(parent, context)
    config = SimulatorConfig(integration_scheme=scheme, accuracy=1e-8)
    ApplySimulatorConfig(config, simulator)
    simulator.AdvanceTo(SEPARATION.duration)

    motion = Simulation(SEPARATION, Integration(accuracy=1e-8)).run().motion
    for name in ("rate", "relative_rate", "relative_position", "relative_velocity"):
        final = system.GetOutputPort(name).Eval(inner)
        # 1e-8 a step of joints that ring; the cruder scheme leaves 4e-7
        assert final == pytest.approx(getattr(motion, name)[-1], abs=1e-6)
    turned = np.trapezoid(motion.rate, motion.time, axis=0)
    gyro = angle.get_output_port().Eval(angle.GetMyContextFromRoot(context))
    assert gyro == pytest.approx(turned, abs=1e-5)  # trapezia of 3 ms


def test_external_wrenches():
    """Thrust and torque on one body, from outside, give what Newton says."""
    apart = generic_pair(springs=False, initial=InitialMotion())
    builder = DiagramBuilder()
    system = builder.AddSystem(SeparationSystem(apart, external_wrenches=True))
    torque, force = np.array([3.0, -5.0, 7.0]), np.array([200.0, -100.0, 50.0])
    upper = apart.body("upper")
    moment = torque + np.cross(upper.p_BoBcm_B, force)  # the force acts at the CG
    wrenches = np.concatenate([np.zeros(6), moment, force])
    source = builder.AddSystem(ConstantVectorSource(wrenches))
    builder.Connect(source.get_output_port(), system.GetInputPort("external_wrenches"))
    parent = builder.Build()
    context = parent.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, apart)
    context.SetAccuracy(1e-6)
    parent.ExecuteInitializationEvents(context)  # lets go

    acceleration = system.GetOutputPort("acceleration").Eval(inner)
    assert acceleration == pytest.approx(force / upper.mass, rel=1e-12)
    rates = system.EvalTimeDerivatives(inner).CopyToVector()[14:26].reshape(2, 6)
    assert rates[0] == pytest.approx(np.zeros(6), abs=1e-15)
    turning = np.linalg.solve(inertia_matrix(upper.I_BBcm_B), torque)
    assert rates[1, :3] == pytest.approx(turning, rel=1e-11)


def test_another_structure_is_refused():
    system = SeparationSystem(SEPARATION)
    context = system.CreateDefaultContext()
    fewer = dataclasses.replace(SEPARATION, attachments=SEPARATION.attachments[:2])
    with pytest.raises(ValueError, match="must have the attachments that"):
        system.set_separation(context, fewer)


def test_mass_properties_as_drake_takes_them():
    """Products are entries of the matrix, about the CG."""
    inertia = (2.0, 3.0, 4.0, 0.1, -0.2, 0.3)
    body = Body(name="b", mass=5.0, p_BoBcm_B=(1.0, 2.0, 3.0), I_BBcm_B=inertia)
    M = spatial_inertia(body)
    central = M.Shift(M.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    expected = [[2.0, 0.1, -0.2], [0.1, 3.0, 0.3], [-0.2, 0.3, 4.0]]
    # shifted by sqrt(14) m and back, at 5 kg
    assert central == pytest.approx(np.array(expected), abs=1e-13)


def test_three_bodies_in_a_stack():
    """The top leaves the middle, which stands askew; momentum of all is conserved."""
    lower, upper = SEPARATION.bodies
    middle = dataclasses.replace(
        upper, name="middle", p_ABo=(0.1, 0.0, 0.2), rpy_AB=(0.4, 0.3, -0.2)
    )
    top = dataclasses.replace(
        upper, name="top", p_ABo=(2.5, 0.0, 0.0), rpy_AB=(-0.1, 0.2, 0.3)
    )
    attachments = list(SEPARATION.attachments)
    for i, (a, b, x, t) in enumerate(
        [("lower", "middle", 0.0, 0.9), ("middle", "top", 2.5, 0.0)]
    ):
        attachments[i] = dataclasses.replace(
            attachments[i], A=a, B=b, p_AoPad_A=(x, 0.1, 0.2), release_time=t
        )
    attachments[0] = dataclasses.replace(attachments[0], spring=None)
    stack = dataclasses.replace(
        SEPARATION,
        bodies=(lower, middle, top),
        attachments=tuple(attachments[:2]),
        B="top",
    )
    system, context, simulator = start(stack, 1e-8)
    before = momentum(system, context)
    # Mated as it stands, no joint pulls: the top is not held, so its spring alone acts,
    # and the lower body feels nothing yet.
    system.ExecuteInitializationEvents(context)
    rates = system.EvalTimeDerivatives(context).CopyToVector()[21:39].reshape(3, 6)
    at_rest = generic_pair().initial  # but for the slow turn of the stack
    turning = np.dot(at_rest.w_WA_A, at_rest.w_WA_A)
    assert np.abs(rates[0]).max() < 10.0 * turning
    assert np.linalg.norm(rates[2]) > 0.5
    simulator.AdvanceTo(stack.duration)
    assert momentum(system, context) == pytest.approx(before, abs=1e-6)  # as for two
    run = Simulation(stack).run()
    assert run.motion.relative_velocity[-1, 0] > 0.1  # the top has left the stack
    # the top's own: the lower attachment lets go at 0.9 s
    assert run.releases["attachment_1"] == 0.9
    assert run.separation_end == run.stroke_ends["spring_2"]


def test_parent_gives_the_same_bits():
    """The same settings, with other blocks beside and a listener on a port."""
    separation = generic_pair(release_times=(0.0, 0.1, 0.101, 0.102))
    alone, context, simulator = start(separation, 1e-6)
    simulator.AdvanceTo(separation.duration)
    expected = alone.GetOutputPort("plant_state").Eval(context)

    builder = DiagramBuilder()
    system = builder.AddSystem(SeparationSystem(separation))
    gain = builder.AddSystem(Gain(2.0, 3))
    builder.Connect(system.GetOutputPort("rate"), gain.get_input_port())
    builder.AddSystem(ConstantVectorSource([1.0]))
    parent = builder.Build()
    context = parent.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, separation)
    simulator_of(parent, context, 1e-6).AdvanceTo(separation.duration)
    state = system.GetOutputPort("plant_state").Eval(inner)
    assert state.tolist() == expected.tolist()


def test_flown_as_a_simulation_flies_it_the_bits_are_those_of_the_run():
    """A parent that stops where `Simulation` does, with its settings.

    With a scheme that evaluates nothing at the end of a step that may be rejected, and
    with steps that are shorter than pushes ask for.
    """
    separation = generic_pair(release_times=(0.0, 0.1, 0.101, 0.102))
    settings = Integration(scheme="runge_kutta3", max_step=0.01)
    run = Simulation(separation, settings).run()
    builder = DiagramBuilder()
    system = builder.AddSystem(SeparationSystem(separation))
    parent = builder.Build()
    context = parent.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, separation)
    context.SetAccuracy(settings.accuracy)
    simulator = Simulator(parent, context)
    config = SimulatorConfig(
        integration_scheme=settings.scheme,
        accuracy=settings.accuracy,
        max_step_size=settings.max_step,
    )
    ApplySimulatorConfig(config, simulator)
    simulator.get_mutable_integrator().request_initial_step_size_target(1e-3)
    for t in run.breaks[1:]:
        simulator.AdvanceTo(t)
        simulator.AdvancePendingEvents()
    for name in ("rate", "relative_position", "relative_velocity", "angle"):
        final = system.GetOutputPort(name).Eval(inner)
        # a cubic through the last step ends on it, but for its own round-off
        assert final == pytest.approx(getattr(run.motion, name)[-1], abs=1e-15)
    assert simulator.get_integrator().get_num_steps_taken() == run.steps


def test_a_context_can_be_used_again():
    """Releases, strokes and momenta of an earlier flight are forgotten."""
    system = SeparationSystem(SEPARATION)
    context = system.CreateDefaultContext()
    states = []
    for _ in range(2):
        context.SetTime(0.0)
        system.set_separation(context, SEPARATION)
        simulator_of(system, context, 1e-6).AdvanceTo(0.4)
        states.append(context.get_continuous_state_vector().CopyToVector().tolist())
    assert states[0] == states[1]


def test_context_without_accuracy_or_numbers():
    """A parent of fixed steps would not find releases, and say nothing."""
    system = SeparationSystem(SEPARATION)
    context = system.CreateDefaultContext()
    with pytest.raises(RuntimeError, match="must hold a separation: call set_sep"):
        Simulator(system, context).Initialize()
    system.set_separation(context, SEPARATION)
    with pytest.raises(RuntimeError, match="Context must have an accuracy"):
        Simulator(system, context).Initialize()


def test_fixed_steps_find_the_release():
    late = generic_pair(release_times=(0.104,) * 4, joint=FREE)
    expected = Simulation(late, Integration(accuracy=1e-9)).run().motion
    system = SeparationSystem(late)
    context = system.CreateDefaultContext()
    system.set_separation(context, late)
    context.SetAccuracy(1e-6)
    simulator = Simulator(system, context)
    config = SimulatorConfig(max_step_size=0.01, use_error_control=False)
    ApplySimulatorConfig(config, simulator)
    simulator.AdvanceTo(late.duration)
    speed = system.GetOutputPort("relative_velocity").Eval(context)
    # strokes end within steps of 10 ms; stepping over the release would miss 0.07
    assert speed == pytest.approx(expected.relative_velocity[-1], abs=5e-4)


def test_illustrated():
    """The scene shows parts where the plant has their bodies, and pushes nobody."""
    lower, upper = SEPARATION.bodies
    wall = Cone(radius_aft=0.6, radius_fore=0.5, length=0.4, thickness=0.02)
    shown = dataclasses.replace(
        SEPARATION,
        bodies=(
            dataclasses.replace(lower, parts=(Part(name="wall", shape=wall),)),
            dataclasses.replace(
                upper,
                parts=(
                    Part(name="tank", shape=Sphere(radius=0.3)),
                    Part(name="mast", shape=Capsule(radius=0.1, length=1.0)),
                ),
            ),
        ),
    )
    builder = DiagramBuilder()
    system = builder.AddSystem(SeparationSystem(shown, illustrated=True))
    meshcat = Meshcat()
    MeshcatVisualizer.AddToBuilder(
        builder, system.GetOutputPort("geometry_query"), meshcat
    )
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, shown)
    context.SetAccuracy(1e-6)
    Simulator(diagram, context).AdvanceTo(0.5)

    query = system.GetOutputPort("geometry_query").Eval(inner)
    inspector = query.inspector()
    assert inspector.NumGeometriesWithRole(Role.kProximity) == 0
    plant = system.plant
    seen = {}
    for i in inspector.GetAllGeometryIds(Role.kIllustration):
        seen[inspector.GetName(i).rpartition("::")[2]] = query.GetPoseInWorld(i)
    assert sorted(seen) == ["mast", "tank", "wall"]
    tank = plant.GetBodyByName("upper").EvalPoseInWorld(
        plant.GetMyContextFromRoot(context)
    )
    assert seen["tank"].IsNearlyEqualTo(tank, 1e-12)
    assert meshcat.HasPath("/drake/visualizer/upper")
