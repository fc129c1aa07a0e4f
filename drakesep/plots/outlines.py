"""Outlines of parts of bodies, as views along axes show them."""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from scipy.spatial import ConvexHull, QhullError

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.bounding_tree import Node, support_point
from drakesep.units import unit_of


_DIRECTIONS = 72
"""In which outlines are drawn."""
_MANY = 64
"""Pieces of a part, beyond which they are not outlined one by one."""
_AT_HOME = np.eye(3), np.zeros(3)


def outlines(
    root: Node,
    view: tuple[int, int],
    place: tuple[Array, Array] | None = None,
) -> list[Array]:
    """Return (d, 2) outlines of the pieces of a part, as a view shows them, m.

    What moves and has many pieces is outlined as a whole.

    Args:
        root: of the part's pieces.
        view: axes that it shows, to the right and up.
        place: R_AB (3, 3) and p_AoBo_A (3,) of the body that moves; None: it stays.
    """
    moving = place is not None
    R, p = place or _AT_HOME
    turns = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)
    directions = np.zeros((_DIRECTIONS, 3))
    directions[:, view[0]], directions[:, view[1]] = np.cos(turns), np.sin(turns)
    leaves = root.leaves
    if len(leaves) > _MANY and all(leaf.corners is not None for leaf in leaves):
        if moving:
            corners = _extreme_corners(root)
            found = corners[(corners @ (R.T @ directions.T)).argmax(axis=0)]
            return [(found @ R.T + p)[:, list(view)]]
        corners = np.concatenate([leaf.corners for leaf in leaves])
        if all(leaf.corners is not None and len(leaf.corners) == 3 for leaf in leaves):
            return list(corners.reshape(-1, 3, 3)[..., list(view)])
    return [
        np.array([R @ support_point(leaf, R.T @ n) + p for n in directions])[
            :, list(view)
        ]
        for leaf in leaves
    ]


@functools.lru_cache(maxsize=16)
def _extreme_corners(root: Node) -> Array:
    """Return the corners (k, 3) of a part's pieces that may be its farthest ones, m."""
    corners = np.unique(np.concatenate([leaf.corners for leaf in root.leaves]), axis=0)
    try:
        extreme: Array = corners[ConvexHull(corners).vertices]
    except QhullError:  # flat
        return corners
    return extreme


def fill(
    axes: Axes, within: Sequence[Array], colour: object, level: int, **more: Any
) -> None:
    """Fill what is within any of some outlines, evenly.

    Args:
        axes: of the view.
        within: (d, 2) each, m.
        colour: of what is filled.
        level: above others, or below them.
        more: of the patch.
    """
    mm = unit_of("position").per_si
    paths = [Outline(mm * _counterclockwise(each), closed=True) for each in within]
    whole = Outline.make_compound_path(*paths)
    style = {"facecolor": colour, "linewidth": 0.0, "zorder": level} | more
    axes.add_patch(PathPatch(whole, **style))


def _counterclockwise(outline: Array) -> Array:
    """Return it closed, (d + 1, 2): where all turn one way, none undoes another."""
    closed = outline[[*range(len(outline)), 0]]
    (x, y), (x_next, y_next) = closed[:-1].T, closed[1:].T
    return closed if (x * y_next - x_next * y).sum() >= 0.0 else closed[::-1]
