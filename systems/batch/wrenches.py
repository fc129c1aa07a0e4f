"""Wrenches on the bodies of a batch, and their sums."""

import jax
import jax.numpy as jnp

from drakesep.systems.equations.relative_motion import BodyState, Wrench, add_wrenches


def no_wrench(bodies: BodyState) -> Wrench:
    """Return a wrench of zero on every body."""
    zero = jnp.zeros_like(bodies.q_WB[0])
    return Wrench((zero, zero, zero), (zero, zero, zero))


class WrenchSum:
    """Adds wrenches up, body by body."""

    def __init__(self, bodies: BodyState):
        """Begin with none.

        Args:
            bodies: of (..., m, n).
        """
        count = bodies.q_WB[0].shape[-2]
        zero = jnp.zeros_like(bodies.q_WB[0][..., 0, :])
        none = (zero, zero, zero)
        self._wrenches = [Wrench(none, none)] * count

    def add(self, body: int, wrench: Wrench) -> None:
        """Add a wrench on a body, given by its index."""
        self._wrenches[body] = add_wrenches(self._wrenches[body], wrench)

    @property
    def wrench(self) -> Wrench:
        """The sums on all bodies, of (..., m, n)."""
        return jax.tree.map(lambda *x: jnp.stack(x, axis=-2), *self._wrenches)
