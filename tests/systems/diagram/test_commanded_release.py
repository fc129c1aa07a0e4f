"""Attachments let go when a signal says so, or when a hinge has turned."""

import dataclasses
import math

import numpy as np
import pytest
from flying import simulator_of
from pydrake.systems.framework import Diagram, DiagramBuilder, EventStatus, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
from separations import STIFF, generic_pair

from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.run import RunStatus
from drakesep.systems.model.separation import InitialMotion
from drakesep.systems.simulation.simulation import Simulation


ACCURACY = 1e-6
# Drake isolates an event to a hundredth of the accuracy, in seconds.
LATENESS = 0.01 * ACCURACY
HELD = math.inf


class Signal(LeafSystem):
    """Up from one time to another, one for each output."""

    def __init__(self, *ups: tuple[float, float]):
        super().__init__()
        self.DeclareVectorOutputPort(
            "up",
            len(ups),
            lambda context, output: output.SetFromVector(
                [float(start <= context.get_time() < end) for start, end in ups]
            ),
        )


class Sequencer(LeafSystem):
    """Raises its output in a discrete event, as a flight computer does."""

    def __init__(self, time: float):
        super().__init__()
        self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("up", self.DeclareDiscreteState(1))
        self.DeclarePeriodicDiscreteUpdateEvent(1e3, time, self._raise)

    def _raise(self, context, update):
        update.set_value(1, [1.0])
        return EventStatus.Succeeded()


def released_after(source, port, times, separation=None, start=0.0):
    """Release times that the diagram has recorded after each of the given times."""
    separation = separation or generic_pair(release_times=(0.05, 0.06))
    builder = DiagramBuilder()
    system = builder.AddSystem(SeparationSystem(separation))
    source = builder.AddSystem(source)
    builder.Connect(source.get_output_port(), system.GetInputPort(port))
    parent = builder.Build()
    context = parent.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, separation)
    context.SetTime(start)
    simulator = simulator_of(parent, context, ACCURACY)
    recorded = []
    for t in times:
        simulator.AdvanceTo(t)
        recorded.append(system.GetOutputPort("released").Eval(inner).tolist())
    return recorded


def test_one_trigger_for_all_takes_the_place_of_the_schedule():
    before, after = released_after(Signal((0.2, 9.0)), "trigger", [0.199, 0.21])
    assert before == [HELD, HELD]
    assert after[0] == after[1]
    assert 0.2 <= after[0] <= 0.2 + LATENESS


def test_a_trigger_for_each_together_and_a_millisecond_apart():
    separation = generic_pair(release_times=(0.05,) * 3)
    source = Signal((0.1, 9.0), (0.1, 9.0), (0.101, 9.0))
    [recorded] = released_after(source, "triggers", [0.2], separation)
    assert recorded[0] == recorded[1]
    assert np.subtract(recorded, [0.1, 0.1, 0.101]).min() >= 0.0
    assert np.subtract(recorded, [0.1, 0.1, 0.101]).max() <= LATENESS


def test_release_is_latched():
    """The signal may fall again, and a pulse is not stepped over."""
    [recorded] = released_after(Signal((0.1, 0.15)), "trigger", [0.3])
    assert recorded == pytest.approx([0.1, 0.1], abs=LATENESS)


@pytest.mark.parametrize(
    "make_source", [lambda: Signal((0.1, 9.0)), lambda: Sequencer(0.1)]
)
@pytest.mark.parametrize("pause", [0.1, 0.1 + 1e-12, 0.05])
def test_simulation_may_pause_where_the_trigger_rises(make_source, pause):
    """Drake ends the process if it must find a crossing at the end of AdvanceTo."""
    before, after = released_after(make_source(), "trigger", [pause, 0.2])
    assert before == [HELD, HELD]
    assert after == pytest.approx([0.1, 0.1], abs=LATENESS)


def test_trigger_of_a_discrete_event():
    """It is up from the start of a step on: there is no crossing to find."""
    [recorded] = released_after(Sequencer(0.1), "trigger", [0.3])
    assert 0.1 <= recorded[0] <= 0.1 + LATENESS


@pytest.mark.parametrize("start", [0.0, 0.02])
def test_trigger_that_is_up_before_the_start(start):
    source = ConstantVectorSource([1.0, 0.0])
    [recorded] = released_after(source, "triggers", [0.1], start=start)
    assert recorded == [start, HELD]


def test_trigger_at_the_start_of_a_discrete_event():
    [recorded] = released_after(Sequencer(0.0), "trigger", [0.1])
    assert 0.0 <= recorded[0] <= LATENESS


class Both(Diagram):
    """One for all at 0.2 s; of one for each, the first rises before and falls again."""

    def __init__(self):
        super().__init__()
        builder = DiagramBuilder()
        for name, ups in (
            ("trigger", [(0.2, 9.0)]),
            ("triggers", [(0.1, 0.15), (0.3, 9.0)]),
        ):
            source = builder.AddSystem(Signal(*ups))
            builder.ExportOutput(source.get_output_port(), name)
        builder.BuildInto(self)


def test_with_both_triggers_the_first_of_the_two_counts():
    builder = DiagramBuilder()
    separation = generic_pair(release_times=(0.05, 0.06))
    system = builder.AddSystem(SeparationSystem(separation))
    both = builder.AddSystem(Both())
    for name in ("trigger", "triggers"):
        builder.Connect(both.GetOutputPort(name), system.GetInputPort(name))
    parent = builder.Build()
    context = parent.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, separation)
    simulator_of(parent, context, ACCURACY).AdvanceTo(0.4)
    released = system.GetOutputPort("released").Eval(inner).tolist()
    assert released == pytest.approx([0.1, 0.2], abs=LATENESS)


def test_triggers_of_the_wrong_size():
    with pytest.raises(RuntimeError, match=r"(?i)size 3.*triggers.*size 2"):
        released_after(Signal(*[(0.1, 9.0)] * 3), "triggers", [0.1])


def test_trigger_that_depends_on_the_motion():
    """A guidance that waits for the rate to turn has no algebraic loop."""

    class Guidance(LeafSystem):
        def __init__(self):
            super().__init__()
            rate = self.DeclareVectorInputPort("rate", 3)
            self.DeclareVectorOutputPort(
                "go",
                1,
                lambda context, output: output.SetFromVector(
                    [float(rate.Eval(context)[1] > limit)]
                ),
            )

    free = generic_pair(release_times=(0.9,) * 4, springs=False)
    motion = Simulation(free, Integration(accuracy=1e-8)).run().motion
    limit = 0.5 * (motion.rate[0, 1] + motion.rate[120, 1])
    assert motion.rate[0, 1] < limit < motion.rate[120, 1]
    builder = DiagramBuilder()
    system = builder.AddSystem(SeparationSystem(free))
    guidance = builder.AddSystem(Guidance())
    builder.Connect(system.GetOutputPort("rate"), guidance.get_input_port())
    builder.Connect(guidance.get_output_port(), system.GetInputPort("trigger"))
    parent = builder.Build()
    context = parent.CreateDefaultContext()
    inner = system.GetMyMutableContextFromRoot(context)
    system.set_separation(inner, free)
    simulator_of(parent, context, 1e-8).AdvanceTo(0.8)
    expected = np.interp(limit, motion.rate[:121, 1], motion.time[:121])
    released = system.GetOutputPort("released").Eval(inner)
    assert released == pytest.approx([expected] * 4, abs=1e-4)  # straight lines of 3 ms


def hinged_pair(release_angle):
    """A hinge at one pad; the spring at the other turns the upper body about it."""
    separation = generic_pair(
        release_times=(0.0, 0.0), initial=InitialMotion(), duration=6.0
    )
    push, hinge = separation.attachments
    push = dataclasses.replace(push, joint=STIFF, p_AoPad_A=(0.0, 0.0, 0.5))
    joint = Joint(
        type="revolute",
        K_F=1e6,
        D_F=2e4,
        K_T=1e6,
        D_T=2e4,
        x_axis_A=(0.0, 1.0, 0.0),
        y_axis_A=(0.0, 0.0, 1.0),
    )
    hinge = dataclasses.replace(
        hinge,
        spring=None,
        p_AoPad_A=(0.0, 0.0, -0.5),
        joint=joint,
        release_time=math.inf,
        release_angle=release_angle,
    )
    return dataclasses.replace(separation, attachments=(push, hinge))


def test_hinge_lets_go_at_its_angle():
    separation = hinged_pair(0.3)
    run = Simulation(separation).run()
    released = run.releases["attachment_2"]
    assert 0.2 < released < separation.duration
    assert released in run.breaks
    # While hinged, the relative rate about the hinge adds up to the angle.
    hinged = run.motion.time <= released
    turned = np.trapezoid(run.motion.relative_rate[hinged, 1], run.motion.time[hinged])
    assert abs(turned) == pytest.approx(0.3, abs=2e-4)  # straight lines of 20 ms
    held = np.abs(run.motion.relative_rate[hinged][:, [0, 2]]).max()
    free = np.abs(run.motion.relative_rate[hinged, 1]).max()
    assert held < 0.05 * free


def test_under_a_parent_the_hinge_lets_go_at_the_same_time():
    separation = hinged_pair(0.3)
    run = Simulation(separation, Integration(accuracy=1e-8)).run()
    system = SeparationSystem(separation)
    context = system.CreateDefaultContext()
    system.set_separation(context, separation)
    simulator_of(system, context, 1e-8).AdvanceTo(separation.duration)
    released = system.GetOutputPort("released").Eval(context)
    assert released[1] == pytest.approx(run.releases["attachment_2"], abs=1e-6)


def test_hinge_that_never_lets_go_is_a_result():
    run = Simulation(hinged_pair(2.9)).run()
    assert run.status is RunStatus.COMPLETED
    assert run.held == ("attachment_2",)
    why = "attachment_2 has not let go: its joint has not turned by 166"
    assert run.not_separated.startswith(why)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"release_angle": 0.0}, "attachment_2: release angle must be above 0 and"),
        ({"release_angle": 3.2}, "and below 180 deg, got 183"),
        ({"release_angle": math.nan}, "release angle must be finite, got nan"),
        ({"joint": STIFF}, "turns about its x axis alone, got fixed"),
    ],
)
def test_bad_release_angle(change, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(hinged_pair(0.3).attachments[1], **change)
