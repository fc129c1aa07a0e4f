"""The colours in which parts of bodies are drawn, wherever."""

from drakesep.systems.model.parts import Cone, Part
from drakesep.systems.model.separation import Body, Separation


# Okabe and Ito's colours, as in plots, but for the red, which nearest points have;
# then others that are told apart from them.
_FIRST = (0.45, 0.45, 0.5)
_OTHERS = (
    (0.0, 0.45, 0.7),
    (0.9, 0.62, 0.0),
    (0.0, 0.62, 0.45),
    (0.8, 0.47, 0.65),
    (0.34, 0.71, 0.91),
    (0.98, 0.93, 0.30),
    (0.45, 0.27, 0.12),
    (0.42, 0.20, 0.62),
    (0.62, 0.82, 0.20),
    (0.05, 0.12, 0.30),
)
_THROUGH = 0.45
"""Opacity of what lets one see through."""


def colour_of(
    part: Part, body: Body, separation: Separation
) -> tuple[float, float, float, float]:
    """Return red, green, blue and opacity of a part of a body.

    Walls let one see through, and what several bodies leave: some are behind it.
    """
    i = separation.bodies.index(body)
    colour = _OTHERS[(i - 1) % len(_OTHERS)] if i else _FIRST
    hollow = isinstance(part.shape, Cone) and part.shape.thickness is not None
    amid = sum(pair.A == body.name for pair in separation.pairs) > 1
    return (*colour, _THROUGH if hollow or amid else 1.0)
