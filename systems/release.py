"""The release of the attachments, held as discrete state."""

import math

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    LeafSystem,
    WitnessFunction,
    WitnessFunctionDirection,
)

from drakesep.systems.model import Separation


class Release(LeafSystem):
    """Lets go of each attachment at its scheduled time.

    A release that is due is latched at the start of the simulation and of every
    step. Witness functions end a step where one becomes due, within a hundredth of
    the accuracy in seconds; the recorded time is the scheduled one. The Context of
    the whole diagram needs an accuracy (``context.SetAccuracy``).

    Output port:
        released: (n,) time at which each attachment was released, s; infinite
            while it holds.

    Parameters:
        0: (n,) scheduled times, s.
    """

    def __init__(self, attachments: int):
        super().__init__()
        self._schedule = self.DeclareNumericParameter(BasicVector(attachments))
        held = self.DeclareDiscreteState(np.full(attachments, math.inf))
        self.DeclareStateOutputPort("released", held)
        self.DeclareInitializationDiscreteUpdateEvent(self._release_at_start)
        self.DeclarePerStepDiscreteUpdateEvent(self._release_those_due)
        self._witnesses = [self._make_witness(i) for i in range(attachments)]

    def set_schedule(self, context: Context, separation: Separation) -> None:
        """Write the release times of a separation into this system's Context."""
        times = [attachment.release_time for attachment in separation.attachments]
        context.get_mutable_numeric_parameter(self._schedule).SetFromVector(times)

    def _get_schedule(self, context: Context) -> list[float]:
        return context.get_numeric_parameter(self._schedule).value().tolist()

    def _get_released(self, context: Context) -> list[float]:
        return context.get_discrete_state_vector().value().tolist()

    def _release_at_start(self, context: Context, update: DiscreteValues) -> None:
        now = context.get_time()
        # What was due before the start happens at the start.
        self._release(
            context, update, [max(now, t) for t in self._get_schedule(context)]
        )

    def _release_those_due(
        self, context: Context, update: DiscreteValues
    ) -> EventStatus:
        return self._release(context, update, self._get_schedule(context))

    def _release(
        self, context: Context, update: DiscreteValues, times: list[float]
    ) -> EventStatus:
        now = context.get_time()
        before = self._get_released(context)
        after = [
            time if math.isinf(released) and time <= now else released
            for released, time in zip(before, times, strict=True)
        ]
        if after == before:
            return EventStatus.DidNothing()  # spares a new evaluation of the forces
        update.set_value(after)
        return EventStatus.Succeeded()

    def _make_witness(self, i: int) -> WitnessFunction:
        # A step that ends at the scheduled time needs no search, and Drake ends the
        # process when the crossing that it searches lies at the end of AdvanceTo:
        # so the sign changes just after that time.
        return self.MakeWitnessFunction(
            f"release {i}",
            WitnessFunctionDirection.kNegativeThenNonNegative,
            lambda context: (
                1.0 if context.get_time() > self._get_schedule(context)[i] else -1.0
            ),
        )

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return the witnesses of the attachments that still hold."""
        return [
            witness
            for witness, released in zip(
                self._witnesses, self._get_released(context), strict=True
            )
            if math.isinf(released)
        ]
