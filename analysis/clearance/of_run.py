"""How near parts of different bodies come to each other in a run."""

import functools
import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from drakesep.analysis.clearance.of_pair import (
    ACCURACY,
    Clearance,
    overlapping,
    smallest_below,
)
from drakesep.analysis.clearance.part_distance import PartDistance
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_finite
from drakesep.systems.equations.mated_stack import mated_places
from drakesep.systems.equations.motion_of_run import mated_trajectory
from drakesep.systems.geometry.bounding_tree import Node
from drakesep.systems.geometry.convex_pieces import mesh_of
from drakesep.systems.geometry.distance import Nearest, Proximity
from drakesep.systems.geometry.meshes import DoubtfulScale
from drakesep.systems.geometry.moved_parts import displacements
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.part_pairs import Names, owners_of, part_pairs
from drakesep.systems.model.parts import Mesh, Part
from drakesep.systems.model.run import Run, Trajectory
from drakesep.systems.model.separation import Body, Separation


_SMALLEST, _LARGEST = 1e-3, 15.0
"""Size of a mesh over its body's radius of gyration, beyond which it is doubted."""
PARTED = 1e-3
"""Distance from which parts that touch while mated are measured, m."""


class NearestPair(NamedTuple):
    """Two parts at some moment."""

    names: Names
    bodies: Names
    nearest: Nearest


@typed
class ClearanceAnalysis:
    """Measures parts of a separation in its runs, whatever values these vary.

    Any number of threads may use one at once.

    Attributes:
        separation: whose parts they are.
        names: (k,) the pairs of parts that are measured.
        bodies: (k,) those that these are parts of.
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
            separation: whose bodies have parts.
            pairs: names of parts of different bodies; all there are if None.
            touching: those that touch or overlap while mated: they are measured from
                when they are first `PARTED`, or by as much deeper into each other.

        Raises:
            ValueError: a pair names no part or two of one body, none is left, a mesh
                cannot be read, or parts overlap while mated that are not said to.
        """
        self._made_of = separation, pairs, touching
        self.separation = separation
        self.names = part_pairs(separation, pairs)
        if not self.names:
            raise InputError("geometry: a clearance needs parts on two bodies")
        self._touching = set(map(frozenset, part_pairs(separation, touching)))
        owners = owners_of(separation)
        self.bodies = [(owners[a], owners[b]) for a, b in self.names]
        asked = {name for pair in self.names for name in pair}
        parts = {
            body.name: [e for e in body.parts if e.name in asked]
            for body in separation.bodies
        }
        for body in separation.bodies:
            for part in parts[body.name]:
                _warn_of_scale(body, part)
        self._proximities = {
            (A, B): Proximity(parts[A], parts[B]) for A, B in dict.fromkeys(self.bodies)
        }

    def __reduce__(self) -> tuple[Callable[..., "ClearanceAnalysis"], tuple[Any, ...]]:
        """Let another process cut parts into pieces anew: Drake's cannot be sent."""
        separation, pairs, touching = self._made_of
        again = functools.partial(ClearanceAnalysis, touching=touching)
        return again, (separation, pairs)

    def check_apart(self) -> None:
        """Raise InputError if parts overlap while mated that are not said to touch.

        As every measurement of a run does: here it is known before one is flown.
        """
        for parts in self._along(mated_trajectory(self.separation), self.separation):
            if frozenset(parts.names) not in self._touching:
                _check_apart(parts)

    def of(
        self,
        run: Run,
        *,
        until: float | None = None,
        on_pair: Callable[[Names], None] | None = None,
    ) -> list[Clearance]:
        """Return how near each pair comes in a run.

        Args:
            run: a completed run of the separation.
            until: to this time, s; to the end of the run if None.
            on_pair: told of each pair before it is measured.

        Raises:
            ValueError: parts overlap at the start that are not said to touch.
            RuntimeError: the run failed.
        """
        end = _end(run, until)
        along, moved = self._along_run(run), self._is_moved(run)
        found = []
        for parts in along:
            if on_pair is not None:
                on_pair(parts.names)
            found.append(self._below(math.inf, parts, end, moved))
        return [one for one in found if one is not None]

    def smallest(
        self, run: Run, *, until: float | None = None, than: float = math.inf
    ) -> Clearance | None:
        """Return how near the pair that comes nearest comes, sooner than all of them.

        Of pairs that come as near, to the accuracy of a clearance, any.

        Args:
            run: a completed run of the separation.
            until: to this time, s; to the end of the run if None.
            than: distance, m; None is returned if no pair comes nearer than it by more
                than the accuracy, and sooner.

        Raises:
            ValueError: parts overlap at the start that are not said to touch.
            RuntimeError: the run failed.
        """
        end = _end(run, until)
        # That pairs are not the nearest is sooner shown once that one is known.
        along = self._along_run(run)
        if math.isinf(than):
            along = _first(_nearest_of(along, 0.5 * end)[0], along)
        moved = self._is_moved(run)
        best: Clearance | None = None
        for parts in along:
            limit = than if best is None else best.minimum
            best = self._below(limit, parts, end, moved) or best
        return best

    def _below(
        self, than: float, parts: PartDistance, end: float, moved: bool
    ) -> Clearance | None:
        """Return how near a pair comes to a time, s; None if not nearer than that, m.

        What overlaps where it stands nominally is a mistake; elsewhere, a contact.
        """
        start = self._start_before(end, parts, moved)
        apart = frozenset(parts.names) not in self._touching
        if apart and moved and parts.overlap(0.0):
            return overlapping(parts, 0.0) if than > ACCURACY else None
        return smallest_below(parts, start, end, than)

    def _is_moved(self, run: Run) -> bool:
        """Return whether a body or a part stands elsewhere in a run than nominally."""
        return _places(run.separation) != _places(self.separation)

    def over_time(self, run: Run) -> Array:
        """Return (n, k) how near each pair is at the n sample times of a run, m.

        Raises:
            RuntimeError: the run failed.
        """
        return self.at_times(run, run.completed_trajectory.time)

    def at_times(
        self, run: Run, times: Array, *, of: Sequence[Names] | None = None
    ) -> Array:
        """Return (n, k) how near each pair is at n times (n,), s, of a run, m.

        Args:
            run: a completed run of the separation.
            times: (n,) s.
            of: which of the pairs in `names`; all if None.

        Raises:
            RuntimeError: the run failed.
        """
        asked = self.names if of is None else of
        along = {parts.names: parts for parts in self._along_run(run)}
        return np.array(
            [
                [along[names].at(t).distance for t in np.asarray(times).tolist()]
                for names in asked
            ]
        ).T

    def nearest(self, run: Run, times: Sequence[float]) -> list[NearestPair]:
        """Return which pair is nearest, and where, at each of some times, s.

        Raises:
            RuntimeError: the run failed.
        """
        bodies = dict(zip(self.names, self.bodies, strict=True))
        along = self._along_run(run)
        moved = self._is_moved(run)
        starts = {parts.names: self._start(parts, moved) for parts in along}
        found = []
        for t in times:
            # A pair that has not parted yet comes after all others.
            parted = [parts for parts in along if starts[parts.names] <= t]
            parts, nearest = _nearest_of(parted or along, t)
            there = parts.in_bodies(nearest)
            found.append(NearestPair(parts.names, bodies[parts.names], there))
            along = _first(parts, along)  # as it may be at the next time
        return found

    def moments(
        self, run: Run, times: Sequence[float], reach: Array | None = None
    ) -> list[list[NearestPair | None]]:
        """Return where each pair is nearest at each of some times, s.

        Those that touch while mated are left out.

        Args:
            run: a completed run of the separation.
            times: (t,) s.
            reach: (k, t) by how much each pair of `apart` may be farther apart than
                what is nearest of all, m: None is told of what is farther; if None, all
                are told.

        Raises:
            RuntimeError: the run failed.
        """
        bodies = dict(zip(self.names, self.bodies, strict=True))
        along = [p for p in self._along_run(run) if p.names in self.apart]
        found: list[list[NearestPair | None]] = [[] for _ in along]
        least = math.inf
        for i, t in enumerate(times):
            for k, parts in enumerate(along):
                within = math.inf if reach is None else least + reach[k, i]
                there = parts.at_below(t, within)
                if there is None:
                    found[k].append(None)
                    continue
                least, there = min(least, there.distance), parts.in_bodies(there)
                found[k].append(NearestPair(parts.names, bodies[parts.names], there))
        return found

    @property
    def apart(self) -> list[Names]:
        """The pairs of parts that do not touch while mated."""
        return [names for names in self.names if frozenset(names) not in self._touching]

    def pieces(self, pair: Names) -> tuple[Names, Proximity, tuple[Node, Node]]:
        """Return the bodies of a pair of parts, what measures it, and its trees."""
        bodies = self.bodies[self.names.index(pair)]
        proximity = self._proximities[bodies]
        return bodies, proximity, (proximity.roots[pair[0]], proximity.roots[pair[1]])

    def ball_around(self, pair: Names) -> tuple[Array, float]:
        """Return the centre (3,) in its body, and the radius of a ball around a part.

        Args:
            pair: whose second part it is.
        """
        _, _, (_, root) = self.pieces(pair)
        return np.array(root.centre), root.radius

    def _along_run(self, run: Run) -> list[PartDistance]:
        return self._along(run.completed_trajectory, run.separation)

    def _along(
        self, trajectory: Trajectory, separation: Separation
    ) -> list[PartDistance]:
        moved = displacements(self.separation, separation)
        paths: dict[tuple[Names, Names | None], RelativePath] = {}
        along = []
        for names, ends in zip(self.names, self.bodies, strict=True):
            by = moved.get(names[0]), moved.get(names[1])
            # One path serves all parts of two bodies that stay.
            key = ends, None if by == (None, None) else names
            if key not in paths:
                paths[key] = RelativePath(trajectory, *ends, by)
            proximity = self._proximities[ends]
            along.append(PartDistance(proximity, names, paths[key], by))
        return along

    def _start_before(self, end: float, parts: PartDistance, moved: bool) -> float:
        start = self._start(parts, moved)
        # What has not parted by then is in contact all the time.
        return start if start < end else 0.0

    def _start(self, parts: PartDistance, moved: bool) -> float:
        """Return from when a pair is measured, s; infinite if it never parts."""
        if frozenset(parts.names) in self._touching:
            return _parted(parts)
        if not moved:
            _check_apart(parts)
        return 0.0


def _check_apart(parts: PartDistance) -> None:
    """Raise InputError if parts overlap at the start."""
    if parts.overlap(0.0):
        first, second = parts.names
        distance = round(1e3 * parts.at(0.0).distance, 3) + 0.0  # no minus zero
        raise InputError(
            f"geometry: {first} and {second} must be apart while mated, or be "
            f"listed as touching; got a distance of {distance:.3f} mm, or one "
            "inside the other"
        )


def _places(separation: Separation) -> tuple[object, ...]:
    """Return where bodies and their parts stand while mated."""
    return mated_places(separation), [body.parts for body in separation.bodies]


def _parted(parts: PartDistance) -> float:
    """Return when a pair that touches while mated has parted, s; infinite if never."""
    mated = parts.at(0.0).distance
    times: list[float] = parts.path.time.tolist()
    for t in times:
        distance = parts.at(t).distance
        if parts.solid and mated - distance > PARTED:
            return t  # deeper into each other: a contact
        if distance > PARTED and not parts.overlap(t):
            return t
    return math.inf


def _nearest_of(
    along: Sequence[PartDistance], t: float
) -> tuple[PartDistance, Nearest]:
    """Return which pair is nearest at a time, s, and where."""
    first, *others = along
    found = first, first.at(t)
    for parts in others:
        nearer = parts.at_below(t, found[1].distance)
        if nearer is not None:
            found = parts, nearer
    return found


def _first(parts: PartDistance, along: Sequence[PartDistance]) -> list[PartDistance]:
    return [parts, *(other for other in along if other is not parts)]


def _end(run: Run, until: float | None) -> float:
    last = float(run.completed_trajectory.time[-1])
    end = last if until is None else until
    check_finite("until", end)
    if not 0.0 < end <= last:
        raise InputError(f"until: must be above 0 and at most {last:g} s, got {end}")
    return end


def _warn_of_scale(body: Body, part: Part) -> None:
    """Warn of a mesh that does not go with the size of its body."""
    mesh = part.shape
    if not isinstance(mesh, Mesh):
        return
    xx, yy, zz, *_ = body.I_BBcm_B
    size = math.sqrt(0.5 * (xx + yy + zz) / body.mass)  # radius of gyration
    extent = mesh.scale * float(mesh_of(part).scale)
    if not _SMALLEST <= extent / size <= _LARGEST:
        warnings.warn(
            f"{part.name}: mesh is {extent:.3g} m across on a body of radius of "
            f"gyration {size:.3g} m; check scale, metres in a unit of the file, now "
            f"{mesh.scale:g} (0.001 for a file in mm)",
            DoubtfulScale,
            stacklevel=3,
        )
