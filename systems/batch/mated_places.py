"""Where the bodies of a batch are in the mated stack, on lanes where that varies."""

from collections.abc import Sequence

import jax.numpy as jnp

from drakesep.systems.batch.lanes import BatchParameters, ParameterReader, pick, rows
from drakesep.systems.equations.mated_stack import (
    Place,
    mated_orientation,
    mated_places,
)
from drakesep.systems.model.parameters import MATED, names_of
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import Quaternion


class BatchPlaces:
    """The places of a separation's bodies while mated.

    Numbers where none varies, which the laws are then compiled with.
    """

    def __init__(self, separation: Separation, varied: Sequence[str]):
        """Prepare.

        Args:
            separation: whose bodies they are.
            varied: names of the parameters that vary.
        """
        self._separation = separation
        self._bodies = [b for b in separation.bodies if b.name != separation.A]
        self._fixed = [*mated_places(separation).values()]
        self._vary = not set(varied).isdisjoint(names_of(self._bodies, MATED))

    def read(self, reader: ParameterReader, n: int) -> list[Place]:
        """Return the place of each body, of (n,) where it may vary.

        Args:
            reader: of the parameters.
            n: of samples.
        """
        shifts = {
            body.name: (
                tuple(reader.entries(body, "mated_offset")),
                tuple(reader.entries(body, "mated_misalignment")),
            )
            for body in self._bodies
        }
        if not self._vary:
            return self._fixed
        return [*mated_places(self._separation, shifts, jnp).values()]

    def lanes(self, places: Sequence[Place], n: int) -> Place:
        """Return places as `BatchParameters` holds them: of (m, n), if they vary."""
        kept = places if self._vary else []
        return Place(
            tuple(rows([place.q_SB[c] for place in kept], n) for c in range(4)),
            tuple(rows([place.p_SBo[c] for place in kept], n) for c in range(3)),
        )

    def of(self, params: BatchParameters) -> list[Place]:
        """Return the place of each body, of (n,) where it may vary."""
        if not self._vary:
            return self._fixed
        return [pick(params.mated, i) for i in range(len(self._fixed))]

    def orientation(self, a: int, b: int, params: BatchParameters) -> Quaternion:
        """Return the orientation q_AB of one body in another while mated."""
        places = self.of(params)
        return mated_orientation(places[a], places[b])

    @property
    def vary(self) -> bool:
        """Whether they do."""
        return self._vary
