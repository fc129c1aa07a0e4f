"""Trees of boxes around the convex pieces of parts, and pairs of their nodes.

What is farther off than the box around it need not be looked into.
"""

import functools
import math
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import pydrake.geometry as drake
from pydrake.math import RigidTransform, RotationMatrix

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.convex_pieces import CUBE, Piece, hull, pieces_of
from drakesep.systems.model.parts import Part


_THICK = 1e-6
"""What boxes are larger by to each side, m: Drake makes no hull of what is flat."""


@dataclass(eq=False)
class Node:
    """A convex piece of a part, or a box around some of its pieces."""

    shape: Any
    """Drake's."""
    X_BG: RigidTransform
    """Pose of the shape in the part's body."""
    corners: Array | None
    """(k, 3) of a polytope, in its body, m; None: the shape tells its own."""
    pieces: Sequence[Piece]
    """That it is or holds."""
    halves: tuple[Array, ...]
    """Which of the pieces each child holds; empty for a piece."""

    @property
    def centre(self) -> tuple[float, float, float]:
        """Of a ball around it, in its body, m."""
        return self._ball[0]

    @property
    def radius(self) -> float:
        """Of the ball, m."""
        return self._ball[1]

    @functools.cached_property
    def _ball(self) -> tuple[tuple[float, float, float], float]:
        points = _points_of(self.pieces)
        centre, _, _ = _box_around(points)
        x, y, z = centre.tolist()
        return (x, y, z), float(np.linalg.norm(points - centre, axis=1).max())

    @functools.cached_property
    def leaves(self) -> "tuple[Node, ...]":
        """The pieces that it holds, each as a node of its own."""
        return tuple(_node([piece]) for piece in self.pieces)

    @functools.cached_property
    def children(self) -> "tuple[Node, ...]":
        """Made when they are asked for: most boxes are never opened."""
        with _MAKING:  # the same ones for all threads
            made: tuple[Node, ...] | None = self.__dict__.get("children")
            if made is None:
                made = tuple(_node([self.pieces[i] for i in h]) for h in self.halves)
                self.__dict__["children"] = made
            return made


_MAKING = threading.Lock()


def nodes_of(root: Node) -> Iterator[Node]:
    """Yield a node and all nodes below it."""
    yield root
    for child in root.children:
        yield from nodes_of(child)


# Support functions.


def support_point(node: Node, n_B: Array) -> Array:
    """Return a node's farthest point (3,), m, along a direction (3,), in its body."""
    if node.corners is not None:
        corner: Array = node.corners[(node.corners @ n_B).argmax()]
        return corner
    R = node.X_BG.rotation().matrix()
    p: Array = R @ _support_point_of_round(node.shape, R.T @ n_B)
    return p + node.X_BG.translation()


def _support_point_of_round(shape: Any, n: Array) -> Array:
    """Return that of a shape of Drake's, both in the frame of the shape."""
    match shape:
        case drake.Sphere():
            point = shape.radius() * n
        case drake.Capsule():
            point = shape.radius() * n
            point[2] += math.copysign(0.5 * shape.length(), n[2])
        case _:  # drake.Cylinder
            across = max(math.hypot(n[0], n[1]), 1e-300)
            point = shape.radius() / across * n
            point[2] = math.copysign(0.5 * shape.length(), n[2])
    return point


def support(node: Node, n_B: Array) -> float:
    """Return how far a node reaches, m, along a direction (3,) in its body."""
    if node.corners is None:
        return float(n_B @ support_point(node, n_B))
    # Which `max` calls too, after half a microsecond of Python: twice a measurement.
    return float(np.maximum.reduce(node.corners @ n_B))


# Trees.


def tree_of(part: Part) -> Node:
    """Return the pieces of a part, with boxes around more and more of them."""
    return _node(pieces_of(part))


def _node(pieces: Sequence[Piece]) -> Node:
    if len(pieces) == 1:
        shape, X_BS, points = pieces[0]
        corners = points if isinstance(shape, drake.Convex) else None
        return Node(shape, X_BS, corners, pieces, ())
    centre, axes, half = _box_around(_points_of(pieces))
    half += _THICK
    centres = np.array([piece.points.mean(axis=0) for piece in pieces])
    order = np.argsort((centres - centre) @ axes[:, 0], kind="stable")
    return Node(
        shape=hull(CUBE * half),
        X_BG=RigidTransform(RotationMatrix(axes), centre),
        corners=centre + CUBE * half @ axes.T,
        pieces=pieces,
        halves=tuple(np.array_split(order, 2)),
    )


def _points_of(pieces: Sequence[Piece]) -> Array:
    return np.concatenate([piece.points for piece in pieces])


def _box_around(points: Array) -> tuple[Array, Array, Array]:
    """Return centre, axes (as columns, the longest first) and half edges of a box."""
    mean = points.mean(axis=0)
    _, axes = np.linalg.eigh((points - mean).T @ (points - mean))
    axes = axes[:, ::-1]
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    along = (points - mean) @ axes
    low, high = along.min(axis=0), along.max(axis=0)
    return mean + axes @ (0.5 * (low + high)), axes, 0.5 * (high - low)


# Pairs of nodes.


Pair: TypeAlias = tuple[Node, Node]
"""A node of a part of A, and one of a part of B."""


def is_leaf(pair: Pair) -> bool:
    """Return whether both nodes are pieces."""
    return not (pair[0].halves or pair[1].halves)


def split(pair: Pair) -> list[Pair]:
    """Return the pairs that a pair of nodes holds, from the larger one's children."""
    a, b = pair
    if a.halves and (a.radius >= b.radius or not b.halves):
        return [(child, b) for child in a.children]
    return [(a, child) for child in b.children]
