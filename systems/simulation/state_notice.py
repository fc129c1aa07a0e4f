"""Tells what is cached that the state has changed, where an integrator does not.

Some of Drake's schemes evaluate at the end of a step. If that step is rejected, Drake
sets time and state back, but tells caches of time alone (1.51.1): the next try would
begin with positions and velocities of the end.
"""

from pydrake.systems.framework import Context, ContinuousState, LeafSystem


class StateNotice(LeafSystem):
    """Comes first in a diagram, which asks for derivatives in the order of its systems.

    It has none of its own. Each evaluation is of another state, but for those between
    which no integrator comes: so nothing is lost.
    """

    def __init__(self) -> None:
        super().__init__()
        self._context: Context | None = None

    def watch(self, context: Context | None) -> None:
        """Give notice of the state of a diagram's Context from now on, or of none."""
        self._context = context

    def DoCalcTimeDerivatives(
        self, context: Context, derivatives: ContinuousState
    ) -> None:
        """Give notice."""
        if self._context is not None:
            self._context.get_mutable_continuous_state_vector()
