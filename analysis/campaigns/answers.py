"""What the draws of a campaign say of requirements on shares of launches.

All is counted by margins: how far a draw is within its limits, on whichever side. So a
requirement of two sides is answered as one of one side is.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.campaigns.order_statistics import (
    CampaignSize,
    share_at_most,
    share_shown,
)
from drakesep.analysis.metrics.metric import is_strict
from drakesep.analysis.metrics.requirements import (
    Requirement,
    Sides,
    Verdict,
    limits_together,
)
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchRequirement:
    """What a share of launches must be within: a limit, or two of one metric.

    Raises:
        ValueError: there is no limit, or one is of every run.
    """

    limits: tuple[Requirement, ...]
    """Of the same share and confidence."""

    def __post_init__(self) -> None:
        """Check the limits."""
        if not self.limits or any(not one.statistical for one in self.limits):
            raise InputError(
                "limits must be of a share of launches, one or more, got "
                f"{[one.metric for one in self.limits]}"
            )

    @property
    def share(self) -> float:
        """Of launches."""
        share = self.limits[0].share
        assert share is not None
        return share

    @property
    def confidence(self) -> float:
        """At which it is to be shown."""
        confidence = self.limits[0].confidence
        assert confidence is not None
        return confidence

    @property
    def sides(self) -> Sides:
        """Whether the share is of those within one limit, or between two."""
        return self.limits[0].sides

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of the metrics that judge it, one for each limit."""
        return tuple(one.judged_by for one in self.limits)

    def margins(self, metrics: Mapping[str, Array]) -> Array:
        """Return how far each draw is within the limits, the least of them.

        Args:
            metrics: (N,) values of each draw by name, in SI; NaN if a draw does not
                tell.

        Returns:
            (N,) in SI, negative beyond a limit; NaN if a draw is beyond none that it
            tells of, and does not tell of all.
        """
        sides = np.array(
            [
                limit.limit - values if limit.from_above else values - limit.limit
                for limit in self.limits
                for values in (np.asarray(metrics[limit.judged_by], float),)
            ]
        )
        least = np.fmin.reduce(sides)
        untold = np.isnan(sides).any(axis=0) & ~self.beyond(least)
        return np.where(untold, np.nan, least)

    def beyond(self, margins: Array) -> NDArray[np.bool_]:
        """Return which margins are those of draws beyond a limit."""
        if any(is_strict(limit.sense) for limit in self.limits):
            return margins <= 0.0
        return margins < 0.0


@typed
def launch_requirements(
    requirements: Sequence[Requirement],
) -> tuple[LaunchRequirement, ...]:
    """Return what is required of shares of launches, in the order of its limits.

    Args:
        requirements: those that are of every run are left out.
    """
    return tuple(LaunchRequirement(limits=two) for two in limits_together(requirements))


@dataclass(frozen=True, slots=True, kw_only=True)
class Tally:
    """What is kept of draws for one requirement: counts, and the worst of them.

    Tallies of parts of a campaign make that of the whole, to the bit, in whatever order
    they are put together.
    """

    runs: int
    """Draws."""
    beyond: int
    """Of them, beyond a limit."""
    untold: int
    """Of them, those that do not tell, such as one that could not be flown."""
    worst_margins: tuple[float, ...]
    """Of those that tell, in SI, the least first: as many as are known to be the worst
    of all."""
    worst_draws: tuple[int, ...]
    """Their numbers in the campaign."""
    doubtful: int = 0
    """Draws that may be beyond a limit, or not, and are no worse than those that are
    kept: enough others are beyond."""

    @classmethod
    def of(
        cls,
        required: LaunchRequirement,
        metrics: Mapping[str, Array],
        *,
        first: int = 0,
        kept: int,
    ) -> Self:
        """Count draws that follow one another.

        Args:
            required: of them.
            metrics: (N,) values by name, in SI; NaN if a draw does not tell.
            first: number of the first draw in the campaign.
            kept: how many worst to keep; see `worst_to_keep`.
        """
        margins = required.margins(metrics)
        told = np.flatnonzero(~np.isnan(margins))
        least = told
        if len(told) > kept:  # and all that equal the last of them
            last = np.partition(margins[told], kept - 1)[kept - 1]
            least = told[margins[told] <= last]
        least = least[np.argsort(margins[least], kind="stable")][:kept]
        return cls(
            runs=len(margins),
            beyond=int(required.beyond(margins).sum()),
            untold=len(margins) - len(told),
            worst_margins=tuple(margins[least].tolist()),
            worst_draws=tuple((first + least).tolist()),
        )

    @classmethod
    def merged(cls, tallies: Iterable[Self]) -> Self:
        """Return the tally of parts of a campaign together.

        All that is worse than the last that a part keeps is known; of draws that equal
        it, as many as their parts keep: each stands for the others.

        Args:
            tallies: one or more, of different draws.
        """
        parts = list(tallies)
        lasts = [
            part.worst_margins[-1] if part.worst_draws else math.nan
            for part in parts
            if len(part.worst_draws) < part.runs - part.untold
        ]
        # NaN, of a part that keeps none: nothing is known to be worse.
        last = np.min(lasts, initial=math.inf)
        margins = np.concatenate([np.array(p.worst_margins, float) for p in parts])
        draws = np.concatenate([np.array(p.worst_draws, np.int64) for p in parts])
        known = margins <= last
        margins, draws = margins[known], draws[known]
        order = np.lexsort((draws, margins))
        return cls(
            runs=sum(part.runs for part in parts),
            beyond=sum(part.beyond for part in parts),
            untold=sum(part.untold for part in parts),
            worst_margins=tuple(margins[order].tolist()),
            worst_draws=tuple(draws[order].tolist()),
            doubtful=sum(part.doubtful for part in parts),
        )


def worst_to_keep(size: CampaignSize, runs: int) -> int:
    """Return how many worst to keep of a part of a campaign, to know its bound.

    As many as the bound's rank, or as many as independent draws of a part may have of
    these: six deviations more than on average. Where a part has more, `CampaignAnswer`
    refuses the whole.

    Args:
        size: of the campaign.
        runs: draws in the part.
    """
    if size.rank is None:
        return 1
    expected = size.rank * runs / size.runs
    return min(size.rank, math.ceil(expected + 6.0 * math.sqrt(expected) + 10.0))


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignAnswer:
    """What a campaign says of one requirement on a share of launches.

    Raises:
        ValueError: there are no draws, or too few of the worst were kept.
    """

    required: LaunchRequirement
    tally: Tally
    """Of all its draws, whose number was fixed beforehand; each independent."""

    def __post_init__(self) -> None:
        """Check that the deciding draw is among those that were kept."""
        rank, kept = self.size.rank, len(self.tally.worst_margins)
        told = self.tally.runs - self.tally.untold
        if rank is not None and kept < min(rank - self.tally.untold, told):
            raise InputError(
                f"tally must keep the {rank} worst of {self.tally.runs} draws, "
                f"got {kept}"
            )

    @property
    def size(self) -> CampaignSize:
        """What so many draws can show, whatever comes of them."""
        return CampaignSize(
            share=self.required.share,
            confidence=self.required.confidence,
            runs=self.tally.runs,
        )

    @property
    def failures(self) -> int:
        """Draws that are not known to be within the limits."""
        return self.tally.beyond + self.tally.untold + self.tally.doubtful

    @property
    def allowed(self) -> int | None:
        """Failures with which it is met; None: so few draws meet nothing."""
        return self.size.allowed

    @property
    def verdict(self) -> Verdict:
        """Whether so large a share of launches is within, at the confidence.

        ``met`` and ``not met`` are both shown at it: with a share just too small, the
        first comes about in no more than 1 less the confidence of all campaigns, and
        with the share that is required the second.
        """
        if self.tally.untold == self.tally.runs:
            return Verdict.NOT_LOOKED_AT
        if self.allowed is not None and self.failures <= self.allowed:
            return Verdict.MET
        if self.size.disproved_by(self.tally.beyond):
            return Verdict.NOT_MET
        return Verdict.NOT_SHOWN

    @property
    def why(self) -> str:
        """The counts behind the verdict, in words."""
        many = f"{self.failures} of {self.tally.runs} draws"
        if self.tally.untold:
            many += f", {self.tally.untold} of which do not tell,"
        if self.tally.doubtful:
            many += f", {self.tally.doubtful} of which may not be,"
        if self.allowed is None:
            return f"{many} are beyond; so few draws show nothing, even if none is"
        return f"{many} are beyond; at most {self.allowed} may be"

    @property
    def share_shown(self) -> float:
        """The share of launches that is within, at least, at the confidence."""
        confidence = self.required.confidence
        return share_shown(self.tally.runs, self.failures, confidence)

    @property
    def share_at_most(self) -> float:
        """The share of launches that is within, at most, at the confidence."""
        confidence = self.required.confidence
        return share_at_most(self.tally.runs, self.tally.beyond, confidence)

    @property
    def margin(self) -> float:
        """How far within the limits so large a share of launches is, at the confidence.

        In SI; negative: they are beyond. The margin of the draw whose rank is
        `CampaignSize.rank`; minus infinity, if there is none: draws are too few, or too
        many do not tell.
        """
        place = self._place
        return -math.inf if place is None else self.tally.worst_margins[place]

    @property
    def bounds(self) -> tuple[float, ...]:
        """Each limit, moved to where the share of launches is just within, in SI."""
        return tuple(
            one.limit - self.margin if one.from_above else one.limit + self.margin
            for one in self.required.limits
        )

    @property
    def deciding_draw(self) -> int | None:
        """The number of the draw whose margin it is; None if there is none."""
        place = self._place
        return None if place is None else self.tally.worst_draws[place]

    @property
    def _place(self) -> int | None:
        """Where the deciding draw stands among the worst that tell."""
        if self.size.rank is None:
            return None
        place = self.size.rank - 1 - self.tally.untold
        return place if place >= 0 else None
