"""The polynomials by which a step of a batch is described, on lanes."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import lax

from drakesep.systems.batch import lobatto
from drakesep.systems.batch.lanes import Lanes


_NEWTONS = 3


def polynomial(c: Lanes, xi: Lanes) -> Lanes:
    """Return the values of polynomials.

    Args:
        c: (k, ...) coefficients of the powers 0 to k - 1.
        xi: where.
    """
    total = jnp.zeros_like(xi)
    for coefficient in c[::-1]:
        total = total * xi + coefficient
    return total


def derivative(c: Lanes) -> Lanes:
    """Return the coefficients (k - 1, ...) of the derivatives of polynomials."""
    powers = np.arange(1.0, len(c))
    return c[1:] * powers.reshape(-1, *[1] * (c.ndim - 1))


def root(c: Lanes, low: Lanes, high: Lanes, *, bisections: int = 5) -> Lanes:
    """Return the roots between two places; without derivative.

    Halves come first: where a polynomial only just crosses zero, Newton's method alone
    creeps. Then it goes on from the chord, or by halves where it would leave what is
    known to hold the root. Where there is none, something between the places is
    returned.

    Args:
        c: (k, ...) coefficients.
        low: lower places.
        high: upper places.
        bisections: how often to halve at first.
    """
    c, low, high = (lax.stop_gradient(x) for x in (c, low, high))
    at_low, at_high = polynomial(c, low), polynomial(c, high)
    for _ in range(bisections):
        middle = 0.5 * (low + high)
        value = polynomial(c, middle)
        beyond = jnp.sign(value) == jnp.sign(at_high)
        low, at_low = jnp.where(beyond, low, middle), jnp.where(beyond, at_low, value)
        high = jnp.where(beyond, middle, high)
        at_high = jnp.where(beyond, value, at_high)
    change = at_high - at_low
    part = -at_low / jnp.where(change == 0.0, 1.0, change)
    xi = low + jnp.clip(part, 0.0, 1.0) * (high - low)
    for _ in range(_NEWTONS):
        value = polynomial(c, xi)
        beyond = jnp.sign(value) == jnp.sign(at_high)
        low, high = jnp.where(beyond, low, xi), jnp.where(beyond, xi, high)
        xi = xi - value / _slope(c, xi)
        xi = jnp.where((xi >= low) & (xi <= high), xi, 0.5 * (low + high))
    return xi


def crossing(c: Lanes, low: Lanes, high: Lanes) -> Lanes:
    """Return the roots between two places; with their derivative.

    Args:
        c: (k, ...) coefficients.
        low: lower places.
        high: upper places.
    """
    xi = root(c, low, high)
    # A step of Newton's with the slope held: the derivative of an implicit function.
    return xi - polynomial(c, xi) / lax.stop_gradient(_slope(c, xi))


def _slope(c: Lanes, xi: Lanes) -> Lanes:
    slope = polynomial(derivative(c), xi)
    return jnp.where(slope == 0.0, 1.0, slope)


class Pieces(NamedTuple):
    """Polynomials on a step, cut where they turn: between points they rise or fall."""

    c: Lanes
    """(8, s, n) coefficients of the powers of xi."""
    xi: Lanes
    """(15, s, n) points: the nodes, and where one turns between two of them."""
    values: Lanes
    """(15, s, n) at the points."""


def pieces(values: Lanes) -> Pieces:
    """Return the polynomials through values (8, s, n) at the nodes of `lobatto`.

    The places where they turn have no derivative: a value there does not change with
    its place to first order.
    """
    c = jnp.tensordot(lobatto.COEFFICIENTS, values, 1)
    slopes = lax.stop_gradient(jnp.tensordot(lobatto.SLOPES, values, 1))
    turns = slopes[:-1] * slopes[1:] < 0.0
    low, high = lobatto.XI[:-1, None, None], lobatto.XI[1:, None, None]

    def with_turns(_: None) -> tuple[Lanes, Lanes]:
        # A slope that only just crosses zero leaves the value as it is.
        turning = root(derivative(c)[:, None], low, high, bisections=0)
        xi = jnp.where(turns, turning, low)
        return xi, polynomial(c[:, None], xi)

    def without(_: None) -> tuple[Lanes, Lanes]:
        return jnp.broadcast_to(low, values[:-1].shape), values[:-1]

    xi, turning = lax.cond(turns.any(), with_turns, without, None)
    return Pieces(
        c, _interleave(lobatto.XI[:, None, None], xi), _interleave(values, turning)
    )


def first_place(some: Pieces, beyond: Lanes, levels: Lanes) -> Lanes:
    """Return (s, n) where polynomials first reach levels, with their derivative.

    Args:
        some: the polynomials.
        beyond: (15, s, n) at which points they are past their level.
        levels: (s, n) the levels.

    Returns:
        Fractions of the step, 0 where the first point is past it.
    """
    after = jnp.argmax(beyond, axis=0)[None]
    before = jnp.maximum(after - 1, 0)
    low, high = (jnp.take_along_axis(some.xi, at, 0)[0] for at in (before, after))
    at = crossing(some.c.at[0].add(-levels), low, high)
    return 0.5 * (1.0 + jnp.where(after[0] > 0, at, -1.0))


def _interleave(nodes: Lanes, between: Lanes) -> Lanes:
    """Return (15, s, n) from 8 at the nodes and 7 between them."""
    nodes = jnp.broadcast_to(nodes, (len(nodes), *between.shape[1:]))
    pairs = jnp.stack([nodes[:-1], between], axis=1)
    return jnp.concatenate([pairs.reshape(-1, *between.shape[1:]), nodes[-1:]])
