"""Requirements on a separation, and whether runs meet them."""

import enum
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from drakesep.analysis.metrics.metric import (
    SENSES,
    Owner,
    Sense,
    is_from_above,
    is_strict,
)
from drakesep.analysis.metrics.registry import DEVIATION, find_metric
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError, check_finite, check_share
from drakesep.systems.model.parameter_table import with_axis


Limits: TypeAlias = Sequence[float] | Mapping[str, Sequence[float]]
"""(3,) of roll, pitch and yaw of the first pair, rad, infinite where there is none; or
such limits of several pairs, by their B's name, and of the first by an empty one."""


Sides: TypeAlias = Literal["one", "two"]
"""Whether a share of launches is of those within one limit, or between two."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Requirement:
    """A limit on one metric of a run: of every run, or of a share of launches.

    Raises:
        ValueError: the limit is not finite, there is no such sense, or a share stands
            without a confidence or the reverse.
    """

    metric: str
    """Name of the metric; see `drakesep.analysis.metrics.registry`."""
    sense: Sense
    limit: float
    """In SI."""
    id: str = ""
    """By which others know it, such as ``UM-4.2``."""
    source: str = ""
    """Where it comes from."""
    share: float | None = None
    """Of launches that must be within the limit, such as 0.99865; None: every run
    must, and the worst that tolerances admit is what is asked for."""
    confidence: float | None = None
    """At which that is to be shown, such as 0.9; with a share, and only with it."""
    sides: Sides = "one"
    """Of what is required of a share: each limit by itself; or ``two``, the limits of
    the same metric and id from above and from below together."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_finite(f"{self.metric}: limit", self.limit)
        check_statistical(self.metric, self.share, self.confidence, self.sides)
        if self.sense not in SENSES:
            raise InputError(
                f"{self.metric}: sense must be one of {' '.join(SENSES)}, "
                f"got {self.sense!r}"
            )

    @property
    def judged_by(self) -> str:
        """The metric that tells whether the limit is kept at all times."""
        found = find_metric(self.metric)
        if found is None:
            return self.metric
        metric, axis = found
        name = with_axis(metric.judged_by(self.sense), axis)
        if find_metric(name) is None:
            raise InputError(
                f"{self.metric}: {self.sense} is judged by {name!r}, which must be a "
                "registered metric with the same axes"
            )
        return name

    @property
    def quantity(self) -> tuple[str, str]:
        """Stem of its metric, of any pair, and the axis; empty if it has none."""
        found = find_metric(self.metric)
        return (self.metric, "") if found is None else (found[0].stem_of_any, found[1])

    @property
    def pair(self) -> str:
        """B of the pair, the attachment or the spring; empty: B of the first pair."""
        found = find_metric(self.metric)
        return "" if found is None else found[0].pair

    @property
    def owner(self) -> Owner:
        """Whose its metric is."""
        found = find_metric(self.metric)
        return Owner.PAIR if found is None else found[0].owner

    @property
    def measured_apart(self) -> bool:
        """Whether its metric is measured apart, of some runs only."""
        found = find_metric(self.metric)
        return found is not None and not found[0].of_every_run

    @property
    def never_negative(self) -> bool:
        """Whether its metric cannot be below zero, so that no limit is."""
        found = find_metric(self.metric)
        return found is not None and found[0].never_negative

    @property
    def from_above(self) -> bool:
        """Whether it limits from above; else from below."""
        return is_from_above(self.sense)

    @property
    def forbids_contact(self) -> bool:
        """Whether it says that nothing touches, and no more."""
        return self.measured_apart and self.sense == ">" and self.limit == 0.0

    @property
    def statistical(self) -> bool:
        """Whether it is of a share of launches: runs at the edges do not tell."""
        return self.share is not None

    def margin(self, value: float) -> float:
        """Return how far a value lies inside the limit; negative if it is beyond."""
        return self.limit - value if self.from_above else value - self.limit

    def keeps(self, margin: float) -> bool:
        """Return whether a value with such a margin meets it."""
        return margin > 0.0 if is_strict(self.sense) else margin >= 0.0


def check_statistical(
    name: str, share: float | None, confidence: float | None, sides: Sides
) -> None:
    """Raise InputError unless a share and its confidence make sense, or neither is.

    Args:
        name: of what is limited.
        share: of launches.
        confidence: at which it is to be shown.
        sides: of which it is.
    """
    if sides not in get_args(Sides):
        raise InputError(f"{name}: sides must be one or two, got {sides!r}")
    if (share is None) != (confidence is None):
        missing = "share" if share is None else "confidence"
        raise InputError(f"{name}: must have share and confidence, got no {missing}")
    if share is not None and confidence is not None:
        check_share(f"{name}: share", share)
        check_share(f"{name}: confidence", confidence)
    elif sides == "two":
        raise InputError(f"{name}: sides must stand with share, got none")


class UnusableLimit(InputError):
    """A limit that says nothing, could not be held, or stands twice.

    Attributes:
        requirement: that has it.
    """

    def __init__(self, requirement: Requirement, wanted: str, got: str = ""):
        """Say what is wrong with a limit.

        Args:
            requirement: that has it.
            wanted: what it must be.
            got: instead of that; if empty, the limit.
        """
        self.requirement, self._wanted, self._got = requirement, wanted, got
        side = f"a limit from {'above' if requirement.from_above else 'below'}"
        super().__init__(self.said(requirement.metric, side, requirement.limit))

    def said(self, name: str, side: str, limit: float) -> str:
        """Return what is wrong, by the names of the metric and of the limit."""
        got = self._got or f"{limit:g}"
        return f"requirements: {name}: {side} {self._wanted}, got {got}"


def check_limits(requirements: Sequence[Requirement]) -> None:
    """Raise UnusableLimit where a limit says nothing, could not be held, or repeats.

    Args:
        requirements: on metrics that there are.
    """
    sides = [(r.metric, r.sense, r.id) for r in requirements]
    for requirement, side in zip(requirements, sides, strict=True):
        _check_limit(requirement)
        if sides.count(side) > 1:
            wanted = "must stand once, or each time with an id of its own"
            got = repr(requirement.id) if requirement.id else "none"
            raise UnusableLimit(requirement, wanted, f"{got} twice")
    for band in limits_together(requirements):
        _check_sides(band)


def limits_together(
    requirements: Sequence[Requirement],
) -> list[tuple[Requirement, ...]]:
    """Return the requirements on shares of launches, limits of one share together.

    Each by itself; or two, that are one requirement of two sides.
    """
    bands: dict[object, tuple[Requirement, ...]] = {}
    for one in requirements:
        if one.statistical:
            side = one.sense if one.sides == "one" else ""
            key = one.metric, one.id, one.share, one.confidence, side
            bands[key] = (*bands.get(key, ()), one)
    return list(bands.values())


def _check_sides(band: tuple[Requirement, ...]) -> None:
    """Raise UnusableLimit if a requirement of two sides has but one."""
    first = band[0]
    of_magnitude = first.never_negative and first.from_above
    if first.sides == "two" and len(band) == 1 and not of_magnitude:
        other = "below" if first.from_above else "above"
        wanted = (
            f"of two sides must stand with one from {other}, of the same id, share and "
            "confidence, or be of a magnitude"
        )
        raise UnusableLimit(first, wanted, "none")


def _check_limit(requirement: Requirement) -> None:
    from_above = requirement.from_above
    if requirement.measured_apart and from_above:
        wanted = "must be none, of a clearance: only the nearest is looked for"
        raise UnusableLimit(requirement, wanted)
    if requirement.never_negative:
        # At zero one from above must be met, else none is; and one from below must not.
        if requirement.keeps(requirement.margin(0.0)) != from_above:
            above = is_strict(requirement.sense) == from_above
            wanted = f"must be {'>' if above else '>='} 0"
            raise UnusableLimit(requirement, wanted)
    judge = find_metric(requirement.judged_by)
    if not from_above and judge is not None and judge[0].is_largest_magnitude:
        # That a rate is large once says nothing of other times.
        wanted = (
            "must be judged by a smallest magnitude: register one, and name it as this "
            "metric's at_least"
        )
        raise UnusableLimit(requirement, wanted)


class Verdict(enum.Enum):
    """Whether a requirement is met; the value says it."""

    MET = "met"
    NOT_MET = "not met"
    NOT_SHOWN = "not shown"
    """Of a share of launches: a campaign shows neither that it is met nor that it is
    not, since its runs are too few for so near a thing. It is not known to be met."""
    NOT_LOOKED_AT = "not looked at"
    """A run does not tell, or none does, or one could not be flown: no verdict."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """How a requirement fares over several runs."""

    requirement: Requirement
    nominal: float
    """Value of the nominal run; NaN if it does not tell."""
    worst: float
    """Value farthest beyond the limit. If none is beyond it, NaN if a run does not
    tell, else the value nearest to it."""
    run: str
    """Label of the run with that value, or of the first that does not tell."""
    settled: bool = True
    """Whether every run that may be worse was flown and confirmed: else nothing is
    known to be met."""
    by_campaign: Verdict | None = None
    """What a campaign says, if one was flown beside the runs."""

    @property
    def margin(self) -> float:
        """Margin of the worst value; NaN if that is."""
        return self.requirement.margin(self.worst)

    @property
    def verdict(self) -> Verdict:
        """Whether the requirement is met.

        That of the runs; but of a share of launches they do not tell: that the worst is
        beyond the limit is no violation, and that it is within is none for launches
        farther out than the tolerances. A campaign does; and a draw of it disproves
        what every run must keep.
        """
        if self.decided_by_campaign:
            return self.by_campaign or Verdict.NOT_LOOKED_AT
        return self.verdict_on_runs

    @property
    def decided_by_campaign(self) -> bool:
        """Whether its verdict is a campaign's, not that of the runs."""
        disproved = self.by_campaign is Verdict.NOT_MET
        on_runs = self.verdict_on_runs is Verdict.NOT_MET
        return self.requirement.statistical or (disproved and not on_runs)

    @property
    def verdict_on_runs(self) -> Verdict:
        """Whether every run is within the limit."""
        if math.isnan(self.worst):
            return Verdict.NOT_LOOKED_AT
        if not self.requirement.keeps(self.margin):
            return Verdict.NOT_MET
        return Verdict.MET if self.settled else Verdict.NOT_LOOKED_AT

    @property
    def met(self) -> bool:
        """Whether every run is known to meet the requirement."""
        return self.verdict is Verdict.MET


@typed
def assess(
    requirements: Sequence[Requirement],
    runs: Mapping[str, Mapping[str, float]],
    nominal: str,
    at_most: Mapping[str, Mapping[str, float]] | None = None,
) -> list[Finding]:
    """Return how each requirement fares over the runs.

    What was not looked at, or is not a number, is never within a limit; beside a value
    that is beyond it, it changes nothing.

    Args:
        requirements: to be judged.
        runs: metrics of each run, by its label; of one that is measured apart, of some
            runs only.
        nominal: label of the nominal run.
        at_most: of runs that end too soon to tell a metric, by label, what it is at
            most: that is beyond a limit from below, whatever would have followed.
    """
    bounds = at_most or {}
    return [_finding(each, runs, nominal, bounds) for each in requirements]


def _finding(
    requirement: Requirement,
    runs: Mapping[str, Mapping[str, float]],
    nominal: str,
    at_most: Mapping[str, Mapping[str, float]],
) -> Finding:
    metric = requirement.judged_by
    values = {
        label: metrics.get(metric, math.nan)
        for label, metrics in runs.items()
        if metric in metrics or not requirement.measured_apart
    }
    for label, value in values.items():
        bound = at_most.get(label, {}).get(metric, math.nan)
        beyond = requirement.margin(bound)
        untold = math.isnan(value) and not requirement.from_above
        if untold and not (math.isnan(beyond) or requirement.keeps(beyond)):
            values[label] = bound

    def badness(label: str) -> tuple[bool, bool, float]:
        margin = requirement.margin(values[label])
        unknown = math.isnan(margin)
        return not (unknown or requirement.keeps(margin)), unknown, -margin

    worst = max(values, key=badness, default="")
    return Finding(
        requirement=requirement,
        nominal=values.get(nominal, math.nan),
        worst=values.get(worst, math.nan),
        run=worst,
    )


def verdict_on_all(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the verdict on all requirements together: one violation settles it.

    Args:
        verdicts: on each.
    """
    found = {*verdicts}
    for verdict in (Verdict.NOT_MET, Verdict.NOT_SHOWN, Verdict.NOT_LOOKED_AT):
        if verdict in found:
            return verdict
    return Verdict.MET


@typed
def deviation_limits(
    requirements: Sequence[Requirement], pair: str = ""
) -> tuple[float, ...]:
    """Return the limits of roll, pitch and yaw, rad; infinite where there is none.

    Where there are several, the least.

    Args:
        requirements: some of which limit deviations.
        pair: B of the pair whose deviations they are; empty: of the first.
    """
    found = find_metric(f"{pair}.{DEVIATION}" if pair else DEVIATION)
    assert found is not None
    return tuple(
        min(
            (r.limit for r in requirements if r.metric == name and r.from_above),
            default=math.inf,
        )
        for name in found[0].names
    )


NO_LIMITS = (math.inf,) * 3


def limits_of(limits: Limits, pair: str) -> Sequence[float]:
    """Return the limits (3,) of a pair's deviations, rad; see `Limits`."""
    if isinstance(limits, Mapping):
        return limits.get(pair, NO_LIMITS)
    return NO_LIMITS if pair else limits
