"""Where bodies of a batch are as seen from others at given times, and how they curve.

Within a step all is a polynomial, so that what happens between two times is bounded by
what is known at the nodes of the steps between them, whichever these are.
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.batch import lobatto
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.integrator import Step
from drakesep.systems.batch.lanes import BatchParameters, Lanes, pick
from drakesep.systems.batch.polynomials import polynomial
from drakesep.systems.model.relative_places import RelativePlaces
from drakesep.systems.vectors import conjugate, multiply, subtract, unrotate


PLACE, CURVED = 7, 2
"""Numbers of a place: a quaternion q_AB and p_AoBo_A; and of what curves."""


class Sampled(NamedTuple):
    """What has been sampled so far of k pairs of bodies."""

    places: Lanes
    """(T, 7 k, n): all q_AB, then all p_AoBo_A."""
    curved: Lanes
    """(T - 1, 2 k, n): see `RelativePlaces.curved`."""


class PlacesFold:
    """Samples where bodies are at the same times in every row."""

    def __init__(
        self,
        equations: BatchEquations,
        ends: Sequence[tuple[str, str]],
        times: Sequence[float],
    ):
        """Prepare.

        Args:
            equations: of the separation.
            ends: (k,) names of bodies A and B.
            times: (T,) that rise, within the run, s.
        """
        names = [body.name for body in equations.separation.bodies]
        self._A, self._B = (
            np.array([names.index(pair[side]) for pair in ends]) for side in (0, 1)
        )
        self._times = np.asarray(times)[:, None]

    @property
    def _shape(self) -> tuple[int, int]:
        return len(self._times), len(self._A)

    def start(self, params: BatchParameters) -> Sampled:
        """Return what there is before the first step."""
        (count, k), (_, n) = self._shape, params.mass.shape
        return Sampled(
            jnp.full((count, PLACE * k, n), jnp.nan),
            jnp.zeros((count - 1, CURVED * k, n)),
        )

    def add(self, sampled: Sampled, params: BatchParameters, step: Step) -> Sampled:
        """Return the samples after a step."""
        q, p = self._at_nodes(step)
        places = jnp.concatenate([*q, *p], axis=1)  # (8, 7 k, n)
        moving = step.length > 0.0
        xi = 2.0 * (self._times - step.start) / jnp.where(moving, step.length, 1.0) - 1
        # Round-off of the step's end is within it.
        inside = moving & (xi >= -1.0) & (xi <= 1.0 + 1e-9)
        c = jnp.tensordot(lobatto.COEFFICIENTS, places, 1)
        at_times = polynomial(c[:, None], xi[:, None])
        end = step.start + step.length
        shared = jnp.clip(
            jnp.minimum(end, self._times[1:])
            - jnp.maximum(step.start, self._times[:-1]),
            0.0,
        )
        curved = jnp.concatenate(self._curving(places, step), axis=0)  # (2 k, n)
        return Sampled(
            jnp.where(inside[:, None], at_times, sampled.places),
            sampled.curved + shared[:, None] * curved,
        )

    def _at_nodes(self, step: Step) -> tuple[tuple[Lanes, ...], tuple[Lanes, ...]]:
        """Return q_AB and p_AoBo_A at the nodes, each of (8, k, n)."""
        a, b = pick(step.bodies, self._A), pick(step.bodies, self._B)
        q = multiply(conjugate(a.q_WB), b.q_WB)
        return q, unrotate(a.R_WB, subtract(b.p_WBo, a.p_WBo))

    def _curving(self, places: Lanes, step: Step) -> tuple[Lanes, Lanes]:
        """Return (k, n) how much a step curves: see `RelativePlaces.curved`."""
        _, k = self._shape
        half = jnp.where(step.length > 0.0, 0.5 * step.length, jnp.inf)
        slope = jnp.tensordot(lobatto.SLOPES, places, 1) / half
        second = jnp.tensordot(lobatto.SLOPES, slope, 1) / half

        def most(x: Lanes, first: int, last: int) -> Lanes:
            c = jnp.tensordot(lobatto.CHEBYSHEV, x[:, first * k : last * k], 1)
            parts = c.reshape(len(c), last - first, k, -1)
            return jnp.linalg.norm(parts, axis=1).sum(axis=0)

        # R is of second degree in the quaternion.
        bending = 2.0 * (most(second, 0, 4) + most(slope, 0, 4) ** 2)
        return most(second, 4, 7), bending

    def finish(self, sampled: Sampled) -> Lanes:
        """Return (7 k T + 2 k (T - 1), n) numbers, as `places_of` reads them."""
        n = sampled.places.shape[-1]
        return jnp.concatenate(
            [sampled.places.reshape(-1, n), sampled.curved.reshape(-1, n)]
        )

    def places_of(self, numbers: Array) -> RelativePlaces:
        """Return the places of n rows, of what `finish` returns."""
        (count, k), n = self._shape, numbers.shape[-1]
        places, curved = np.split(numbers, [PLACE * k * count])
        # (T, 7, k, n) to (n, T, k, 7)
        places = places.reshape(count, PLACE, k, n).transpose(3, 0, 2, 1)
        curved = curved.reshape(count - 1, CURVED, k, n).transpose(3, 0, 2, 1)
        return RelativePlaces(places[..., :4], places[..., 4:], curved)
