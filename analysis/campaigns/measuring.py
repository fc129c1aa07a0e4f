"""Which draws' clearances must be measured, and what is then known of a requirement.

Of every draw it is known how near parts come at least. To know how many are beyond a
limit, those are measured that may be; to know the bound of a share of launches, those
that may come before it, the worst first, until no other may: the same draws, whoever
measures them and however many at once.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.campaigns.answers import LaunchRequirement, Tally
from drakesep.analysis.campaigns.order_statistics import CampaignSize
from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.systems.arrays import Array


ROUND, FEW = 64, 16
"""Draws that are measured before it is asked again which others must be, at most; and
as long as they are fewer than the bound's rank, at least."""
ENOUGH = 500
"""Draws that are measured to count those beyond a limit, once it is broken."""
MOST = 5000
"""Draws whose clearance is measured, at most: of more, some do not tell."""
SURE = 2.0 * ACCURACY
"""To which the bound of a share is known, as any clearance is, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NearestOfDraws:
    """How near parts come in all draws, by one clearance, for one requirement."""

    required: LaunchRequirement
    """Of a share of launches; a limit from below."""
    size: CampaignSize
    at_least: Array
    """(N,) m, as `DrawnClearances` has it."""
    measured: NDArray[np.bool_]
    """(N,)."""

    @property
    def open(self) -> NDArray[np.bool_]:
        """(N,) which draws must be measured."""
        return self._open_for_bound | self._open_for_count

    @property
    def left(self) -> int:
        """How many draws must be measured yet, about: at least, until that is known."""
        wanted = self._open_for_count if self.short else self.open
        return max(int(wanted.sum()), self.short)

    @property
    def known_to(self) -> float:
        """To which distance all draws are measured, m, as surely as any clearance."""
        return float(self.at_least[self._unmeasured].min(initial=math.inf)) + SURE

    @property
    def _unmeasured(self) -> NDArray[np.bool_]:
        return ~self.measured & ~np.isnan(self.at_least)

    @property
    def _untold(self) -> int:
        return int(np.isnan(self.at_least).sum())

    @property
    def _margins(self) -> Array:
        return self.at_least - self.required.limits[0].limit

    @property
    def _beyond(self) -> NDArray[np.bool_]:
        """(N,) which draws are, as far as it is known of those that are measured."""
        return self.required.beyond(self._margins)

    @property
    def _rank(self) -> int:
        """Which of the draws that tell is looked for: the bound, else the worst.

        Those that do not tell come before all others.
        """
        bound = self.size.rank or 1
        return max(bound - self._untold, 1) if bound <= MOST else 1

    @property
    def _told(self) -> Array:
        """What was measured of draws that tell, m."""
        return self.at_least[self.measured & ~np.isnan(self.at_least)]

    @property
    def short(self) -> int:
        """How many draws more must be measured until the bound may be known."""
        return max(self._rank - len(self._told), 0)

    @property
    def _last(self) -> float:
        """What the draw of that rank measures, m; inf: too few are measured."""
        if self.short:
            return math.inf
        return float(np.partition(self._told, self._rank - 1)[self._rank - 1])

    @property
    def _open_for_bound(self) -> NDArray[np.bool_]:
        return self._unmeasured & (self.at_least < self._last - SURE)

    @property
    def _open_for_count(self) -> NDArray[np.bool_]:
        """(N,) which may be beyond the limit; none, if enough are known to be.

        If so many are measured, and it is broken.
        """
        beyond = int((self.measured & self._beyond).sum())
        enough = self.measured.sum() >= ENOUGH
        if enough and self.size.disproved_by(beyond):
            return np.zeros(len(self.measured), bool)
        return self._unmeasured & self._beyond

    @property
    def values(self) -> Array:
        """(N,) how near parts come, m; NaN of draws that do not tell.

        Of a draw that was not measured and comes after the bound in any case, it is
        said no more than that.
        """
        values = np.where(self.measured, self.at_least, np.nan)
        rest, doubtful = self._unmeasured, self._unmeasured & self._beyond
        too_many = (self.size.rank or 1) > MOST or self._open_for_bound.any()
        if too_many:  # what is certain counts
            values[rest] = self.at_least[rest]
            values[doubtful] = np.nan
        else:
            after = np.nextafter(self._last, math.inf)
            values[rest] = np.maximum(self.at_least[rest], after)
            values[doubtful] = math.inf  # beyond or not, they are counted apart
        return values

    def tally(self, kept: int) -> Tally:
        """Return the tally of all draws.

        Args:
            kept: how many worst to keep.
        """
        values = self.values
        told = Tally.of(self.required, {self.required.metrics[0]: values}, kept=kept)
        doubtful = self._unmeasured & self._beyond & ~np.isnan(values)
        return replace(told, doubtful=int(doubtful.sum()))


def next_draws(of_requirements: Sequence[NearestOfDraws]) -> NDArray[np.intp]:
    """Return the draws that are to be measured next; none, if all that must be are.

    Args:
        of_requirements: of all on the same clearance.
    """
    first = of_requirements[0]
    done = int(first.measured.sum())
    wanted = np.flatnonzero(np.logical_or.reduce([one.open for one in of_requirements]))
    order = np.argsort(first.at_least[wanted], kind="stable")
    short = max(one.short for one in of_requirements)
    size = min(max(short, FEW), ROUND) if short else ROUND
    return wanted[order][: min(size, max(MOST - done, 0))]
