"""How near parts come in very many runs, at least: few of them need be measured.

Parts of a nominal run are separated by planes at some moments. Of another run, held
against these planes at the ends of a stretch of time, they prove a distance within it:
along a plane's normal, a corner that moves on a curve lies beyond the straight line
between two of its places by no more than a quarter of the time between, times the
integral of its acceleration. Most stretches need no planes: there the run strays too
little from the nominal one.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.systems.arrays import Array
from drakesep.systems.geometry.relative_path import Pose
from drakesep.systems.geometry.separating_planes import (
    SeparatingPlanes,
    separating_planes,
    turned_by,
)
from drakesep.systems.model.parameters import MATED, names_of, places_of_parts
from drakesep.systems.model.part_pairs import Names
from drakesep.systems.model.parts import Mesh
from drakesep.systems.model.relative_places import RelativePlaces
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Separation
from drakesep.systems.vectors import rotation_matrix


_MOMENTS = 128
"""Moments that runs are looked at, at most."""
_LONGER = 1.25
"""How much longer than those that were tried any run may take to end its window; one
that takes longer still is not screened."""
_FARTHER = 1.5
"""How much farther than those that were tried runs may stray for planes to be as good
as they can be."""


@dataclass(frozen=True, kw_only=True)
class Watch:
    """What is to be known of runs that are screened."""

    ends: tuple[Names, ...]
    """(k,) bodies A and B, whose places are looked at."""
    times: tuple[float, ...]
    """(T,) at which they are, s."""


def watch(clearances: Sequence[LowestClearance], runs: Sequence[Run]) -> Watch:
    """Return what is to be known of runs whose clearances are screened.

    Args:
        clearances: one or more.
        runs: completed ones: the nominal, and some like those that are to come.
    """
    nominal = runs[0].completed_trajectory.time
    last = float(nominal[-1])
    if all(one.window for one in clearances):
        longest = max(one.end(run) for one in clearances for run in runs)
        last = min(last, _LONGER * longest)
    # Where a run is sampled closely, it moves fast.
    times = nominal[nominal < last]
    times = np.append(times[:: -(-len(times) // _MOMENTS)], last)
    ends: dict[Names, None] = {}
    for one in clearances:
        ends |= dict.fromkeys(one.analysis.bodies)
        pairs, _ = one.window or ((), 0.0)
        ends |= dict.fromkeys((pair.A, pair.B) for pair in pairs)
    return Watch(ends=tuple(ends), times=tuple(times.tolist()))


def can_be_screened(
    clearance: LowestClearance, separation: Separation, varied: Collection[str]
) -> bool:
    """Return whether planes tell anything of a clearance.

    Not of parts that touch while mated, which count once they have parted; nor where
    parts vary in their places; nor whether a surface is inside another at the start,
    where bodies vary in theirs.

    Args:
        clearance: in question.
        separation: whose it is.
        varied: names of the parameters that vary.
    """
    if clearance.touching:
        return False
    if not {*places_of_parts(separation)}.isdisjoint(varied):
        return False
    asked = {name for pair in clearance.pairs for name in pair}
    parts = [part for body in separation.bodies for part in body.parts]
    surfaces = any(isinstance(p.shape, Mesh) for p in parts if p.name in asked)
    placed = names_of(separation.bodies, MATED)
    return not surfaces or {*placed}.isdisjoint(varied)


class _Motion(NamedTuple):
    """Where B is in A in n runs."""

    R_AB: Array
    """(n, T, 3, 3)."""
    p_AoBo_A: Array
    """(n, T, 3), m."""
    curved: Array
    """(n, T - 1, 2), as `RelativePlaces` has it."""
    turned: Array
    """(n, T) by how much B is turned otherwise than in the nominal run."""

    def at(self, rows: NDArray[np.intp], moment: int) -> tuple[Array, Array]:
        return self.R_AB[rows, moment], self.p_AoBo_A[rows, moment]

    def of(self, point: Array) -> Array:
        """Return (n, T, 3) where a point (3,) of B is in A, m."""
        # Not as products of small matrices, which take several times as long.
        place: Array = np.einsum("ntij,j->nti", self.R_AB, point) + self.p_AoBo_A
        return place

    def off_line(self, radius: float, durations: Array) -> Array:
        """Return (n, T - 1) how far points are off straight lines meanwhile, m.

        Args:
            radius: from B's origin to the farthest of them, m.
            durations: (T - 1,) s.
        """
        off: Array = 0.25 * durations * (self.curved @ np.array([1.0, radius]))
        return off


class _PairScreen:
    """Screens a pair of parts."""

    def __init__(
        self,
        clearance: LowestClearance,
        pair: Names,
        tried: _Motion,
        times: Array,
        target: float,
    ):
        """Find planes.

        Args:
            clearance: whose pair it is.
            pair: of parts.
            tried: motion of the nominal run, and of some like those that are to come.
            times: (T,) s.
            target: distance, m, above which bounds need not be exact.
        """
        _, proximity, roots = clearance.analysis.pieces(pair)
        ball = roots[1]
        self._centre, self._radius = np.array(ball.centre), ball.radius
        self._reach = float(np.linalg.norm(self._centre)) + self._radius
        self._durations, self._target = np.diff(times), target
        self._nominal = _Motion(*(x[:1] for x in tried))
        R, p = self._nominal.R_AB[0], self._nominal.p_AoBo_A[0]
        turned = tried.turned.max(axis=0)
        strayed = self._strayed(tried).max(axis=0)
        # Planes are held against the moments before and after, too.
        step = np.zeros(len(times))
        steps = turned_by(R[1:], R[:-1])
        step[:-1], step[1:] = steps, np.maximum(step[1:], steps)
        self._planes: list[SeparatingPlanes] = [
            separating_planes(
                proximity,
                roots,
                _pose(R[j], p[j]),
                enough=target + _FARTHER * float(strayed[j]),
                spread=_FARTHER * float(turned[j]) + float(step[j]) + 1e-6,
            )
            for j in range(len(times))
        ]
        self._off_line = self._nominal.off_line(self._reach, self._durations)[0]
        row = np.array([0], dtype=np.intp)
        self._least = np.array(
            [self._by_planes(self._nominal, row, j)[0] for j in range(len(times) - 1)]
        )
        self._least -= self._off_line

    def _strayed(self, motion: _Motion) -> Array:
        """Return (n, T) how far any point of the part is from the nominal one, m."""
        nominal = self._nominal
        moved = motion.of(self._centre) - nominal.of(self._centre)
        way = np.sqrt(np.einsum("ntx,ntx->nt", moved, moved))
        strayed: Array = way + self._radius * motion.turned
        return strayed

    def lower_bounds(self, motion: _Motion, counts: NDArray[np.bool_]) -> Array:
        """Return (n,) how near the parts come at least, m.

        Args:
            motion: of n runs.
            counts: (n, T - 1) whether it matters between two times.
        """
        strayed = self._strayed(motion)
        off_line = motion.off_line(self._reach, self._durations)
        bounds = self._least - np.maximum(strayed[:, :-1], strayed[:, 1:])
        bounds -= off_line + self._off_line
        wanted = counts & ~(bounds >= self._target)
        for j in np.flatnonzero(wanted.any(axis=0)).tolist():
            rows = np.flatnonzero(wanted[:, j])
            closer = self._by_planes(motion, rows, j) - off_line[rows, j]
            bounds[rows, j] = np.fmax(bounds[rows, j], closer)
        least: Array = np.where(counts, bounds, np.inf).min(axis=1)
        return least

    def _by_planes(self, motion: _Motion, rows: NDArray[np.intp], j: int) -> Array:
        """Return (m,) what planes tell of rows (m,) at both ends of a stretch, m."""
        ends = [motion.at(rows, moment) for moment in (j, j + 1)]
        told = [
            np.minimum(*(planes.lower_bounds(*end) for end in ends))
            for planes in self._planes[j : j + 2]
        ]
        best: Array = np.maximum(*told)
        return best


def _rotations(q_AB: Array) -> Array:
    """Return (n, T, 3, 3) of quaternions (n, T, 4)."""
    R = np.empty((*q_AB.shape[:-1], 9))
    for i, entry in enumerate(rotation_matrix(tuple(np.moveaxis(q_AB, -1, 0)))):
        R[..., i] = entry
    return R.reshape(*q_AB.shape[:-1], 3, 3)


def _pose(R_AB: Array, p_AoBo_A: Array) -> Pose:
    """Return a pose of B in A, of which no velocity is asked."""
    nothing = np.zeros(3)
    return Pose(np.zeros(4), R_AB, p_AoBo_A, nothing, nothing)


class ClearanceScreen:
    """Screens a clearance: lower bounds for many runs.

    Any number of threads may use one at once.
    """

    def __init__(
        self,
        clearance: LowestClearance,
        watched: Watch,
        tried: RelativePlaces,
        runs: Sequence[Run],
    ):
        """Find the planes.

        Args:
            clearance: that is screened.
            watched: what is known of runs.
            tried: where bodies are in some of them, the nominal first.
            runs: the same as completed runs.
        """
        self._watched, self._window = watched, clearance.window
        self._to_the_end = watched.times[-1] >= runs[0].completed_trajectory.time[-1]
        # No order statistic that is looked for is less extreme.
        nominal, *others = (clearance.nearest(run).minimum for run in runs)
        target = max(nominal, min(others, default=nominal)) + 2.0 * ACCURACY
        self._nominal = RelativePlaces(*(x[:1] for x in tried))
        analysis = clearance.analysis
        times = np.array(watched.times)
        moved = {ends: self._motion(tried, ends) for ends in {*analysis.bodies}}
        self._pairs = [
            (ends, _PairScreen(clearance, pair, moved[ends], times, target))
            for pair, ends in zip(analysis.names, analysis.bodies, strict=True)
        ]

    def _motion(self, places: RelativePlaces, ends: Names) -> _Motion:
        k = self._watched.ends.index(ends)
        R = _rotations(places.q_AB[:, :, k])
        turned = turned_by(R, _rotations(self._nominal.q_AB[:, :, k]))
        return _Motion(R, places.p_AoBo_A[:, :, k], places.curved[:, :, k], turned)

    def lower_bounds(self, places: RelativePlaces) -> Array:
        """Return (n,) how near parts come at least, m.

        Of a run whose window does not end while it is watched, nothing is known: -inf.
        Where nothing comes nearer than some distance that no worst run keeps, no more
        than about that is told.

        Args:
            places: of n runs.
        """
        counts, known = self._counts(places)
        least = np.full(len(known), np.inf)
        moved = {ends: self._motion(places, ends) for ends in dict(self._pairs)}
        for ends, screen in self._pairs:
            # Where one pair does not tell, NaN, the others prove nothing.
            least = np.minimum(least, screen.lower_bounds(moved[ends], counts))
        # By how much the run that is measured, and its measure, may be off.
        least -= ACCURACY
        return np.where(known & np.isfinite(least), least, -np.inf)

    def _counts(
        self, places: RelativePlaces
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return (n, T - 1) which stretches matter, and (n,) whether these are all."""
        n, count = places.p_AoBo_A.shape[:2]
        if self._window is None:
            return np.ones((n, count - 1), bool), np.full(n, self._to_the_end)
        pairs, until = self._window
        over = np.ones((n, count), bool)
        for pair in pairs:
            k = self._watched.ends.index((pair.A, pair.B))
            along = places.p_AoBo_A[:, :, k] @ np.array(pair.direction)
            over &= np.logical_or.accumulate(along - along[:, :1] >= until, axis=1)
        return ~over[:, :-1], over[:, -1]
