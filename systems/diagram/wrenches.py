"""What acts on floating bodies, and its wrenches, as values between systems.

What acts changes at events only: a force system finds it then, once, and puts it out as
a list of functions of the bodies' motion and time. Their wrenches are one vector of 6 n
entries: torque about the origin and force, in W, for each of n bodies. For a body that
floats in the world these are its generalized forces in Drake, so that such a vector
goes into the plant as it stands; a list of ExternallyAppliedSpatialForce would double
the cost of a run.
"""

from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeVar

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    InputPort,
    LeafSystem,
)

from drakesep.systems.diagram.state_layout import StateLayout
from drakesep.systems.equations.relative_motion import BodyState, Wrench


class WrenchSum:
    """Adds wrenches up, body by body."""

    def __init__(self, bodies: int):
        self.entries = [0.0] * (6 * bodies)

    def add(self, body: int, wrench: Wrench) -> None:
        """Add a wrench on a body, given by its index."""
        entries = self.entries
        (tx, ty, tz), (fx, fy, fz) = wrench
        i = 6 * body
        entries[i] += tx
        entries[i + 1] += ty
        entries[i + 2] += tz
        entries[i + 3] += fx
        entries[i + 4] += fy
        entries[i + 5] += fz


class Force(Protocol):
    """Something that acts on bodies, as it does until an event changes it."""

    def __call__(self, bodies: Sequence[BodyState], t: float, total: WrenchSum) -> None:
        """Add its wrenches at a time, s, to those on the bodies."""


Acting = TypeVar("Acting", bound=Force)


class Forces(Generic[Acting]):
    """What acts by a system: its output ports ``acting`` and ``wrenches``."""

    def __init__(
        self,
        system: LeafSystem,
        state: InputPort,
        layout: StateLayout,
        find: Callable[[Context], list[Acting]],
        prerequisites: set[DependencyTicket],
    ):
        """Declare the ports.

        Args:
            system: that acts.
            state: its input port of the plant's state.
            layout: where `state` holds the motion of each body.
            find: returns what acts. Contexts are copied with it: it holds no system.
            prerequisites: what that depends on.
        """
        self._state = state
        self._layout = layout

        def calc_acting(context: Context, output: AbstractValue) -> None:
            output.set_value(find(context))

        self._acting = system.DeclareAbstractOutputPort(
            "acting", lambda: Value[object](), calc_acting, prerequisites
        )
        size = 6 * len(layout.starts)
        system.DeclareVectorOutputPort("wrenches", size, self._calc_wrenches)

    def eval(self, context: Context) -> list[Acting]:
        """Return what acts."""
        acting: list[Acting] = self._acting.Eval(context)
        return acting

    def read_bodies(self, context: Context) -> list[BodyState]:
        """Return the motion of the bodies."""
        return self._layout.read(self._state.Eval(context).tolist())

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        acting = self.eval(context)
        if not acting:
            output.SetZero()  # much cheaper
            return
        total = WrenchSum(len(self._layout.starts))
        bodies, t = self.read_bodies(context), context.get_time()
        for force in acting:
            force(bodies, t, total)
        output.SetFromVector(total.entries)
