"""How near parts come as an objective: the worst clearance over tolerances.

The smallest distance over pairs and times has a kink wherever another pair or time
becomes the smallest, and is known to some tens of micrometres: too coarse for
differences. Its slope is that of the distance between the two nearest points, as they
are fixed in their bodies, along their common normal and at the time of the smallest
(the envelope theorem): where both are best, a change of either is of second order.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from drakesep.analysis.clearance.of_pair import ACCURACY, Clearance
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.analysis.metrics.clearances import CLEARANCE
from drakesep.analysis.metrics.objectives import (
    About,
    LargestOfParts,
    Limits,
    Needs,
    SignedMetric,
)
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.geometry.moved_parts import displacements
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.magnitudes import check_size
from drakesep.systems.model.part_pairs import Names, owners_of, pairs_apart
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair, Separation, leaving_among


LOWEST = f"lowest_{CLEARANCE}"
"""The objective that makes all parts come near."""
_ABOUT = 4.0 * ACCURACY
"""Within which a likely distance is about right, m."""
_MOMENTS = 25
"""At which all pairs are looked at, for which of them may come nearest."""


@typed
class LowestClearance(LargestOfParts):
    """Less the smallest distance between parts: 0, the highest, at contact.

    Attributes:
        metric: the clearance that it makes small.
    """

    needs = Needs.MEASUREMENT

    def __init__(
        self,
        separation: Separation,
        pairs: Sequence[Sequence[str]] | None = None,
        *,
        touching: Sequence[Sequence[str]] = (),
        until_separation: float | None = None,
        leaving: Sequence[str] = (),
        metric: str = CLEARANCE,
        name: str = "",
    ):
        """Prepare.

        Args:
            separation: whose bodies have parts.
            pairs: of parts; if None, all of different bodies that do not touch while
                mated: those that do begin at no distance.
            touching: those that touch or overlap while mated.
            until_separation: how far B is to move in its direction until the distances
                do not matter any more, m; to the end of the run if None.
            leaving: names of the bodies that are to move so far; if empty, every body
                that leaves.
            metric: name of the clearance that it makes small.
            name: in tables; made of that if empty.

        Raises:
            ValueError: a pair names no part or two of one body, the separation is not
                positive, or no such body leaves.
        """
        if until_separation is not None:
            check_size("length", "until_separation", until_separation)
        self.metric = metric
        self.name = name or f"lowest_{metric}"
        self.shown_as = SignedMetric(metric, -1.0)
        known = [pair.B for pair in separation.pairs]
        for body in leaving:
            if body not in known:
                raise InputError(unknown("body that leaves", body, known))
        self._leaving = tuple(map(separation.pair_of, leaving)) or separation.pairs
        self._until_separation = until_separation
        self._separation, self._touching = separation, touching
        self._pairs = pairs_apart(separation, pairs, touching)
        self._prepared: ClearanceAnalysis | None = None
        self._owners = owners_of(separation)
        if not self._pairs:
            raise InputError(
                "pairs: must have one of two bodies that does not touch while mated, "
                "got none"
            )

    def prepare(self) -> None:
        """Cut parts into pieces, once, which warns of meshes of a doubtful scale.

        It takes its time: left until then, it is done when a distance is first asked.
        """
        if self._prepared is None:
            self._prepared = ClearanceAnalysis(
                self._separation, self._pairs, touching=self._touching
            )

    def check_apart(self) -> None:
        """Raise InputError if parts overlap while mated that are not said to touch."""
        self.analysis.check_apart()

    @property
    def pairs(self) -> Sequence[Names]:
        """The pairs of parts that are measured."""
        return self._pairs

    @property
    def touching(self) -> bool:
        """Whether any of them touch or overlap while mated."""
        touching = set(map(frozenset, self._touching))
        return any(frozenset(pair) in touching for pair in self._pairs)

    @property
    def window(self) -> tuple[tuple[Pair, ...], float] | None:
        """The pairs whose bodies must have moved so far, m, until it does not matter.

        None: it matters to the end of the run.
        """
        until = self._until_separation
        return None if until is None else (self._leaving, until)

    @property
    def analysis(self) -> ClearanceAnalysis:
        """What measures it."""
        self.prepare()
        assert self._prepared is not None
        return self._prepared

    def nearest(self, run: Run, likely: float = math.inf) -> Clearance:
        """Return how near the nearest pair comes in a completed run.

        Args:
            run: a completed run.
            likely: about how near that is, or more, if it is known: then it is sooner
                told, m.
        """
        found = self.nearer(run, likely + _ABOUT)
        if found is None:
            found = self.nearer(run, math.inf)
        assert found is not None
        return found

    def nearer(self, run: Run, than: float) -> Clearance | None:
        """Return how near the nearest pair comes; None if not nearer than that, m."""
        return self.analysis.smallest(run, until=self.end(run), than=than)

    def of_run(self, run: Run, limits: Limits) -> float:
        """Return less the smallest distance in a completed run, m."""
        return -self.nearest(run).minimum

    def resolution(self, accuracy: float) -> float:
        """Return by how much it may differ in two runs that are equal but for errors.

        Args:
            accuracy: of the runs' motion, m.
        """
        return ACCURACY + accuracy

    def about(self, run: Run, limits: Limits, at_least: float = -math.inf) -> About:
        """Return the objective, and how far its two nearest points are apart around.

        So far apart, or nearer, their parts are in any run.
        """
        found = self.nearest(run, likely=-at_least)
        A, B = self._owners[found.first], self._owners[found.second]
        ends_there = found.time >= self.end(run)
        points = (found.first, found.p_AoCa_A), (found.second, found.p_BoCb_B)

        def second_from_first(other: Run) -> np.ndarray:
            time = self.end(other) if ends_there else found.time
            nearby = other.completed_trajectory.around(time)
            pose = RelativePath(nearby, A, B).at(time)
            first, second = _carried(points, run, other)
            return np.asarray(pose.p_AoBo_A + pose.R_AB @ second - first)

        apart = second_from_first(run)
        length = float(np.linalg.norm(apart))
        # Shapes that touch have no normal, and no clearance to lose.
        n_A = apart / length if found.contact is None and length > 0.0 else 0.0 * apart
        rest = found.minimum - float(n_A @ apart)
        return About(
            -found.minimum,
            lambda other: -float(n_A @ second_from_first(other)) - rest,
            self.is_window_ended(run),
            lambda other: -float(np.linalg.norm(second_from_first(other))),
        )

    def linearised_parts(
        self, run: Run, around: Sequence[Run], reach: Array | None = None
    ) -> tuple[Array, Array]:
        """Return less the distances of all pairs at some moments, and their changes.

        To first order: those of the nearest points, as for the smallest. What is too
        far apart to become the smallest is -inf, and does not change.
        """
        times = np.linspace(0.0, self.end(run), _MOMENTS)
        flown = [one.completed_trajectory for one in (run, *around)]
        ends_of = dict(zip(self.analysis.names, self.analysis.bodies, strict=True))
        places = {
            ends: [RelativePath(one, *ends).places(times) for one in flown]
            for ends in set(ends_of.values())
        }
        stacked = {
            ends: tuple(np.array(x) for x in zip(*each, strict=True))
            for ends, each in places.items()
        }
        within = None
        moved = any(displacements(run.separation, one.separation) for one in around)
        if reach is not None and not moved:
            within = np.array(
                [
                    reach @ self._most_moved(names, *stacked[ends_of[names]])
                    for names in self.analysis.apart
                ]
            )
        values = np.full((len(self.analysis.apart), len(times)), -np.inf)
        changes = np.zeros((*values.shape, len(around)))
        told = self.analysis.moments(run, times.tolist(), within)
        for k, (names, pair) in enumerate(zip(self.analysis.apart, told, strict=True)):
            (a, b), (R, p) = names, stacked[ends_of[names]]
            known = [i for i, there in enumerate(pair) if there is not None]
            near = [there.nearest for there in pair if there is not None]
            if not near:
                continue
            R, p = R[:, known], p[:, known]
            n_A = np.nan_to_num([there.n_A for there in near])
            points = (
                (a, [there.p_AoCa_A for there in near]),
                (b, [there.p_BoCb_B for there in near]),
            )
            carried = [_carried(points, run, one) for one in (run, *around)]
            first, second = (np.array(x) for x in zip(*carried, strict=True))
            second_A = p + np.einsum("rtij,rtj->rti", R, second)
            along = np.einsum("rti,ti->rt", second_A - (first - first[0]), n_A)
            values[k, known] = [-there.distance for there in near]
            changes[k, known] = (along[0] - along[1:]).T
        return values, changes

    def _most_moved(self, pair: Names, R_AB: Array, p_AoBo_A: Array) -> Array:
        """Return (r, t) how far any point of a pair's second part is moved, at most, m.

        Args:
            pair: names of its parts.
            R_AB: (1 + r, t, 3, 3) of a run and of those around it.
            p_AoBo_A: (1 + r, t, 3) of the same, m.
        """
        centre, radius = self.analysis.ball_around(pair)
        centres = p_AoBo_A + R_AB @ centre
        turned = np.linalg.norm(R_AB[1:] - R_AB[0], axis=(2, 3))
        moved = np.linalg.norm(centres[1:] - centres[0], axis=2)
        return np.asarray(moved + radius * turned)

    def approach(
        self, run: Run, found: Clearance, count: int = 60
    ) -> tuple[Array, Array]:
        """Return how near the nearest pair is while distances matter.

        Args:
            run: a completed run.
            found: what is nearest in it.
            count: of moments.

        Returns:
            (n,) how far the body has moved in its direction that leaves, of those that
            are meant, for the two whose parts are nearest (see `leaving_among`), m; and
            (n,) the distances, m.
        """
        times = np.append(np.linspace(0.0, self.end(run), count), found.time)
        times.sort()
        bodies = self._owners[found.first], self._owners[found.second]
        leaves = leaving_among(self._leaving, bodies)
        moved = _path_of(leaves, run).moved(times, leaves.direction)
        pair = found.first, found.second
        return moved, self.analysis.at_times(run, times, of=[pair])[:, 0]

    def is_window_ended(self, run: Run) -> bool:
        """Return whether B moves as far as the window goes; else none can judge it."""
        return self._until_separation is None or math.isfinite(self._reached(run))

    def end(self, run: Run) -> float:
        """Return until when distances matter, s: to the end if it is not reached."""
        last = float(run.completed_trajectory.time[-1])
        return last if self._until_separation is None else min(self._reached(run), last)

    def _reached(self, run: Run) -> float:
        """Return when B has moved as far as the window goes, s; infinite if never."""
        until = self._until_separation
        assert until is not None
        return max(
            _path_of(pair, run).time_apart(until, pair.direction)
            for pair in self._leaving
        )


def _carried(
    points: Sequence[tuple[str, ArrayLike]], run: Run, other: Run
) -> list[Array]:
    """Return points (..., 3) of parts, in their bodies, where they are in another run.

    Args:
        points: with the names of their parts, as they are in a run.
        run: that one.
        other: in which parts may have been moved within their bodies.
    """
    moved = displacements(run.separation, other.separation)
    carried = []
    for name, point in points:
        X, p = moved.get(name), np.asarray(point, dtype=float)
        if X is not None:
            p = p @ X.rotation().matrix().T + X.translation()
        carried.append(p)
    return carried


def _path_of(pair: Pair, run: Run) -> RelativePath:
    """Return the path of B of a pair as seen from A."""
    return RelativePath(run.completed_trajectory, pair.A, pair.B)
