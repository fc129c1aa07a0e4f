"""The release of the attachments, held as discrete state."""

import math

from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    Event,
    LeafSystem,
    State,
    UnrestrictedUpdateEvent,
    WitnessFunction,
    WitnessFunctionDirection,
)

from drakesep.systems.model import Separation


class Release(LeafSystem):
    """Lets go of each attachment at its scheduled time.

    A release that is due at or before the start of the simulation happens at its
    start. A later one is found by a witness function, within a hundredth of the
    accuracy in seconds; the recorded time is then the scheduled one. The Context
    of the whole diagram needs an accuracy (``context.SetAccuracy``).

    Output port:
        released: (n,) time at which each attachment was released, s; infinite
            while it holds.

    Parameters:
        0: (n,) scheduled times, s.
    """

    def __init__(self, attachments: int):
        super().__init__()
        self._schedule = self.DeclareNumericParameter(BasicVector(attachments))
        held = self.DeclareDiscreteState([math.inf] * attachments)
        self.DeclareStateOutputPort("released", held)
        self.DeclareInitializationDiscreteUpdateEvent(self._release_those_due)
        self._witnesses = [self._make_witness(i) for i in range(attachments)]

    def set_schedule(self, context: Context, separation: Separation) -> None:
        """Write the release times of a separation into this system's Context."""
        times = [attachment.release_time for attachment in separation.attachments]
        context.get_mutable_numeric_parameter(self._schedule).SetFromVector(times)

    def _scheduled(self, context: Context) -> list[float]:
        times: list[float] = context.get_numeric_parameter(self._schedule).value()
        return times

    def _release_those_due(self, context: Context, update: DiscreteValues) -> None:
        now = context.get_time()
        held = context.get_discrete_state_vector().value().tolist()
        update.set_value(
            [
                now if math.isinf(released) and scheduled <= now else released
                for released, scheduled in zip(
                    held, self._scheduled(context), strict=True
                )
            ]
        )

    def _make_witness(self, i: int) -> WitnessFunction:
        def release(_: LeafSystem, context: Context, __: Event, state: State) -> None:
            released = state.get_mutable_discrete_state().get_mutable_value()
            released[i] = self._scheduled(context)[i]

        return self.MakeWitnessFunction(
            f"release {i}",
            WitnessFunctionDirection.kNegativeThenNonNegative,
            lambda context: context.get_time() - self._scheduled(context)[i],
            UnrestrictedUpdateEvent(system_callback=release),
        )

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:
        """Return the witnesses of the attachments that still hold."""
        held = context.get_discrete_state_vector().value().tolist()
        return [
            witness
            for witness, released in zip(self._witnesses, held, strict=True)
            if math.isinf(released)
        ]
