"""How near two parts are along the path of their bodies: at a time, or in a stretch.

Only those of their pieces are measured that may matter, from boxes around many of them
downward, and only if what is known since they were last measured does not settle it.
"""

import heapq
import math
from typing import Any

import numpy as np

from drakesep.analysis.clearance.node_pairs import NodePairs
from drakesep.systems.geometry.bounding_tree import is_leaf
from drakesep.systems.geometry.distance import (
    TOUCHING,
    DistanceBound,
    Nearest,
    Proximity,
    certify,
    is_inside,
    nearest_of,
)
from drakesep.systems.geometry.moved_parts import Displacement
from drakesep.systems.geometry.relative_path import Pose, RelativePath
from drakesep.systems.model.part_pairs import Names
from drakesep.systems.model.parts import Mesh


_OPENED = 256
"""Boxes that are opened for a stretch of time, before it is rather halved."""
_ABOUT = 0.5
"""Part of the smallest distance by which another may be nearer, where any will do."""


class PartDistance:
    """Measures two parts along the path of their bodies.

    It keeps what it has measured for what it is asked next: it serves one thread.

    Attributes:
        names: of the parts.
        path: of the second's body B in the first's, A; or of the frames that are moved
            with them, if they are: nearest points are in those, until `in_bodies`.
        solid: whether distances below zero tell how deep they overlap: not of meshes,
            which are surfaces.
    """

    def __init__(
        self,
        proximity: Proximity,
        names: Names,
        path: RelativePath,
        moved: tuple[Displacement, Displacement] = (None, None),
    ):
        """Prepare for one run.

        Args:
            proximity: made of the parts before they were moved.
            names: of the parts.
            path: that takes the displacements into account.
            moved: how either part is displaced in its body.
        """
        self.names, self.path = names, path
        self._moved = moved
        self._proximity = proximity
        self._parts = [proximity.parts[name] for name in names]
        self.solid = not any(isinstance(part.shape, Mesh) for part in self._parts)
        first, second = (proximity.roots[name] for name in names)
        self._pairs = NodePairs((first, second))

    def at(self, t: float) -> Nearest:
        """Return how near the parts are at a time, s."""
        return self._nearest(self.path.at(t))

    def in_bodies(self, nearest: Nearest) -> Nearest:
        """Return how near the parts are with points and normal in their bodies."""
        first, second = self._moved
        p_AoCa_A, p_BoCb_B, n_A = nearest[1:]
        if first is not None:
            p_AoCa_A, n_A = first @ p_AoCa_A, first.rotation() @ n_A
        if second is not None:
            p_BoCb_B = second @ p_BoCb_B
        return Nearest(nearest.distance, p_AoCa_A, p_BoCb_B, n_A)

    def at_below(self, t: float, limit: float) -> Nearest | None:
        """Return how near they are at a time, s; None if not below a limit, m."""
        return self._nearest_below(self.path.at(t), limit)

    def overlap(self, t: float) -> bool:
        """Return whether they overlap, or one is inside the other, at a time, s."""
        touching = self.may_come_below(t, t, TOUCHING)
        if touching is not None and touching.distance <= TOUCHING:
            return True
        if self.solid:
            return False
        # Surfaces that are apart: where they are about nearest, one is inside, or none.
        pose = self.path.at(t)
        nearest = self._nearest(pose, within=_ABOUT)
        first, second = self._parts
        p_AoCb_A = pose.R_AB @ nearest.p_BoCb_B + pose.p_AoBo_A
        p_BoCa_B = pose.R_AB.T @ (nearest.p_AoCa_A - pose.p_AoBo_A)
        return is_inside(first, p_AoCb_A) or is_inside(second, p_BoCa_B)

    def may_come_below(self, start: float, end: float, limit: float) -> Nearest | None:
        """Return None if they come no nearer than a limit, m, between two times, s.

        Else that is not shown, and how near they are half-way is returned: those of
        their pieces, or of boxes around these, that may come below the limit.
        """
        pose = self.path.at(0.5 * (start + end))
        motion, half = self.path.bounds(start, end), 0.5 * (end - start)
        fresh: dict[int, DistanceBound] = {}
        opened = 0
        while True:
            moved = self._pairs.motion_within(pose, motion, half)
            bounds = self._pairs.lower_bounds(pose) - moved
            doubtful = np.flatnonzero(~(bounds >= limit)).tolist()
            boxes = [k for k in doubtful if k in fresh and not is_leaf(self._pairs[k])]
            opened += len(boxes)
            if opened > _OPENED and start < end:
                return self._nearest(pose)  # in half the time, fewer come near
            for k in boxes:
                self._pairs.open(k)
                del fresh[k]
            if not self._refine(doubtful, pose, fresh):
                break
        if not doubtful:
            return None
        nearest = min(doubtful, key=lambda k: fresh[k].distance)
        return nearest_of(self._pairs[nearest], fresh[nearest])

    def _refine(
        self, doubtful: list[int], pose: Pose, fresh: dict[int, DistanceBound]
    ) -> bool:
        """Measure or certify what has not been, and return whether there was any."""
        stale = [k for k in doubtful if k not in fresh]
        vague = [k for k in doubtful if k in fresh and not fresh[k].is_certified]
        for k in stale:
            fresh[k] = self._measure(k, pose)
        for k in vague:
            fresh[k] = self._certify(k, pose, fresh[k])
        return bool(stale or vague)

    def _nearest(self, pose: Pose, within: float = 0.0) -> Nearest:
        """Return the nearest pair of pieces where B is at a pose in A.

        Args:
            pose: of B in A.
            within: the part of its distance by which another may be nearer.
        """
        nearest = self._nearest_below(pose, math.inf, within)
        assert nearest is not None
        return nearest

    def _nearest_below(
        self, pose: Pose, limit: float, within: float = 0.0
    ) -> Nearest | None:
        """Return the nearest pair of pieces, None if none is nearer than a limit, m.

        What may be nearest is measured, from the least bound up; a box that is nearest
        gives way to what is in it.
        """
        lows: list[float] = self._pairs.lower_bounds(pose).tolist()
        heap: list[tuple[float, int, Any]] = [
            (low, k, None) for k, low in enumerate(lows)
        ]
        heapq.heapify(heap)
        while True:
            low, k, bound = heapq.heappop(heap)
            if low >= limit:
                return None
            if bound is None:
                bound = self._measure(k, pose)
            elif not is_leaf(self._pairs[k]):
                for new in self._pairs.open(k):
                    heapq.heappush(heap, (bound.low, new, None))
                continue
            elif bound.is_certified:
                return nearest_of(self._pairs[k], bound)
            else:
                bound = self._certify(k, pose, bound)
            heapq.heappush(heap, (self._least(k, bound, within), k, bound))

    def _least(self, k: int, bound: DistanceBound, within: float) -> float:
        """Return how near a pair or what it holds may be: of a piece, what is known.

        Of a piece, less the part of it by which another may be nearer.
        """
        certain = is_leaf(self._pairs[k]) and bound.is_certified
        return (1.0 - within) * bound.distance if certain else bound.low

    def _measure(self, k: int, pose: Pose) -> DistanceBound:
        bound = self._proximity.measure(self._pairs[k], pose)
        self._pairs.note(k, pose, bound)
        return bound

    def _certify(self, k: int, pose: Pose, bound: DistanceBound) -> DistanceBound:
        bound = certify(self._pairs[k], pose, bound)
        self._pairs.note(k, pose, bound)
        return bound
