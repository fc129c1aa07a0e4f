"""What is looked at of a step of a batch: components of motions, and parts of time."""

import functools
from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp

from drakesep.analysis.engines.jax.step_signals import StepSignals
from drakesep.analysis.metrics.metric import Law, Signal
from drakesep.systems.batch.lanes import Lanes
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.equations.relative_motion import RelativeMotion
from drakesep.systems.vectors import Vector


_ROUND_OFF = 1e-9
"""By which a time that is its end may lie beyond a step, as a part of it."""


class Component(NamedTuple):
    """A component of the motion of a body that leaves."""

    pair: str
    """Its name; empty: of the first."""
    quantity: str
    """Field of `RelativeMotion`."""
    law: Law | None
    """Makes it of the field."""
    place: int
    """Among what it is one of."""
    summed: bool
    """Whether it is the integral of that over time."""


def components_of(pair: str, signal: Signal) -> list[Component]:
    """Return the components of a signal of a pair."""
    return [
        Component(pair, signal.quantity, signal.law, i, signal.summed)
        for i in signal.components
    ]


class Components:
    """The components of motions at the nodes of a step; each is made once."""

    def __init__(self, told: Callable[[str], tuple[RelativeMotion, PairFacts]]):
        """Prepare.

        Args:
            told: gives the motion and the facts of a pair.
        """
        self._told = functools.cache(told)
        self._made = functools.cache(self._make)

    def lanes(self, component: Component) -> Lanes:
        """Return a component (8, n); of one that is summed, what is summed."""
        made = self._made(component.pair, component.quantity, component.law)
        lanes: Lanes = made[component.place]
        return lanes

    def _make(self, pair: str, quantity: str, law: Law | None) -> tuple[Lanes, ...]:
        motion, facts = self._told(pair)
        field: Vector = getattr(motion, quantity)
        return field if law is None else law(field, facts, jnp)


class Part(NamedTuple):
    """A part of a step."""

    start: Lanes
    """(n,), s."""
    length: Lanes
    """(n,), s."""
    signals: StepSignals
    inside: Lanes
    """(n,) whether it is looked at."""

    def between(self, start: float | None, end: float | None) -> "Part":
        """Return what lies from one time to another; None: there is no such end."""
        if start is None and end is None:
            return self
        low, high = jnp.zeros_like(self.length), jnp.ones_like(self.length)
        if start is not None:
            low = jnp.clip((start - self.start) / self._divisor, 0.0, 1.0)
        if end is not None:
            high = jnp.clip((end - self.start) / self._divisor, 0.0, 1.0)
        return Part(
            self.start + low * self.length,
            (high - low) * self.length,
            self.signals.part(low, high),
            self.inside & (high > low),
        )

    def fraction(self, time: float) -> tuple[Lanes, Lanes]:
        """Return (n,) where a time lies in it, and whether it does."""
        theta = (time - self.start) / self._divisor
        # Round-off of the step's end is within it.
        holds = (self.length > 0.0) & (theta >= 0.0) & (theta <= 1.0 + _ROUND_OFF)
        return theta, holds

    @property
    def _divisor(self) -> Lanes:
        return jnp.where(self.length > 0.0, self.length, 1.0)
