"""The state of a run at any time, from its integration steps.

Drake's own dense output is not used: it takes the derivatives at the start of a step
at the time of its end, which is wrong for forces that depend on time, as springs' do
(drake 1.51.1: 7e-4 m/s^2 of 3 in the first step of a release at accuracy 1e-6).
"""

import functools
from bisect import bisect_right
from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.framework import Context
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from drakesep.systems.arrays import Array
from drakesep.systems.diagram.separation_system import SeparationSystem
from drakesep.systems.diagram.state_layout import BodyStates
from drakesep.systems.equations.relative_motion import BodyState


@dataclass
class _Piece:
    """A stretch of the run without a kink at which steps end."""

    times: list[float] = field(default_factory=list)
    states: list[Array] = field(default_factory=list)
    slopes: list[Array] = field(default_factory=list)
    """At the start and at the end, or at every step."""
    ended: bool = False

    @functools.cached_property
    def cubic(self) -> CubicSpline | CubicHermiteSpline:
        """Through its steps, once it has ended."""
        if len(self.slopes) == len(self.times):
            return CubicHermiteSpline(self.times, self.states, self.slopes)
        ends = ((1, self.slopes[0]), (1, self.slopes[-1]))
        return CubicSpline(self.times, self.states, bc_type=ends)


class Recorder:
    """Records the state at every step; call `note` from a Simulator's monitor.

    Between kinks the state is the cubic spline through the steps, with the derivatives
    at both ends: of fourth order, as an error of third-order steps is. Past a kink
    within a step such a spline would ring: where there may be some, derivatives are
    taken at every step, for a fifth more time, and no step feels another.
    """

    def __init__(
        self, system: SeparationSystem, context: Context, *, kinks_within_steps: bool
    ):
        self._system = system
        self._context = context
        self._every_slope = kinks_within_steps
        self._pieces: list[_Piece] = []

    def start_piece(self) -> None:
        """Begin a stretch without a kink at which steps end."""
        piece = _Piece()
        self._pieces.append(piece)
        self._note_state(piece)
        self._note_slope(piece)

    def end_piece(self) -> None:
        """End it: before the releases of this time take place."""
        piece = self._pieces[-1]
        if len(piece.slopes) < len(piece.times):
            self._note_slope(piece)
        piece.ended = True

    def note(self) -> None:
        """Record a step."""
        if self._pieces and not self._pieces[-1].ended:
            piece = self._pieces[-1]
            if self._context.get_time() > piece.times[-1]:
                self._note_state(piece)
                if self._every_slope:
                    self._note_slope(piece)

    def _note_state(self, piece: _Piece) -> None:
        piece.times.append(self._context.get_time())
        state = self._context.get_continuous_state_vector()
        piece.states.append(state.CopyToVector())

    def _note_slope(self, piece: _Piece) -> None:
        slope = self._system.EvalTimeDerivatives(self._context)
        piece.slopes.append(slope.CopyToVector())

    def step_times(self) -> Array:
        """Return the times at which steps ended, increasing, s."""
        return np.unique(np.concatenate([piece.times for piece in self._pieces]))

    def bodies(self, times: Array) -> list[BodyState]:
        """Return the bodies' motion at n increasing times; at a kink, after it."""
        return self._system.layout.read(self._evaluate(times, 0))

    def bodies_at(self, time: float) -> BodyStates:
        """Return the bodies' motion at one time, s; at a kink, after it."""
        starts = [piece.times[0] for piece in self._pieces]
        piece = self._pieces[bisect_right(starts, time) - 1]
        return self._system.layout.bodies(piece.cubic(time).tolist())

    def accelerations(self, times: Array) -> list[Array]:
        """Return (6, n) of each: angular, rad/s^2, and of its origin, m/s^2, in W."""
        slopes = self._evaluate(times, 1)
        return [slopes[v : v + 6] for _, v in self._system.layout.starts]

    def _evaluate(self, times: Array, derivative: int) -> Array:
        starts = [piece.times[0] for piece in self._pieces]
        first = np.searchsorted(times, starts)
        parts = [
            piece.cubic(at, derivative)
            for piece, at in zip(self._pieces, np.split(times, first[1:]), strict=True)
        ]
        return np.concatenate(parts).T
