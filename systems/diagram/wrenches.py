"""What acts on floating bodies, and its wrenches, as values between systems.

What acts changes at events only: a force system finds it then, once, and puts it out as
a list of functions of the bodies' motion and time. Their wrenches are one vector of 6 n
entries: torque about the origin and force, in W, for each of n bodies. For a body that
floats in the world these are its generalized forces in Drake, so that such a vector
goes into the plant as it stands; a list of ExternallyAppliedSpatialForce would double
the cost of a run.
"""

from collections.abc import Callable, Sequence
from typing import Any, Generic, Protocol, TypeVar

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    InputPort,
    LeafSystem,
)

from drakesep.systems.diagram.state_layout import BodyStates, StateLayout
from drakesep.systems.equations.relative_motion import Wrench, add_wrenches


_NONE = Wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class WrenchSum:
    """Adds wrenches up, body by body."""

    def __init__(self, bodies: int):
        self.wrenches = [_NONE] * bodies
        """On each body."""

    def add(self, body: int, wrench: Wrench) -> None:
        """Add a wrench on a body, given by its index."""
        before = self.wrenches[body]
        self.wrenches[body] = (
            wrench if before is _NONE else add_wrenches(before, wrench)
        )

    def add_entries(self, entries: Sequence[float]) -> None:
        """Add a wrench on each body, all in one vector."""
        for body in range(len(self.wrenches)):
            tx, ty, tz, fx, fy, fz = entries[6 * body : 6 * body + 6]
            self.add(body, Wrench((tx, ty, tz), (fx, fy, fz)))

    @property
    def entries(self) -> list[float]:
        """All in one vector."""
        entries: list[float] = []
        for torque, force in self.wrenches:
            entries += torque
            entries += force
        return entries


class Force(Protocol):
    """Something that acts on bodies, as it does until an event changes it."""

    def __call__(self, bodies: BodyStates, t: float, total: WrenchSum) -> None:
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
        external: InputPort | None = None,
    ):
        """Declare the ports.

        Args:
            system: that acts.
            state: its input port of the plant's state.
            layout: where `state` holds the motion of each body.
            find: returns what acts. Contexts are copied with it: it holds no system.
            prerequisites: what that depends on.
            external: its input port of wrenches that act beside, if it has one.
        """
        self._state = state
        self._layout = layout
        self._external = external
        self._last: tuple[Any, Any, list[float]] = (None, None, [])

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

    def read_bodies(self, context: Context) -> BodyStates:
        """Return the motion of the bodies."""
        return self._layout.bodies(self._state.Eval(context).tolist())

    def _calc_wrenches(self, context: Context, output: BasicVector) -> None:
        acting = self.eval(context)
        given = [] if self._external is None else self._external.Eval(context).tolist()
        if not (acting or given):
            output.SetZero()  # much cheaper
            return
        moment = context.get_time(), self._state.Eval(context).tolist(), given
        # Asked for twice where a step ends to be recorded, and the next one begins.
        last_acting, last_moment, entries = self._last
        if acting is not last_acting or moment != last_moment:
            entries = self.wrenches_at(acting, *moment)
            self._last = acting, moment, entries
        output.SetFromVector(entries)

    def wrenches_at(
        self, acting: list[Acting], t: float, x: list[float], given: list[float]
    ) -> list[float]:
        """Return the wrenches on the bodies.

        Args:
            acting: what acts.
            t: time, s.
            x: state of the plant.
            given: wrenches that act beside; none if empty.
        """
        total = WrenchSum(len(self._layout.starts))
        if given:
            total.add_entries(given)
        bodies = self._layout.bodies(x)
        for force in acting:
            force(bodies, t, total)
        return total.entries
