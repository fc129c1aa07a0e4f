"""The state of a run at any time, from its integration steps.

Drake's own dense output is not used: it takes the derivatives at the start of a step
at the time of its end, which is wrong for forces that depend on time, as springs' do
(drake 1.51.1: 7e-4 m/s^2 of 3 in the first step of a release at accuracy 1e-6).
"""

import functools

import numpy as np
from pydrake.systems.framework import Context

from drakesep.systems.arrays import Array
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.diagram.state_layout import BodyStates
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.simulation.step_polynomials import StepPolynomials


class Recorder:
    """Records the state at every step; call `note` from a Simulator's monitor.

    And its derivatives, with which the next step begins. No step feels what is within
    another, as a kink is that is not foreseen.
    """

    def __init__(self, system: SeparationSystem, context: Context):
        self._system = system
        self._context = context
        self._times: list[float] = []
        self._states: list[Array] = []
        self._slopes: list[Array] = []

    def start_piece(self) -> None:
        """Begin a stretch without a kink, after what happens at this time."""
        self._times.append(self._context.get_time())
        state = self._context.get_continuous_state_vector()
        self._states.append(state.CopyToVector())
        slope = self._system.EvalTimeDerivatives(self._context)
        self._slopes.append(slope.CopyToVector())

    def note(self) -> None:
        """Record a step."""
        if self._times and self._context.get_time() > self._times[-1]:
            self.start_piece()

    def step_times(self) -> Array:
        """Return the times at which steps ended, increasing, s."""
        return np.unique(self._times)

    @functools.cached_property
    def bodies_at_steps(self) -> list[BodyState]:
        """The bodies' motion at those times."""
        return self.bodies(self.step_times())

    def bodies(self, times: Array) -> list[BodyState]:
        """Return the bodies' motion at n times of the run; at a kink, after it."""
        return self._system.layout.read(self._path.states(times))

    def bodies_at(self, time: float) -> BodyStates:
        """Return the bodies' motion at one time, s; at a kink, after it."""
        [x] = self._path.states(np.array([time])).T
        return self._system.layout.bodies(x.tolist())

    def accelerations(self, times: Array) -> Array:
        """Return (m, 6, n) of each body at n times of the run; at a kink, after it.

        Angular, rad/s^2, and of its origin, m/s^2, in W.
        """
        return self._path.accelerations(times)

    @functools.cached_property
    def _path(self) -> StepPolynomials:
        """Through the steps, once the run has ended."""
        columns = (np.stack(x, axis=-1) for x in (self._states, self._slopes))
        return StepPolynomials(self._system.layout, np.array(self._times), *columns)
