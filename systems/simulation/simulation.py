"""Runs of one separation: the diagram is built once, then flown as often as asked."""

import itertools
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus
from scipy.optimize import brentq

from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.equations import relative_motion as motion_laws
from drakesep.systems.equations.momentum_of_run import momentum_given
from drakesep.systems.equations.motion_of_run import relative_motion_of
from drakesep.systems.equations.pushers import push_displacement, push_place
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.equations.springs import is_held_back, law_of
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import check_read, with_values
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.run import (
    ContactForces,
    Motion,
    Run,
    RunStatus,
    Trajectory,
)
from drakesep.systems.model.separation import Attachment, Pair, Separation
from drakesep.systems.sampling import NANOSECOND, find_breaks, find_kinks, sample_times
from drakesep.systems.simulation.contact_log import ContactLog
from drakesep.systems.simulation.error_control import error_control
from drakesep.systems.simulation.foresight import Foresight
from drakesep.systems.simulation.recorder import Recorder
from drakesep.systems.simulation.state_notice import StateNotice


_MOST_STEPS, _MOST_EVALUATIONS = 100_000, 3_000_000
"""Of a run, which takes hundreds to thousands, and of its forces: with gains or forces
that no launcher has it would take days. What is counted is the same on any machine."""
_FIRST_STEP = 1e-3
"""Tried at the start, s."""
_STEPS_PER_PUSH = 12
"""At least, of springs by time."""


@typed
class Simulation:
    """Flies a separation, and any variation of its parameters.

    Every run starts from a fresh Context and a fresh Simulator: a run is the same,
    bit for bit, whatever was flown before it.
    """

    def __init__(self, separation: Separation, integration: Integration | None = None):
        self.separation = separation
        self.integration = integration or Integration()
        builder = DiagramBuilder()
        self._notice = builder.AddSystem(StateNotice())
        # Momentum is summed after a run: what is integrated costs at every step.
        self._system: SeparationSystem = builder.AddSystem(
            SeparationSystem(separation, motion_analysis=False)
        )
        self._diagram = builder.Build()
        self._read = self._system.parameters_read(separation)

    def reads(self, names: Iterable[str]) -> bool:
        """Return whether parameters of these names are all read, and may be changed."""
        return self._read.issuperset(names)

    @typed
    def run(self, values: Mapping[str, float] | None = None) -> Run:
        """Fly the separation with some of its parameters changed.

        Args:
            values: new values by parameter name, in SI; see
                `drakesep.systems.model.parameters`.

        Returns:
            The run. One that fails numerically has the status FAILED and says why.

        Raises:
            ValueError: a parameter is unknown or none that the systems read, or its
                value is not physical.
        """
        separation = with_values(self.separation, values or {})
        check_read(values or {}, self._read, "a Drake system")
        whole = self._diagram.CreateDefaultContext()
        context = self._system.GetMyMutableContextFromRoot(whole)
        self._system.set_separation(context, separation)
        self._notice.watch(whole)
        simulator = self._make_simulator(whole)
        try:
            contacts = ContactLog(self._system, context)
            recorder, releases = self._advance(simulator, context, separation, contacts)
            ends = _find_stroke_ends(separation, recorder, releases)
            breaks = find_breaks(separation, releases, ends)
            times = sample_times(separation, releases, ends)
            times = _with_contacts(times, recorder.step_times(), contacts.forces)
            momenta = momentum_given(
                separation,
                times,
                recorder.step_times(),
                recorder.bodies,
                releases,
                ends,
            )
            motions, trajectory = _sample(separation, recorder, times, momenta)
        except (RuntimeError, ArithmeticError, ValueError) as error:
            # Drake's: the step size collapsed, say. Python's: a number overflowed.
            return Run(
                separation=separation,
                status=RunStatus.FAILED,
                message=f"{error} (at t = {context.get_time():g} s)",
            )
        finally:
            # It knows the simulator: a circle through C++, which is never freed.
            simulator.clear_monitor()
            self._notice.watch(None)
        integrator = simulator.get_mutable_integrator()
        return Run(
            separation=separation,
            status=RunStatus.COMPLETED,
            motion=motions.pop(separation.B),
            others=motions,
            trajectory=trajectory,
            breaks=breaks,
            releases=releases,
            stroke_ends=ends,
            contacts=contacts.forces,
            steps=integrator.get_num_steps_taken(),
            evaluations=integrator.get_num_derivative_evaluations(),
        )

    def _make_simulator(self, context: Context) -> Simulator:
        # New for every run: a used integrator remembers its last step size.
        context.SetAccuracy(self.integration.accuracy)
        pushed = self.separation.recontact is not None
        accuracy, max_step = error_control(self.integration, recontact=pushed)
        simulator = Simulator(self._diagram, context)
        ApplySimulatorConfig(
            SimulatorConfig(
                integration_scheme=self.integration.scheme,
                accuracy=accuracy,
                max_step_size=max_step,
                use_error_control=True,
            ),
            simulator,
        )
        # Drake's own first try, a tenth of the largest step, overflows stiff joints; it
        # refuses one above the largest.
        first_step = min(_FIRST_STEP, max_step)
        simulator.get_mutable_integrator().request_initial_step_size_target(first_step)
        return simulator

    def _advance(
        self,
        simulator: Simulator,
        context: Context,
        separation: Separation,
        contacts: ContactLog,
    ) -> tuple[Recorder, dict[str, float]]:
        """Fly to the end; return what was recorded, and when attachments let go, s."""
        system = self._system
        released = system.GetOutputPort("released")
        recorder = Recorder(system, context)
        check_effort = _effort_check(simulator, self.integration.time_limit)
        ahead = Foresight(system, context, separation, self.integration.accuracy)

        def monitor(_: Context) -> EventStatus:
            recorder.note()
            contacts.note()
            check_effort()
            if ahead.is_near():
                return EventStatus.ReachedTermination(system, "near an event")
            return EventStatus.DidNothing()

        simulator.set_monitor(monitor)
        simulator.Initialize()
        integrator = simulator.get_mutable_integrator()
        largest = integrator.get_maximum_step_size()
        # Steps end at kinks: none straddles one.
        while (now := context.get_time()) < separation.duration:
            releases = _releases(separation, released.Eval(context))
            strokes = separation.timed_stroke_ends(releases)
            kinks = find_kinks(
                separation, separation.scheduled_releases | releases, strokes
            )
            # Also of one a nanosecond after another: what follows begins after it.
            ahead_of_now = (t for t in kinks if t > now)
            stop = min(next(ahead_of_now, math.inf), separation.duration)
            integrator.set_maximum_step_size(
                min(largest, _largest_in_push(now, separation, releases, strokes))
            )
            foreseen = now + ahead.step()
            recorder.start_piece()
            simulator.AdvanceTo(foreseen if foreseen < stop - NANOSECOND else stop)
            simulator.AdvancePendingEvents()
        releases = _releases(separation, released.Eval(context))
        names = [attachment.name for attachment in separation.attachments]
        return recorder, dict.fromkeys(names, math.inf) | releases


def _largest_in_push(
    now: float,
    separation: Separation,
    releases: Mapping[str, float],
    stroke_ends: Mapping[str, float],
) -> float:
    """Return the largest step while springs by time push, s."""
    spans = [
        (releases.get(attachment.name, math.inf), stroke_ends[spring.name])
        for attachment, spring in separation.pushing
        if spring.name in stroke_ends
    ]
    lengths = [end - start for start, end in spans if start <= now < end - NANOSECOND]
    return min(lengths, default=math.inf) / _STEPS_PER_PUSH


def _effort_check(simulator: Simulator, time_limit: float) -> Callable[[], None]:
    """Return what is to be called at each step, and raises once a run takes too many.

    Not EventStatus.Failed, which ends the process with a crash.

    Args:
        simulator: of the run.
        time_limit: of this thread, which flies it, s.
    """
    integrator = simulator.get_integrator()
    steps = itertools.count(1)
    begun = time.thread_time()
    # It takes 20 us to ask for a thread's own time, which is no more than has passed.
    ask = time.monotonic() + time_limit

    def check() -> None:
        nonlocal ask
        if next(steps) > _MOST_STEPS:
            raise RuntimeError(f"it takes more than {_MOST_STEPS} steps")
        if integrator.get_num_derivative_evaluations() > _MOST_EVALUATIONS:
            raise RuntimeError(
                f"it takes more than {_MOST_EVALUATIONS} evaluations of its forces"
            )
        if time.monotonic() > ask:
            left = begun + time_limit - time.thread_time()
            if left < 0.0:
                raise RuntimeError(
                    "it takes more than its time limit on this machine, "
                    f"{time_limit:g} s"
                )
            ask = time.monotonic() + left

    return check


def _releases(separation: Separation, released: Array) -> dict[str, float]:
    """Return when each attachment let go, s, of those that did."""
    return {
        attachment.name: float(t)
        for attachment, t in zip(separation.attachments, released, strict=True)
        if math.isfinite(t)
    }


def _find_stroke_ends(
    separation: Separation,
    recorder: Recorder,
    releases: Mapping[str, float],
) -> dict[str, float]:
    """Return when each spring reached its stroke, s, by its name.

    It is infinite of one that did not within the run, since its bodies are kept
    together.

    Raises:
        RuntimeError: one did not, although nothing keeps them.
    """
    held = [name for name, release in releases.items() if math.isinf(release)]
    ends = separation.timed_stroke_ends(releases)
    for attachment, spring in separation.pushing:
        release = releases[attachment.name]
        if not law_of(spring).by_time and math.isfinite(release):
            ends[spring.name] = _find_stroke_end(
                separation, recorder, attachment, spring, release
            )
        # The model knows when scheduled releases are; not those at an angle.
        if ends.get(spring.name, math.inf) >= separation.duration:
            kept = is_held_back(separation, attachment)
            if not kept and separation.may_part(attachment, held):
                raise RuntimeError(f"{spring.name} has not reached its stroke")
            ends[spring.name] = math.inf
    return ends


def _find_stroke_end(
    separation: Separation,
    recorder: Recorder,
    attachment: Attachment,
    spring: Pusher,
    release: float,
) -> float:
    """Return when a spring by displacement reached its stroke, s, or infinity.

    Args:
        separation: as it was flown.
        recorder: of its run.
        attachment: of the spring.
        spring: the spring.
        release: when the attachment let go, s.
    """
    a, b = separation.ends(attachment)
    place = push_place(separation, attachment, spring)
    stroke = law_of(spring).end(spring, math)

    def left(bodies: Any) -> tuple[Any, Any]:
        displacement, speed = push_displacement(bodies[a], bodies[b], *place)
        return stroke - displacement, speed

    times = recorder.step_times()
    first = np.searchsorted(times, release)
    times = times[first:]
    ahead, speed = (x[first:] for x in left(recorder.bodies_at_steps))
    # Where a step has ended there, it is known to a nanosecond.
    soon = NANOSECOND * np.abs(speed)
    beyond = np.flatnonzero(ahead <= soon)
    if not beyond.size:
        return math.inf
    k = beyond[0]
    if k == 0 or ahead[k] >= -soon[k]:
        return float(times[k])  # the first: it was past its stroke when it was let go
    # What it is given as arguments is free at once; what a closure holds, much later.
    end = brentq(
        _left_at, *times[k - 1 : k + 1], args=(left, recorder), xtol=NANOSECOND
    )
    return float(end)


def _left_at(t: float, left: Callable[[Any], Any], recorder: Recorder) -> float:
    return float(left(recorder.bodies_at(t))[0])


def _with_contacts(
    times: Array, steps: Array, contacts: Sequence[ContactForces]
) -> Array:
    """Return sample times and the steps of contacts, with those beside them, s.

    Between samples the motion is taken for smooth, which a blow is not.
    """
    touching = np.isin(steps, [t for contact in contacts for t in contact.time])
    beside = touching.copy()
    beside[:-1] |= touching[1:]
    beside[1:] |= touching[:-1]
    # A step at a sample time but for round-off is that sample.
    new = steps[beside]
    after = np.searchsorted(times, new)
    nearest = np.minimum(
        np.abs(new - times[np.maximum(after - 1, 0)]),
        np.abs(new - times[np.minimum(after, len(times) - 1)]),
    )
    return np.union1d(times, new[nearest > NANOSECOND])


def _sample(
    separation: Separation,
    recorder: Recorder,
    times: Array,
    momenta: Mapping[str, Array],
) -> tuple[dict[str, Motion], Trajectory]:
    """Return the motions of the bodies that leave, by their names, and of all in W."""
    bodies, accelerations = recorder.bodies(times), recorder.accelerations(times)
    names = tuple(body.name for body in separation.bodies)
    states = np.array([[*b.q_WB, *b.p_WBo, *b.w_WB, *b.v_WBo] for b in bodies])
    trajectory = Trajectory(names=names, time=times, states=np.moveaxis(states, -1, 0))
    motions = {}
    for pair in separation.pairs:
        b = names.index(pair.B)
        motions[pair.B] = _motion(
            separation, pair, trajectory, bodies[b], accelerations[b], momenta[pair.B]
        )
    return motions, trajectory


def _motion(
    separation: Separation,
    pair: Pair,
    trajectory: Trajectory,
    B: BodyState,
    acceleration: Array,
    momentum: Array,
) -> Motion:
    """Return the motion of a pair.

    Args:
        separation: as it was flown.
        pair: in which B leaves.
        trajectory: of all bodies.
        B: its states.
        acceleration: (6, n) angular, and of its origin, in W.
        momentum: (n, 6) linear and angular, that springs gave it, in B.
    """
    p_BoBcm_B = separation.body(pair.B).p_BoBcm_B
    alpha_WB, a_WBo = tuple(acceleration[:3]), tuple(acceleration[3:])
    a_WBcm = motion_laws.cg_acceleration(B, p_BoBcm_B, alpha_WB, a_WBo)
    return Motion(
        time=trajectory.time,
        acceleration=np.stack(a_WBcm, axis=1),
        linear_momentum_change=momentum[:, :3],
        angular_momentum_change=momentum[:, 3:],
        **relative_motion_of(separation, pair, trajectory),
    )
