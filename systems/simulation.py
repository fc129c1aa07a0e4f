"""Runs of one separation: the diagram is built once, then flown as often as asked."""

import itertools
import math
from collections.abc import Iterable, Mapping

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.trajectories import PiecewisePolynomial

from drakesep.systems import laws
from drakesep.systems.model import Separation
from drakesep.systems.motion_analysis import Measured
from drakesep.systems.parameters import with_values
from drakesep.systems.run import Array, Motion, Run, RunStatus
from drakesep.systems.separation_system import SeparationSystem
from drakesep.systems.settings import Integration


_ROWS = 300
"""Sample intervals over a run, at least."""
_NANOSECOND = 1e-9
_ROWS_PER_PUSH = 64
"""Sample intervals over the shortest push, where the motion changes fastest."""


class Simulation:
    """Flies a separation, and any variation of its parameters.

    Every run starts from a fresh Context and a fresh Simulator: a run is the same,
    bit for bit, whatever was flown before it.
    """

    def __init__(self, separation: Separation, integration: Integration | None = None):
        self.separation = separation
        self.integration = integration or Integration()
        self._system = SeparationSystem(separation)

    def run(self, values: Mapping[str, float] | None = None) -> Run:
        """Fly the separation with some of its parameters changed.

        Args:
            values: new values by parameter name, in SI; see
                `drakesep.systems.parameters`.

        Returns:
            The run. One that fails numerically has the status FAILED and says why.

        Raises:
            ValueError: a parameter is unknown, or its value is not physical.
        """
        separation = with_values(self.separation, values or {})
        context = self._system.CreateDefaultContext()
        self._system.set_separation(context, separation)
        context.SetAccuracy(self.integration.accuracy)
        simulator = Simulator(self._system, context)
        ApplySimulatorConfig(
            SimulatorConfig(
                integration_scheme=self.integration.scheme,
                accuracy=self.integration.accuracy,
                max_step_size=self.integration.max_step,
                use_error_control=True,
            ),
            simulator,
        )
        try:
            simulator.Initialize()
            integrator = simulator.get_mutable_integrator()
            integrator.StartDenseIntegration()
            # Steps that end where a spring does spare the integrator a kink.
            for t in _stops(separation.stroke_ends, separation.duration):
                simulator.AdvanceTo(t)
            dense = integrator.StopDenseIntegration()
        except RuntimeError as error:  # Drake's: the step size collapsed, say
            return _failed(separation, f"{error} (at t = {context.get_time():g} s)")
        breaks = find_breaks(separation)
        motion = _sample(self._system, separation, dense, sample_times(separation))
        if not np.isfinite(motion.acceleration).all():
            return _failed(separation, "the motion is not finite")
        return Run(
            separation=separation,
            status=RunStatus.COMPLETED,
            motion=motion,
            breaks=breaks,
            steps=integrator.get_num_steps_taken(),
            evaluations=integrator.get_num_derivative_evaluations(),
        )


def _failed(separation: Separation, message: str) -> Run:
    return Run(separation=separation, status=RunStatus.FAILED, message=message)


def find_breaks(separation: Separation) -> tuple[float, ...]:
    """Return the times at which the motion has a kink, with start and end, s."""
    releases = [max(0.0, a.release_time) for a in separation.attachments]
    kinks = (*releases, *separation.stroke_ends)
    return (0.0, *_stops(kinks, separation.duration))


def _stops(times: Iterable[float], end: float) -> list[float]:
    stops = [0.0]
    for t in sorted(times):
        # Kinks a nanosecond apart are one: nothing moves between them.
        if t - stops[-1] > _NANOSECOND and end - t > _NANOSECOND:
            stops.append(t)
    return [*stops[1:], end]


def sample_times(separation: Separation) -> Array:
    """Return when a run is sampled, s: evenly between kinks, closer in the push."""
    end = separation.duration
    coast = end / _ROWS
    pushes = [spring.duration for spring in separation.springs]
    push = min(coast, min(pushes, default=end) / _ROWS_PER_PUSH)
    push_start = separation.release_start
    push_end = max(separation.stroke_ends, default=push_start)
    breaks = find_breaks(separation)
    times = [np.zeros(1)]
    for t0, t1 in itertools.pairwise(breaks):
        step = push if push_start <= t0 < push_end else coast
        intervals = math.ceil((t1 - t0) / step)
        times.append(np.linspace(t0, t1, intervals + 1)[1:])
    return np.concatenate(times)


def _sample(
    system: SeparationSystem,
    separation: Separation,
    dense: PiecewisePolynomial,
    times: Array,
) -> Motion:
    layout = system.layout
    x = dense.vector_values(times)
    xdot = dense.derivative(1).vector_values(times)
    names = [body.name for body in separation.bodies]
    bodies = layout.read(x)
    A, B = bodies[names.index(separation.A)], bodies[names.index(separation.B)]
    _, v = layout.starts[names.index(separation.B)]
    measured = Measured.of(separation)
    motion = laws.relative_motion(
        A, B, measured.p_BoBcm_B, measured.mated_p_AoBcm_A, np
    )
    acceleration = laws.cg_acceleration(
        B, measured.p_BoBcm_B, tuple(xdot[v : v + 3]), tuple(xdot[v + 3 : v + 6])
    )
    momentum = x[layout.size :]
    return Motion(
        time=times,
        acceleration=np.stack(acceleration, axis=1),
        linear_momentum_change=measured.mass * momentum[:3].T,
        angular_momentum_change=measured.inertia * momentum[3:].T,
        **{name: np.stack(vector, axis=1) for name, vector in motion._asdict().items()},
    )
