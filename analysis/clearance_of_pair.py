"""How near two elements come to each other along the path of their bodies.

The smallest distance is that over continuous time. Where pieces stand at some moment
bounds how near they can be a little later: a plane between two convex pieces stays
between them until they have moved by their distance along its normal (conservative
advancement; Tang, Kim and Manocha, "C2A", ICRA 2009, doi 10.1109/ROBOT.2009.5152234).
Stretches of time that this does not settle are halved.
"""

import heapq
import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.element_pairs import Names
from drakesep.systems.proximity import (
    TOUCHING,
    Nearest,
    Pair,
    Proximity,
    Told,
    is_inside,
    is_leaf,
    nearest_of,
    split,
)
from drakesep.systems.relative_path import Pose, RelativePath


Array = NDArray[np.float64]

ACCURACY = 5e-5
"""By which a smallest distance may miss that over continuous time, m."""
_STRIDE = 4
"""Samples from one look to the next, before stretches between them are settled."""
_INSTANT = 1e-7
"""To which the time of a contact is found, s."""
_APART = 1e-5
"""From which the normal is told well enough for a closing speed, m."""
_MOMENTS = (1e-6, 1e-5, 1e-4, 1e-3)
"""Before a contact, at which its closing speed may be told, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Where two elements first touch."""

    time: float
    """s."""
    closing_speed: float
    """At which they approach along the normal, m/s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clearance:
    """How near two elements come in a run."""

    first: str
    second: str
    minimum: float
    """Smallest distance, m; 0 if they touch."""
    time: float
    """When, s; of contact, if they touch."""
    p_AoCa_A: tuple[float, ...]
    """Nearest point of the first then, in its body, m."""
    p_BoCb_B: tuple[float, ...]
    """Nearest point of the second then, in its body, m."""
    contact: Contact | None = None
    """None: they do not touch."""


class ClearanceOfPair:
    """Measures two elements along the path of their bodies.

    It keeps the last distance of each pair of pieces, and measures anew only those that
    may have come nearest since.

    Attributes:
        time: (n,) sample times of the path, s.
    """

    def __init__(self, proximity: Proximity, names: Names, path: RelativePath):
        """Prepare for one run."""
        self._proximity, self._names, self._path = proximity, names, path
        self.time = path.time
        first, second = (proximity.roots[name] for name in names)
        self._pairs: list[Pair] = [(first, second)]
        self._set_centres()
        count = len(self._pairs)
        self._low = np.full(count, -np.inf)
        self._n_A = np.zeros((count, 3))
        self._centre_A = np.zeros((count, 3))
        self._q_AB = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))

    def at(self, t: float) -> Nearest:
        """Return how near the elements are at a time, s."""
        return self._nearest(self._look(t))

    def overlap(self, t: float) -> bool:
        """Return whether they overlap, or one is inside the other, at a time, s."""
        pose = self._look(t)
        nearest = self._nearest(pose)
        first, second = (self._proximity.elements[name] for name in self._names)
        p_AoCb_A = pose.R_AB @ nearest.p_BoCb_B + pose.p_AoBo_A
        p_BoCa_B = pose.R_AB.T @ (nearest.p_AoCa_A - pose.p_AoBo_A)
        return (
            nearest.distance <= TOUCHING
            or is_inside(first, p_AoCb_A)
            or is_inside(second, p_BoCa_B)
        )

    def minimum(
        self, start: float, end: float, accuracy: float = ACCURACY
    ) -> Clearance:
        """Return how near they come between two times, s."""
        inner = self.time[::_STRIDE]
        inner = inner[(inner > start) & (inner < end)]
        times = [start, *inner.tolist(), end]
        time, best = start, self.at(start)
        for t in times[1:]:
            nearest = self.at(t)
            if nearest.distance < best.distance:
                time, best = t, nearest
        stack = list(itertools.pairwise(times))
        while stack and best.distance > TOUCHING:
            a, b = stack.pop()
            there = self._settle(a, b, best.distance - accuracy)
            if there is None:
                continue
            middle = 0.5 * (a + b)
            if there.distance < best.distance:
                time, best = middle, there
            stack += [(a, middle), (middle, b)]
        contact = None
        if best.distance <= TOUCHING + accuracy:
            contact = self._first_contact(start, end)
        if contact is not None:
            time = contact.time
            best = self.at(time)._replace(distance=0.0)
        return Clearance(
            first=self._names[0],
            second=self._names[1],
            minimum=best.distance,
            time=time,
            p_AoCa_A=tuple(best.p_AoCa_A.tolist()),
            p_BoCb_B=tuple(best.p_BoCb_B.tolist()),
            contact=contact,
        )

    def _first_contact(self, start: float, end: float) -> Contact | None:
        """Return the first contact between two times, None if there is none."""
        stack = [(start, end)]
        while stack:
            a, b = stack.pop()
            nearest = self._settle(a, b, TOUCHING)
            if nearest is None:
                continue
            if b - a < _INSTANT:
                return Contact(time=a, closing_speed=self._closing_speed(a))
            middle = 0.5 * (a + b)
            if nearest.distance <= TOUCHING:
                stack = [(a, middle)]
            else:
                stack += [(middle, b), (a, middle)]
        return None

    def _closing_speed(self, t: float) -> float:
        # A moment before: shapes that touch have no normal.
        for before in _MOMENTS:
            pose = self._look(max(t - before, 0.0))
            nearest = self._nearest(pose)
            if nearest.distance > _APART:
                break
        r_A = pose.R_AB @ nearest.p_BoCb_B
        velocity = pose.v_ABo_A + np.cross(pose.w_AB_A, r_A)
        return float(-nearest.n_A @ velocity)

    # Moments.

    def _look(self, t: float) -> Pose:
        pose = self._path.at(t)
        self._proximity.place(pose.R_AB, pose.p_AoBo_A)
        return pose

    def _nearest(self, pose: Pose) -> Nearest:
        """Return the nearest pair of pieces of elements as they are placed.

        What may be nearest is measured, from the least bound up; a box that is nearest
        gives way to what is in it.
        """
        heap: list[tuple[float, int, Any]] = [
            (bound, k, None) for k, bound in enumerate(self._bounds(pose).tolist())
        ]
        heapq.heapify(heap)
        while True:
            _, k, told = heapq.heappop(heap)
            if told is None:
                told = self._measure(k, pose)
                bound = told.distance if is_leaf(self._pairs[k]) else told.low
                heapq.heappush(heap, (bound, k, told))
            elif is_leaf(self._pairs[k]):
                return nearest_of(self._pairs[k], told)
            else:
                for new in self._open(k):
                    heapq.heappush(heap, (told.low, new, None))

    def _measure(self, k: int, pose: Pose) -> Told:
        pair = self._pairs[k]
        told = self._proximity.measure(pair)
        self._low[k], self._n_A[k] = told.low, told.n_A
        self._centre_A[k] = pose.R_AB @ self._centre_B[k] + pose.p_AoBo_A
        self._q_AB[k] = pose.q_AB
        return told

    def _open(self, k: int) -> list[int]:
        """Put the children of a pair into its place, and return where they stand."""
        children = split(self._pairs[k])
        last = len(self._pairs)
        self._pairs[k] = children[0]
        self._pairs += children[1:]
        more = len(children) - 1
        for name in ("_low", "_n_A", "_centre_A", "_q_AB"):
            kept = getattr(self, name)
            setattr(
                self, name, np.concatenate([kept, np.repeat(kept[k : k + 1], more, 0)])
            )
        self._set_centres()
        # Where they were is not known yet.
        new = [k, *range(last, last + more)]
        self._low[new] = -np.inf
        return new

    def _set_centres(self) -> None:
        self._centre_B = np.array([b.centre for _, b in self._pairs])
        self._radius = np.array([b.radius for _, b in self._pairs])

    def _bounds(self, pose: Pose) -> Array:
        """Return (k,) what the distances are at least, as pieces have moved since.

        Of what overlaps nothing is known.
        """
        moved = self._centre_B @ pose.R_AB.T + pose.p_AoBo_A - self._centre_A
        along = np.einsum("ki,ki->k", moved, self._n_A)
        cosine = np.minimum(np.abs(self._q_AB @ pose.q_AB), 1.0)
        turned = 2.0 * np.arccos(cosine)
        bounds = self._low + along - turned * self._radius
        # Between shapes that touch, Drake's normal may be no number.
        told = (self._low > TOUCHING) & np.isfinite(bounds)
        return np.where(told, bounds, -np.inf)

    # Stretches of time.

    def _settle(self, a: float, b: float, limit: float) -> Nearest | None:
        """Return None if no distance goes below a limit between two times, s.

        Else how near the elements are half-way.
        """
        pose = self._look(0.5 * (a + b))
        fresh: set[int] = set()
        while True:
            bounds = self._bounds(pose) - self._ways(pose, a, b)
            doubtful = np.flatnonzero(~(bounds >= limit)).tolist()
            for k in [k for k in doubtful if k in fresh]:
                if not is_leaf(self._pairs[k]):
                    self._open(k)
                    fresh.remove(k)
            stale = [k for k in doubtful if k not in fresh]
            if not stale:
                break
            for k in stale:
                self._measure(k, pose)
            fresh.update(stale)
        return self._nearest(pose) if doubtful else None

    def _ways(self, pose: Pose, a: float, b: float) -> Array:
        """Return (k,) how far pieces move from half-way between two times, at most.

        Along the normal that separates them, turning included.
        """
        half = 0.5 * (b - a)
        w, acceleration, bending = self._path.bounds(a, b)
        arms = self._centre_B @ pose.R_AB.T
        velocities = pose.v_ABo_A + np.cross(pose.w_AB_A, arms)
        speeds = np.abs(np.einsum("ki,ki->k", velocities, self._n_A))
        curving = acceleration + bending * np.linalg.norm(arms, axis=1)
        ways = speeds * half + 0.5 * curving * half**2 + w * half * self._radius
        return np.asarray(ways)
