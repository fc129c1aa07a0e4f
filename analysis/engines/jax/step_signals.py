"""Signals on one step of a batch, and what is found of them over continuous time.

On a step a signal is the polynomial through its values at the nodes of `lobatto`,
split where it turns: peaks, crossings and integrals of magnitudes are those of the
polynomial. The place of a peak or of a zero needs no derivative, since what is found
does not change with it to first order; the place of a crossing carries its own.
"""

import functools
from collections.abc import Sequence
from typing import TypeAlias

import jax.numpy as jnp
import numpy as np
from jax import lax
from numpy.typing import NDArray

from drakesep.systems.batch import lobatto
from drakesep.systems.batch.lanes import Lanes
from drakesep.systems.batch.polynomials import (
    Pieces,
    first_place,
    pieces,
    polynomial,
    root,
)


Rows: TypeAlias = slice | NDArray[np.intp]
"""Which of the signals: a slice where they follow one another, which costs less."""


def rows(places: Sequence[int]) -> Rows:
    """Return which signals stand at places."""
    first, last = places[0], places[-1]
    if list(places) == list(range(first, last + 1)):
        return slice(first, last + 1)
    return np.array(places)


class StepSignals:
    """Signals on one step, as polynomials, (8, s, n)."""

    def __init__(self, signals: Sequence[Lanes]):
        """Prepare.

        Args:
            signals: s of them, (8, n) at the nodes of `lobatto`.
        """
        self._at_nodes = jnp.stack(signals, axis=1)

    @functools.cached_property
    def _pieces(self) -> Pieces:
        return pieces(self._at_nodes)

    def at(self, theta: Lanes) -> Lanes:
        """Return the values (k, s, n) at fractions (k, n) of the step."""
        return polynomial(self._coefficients[:, None], 2.0 * theta[:, None] - 1.0)

    def part(self, start: Lanes, end: Lanes) -> "StepSignals":
        """Return the signals on a part of the step, as steps of their own.

        Args:
            start: (n,) fraction of the step.
            end: (n,) fraction of the step.
        """
        at = self.at(start + (end - start) * lobatto.THETA[:, None])
        return StepSignals(list(jnp.moveaxis(at, 1, 0)))

    @functools.cached_property
    def _coefficients(self) -> Lanes:
        return jnp.tensordot(lobatto.COEFFICIENTS, self._at_nodes, 1)

    @functools.cached_property
    def lowest(self) -> Lanes:
        """(s, n) the smallest values."""
        return self._pieces.values.min(axis=0)

    @functools.cached_property
    def highest(self) -> Lanes:
        """(s, n) the largest values."""
        return self._pieces.values.max(axis=0)

    def mean_square(self, which: Rows) -> Lanes:
        """Return the mean squares (l, n) of some signals."""
        return jnp.tensordot(lobatto.WEIGHTS, self._at_nodes[:, which] ** 2, 1)

    def mean_magnitude(self, which: Rows) -> Lanes:
        """Return the mean magnitudes (l, n) of some signals."""
        c, xi, values = (x[:, which] for x in self._pieces)
        crosses = values[:-1] * values[1:] < 0.0

        def split(_: None) -> Lanes:
            zero = root(c[:, None], xi[:-1], xi[1:])
            zero = jnp.where(crosses, zero, xi[1:])
            powers = np.arange(1.0, lobatto.COUNT + 1.0)[:, None, None]
            area = jnp.concatenate([jnp.zeros_like(c[:1]), c / powers])[:, None]
            at_points, at_zeros = polynomial(area, xi), polynomial(area, zero)
            return 0.5 * (
                jnp.abs(at_zeros - at_points[:-1]) + jnp.abs(at_points[1:] - at_zeros)
            ).sum(axis=0)

        def whole(_: None) -> Lanes:
            mean = jnp.tensordot(lobatto.WEIGHTS, self._at_nodes[:, which], 1)
            return jnp.abs(mean)

        return lax.cond(crosses.any(), split, whole, None)

    def first_beyond(self, which: Rows, limits: Lanes) -> tuple[Lanes, Lanes]:
        """Return (l, n) whether signals' magnitudes exceed limits, and first where.

        Args:
            which: of the signals.
            limits: (l,) of their magnitudes.

        Returns:
            Whether they do, and the fractions of the step.
        """
        some = Pieces(*(x[:, which] for x in self._pieces))
        beyond = jnp.abs(some.values) > limits[:, None]

        def find(_: None) -> Lanes:
            after = jnp.argmax(beyond, axis=0)[None]
            side = jnp.sign(jnp.take_along_axis(some.values, after, 0)[0])
            return first_place(some, beyond, limits[:, None] * side)

        def nowhere(_: None) -> Lanes:
            return jnp.zeros(beyond.shape[1:])

        theta = lax.cond(beyond.any(), find, nowhere, None)
        return beyond.any(axis=0), theta


def summed(rate: Lanes, length: Lanes, before: Lanes) -> Lanes:
    """Return the integral (8, n) of a rate at the nodes.

    Args:
        rate: (8, n) at the nodes.
        length: (n,) of the step.
        before: (n,) the integral where the step begins.
    """
    return before + 0.5 * length * jnp.tensordot(lobatto.INTEGRALS, rate, 1)


def unwrapped(angle: Lanes, before: Lanes) -> Lanes:
    """Return an angle (8, n) at the nodes without its jumps by a whole turn.

    Args:
        angle: within half a turn.
        before: (n,) the same without jumps, where the step begins; NaN: as it is.
    """
    before = jnp.where(jnp.isnan(before), angle[0], before)
    changes = jnp.diff(angle, axis=0, prepend=before[None])
    turns = 2.0 * jnp.pi * jnp.cumsum(jnp.round(changes / (2.0 * jnp.pi)), axis=0)
    return angle - turns
