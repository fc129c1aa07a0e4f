"""The clearances of a campaign's draws: bounds of all, and the values of some."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.screen import ClearanceScreen, Watch, watch
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.systems.arrays import Array
from drakesep.systems.model.relative_places import RelativePlaces
from drakesep.systems.model.run import Run, RunStatus


TRIED = 8
"""Draws that tell how far others stray from the nominal run."""
TOGETHER = 1024
"""Rows that are screened together: their places take memory."""
_GRAIN = 1e-6
"""Of bounds, m."""
_CLOSE = 5e-4
"""Beyond its bound, within which a clearance is looked for first, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DrawnClearances:
    """How near parts come in n draws, by c clearances."""

    at_least: Array
    """(n, c) m: what was measured, else what is certain; -inf: nothing is; NaN: the run
    failed, or its window does not end."""
    measured: NDArray[np.bool_]
    """(n, c) whether it was."""


class BatchScreens:
    """Screens clearances in rows of a batch."""

    def __init__(
        self, batch: Batch, clearances: Sequence[LowestClearance], rows: Array
    ):
        """Prepare, by the nominal run and some others.

        Args:
            batch: that flies.
            clearances: that are screened.
            rows: (r, n_p) like those that are to be screened.
        """
        self._count = len(clearances)
        tried = np.vstack([batch.nominal, rows])
        runs = batch.runs(tried)
        sound = [i for i, run in enumerate(runs) if has_separated(run)]
        self._batch: Batch | None = None
        self._screens: list[ClearanceScreen] = []
        if 0 not in sound:  # without a nominal run there are no planes
            return
        completed = [runs[i] for i in sound]
        watched: Watch = watch(clearances, completed)
        self._batch = batch.watching(watched.ends, watched.times)
        [(_, places)] = self._batch.places(tried[sound])
        self._screens = [
            ClearanceScreen(one, watched, places, completed) for one in clearances
        ]

    def at_least(self, rows: Array) -> Array:
        """Return (n, c) how near parts come at least, m; -inf: nothing is known.

        Args:
            rows: (n, n_p) of parameter values.
        """
        bounds = np.full((len(rows), self._count), -math.inf)
        if self._batch is None:
            return bounds
        # All at once: how many parts they come in depends on who flies them.
        parts = [places for _, places in self._batch.places(rows)]
        places = RelativePlaces(*map(np.concatenate, zip(*parts, strict=True)))
        for i, screen in enumerate(self._screens):
            bounds[:, i] = screen.lower_bounds(places)
        # Products of matrices differ in their last bits from one number of threads to
        # another: bytes are to be the same.
        return np.floor(bounds / _GRAIN) * _GRAIN


def measured_in(run: Run, clearance: LowestClearance, at_least: float) -> float:
    """Return how near parts come in a run, m; NaN if it does not tell.

    Args:
        run: completed or failed.
        clearance: that is measured.
        at_least: what is known of it, m; else -inf.
    """
    if not has_separated(run) or not clearance.is_window_ended(run):
        return math.nan
    likely = at_least + _CLOSE if math.isfinite(at_least) else math.inf
    return clearance.nearest(run, likely).minimum


def has_separated(run: Run) -> bool:
    """Return whether a run was completed, and what should part has parted."""
    return run.status is not RunStatus.FAILED and not run.not_separated
