"""Things that happen once: held as discrete state, and exact to event isolation."""

import math
from abc import abstractmethod

from pydrake.systems.framework import (
    Context,
    DiscreteValues,
    EventStatus,
    LeafSystem,
    WitnessFunction,
    WitnessFunctionDirection,
)


ROUND_OFF = 1e-12
"""Of times that add up to one at which something is due, s."""
_STEP_MIN = 1e-9
"""Age of a step, s, from which on it may be ended."""


class LatchingSystem(LeafSystem):
    """A system that latches what has happened, at the start of every step.

    What is due is latched at the start of the simulation and of every step. A witness
    function ends a step in which something becomes due, within a hundredth of the
    accuracy in seconds: the Context of the whole diagram needs an accuracy.

    A subclass says in `_due` what is to be latched, and in `_is_waiting` until when.
    """

    def __init__(self, values: list[float]):
        """Declare the state.

        Args:
            values: what is latched at first.
        """
        super().__init__()
        self._at_first = values
        self._latched = self.DeclareDiscreteState(values)
        self._latched_ticket = self.discrete_state_ticket(self._latched)
        self._step_start = self.DeclareDiscreteState([-math.inf])
        self.DeclareInitializationDiscreteUpdateEvent(self._latch_at_start)
        self.DeclarePerStepDiscreteUpdateEvent(self._latch)
        self._witness = self.MakeWitnessFunction(
            "due",
            WitnessFunctionDirection.kNegativeThenNonNegative,
            lambda context: 1.0 if self._is_overdue(context) else -1.0,
        )

    @abstractmethod
    def _due(self, context: Context, latched: list[float], t: float) -> list[float]:
        """Return the values that are to be latched at a time, s, after what is."""

    @abstractmethod
    def _is_waiting(self, latched: list[float]) -> bool:
        """Return whether anything can still become due, after what is latched."""

    def _is_due(self, context: Context, latched: list[float], t: float) -> bool:
        """Return whether something is due at a time, s, at which a step is to end."""
        return self._due(context, latched, t) != latched

    def _needs_age(self, context: Context) -> bool:
        """Return whether something can be due at the start of a step, unlatched.

        So it is if it depends on what another system latches, at the same instant.
        """
        return True

    def _reset(self, context: Context) -> None:
        """Forget what has happened."""
        context.SetDiscreteState(self._latched, self._at_first)
        context.SetDiscreteState(self._step_start, [-math.inf])

    def _get_latched(self, context: Context) -> list[float]:
        return context.get_discrete_state(self._latched).value().tolist()

    def _is_starting(self, context: Context) -> bool:
        return math.isinf(context.get_discrete_state(self._step_start)[0])

    def _latch_at_start(self, context: Context, update: DiscreteValues) -> EventStatus:
        if math.isnan(context.get_numeric_parameter(0).value().sum()):
            raise RuntimeError(
                "the Context must hold a separation: call set_separation, with the "
                "part of it that belongs to the system, before the simulation"
            )
        if context.get_accuracy() is None:
            raise RuntimeError(
                "the Context must have an accuracy, to which releases and loads are "
                "exact: call context.SetAccuracy(1e-6), say, before the simulation"
            )
        now, latched = context.get_time(), self._get_latched(context)
        update.set_value(self._latched, self._due(context, latched, now))
        update.set_value(self._step_start, [now])
        return EventStatus.Succeeded()

    def _latch(self, context: Context, update: DiscreteValues) -> EventStatus:
        now, latched = context.get_time(), self._get_latched(context)
        if not self._is_waiting(latched):
            return EventStatus.DidNothing()
        due = self._due(context, latched, now)
        if due == latched and not self._needs_age(context):
            return EventStatus.DidNothing()
        update.set_value(self._latched, due)
        update.set_value(self._step_start, [now])
        return EventStatus.Succeeded()

    def _is_overdue(self, context: Context) -> bool:
        # What is due from the start of a step on has no crossing: the step must have an
        # age. And a step that ends where something is due needs no search: Drake ends
        # the process when the crossing that it searches lies at the end of AdvanceTo.
        now = context.get_time()
        if self._needs_age(context):
            start = context.get_discrete_state(self._step_start)[0]
            if now - start <= _STEP_MIN:
                return False
        just_before = min(now - 2.0 * ROUND_OFF, math.nextafter(now, -math.inf))
        return self._is_due(context, self._get_latched(context), just_before)

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return one for all, while something can become due.

        Drake does not ask again before the next `AdvanceTo`.
        """
        waiting = self._is_waiting(self._get_latched(context))
        return [self._witness] if waiting else []
