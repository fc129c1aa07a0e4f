"""How the values of several objectives make one."""

from typing import NamedTuple, Protocol

import numpy as np

from drakesep.systems.arrays import Array


class Rule(Protocol):
    """How the values of several objectives make one."""

    def value(self, each: Array) -> Array:
        """Return (...,) what values (..., t) make."""

    def slopes(self, each: Array) -> Array:
        """Return its derivatives (..., t) with them."""

    def resolution(self, each: Array) -> float:
        """Return its resolution from theirs (t,)."""


class WeightedSum(NamedTuple):
    """A weighted sum."""

    factors: Array

    def value(self, each: Array) -> Array:
        """Return (...,) what values (..., t) make."""
        return np.asarray(each @ self.factors)

    def slopes(self, each: Array) -> Array:
        """Return its derivatives (..., t) with them."""
        return np.broadcast_to(self.factors, each.shape)

    def resolution(self, each: Array) -> float:
        """Return its resolution from theirs (t,)."""
        return float(np.abs(self.factors) @ each)


class Largest(NamedTuple):
    """The largest; where two are as large, the slope of the first."""

    def value(self, each: Array) -> Array:
        """Return (...,) what values (..., t) make."""
        return np.asarray(each.max(axis=-1))

    def slopes(self, each: Array) -> Array:
        """Return its derivatives (..., t) with them."""
        return np.asarray(np.eye(each.shape[-1])[each.argmax(axis=-1)])

    def resolution(self, each: Array) -> float:
        """Return its resolution from theirs (t,)."""
        return float(each.max())
