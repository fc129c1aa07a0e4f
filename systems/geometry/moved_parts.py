"""Parts that stand elsewhere in their bodies than in another description of these.

A part is rigid: where it stands elsewhere, all of it is moved by one displacement. So
what was made of it once, convex pieces and boxes around them, serves wherever it is.
"""

from typing import TypeAlias

from pydrake.math import RigidTransform

from drakesep.systems.geometry.convex_pieces import place_of
from drakesep.systems.model.parameters import parts_of
from drakesep.systems.model.separation import Separation


Displacement: TypeAlias = RigidTransform | None
"""Of a part within its body, in the body's axes; None: it stays."""


def displacements(before: Separation, after: Separation) -> dict[str, RigidTransform]:
    """Return how parts have been moved within their bodies, of those that have been.

    Args:
        before: with parts.
        after: with some of them, maybe in other places.
    """
    known = {part.name: part for part in parts_of(before)}
    moved = {}
    for part in parts_of(after):
        was = known.get(part.name, part)
        if (was.p_BoGo_B, was.rpy_BG) != (part.p_BoGo_B, part.rpy_BG):
            moved[part.name] = place_of(part) @ place_of(was).inverse()
    return moved
