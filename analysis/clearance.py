"""How near elements of different bodies come to each other in a run.

The smallest distance is that over continuous time. Where pieces stand at some moment
bounds how near they can be a little later: a plane between two convex pieces stays
between them until they have moved by their distance along its normal (conservative
advancement; Tang, Kim and Manocha, "C2A", ICRA 2009, doi 10.1109/ROBOT.2009.5152234).
Stretches of time that this does not settle are halved.
"""

import heapq
import itertools
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.element_pairs import Names, element_pairs, owners_of
from drakesep.systems.checks import InputError, check_finite
from drakesep.systems.elements import Element, Mesh
from drakesep.systems.mesh_files import read_mesh
from drakesep.systems.model import Body, Separation
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
from drakesep.systems.run import Run


Array = NDArray[np.float64]

ACCURACY = 5e-5
"""By which a smallest distance may miss that over continuous time, m."""
_SMALLEST, _LARGEST = 1e-3, 15.0
"""Size of a mesh over its body's radius of gyration, beyond which it is doubted."""
PARTED = 1e-3
"""Distance from which elements that touch while mated are measured, m."""
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


class NearestPair(NamedTuple):
    """Two elements at some moment."""

    names: Names
    bodies: Names
    nearest: Nearest


class ClearanceAnalysis:
    """Measures elements of a separation in its runs, whatever values these vary.

    Attributes:
        separation: whose elements they are.
        names: (k,) the pairs of elements that are measured.
    """

    def __init__(
        self,
        separation: Separation,
        pairs: Sequence[Sequence[str]] | None = None,
        *,
        touching: Sequence[Sequence[str]] = (),
    ):
        """Prepare.

        Args:
            separation: whose bodies have elements.
            pairs: names of elements of different bodies; all there are if None.
            touching: those that touch or overlap while mated: they are measured from
                when they are first `PARTED`.

        Raises:
            ValueError: a pair names no element or two of one body, none is left, a mesh
                cannot be read, or elements overlap while mated that are not said to.
        """
        self.separation = separation
        self.names = element_pairs(separation, pairs)
        if not self.names:
            raise InputError("geometry: a clearance needs elements on two bodies")
        self._touching = set(map(frozenset, element_pairs(separation, touching)))
        owners = owners_of(separation)
        self._bodies = [(owners[a], owners[b]) for a, b in self.names]
        asked = {name for pair in self.names for name in pair}
        for body in separation.bodies:
            for element in body.elements:
                if element.name in asked:
                    _warn_of_scale(body, element)
        self._proximities = {
            ends: self._proximity(ends) for ends in dict.fromkeys(self._bodies)
        }

    def _proximity(self, ends: tuple[str, str]) -> Proximity:
        """Return what measures the elements of two bodies that are asked for."""
        asked = {name for pair in self.names for name in pair}
        on_A, on_B = (
            [e for e in self.separation.body(end).elements if e.name in asked]
            for end in ends
        )
        return Proximity(on_A, on_B)

    def of(self, run: Run, *, until: float | None = None) -> list[Clearance]:
        """Return how near each pair comes in a run.

        Args:
            run: a completed run of the separation.
            until: to this time, s; to the end of the run if None.

        Raises:
            ValueError: elements overlap at the start that are not said to touch.
            RuntimeError: the run failed.
        """
        last = float(run.completed_trajectory.time[-1])
        end = last if until is None else until
        check_finite("until", end)
        if not 0.0 < end <= last:
            raise InputError(
                f"until: must be above 0 and at most {last:g} s, got {end}"
            )
        measured = []
        for names, one in self._along(run):
            start = self._start(names, one)
            # What has not parted by then is in contact all the time.
            measured.append(one.minimum(start if start < end else 0.0, end))
        return measured

    def over_time(self, run: Run) -> Array:
        """Return (n, k) how near each pair is at the n sample times of a run, m.

        Raises:
            RuntimeError: the run failed.
        """
        time = run.completed_trajectory.time.tolist()
        return np.array(
            [[one.at(t).distance for t in time] for _, one in self._along(run)]
        ).T

    def nearest(self, run: Run, times: Sequence[float]) -> "list[NearestPair]":
        """Return which pair is nearest, and where, at each of some times, s.

        Raises:
            RuntimeError: the run failed.
        """
        found: list[list[tuple[bool, NearestPair]]] = [[] for _ in times]
        for (names, one), ends in zip(self._along(run), self._bodies, strict=True):
            start = self._start(names, one)
            for t, here in zip(times, found, strict=True):
                # A pair that has not parted yet comes after all others.
                here.append((t < start, NearestPair(names, ends, one.at(t))))
        return [
            min(here, key=lambda each: (each[0], each[1].nearest.distance))[1]
            for here in found
        ]

    def _along(self, run: Run) -> "list[tuple[Names, ClearanceOfPair]]":
        trajectory = run.completed_trajectory
        paths = {ends: RelativePath(trajectory, *ends) for ends in self._proximities}
        return [
            (names, ClearanceOfPair(self._proximities[ends], names, paths[ends]))
            for names, ends in zip(self.names, self._bodies, strict=True)
        ]

    def _start(self, names: Names, one: "ClearanceOfPair") -> float:
        """Return from when a pair is measured, s; infinite if it never parts."""
        if frozenset(names) in self._touching:
            times = one.time.tolist()
            return next(
                (
                    t
                    for t in times
                    if one.at(t).distance > PARTED and not one.overlap(t)
                ),
                math.inf,
            )
        if one.overlap(0.0):
            raise InputError(
                f"geometry: {names[0]} and {names[1]} must be apart while mated, or be "
                f"listed as touching; got a distance of {1e3 * one.at(0.0).distance:g} "
                "mm or one inside the other"
            )
        return 0.0


def _warn_of_scale(body: Body, element: Element) -> None:
    """Warn of a mesh that does not go with the size of its body."""
    mesh = element.shape
    if not isinstance(mesh, Mesh):
        return
    xx, yy, zz, *_ = body.I_BBcm_B
    size = math.sqrt(0.5 * (xx + yy + zz) / body.mass)  # radius of gyration
    try:
        extent = mesh.scale * float(read_mesh(mesh.file).scale)
    except InputError as error:
        raise InputError(f"{element.name}: {error}") from error
    if not _SMALLEST <= extent / size <= _LARGEST:
        warnings.warn(
            f"{element.name}: mesh is {extent:.3g} m across on a body of radius of "
            f"gyration {size:.3g} m; check scale, metres in a unit of the file, now "
            f"{mesh.scale:g}",
            stacklevel=3,
        )


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
        inner = self._path.time[::_STRIDE]
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
