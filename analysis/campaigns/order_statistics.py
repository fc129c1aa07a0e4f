"""How many runs show that a share of launches meets a limit, and how surely.

Of a campaign's independent draws some are beyond the limit: their number has a binomial
distribution, whatever that of the metric. The tests are those of Hanson and Beard,
"Applying Monte Carlo Simulation to Launch Vehicle Design and Requirements Analysis",
NASA/TP-2010-216447, and J. Spacecraft and Rockets 49(1), 2012, doi:10.2514/1.52910.
They hold for independent draws of one distribution, and for a number of runs that was
fixed beforehand: to fly on until the verdict pleases voids the confidence.
"""

from bisect import bisect_left
from dataclasses import dataclass

from scipy.special import betainc, betaincc, betaincinv

from drakesep.analysis.search.optimality import fraction_beyond
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_share


_ROUND_OFF = 1e-12
"""Relative, of a risk: one that equals what is allowed is allowed."""
_MOST_RUNS = 10**15
"""Numbers up to it are exact as floats."""


def consumers_risk(runs: int, failures: int, share: float) -> float:
    """Return the probability that a design which is just too bad passes.

    Args:
        runs: of the campaign.
        failures: at most so many of them may be beyond the limit.
        share: of launches that are within it.

    Returns:
        The probability of so few failures if just this share is within: for any
        smaller share, it is smaller.
    """
    if failures >= runs:
        return 1.0
    # The binomial sum; scipy's own, bdtr, is NaN for many runs.
    return float(betainc(runs - failures, failures + 1, share))


def producers_risk(runs: int, failures: int, true_share: float) -> float:
    """Return the probability that a design which is good fails to pass.

    Args:
        runs: of the campaign.
        failures: at most so many of them may be beyond the limit.
        true_share: of launches that are within it, more than what is required.
    """
    if failures >= runs:
        return 0.0
    return float(betaincc(runs - failures, failures + 1, true_share))


@typed
def runs_needed(share: float, confidence: float, failures: int = 0) -> int:
    """Return the fewest runs that show a share, if so many failures are allowed.

    Args:
        share: of launches that must be within the limit, such as 0.99865.
        confidence: 1 less the consumer's risk, such as 0.9.
        failures: runs beyond the limit that are allowed.

    Raises:
        ValueError: the share or the confidence is not between 0 and 1, failures are
            negative, or more runs are needed than can be counted.
    """
    check_share("share", share)
    check_share("confidence", confidence)
    if failures < 0:
        raise InputError(f"failures must be >= 0, got {failures}")
    sizes = range(failures + 1, _MOST_RUNS)
    first = bisect_left(
        sizes,
        True,
        key=lambda runs: _shows(consumers_risk(runs, failures, share), confidence),
    )
    if first == len(sizes):
        raise InputError(f"share: {share!r} takes more than {_MOST_RUNS} runs")
    return sizes[first]


@typed
def failures_allowed(runs: int, share: float, confidence: float) -> int | None:
    """Return how many runs may be beyond the limit, if a share is to be shown.

    Args:
        runs: of the campaign.
        share: of launches that must be within the limit.
        confidence: 1 less the consumer's risk.

    Returns:
        None if so few runs do not show it even without a failure.

    Raises:
        ValueError: there is no run, or a share is not between 0 and 1.
    """
    check_share("share", share)
    check_share("confidence", confidence)
    if runs < 1:
        raise InputError(f"runs must be >= 1, got {runs}")
    too_many = bisect_left(
        range(runs),
        True,
        key=lambda k: not _shows(consumers_risk(runs, k, share), confidence),
    )
    return too_many - 1 if too_many else None


def share_shown(runs: int, failures: int, confidence: float) -> float:
    """Return the share of launches that is within the limit, at least.

    At this confidence: at least the share that is required, if and only if no more runs
    have failed than are allowed.
    """
    return 1.0 - fraction_beyond(failures, runs, confidence)


def share_at_most(runs: int, failures: int, confidence: float) -> float:
    """Return the share of launches that is within the limit, at most.

    At this confidence: 1, if no run has failed.
    """
    if failures <= 0:
        return 1.0
    return float(betaincinv(runs - failures + 1, failures, confidence))


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignSize:
    """How much a campaign can show, known before it flies.

    Raises:
        ValueError: there is no run, or a share is not between 0 and 1.
    """

    share: float
    """Of launches that must be within the limit."""
    confidence: float
    """At which it is to be shown: 1 less the consumer's risk that is accepted."""
    runs: int
    """Independent draws, their number fixed beforehand."""

    def __post_init__(self) -> None:
        """Check the values."""
        failures_allowed(self.runs, self.share, self.confidence)

    @property
    def allowed(self) -> int | None:
        """Failures with which the share is shown; None: even without one it is not."""
        return failures_allowed(self.runs, self.share, self.confidence)

    @property
    def rank(self) -> int | None:
        """Which draw is the bound of the share: 1 for the worst, 2 for the second.

        At the confidence, so large a share of launches is no worse. None if the runs
        are too few for any of them.
        """
        return None if self.allowed is None else self.allowed + 1

    @property
    def consumers_risk(self) -> float:
        """Of passing a design that is just too bad: at most 1 less the confidence.

        0 if nothing passes.
        """
        if self.allowed is None:
            return 0.0
        return consumers_risk(self.runs, self.allowed, self.share)

    def producers_risk(self, true_share: float) -> float:
        """Return the risk that a design with a better share does not pass."""
        if self.allowed is None:
            return 1.0
        return producers_risk(self.runs, self.allowed, true_share)

    def share_that_passes(self, chance: float) -> float:
        """Return how good a design must be to pass with such a chance.

        Args:
            chance: 1 less the producer's risk.

        Returns:
            The share of launches within the limit; 1 if nothing passes.
        """
        if self.allowed is None:
            return 1.0
        return share_shown(self.runs, self.allowed, 1.0 - chance)

    def disproved_by(self, failures: int) -> bool:
        """Return whether so many failures show that the share is not met.

        At the same confidence: if the share were met, so many would be as improbable.
        """
        if failures <= 0:
            return False
        chance = producers_risk(self.runs, failures - 1, self.share)
        return _shows(chance, self.confidence)


def _shows(risk: float, confidence: float) -> bool:
    return risk <= (1.0 - confidence) * (1.0 + _ROUND_OFF)
