"""How near two parts come to each other along the path of their bodies.

The smallest distance is that over continuous time. Where pieces stand at some moment
bounds how near they can be a little later: a plane between two convex pieces stays
between them until they have moved by their distance along its normal (conservative
advancement; Tang, Kim and Manocha, "C2A", ICRA 2009, doi 10.1109/ROBOT.2009.5152234).
Stretches of time that this does not settle are halved.
"""

import heapq
import itertools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.distance import (
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
from drakesep.systems.geometry.relative_path import Pose, RelativePath
from drakesep.systems.model.part_pairs import Names
from drakesep.systems.model.parts import Mesh
from drakesep.systems.vectors import cross


ACCURACY = 5e-5
"""By which a smallest distance may miss that over continuous time, m."""
_LOOKS = 12
"""Moments that are looked at before the stretches between them are settled."""
_OPENED = 256
"""Boxes that are opened for a stretch of time, before it is rather halved."""
_POLISHED = 1e-6
"""To which the time of a smallest distance is found, s."""
_INSTANT = 1e-7
"""To which the time of a contact is found, s."""
_APART = 1e-5
"""From which the normal is told well enough for a closing speed, m."""
_MOMENTS = (1e-6, 1e-5, 1e-4, 1e-3)
"""Before a contact, at which its closing speed may be told, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Where two parts first touch."""

    time: float
    """s."""
    closing_speed: float
    """At which they approach along the normal, m/s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clearance:
    """How near two parts come in a run."""

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


# What is known of a pair of pieces since it was measured: a row of numbers.
_LOW, _RADIUS, _WIDTH = 0, 1, 15
_N_A, _CENTRE_A, _CENTRE_B = slice(2, 5), slice(5, 8), slice(8, 11)
_Q_AB = slice(11, 15)
_ROOM = 64
"""Rows to begin with."""


class _Moment(NamedTuple):
    time: float
    nearest: Nearest


class ClearanceOfPair:
    """Measures two parts along the path of their bodies.

    It keeps the last distance of each pair of pieces, and measures anew only those that
    may have come nearest since.

    Attributes:
        time: (n,) sample times of the path, s.
        solid: whether distances below zero tell how deep they overlap: not of meshes,
            which are surfaces.
    """

    def __init__(self, proximity: Proximity, names: Names, path: RelativePath):
        """Prepare for one run."""
        self._proximity, self._names, self._path = proximity, names, path
        self.time = path.time
        first, second = (proximity.roots[name] for name in names)
        self.solid = not any(
            isinstance(proximity.parts[name].shape, Mesh) for name in names
        )
        self._pairs: list[Pair] = []
        self._rows = np.empty((_ROOM, _WIDTH))
        self._add((first, second))

    def at(self, t: float) -> Nearest:
        """Return how near the parts are at a time, s."""
        return self._nearest(self._look(t))

    def at_below(self, t: float, limit: float) -> Nearest | None:
        """Return how near they are at a time, s; None if not below a limit, m."""
        return self._nearest_below(self._look(t), limit)

    def overlap(self, t: float) -> bool:
        """Return whether they overlap, or one is inside the other, at a time, s."""
        pose = self._look(t)
        if self._settle(t, t, TOUCHING) is None and self.solid:
            return False
        nearest = self._nearest(pose)
        first, second = (self._proximity.parts[name] for name in self._names)
        p_AoCb_A = pose.R_AB @ nearest.p_BoCb_B + pose.p_AoBo_A
        p_BoCa_B = pose.R_AB.T @ (nearest.p_AoCa_A - pose.p_AoBo_A)
        return (
            nearest.distance <= TOUCHING
            or is_inside(first, p_AoCb_A)
            or is_inside(second, p_BoCa_B)
        )

    def minimum(self, start: float, end: float) -> Clearance:
        """Return how near they come between two times, s."""
        found = self.nearer(start, end, math.inf)
        assert found is not None
        return found

    def nearer(self, start: float, end: float, than: float) -> Clearance | None:
        """Return how near they come between two times, s; None if not as near.

        Args:
            start: s.
            end: s.
            than: distance, m, below which they must come by more than `ACCURACY`.
        """
        times = np.linspace(start, end, _LOOKS).tolist()
        best: _Moment | None = None
        if math.isinf(than):
            looked = [_Moment(t, self.at(t)) for t in times]
            best = min(looked, key=lambda moment: moment.nearest.distance)
            than = best.nearest.distance
        stack = list(itertools.pairwise(times))
        while stack and than > TOUCHING:
            a, b = stack.pop()
            there = self._settle(a, b, than - ACCURACY)
            if there is None:
                continue
            middle = 0.5 * (a + b)
            if there.distance < than:
                best, than = _Moment(middle, there), there.distance
            if b - a > _INSTANT:  # in which nothing moves by the accuracy
                stack += [(a, middle), (middle, b)]
        if best is None:
            return None
        contact = None
        if best.nearest.distance <= TOUCHING + ACCURACY:
            contact = self._first_contact(start, end)
        if contact is None:
            best = self._polished(best, start, end)
        else:
            touching = self.at(contact.time)._replace(distance=0.0)
            best = _Moment(contact.time, touching)
        return self._clearance(best, contact)

    def _polished(self, best: _Moment, start: float, end: float) -> _Moment:
        """Return the smallest distance near a moment that is all but it."""
        i = int(np.searchsorted(self.time, best.time))
        low = max(start, float(self.time[max(i - 1, 0)]))
        high = min(end, float(self.time[min(i + 1, len(self.time) - 1)]))
        if low >= high:
            return best
        found = minimize_scalar(
            lambda t: self.at(float(t)).distance,
            bounds=(low, high),
            method="bounded",
            options={"xatol": _POLISHED},
        )
        # Which ends it never looks at: where the smallest is there, it is nowhere else.
        times = (low, high, float(found.x))
        there = [_Moment(t, self.at(t)) for t in times]
        return min(*there, best, key=lambda moment: moment.nearest.distance)

    def _clearance(self, moment: _Moment, contact: Contact | None) -> Clearance:
        time, best = moment
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
        """Return the nearest pair of pieces of parts as they are placed."""
        nearest = self._nearest_below(pose, math.inf)
        assert nearest is not None
        return nearest

    def _nearest_below(self, pose: Pose, limit: float) -> Nearest | None:
        """Return the nearest pair of pieces, None if none is nearer than a limit, m.

        What may be nearest is measured, from the least bound up; a box that is nearest
        gives way to what is in it.
        """
        heap: list[tuple[float, int, Any]] = [
            (bound, k, None) for k, bound in enumerate(self._bounds(pose).tolist())
        ]
        heapq.heapify(heap)
        while True:
            bound, k, told = heapq.heappop(heap)
            if bound >= limit:
                return None
            if told is None:
                told = self._measure(k, pose)
                heapq.heappush(heap, (self._least(k, told), k, told))
            elif not is_leaf(self._pairs[k]):
                for new in self._open(k):
                    heapq.heappush(heap, (told.low, new, None))
            elif told.is_sharp:
                return nearest_of(self._pairs[k], told)
            else:
                told = self._sharpen(k, pose, told)
                heapq.heappush(heap, (self._least(k, told), k, told))

    def _least(self, k: int, told: Told) -> float:
        """Return how near a pair or what it holds may be: of a piece, what is known."""
        certain = is_leaf(self._pairs[k]) and told.is_sharp
        return told.distance if certain else told.low

    def _measure(self, k: int, pose: Pose) -> Told:
        told = self._proximity.measure(self._pairs[k])
        self._note(k, pose, told)
        return told

    def _sharpen(self, k: int, pose: Pose, told: Told) -> Told:
        told = self._proximity.sharpen(self._pairs[k], told)
        self._note(k, pose, told)
        return told

    def _note(self, k: int, pose: Pose, told: Told) -> None:
        """Keep what was told of a pair."""
        row = self._rows[k]
        row[_LOW], row[_N_A], row[_Q_AB] = told.low, told.n_A, pose.q_AB
        row[_CENTRE_A] = pose.R_AB @ row[_CENTRE_B] + pose.p_AoBo_A

    def _open(self, k: int) -> list[int]:
        """Put the children of a pair into its place, and return where they stand."""
        first, *others = split(self._pairs[k])
        self._put(k, first)
        return [k, *(self._add(pair) for pair in others)]

    def _add(self, pair: Pair) -> int:
        """Add a pair, and return where it stands."""
        k = len(self._pairs)
        if k == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._pairs.append(pair)
        self._put(k, pair)
        return k

    def _put(self, k: int, pair: Pair) -> None:
        """Put a pair somewhere; where it was is not known yet."""
        self._pairs[k] = pair
        row = self._rows[k]
        row[:] = 0.0
        row[_LOW] = -np.inf
        row[_CENTRE_B], row[_RADIUS] = pair[1].centre, pair[1].radius

    @property
    def _known(self) -> Array:
        """(k, 15) what is known of each pair."""
        return self._rows[: len(self._pairs)]

    def _bounds(self, pose: Pose) -> Array:
        """Return (k,) what the distances are at least, as pieces have moved since.

        Of what overlaps nothing is known.
        """
        known = self._known
        low = known[:, _LOW]
        moved = known[:, _CENTRE_B] @ pose.R_AB.T + pose.p_AoBo_A - known[:, _CENTRE_A]
        along = np.einsum("ki,ki->k", moved, known[:, _N_A])
        cosine = np.minimum(np.abs(known[:, _Q_AB] @ pose.q_AB), 1.0)
        turned = 2.0 * np.arccos(cosine)
        bounds = low + along - turned * known[:, _RADIUS]
        # Between shapes that touch, Drake's normal may be no number.
        return np.where(np.isfinite(bounds), bounds, -np.inf)

    # Stretches of time.

    def _settle(self, a: float, b: float, limit: float) -> Nearest | None:
        """Return None if no distance goes below a limit between two times, s.

        Else how near the pieces are half-way that may go below it.
        """
        pose = self._look(0.5 * (a + b))
        fresh: dict[int, Told] = {}
        opened = 0
        while True:
            bounds = self._bounds(pose) - self._ways(pose, a, b)
            doubtful = np.flatnonzero(~(bounds >= limit)).tolist()
            boxes = [k for k in doubtful if k in fresh and not is_leaf(self._pairs[k])]
            opened += len(boxes)
            if opened > _OPENED and a < b:
                return self._nearest(pose)  # in half the time, fewer come near
            for k in boxes:
                self._open(k)
                del fresh[k]
            stale = [k for k in doubtful if k not in fresh]
            vague = [k for k in doubtful if k in fresh and not fresh[k].is_sharp]
            if not (stale or vague):
                break
            for k in stale:
                fresh[k] = self._measure(k, pose)
            for k in vague:
                fresh[k] = self._sharpen(k, pose, fresh[k])
        if not doubtful:
            return None
        nearest = min(doubtful, key=lambda k: fresh[k].distance)
        return nearest_of(self._pairs[nearest], fresh[nearest])

    def _ways(self, pose: Pose, a: float, b: float) -> Array:
        """Return (k,) how far pieces move from half-way between two times, at most.

        Along the normal that separates them, turning included.
        """
        half = 0.5 * (b - a)
        w, acceleration, bending = self._path.bounds(a, b)
        arms = self._known[:, _CENTRE_B] @ pose.R_AB.T
        # Not with np.cross, which takes longer than all the rest.
        turned = np.stack(cross(tuple(pose.w_AB_A), tuple(arms.T)), axis=1)
        velocities = pose.v_ABo_A + turned
        speeds = np.abs(np.einsum("ki,ki->k", velocities, self._known[:, _N_A]))
        curving = acceleration + bending * np.linalg.norm(arms, axis=1)
        turning = w * self._known[:, _RADIUS]
        return np.asarray((speeds + turning) * half + 0.5 * curving * half**2)
