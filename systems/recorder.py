"""The state of a run at any time, from its integration steps.

Drake's own dense output is not used: it takes the derivatives at the start of a step
at the time of its end, which is wrong for forces that depend on time, as springs' do
(drake 1.51.1: 7e-4 m/s^2 of 3 in the first step of a release at accuracy 1e-6).
"""

from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.framework import Context, System
from scipy.interpolate import CubicSpline

from drakesep.systems.run import Array


@dataclass
class _Piece:
    """A stretch of the run without a kink."""

    start_slope: Array
    times: list[float] = field(default_factory=list)
    states: list[Array] = field(default_factory=list)
    end_slope: Array | None = None


class Recorder:
    """Records the state at every step; call `note` from a Simulator's monitor.

    Between kinks the state is the cubic spline through the steps, with the
    derivatives at both ends: of fourth order, as an error of third-order steps is.
    """

    def __init__(self, system: System, context: Context):
        self._system = system
        self._context = context
        self._pieces: list[_Piece] = []

    def start_piece(self) -> None:
        """Begin a stretch without a kink."""
        self._pieces.append(_Piece(start_slope=self._slope()))
        self.note(self._context)

    def end_piece(self) -> None:
        """End it: before the releases of this time take place."""
        self._pieces[-1].end_slope = self._slope()

    def note(self, context: Context) -> None:
        """Record a step."""
        if self._pieces and self._pieces[-1].end_slope is None:
            piece = self._pieces[-1]
            if not piece.times or context.get_time() > piece.times[-1]:
                piece.times.append(context.get_time())
                piece.states.append(
                    context.get_continuous_state_vector().CopyToVector()
                )

    def _slope(self) -> Array:
        return self._system.EvalTimeDerivatives(self._context).CopyToVector()

    def step_times(self) -> Array:
        """Return the times at which steps ended, increasing, s."""
        return np.unique(np.concatenate([piece.times for piece in self._pieces]))

    def sample(self, times: Array) -> tuple[Array, Array]:
        """Return the state and its derivatives, (nx, n) each, at increasing times.

        At a kink they are those after it.
        """
        starts = [piece.times[0] for piece in self._pieces]
        owners = np.searchsorted(starts, times, side="right") - 1
        states, slopes = [], []
        for i, piece in enumerate(self._pieces):
            at = times[owners == i]
            ends = ((1, piece.start_slope), (1, piece.end_slope))
            cubic = CubicSpline(piece.times, piece.states, bc_type=ends)
            states.append(cubic(at))
            slopes.append(cubic(at, 1))
        return np.concatenate(states).T, np.concatenate(slopes).T
