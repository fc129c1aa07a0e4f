"""What events and step control ask of the springs of a batch, and nothing else.

The only place of the integration that knows the kinds of springs. Numbers are on lanes;
what a spring is like (how it ends, where its profile has corners) is the design's, and
the same for all lanes.
"""

import jax.numpy as jnp
import numpy as np

from drakesep.systems.batch.equations import (
    BatchEquations,
    BatchParameters,
    Lanes,
    Mode,
)
from drakesep.systems.equations.relative_motion import BodyState
from drakesep.systems.model.springs import DisplacementSpring


class SpringQueries:
    """The springs of a batch, as its events and its step control see them.

    Attributes:
        count: of the springs.
        attachments: (k,) the attachment of each.
        known_end: (k, 1) whether the time at which each ends follows from its release.
    """

    def __init__(self, equations: BatchEquations):
        """Prepare.

        Args:
            equations: of the separation.
        """
        self._equations = equations
        self._springs = equations.separation.springs
        self.count = len(self._springs)
        self.attachments = equations.spring_attachments
        self.known_end = np.isin(np.arange(self.count), equations.timed)[:, None]

    def pushing(self, mode: Mode) -> Lanes:
        """Return (k, n) whether each is released, and has not let go."""
        return self._equations.pushing(mode)

    def end_times(self, params: BatchParameters, mode: Mode) -> Lanes:
        """Return (k, n) when each ends, s; of no meaning where that is not known."""
        return self._equations.stroke_end(params, mode)

    def corners(self, k: int) -> tuple[float, ...]:
        """Return the corners of a spring's profile, as parts of its stroke."""
        spring = self._springs[k]
        if not isinstance(spring, DisplacementSpring):
            return ()
        return tuple(u for u, _ in spring.profile[1:-1])

    def lifts_off(self, k: int) -> bool:
        """Return whether a spring's pad may lift off before the stroke's end."""
        spring = self._springs[k]
        return isinstance(spring, DisplacementSpring) and spring.damping > 0.0

    def past(
        self, k: int, part: float, bodies: BodyState, params: BatchParameters
    ) -> Lanes:
        """Return how far a spring's pad is past a part of its stroke, m."""
        displacement, _ = self._equations.displacement(k, bodies, params)
        return displacement - part * params.stroke[k]

    def force(self, k: int, bodies: BodyState, params: BatchParameters) -> Lanes:
        """Return a spring's force, were it to pull once its pad has lifted off, N."""
        return self._equations.stroke_force(k, bodies, params)

    def frequency(self, k: int, params: BatchParameters) -> Lanes:
        """Return (n,) how fast what a spring pushes moves, rad/s."""
        if self.known_end[k]:
            return params.frequency[k]
        a, b = self._equations.ends[self.attachments[k]]
        inverse_mass = 1.0 / params.mass
        stiffness = params.force_max[k] / params.stroke[k]
        both = inverse_mass[a] + inverse_mass[b]
        # As if all springs pushed where this one does.
        return jnp.sqrt(self.count * stiffness * both)
