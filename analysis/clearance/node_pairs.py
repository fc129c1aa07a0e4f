"""What is known of pairs of nodes since each was last measured.

A plane between two convex sets stays between them until they have moved by their
distance along its normal (conservative advancement; Tang, Kim and Manocha, "C2A", ICRA
2009, doi 10.1109/ROBOT.2009.5152234). So what was measured at one pose bounds the
distance at all others, and over a stretch of time.
"""

from typing import NamedTuple

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.geometry.bounding_tree import Pair, split
from drakesep.systems.geometry.distance import DistanceBound
from drakesep.systems.geometry.relative_path import MotionBounds, Pose
from drakesep.systems.vectors import cross


_ROOM = 64
"""Pairs that there is room for to begin with."""


class _Known(NamedTuple):
    """Arrays with an entry for each pair."""

    low: Array
    """(n,) what the distance was at least, m; -inf: not measured, or no plane is."""
    n_A: Array
    """(n, 3) unit vector across the plane, from A's node to B's."""
    centre_A: Array
    """(n, 3) where the centre of B's node was then, in A, m."""
    centre_B: Array
    """(n, 3) centre of a ball around B's node, in B, m."""
    radius: Array
    """(n,) of that ball, m."""
    q_AB: Array
    """(n, 4) how B was turned then."""

    @classmethod
    def with_room(cls, n: int) -> "_Known":
        n_A, centre_A, centre_B = np.empty((3, n, 3))
        return cls(np.empty(n), n_A, centre_A, centre_B, np.empty(n), np.empty((n, 4)))

    def with_twice_the_room(self) -> "_Known":
        return _Known(*(np.concatenate([x, np.empty_like(x)]) for x in self))

    def first(self, n: int) -> "_Known":
        return _Known(*(x[:n] for x in self))


class NodePairs:
    """Pairs of nodes that together hold two parts, and what is known of each."""

    def __init__(self, roots: Pair):
        """Begin with the pair of both parts' roots, of which nothing is known."""
        self._pairs: list[Pair] = []
        self._room = _Known.with_room(_ROOM)
        self.add(roots)

    def __len__(self) -> int:
        return len(self._pairs)

    def __getitem__(self, k: int) -> Pair:
        return self._pairs[k]

    def add(self, pair: Pair) -> int:
        """Add a pair of which nothing is known, and return where it stands."""
        k = len(self._pairs)
        if k == len(self._room.low):
            self._room = self._room.with_twice_the_room()
        self._known = self._room.first(k + 1)
        self._pairs.append(pair)
        self.replace(k, pair)
        return k

    def replace(self, k: int, pair: Pair) -> None:
        """Put a pair of which nothing is known in the place of another."""
        self._pairs[k] = pair
        known = self._known
        known.low[k] = -np.inf
        known.n_A[k], known.centre_A[k], known.q_AB[k] = 0.0, 0.0, 0.0
        known.centre_B[k], known.radius[k] = pair[1].centre, pair[1].radius

    def open(self, k: int) -> list[int]:
        """Put what a pair holds into its place, and return where that stands."""
        first, *others = split(self._pairs[k])
        self.replace(k, first)
        return [k, *(self.add(pair) for pair in others)]

    def note(self, k: int, pose: Pose, bound: DistanceBound) -> None:
        """Keep what was measured of a pair where B is at a pose in A."""
        known = self._known
        known.low[k], known.n_A[k], known.q_AB[k] = bound.low, bound.n_A, pose.q_AB
        known.centre_A[k] = pose.R_AB @ known.centre_B[k] + pose.p_AoBo_A

    def lower_bounds(self, pose: Pose) -> Array:
        """Return (n,) what the distances are at least where B is at a pose in A, m.

        Of what overlapped when it was measured nothing is known: -inf.
        """
        known = self._known
        moved = known.centre_B @ pose.R_AB.T + pose.p_AoBo_A - known.centre_A
        along = np.einsum("ki,ki->k", moved, known.n_A)
        cosine = np.minimum(np.abs(known.q_AB @ pose.q_AB), 1.0)
        turned = 2.0 * np.arccos(cosine)
        bounds = known.low + along - turned * known.radius
        # Between shapes that touch, Drake's normal may be no number.
        return np.where(np.isfinite(bounds), bounds, -np.inf)

    def motion_within(self, pose: Pose, bounds: MotionBounds, duration: float) -> Array:
        """Return (n,) how far B's nodes come nearer in a time, at most, m.

        Along the normals across the planes, turning included.

        Args:
            pose: of B in A, from which they move.
            bounds: on the motion in that time before and after.
            duration: s.
        """
        known = self._known
        arms = known.centre_B @ pose.R_AB.T
        # Not with np.cross, which takes longer than all the rest.
        turned = np.stack(cross(tuple(pose.w_AB_A), tuple(arms.T)), axis=1)
        velocities = pose.v_ABo_A + turned
        speeds = np.abs(np.einsum("ki,ki->k", velocities, known.n_A))
        curving = bounds.acceleration + bounds.bending * np.linalg.norm(arms, axis=1)
        turning = bounds.angular_speed * known.radius
        return np.asarray((speeds + turning) * duration + 0.5 * curving * duration**2)
