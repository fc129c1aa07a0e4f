"""One separation, with all that is asked of it: frozen, in SI, checked when it is made.

It is what every study works on. A case file is turned into one when it is read; from
Python it is made of a `Separation` and the records beside it. `dataclasses.replace`
varies it, with the same checks.
"""

import functools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, Self

from drakesep.analysis.failure_cases import (
    FailureCase,
    check_failure_cases,
    check_probabilities,
)
from drakesep.analysis.metrics.clearances import CLEARANCE
from drakesep.analysis.metrics.metric import Functional, Metric, Owner
from drakesep.analysis.metrics.objectives import OBJECTIVES, Objective, lowest, towards
from drakesep.analysis.metrics.of_run import metric_named
from drakesep.analysis.metrics.registry import (
    DEVIATION,
    WITHIN,
    find_metric,
    registered_metrics,
)
from drakesep.analysis.metrics.requirements import (
    NO_LIMITS,
    Requirement,
    check_limits,
    deviation_limits,
)
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.analysis.tolerances.correlations import RankCorrelation
from drakesep.analysis.tolerances.ellipsoid import Ellipsoid
from drakesep.analysis.tolerances.joint_distribution import JointDistribution
from drakesep.analysis.tolerances.sides import Tolerance
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    Vector3,
    check_entries,
    check_finite,
    named,
    unknown,
)
from drakesep.systems.frozen_mapping import FrozenMapping
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameters import (
    ParameterName,
    places_of_parts,
    with_values,
)
from drakesep.systems.model.part_pairs import (
    Names,
    owners_of,
    pairs_apart,
    part_pairs,
)
from drakesep.systems.model.separation import Separation


if TYPE_CHECKING:  # imports Drake
    from drakesep.analysis.clearance.objective import LowestClearance


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class ClearancePairs:
    """Which parts are measured to each other."""

    pairs: tuple[Names, ...] | None = None
    """Names of two parts each; if None, all of different bodies."""
    touching: tuple[Names, ...] = ()
    """Those that touch or overlap while mated: measured once they have parted."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class PrintedResult:
    """What a publication prints of a worst case, after the paper's Table 4.

    Raises:
        ValueError: a number is not finite.
    """

    rate: Vector3
    """Of B after separation, in its axes, rad/s."""
    deviation_within_limits_until: float
    """s."""
    longitudinal_speed: float
    """m/s."""
    iterations: int
    """Of the solver."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_entries("rate", self.rate, 3)
        until = self.deviation_within_limits_until
        check_finite("deviation_within_limits_until", until)
        check_finite("longitudinal_speed", self.longitudinal_speed)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedCase:
    """A worst case that a publication gives.

    Raises:
        ValueError: the label cannot stand in the name of a file, or an objective is
            none of the paper's.
    """

    label: str
    """Of its run in tables and plots; of letters, digits, _ and -."""
    values: Mapping[str, float]
    """Of parameters by name, in SI; the others are nominal."""
    objectives: tuple[str, ...] = ()
    """Of the paper, whose worst case it is said to be."""
    printed: PrintedResult | None = None
    """What it prints of the run."""

    def __post_init__(self) -> None:
        """Check the values."""
        object.__setattr__(self, "values", FrozenMapping(self.values))
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", self.label):
            raise InputError(
                f"published: label must be made of letters, digits, _ and -, "
                f"got {self.label!r}"
            )
        for name in self.objectives:
            if name not in OBJECTIVES:
                message = unknown("objective", name, OBJECTIVES)
                raise InputError(f"published: {self.label}: {message}")


@typed
@dataclass(frozen=True, kw_only=True)
class AnalysisCase:
    """A separation with its tolerances and requirements.

    Attributes:
        tolerance_set: what the tolerances admit, and can exist; made of the tolerances
            and ellipsoids around the separation's own values.
        joint_distribution: of the dispersed parameters, as a campaign draws them.

    Raises:
        ValueError: a tolerance, an ellipsoid, a correlation, a requirement, a pair of
            parts or a published or failure case does not fit the separation, or the
            others.
    """

    separation: Separation
    name: str = "case"
    """In titles."""
    integration: Integration = field(default_factory=Integration)
    """How runs are integrated in Drake."""
    tolerances: Mapping[str, Tolerance] = field(default_factory=dict)
    """About the separation's values, by parameter name, in SI: a number, to either
    side; `Sides`; or a distribution, which says what searches look at."""
    ellipsoids: tuple[Ellipsoid, ...] = ()
    """Dispersed parameters that do not all reach their tolerances together."""
    correlations: tuple[RankCorrelation, ...] = ()
    """Of dispersed parameters in a campaign; searches do not look at them."""
    requirements: tuple[Requirement, ...] = ()
    """Limits on metrics; of two on the same, to the same side, each has an id."""
    objectives: Literal["paper"] | None = None
    """What is looked at beside the requirements: the paper's objectives, or nothing."""
    clearance: ClearancePairs = field(default_factory=ClearancePairs)
    published: tuple[PublishedCase, ...] = ()
    """Worst cases that others have found."""
    failure_cases: tuple[FailureCase, ...] = ()
    """What may go wrong, each of which is verified on request."""
    failure_probabilities: Mapping[str, float] = field(default_factory=dict)
    """Of failure cases, by name, in a launch of a campaign; the others do not happen
    there, nor do two together."""
    tolerance_set: ToleranceSet = field(init=False, repr=False, compare=False)
    joint_distribution: JointDistribution = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Check the values, and build the set of the tolerances."""
        with named("clearance"):
            part_pairs(self.separation, self.clearance.pairs)
            part_pairs(self.separation, self.clearance.touching)
        object.__setattr__(self, "tolerances", FrozenMapping(self.tolerances))
        box = ToleranceBox.around(self.separation, self.tolerances)
        with named("ellipsoids"):
            admitted = ToleranceSet(self.separation, box, self.ellipsoids)
        object.__setattr__(self, "tolerance_set", admitted)
        joint = JointDistribution(box, self.correlations, self.ellipsoids)
        object.__setattr__(self, "joint_distribution", joint)
        self._check_requirements()
        self._check_parts_measured()
        self._check_objectives()
        self._check_published()
        check_failure_cases(self.separation, self.failure_cases)
        probabilities = FrozenMapping(self.failure_probabilities)
        object.__setattr__(self, "failure_probabilities", probabilities)
        check_probabilities(self.failure_cases, probabilities)

    def _check_parts_measured(self) -> None:
        """Raise InputError if a part's place varies and nothing is measured to it."""
        pairs = part_pairs(self.separation, self.clearance.pairs)
        measured = {name for pair in pairs for name in pair}
        for requirement in self.requirements:
            if requirement.measured_apart:
                measured |= {*(_clearance_named(requirement.metric).parts or ())}
        for name in self.tolerances:
            if name in places_of_parts(self.separation):
                part = ParameterName.of(name).owner
                if part not in measured:
                    raise InputError(
                        f"dispersions: {name}: must be of a part that is measured to "
                        f"one of another body, got {part!r}, which is not: to vary it "
                        "would have no effect"
                    )

    def _check_requirements(self) -> None:
        for requirement in self.requirements:
            metric = requirement.metric
            found = find_metric(metric)
            if found is None or metric not in found[0].names:
                known = [name for one in registered_metrics() for name in one.names]
                raise InputError(f"requirements: {unknown('metric', metric, known)}")
        check_limits(self.requirements)
        for requirement in self.requirements:
            with named("requirements"):
                self._check_owner(requirement)
                if requirement.measured_apart:
                    self._check_parts(requirement.metric)
                else:
                    self._check_within(requirement)

    def _check_within(self, requirement: Requirement) -> None:
        """Raise InputError if a time within limits is required, and there are none."""
        judge = metric_named(requirement.judged_by)
        limits = self.limits_of_pairs.get(requirement.pair, NO_LIMITS)
        within = judge.functional is Functional.TIME_WITHIN
        if within and not any(map(math.isfinite, limits)):  # until the end
            raise InputError(
                f"{requirement.metric}: needs a requirement '<=' on {DEVIATION}, "
                "got none"
            )

    def _check_parts(self, metric: str) -> None:
        """Raise InputError unless there are parts whose clearance is asked for."""
        asked = _clearance_named(metric)
        bodies = [body.name for body in self.separation.bodies]
        B = asked.pair or self.separation.B
        if asked.to and asked.to not in bodies:
            raise InputError(f"{metric}: {unknown('body', asked.to, bodies)}")
        if asked.to == B:
            raise InputError(f"{metric}: must be to another body than {B}")
        if asked.pair and asked.parts:
            raise InputError(f"{metric}: must not name a body: its parts say whose")
        if asked.pair and not asked.to:
            raise InputError(
                f"{metric}: must say to which body, such as {metric}_to_"
                f"{self.separation.pair_of(B).A}"
            )
        with named(metric):
            apart = self._parts_apart(asked)
        if not apart:
            which = f"{B} and {asked.to}" if asked.to else "two bodies"
            raise InputError(
                f"{metric} needs geometry on {which} that does not touch while mated, "
                "got none"
            )

    def _parts_apart(self, clearance: Metric) -> list[Names]:
        """Return the pairs of parts that a clearance is of."""
        of = self.clearance
        if clearance.parts:
            return part_pairs(self.separation, [clearance.parts])
        pairs = pairs_apart(self.separation, of.pairs, of.touching)
        if not clearance.to:
            return pairs
        ends = {clearance.pair or self.separation.B, clearance.to}
        owners = owners_of(self.separation)
        return [(a, b) for a, b in pairs if {owners[a], owners[b]} == ends]

    def _leaving(self, clearance: Metric) -> list[str]:
        """Return the bodies whose way ends a clearance's window.

        That which it names; or those of its parts that leave; or all, if none does.
        """
        if clearance.to:
            return [clearance.pair or self.separation.B]
        leave = [pair.B for pair in self.separation.pairs]
        owners = owners_of(self.separation)
        mine = {owners[part] for part in clearance.parts or ()}
        return [B for B in leave if B in mine] or leave

    def _check_owner(self, requirement: Requirement) -> None:
        """Raise InputError unless there is what a requirement is about."""
        separation, name = self.separation, requirement.pair
        if requirement.owner is Owner.PAIR:
            known = ["", *(pair.B for pair in separation.others)]
        else:
            of_springs = requirement.owner is Owner.SPRING
            known = [*separation.owners_of_forces(springs=of_springs)]
        if name not in known:
            why = unknown(requirement.owner.value, name, known)
            raise InputError(f"{requirement.metric}: {why}")

    def _check_objectives(self) -> None:
        if self.objectives not in ("paper", None):
            raise InputError(
                f"objectives: must be 'paper' or left out, got {self.objectives!r}"
            )
        if self.published and not self.objectives:
            raise InputError(
                "published: worst cases of the paper's objectives need "
                "'objectives: paper' beside them, got none"
            )

    def _check_published(self) -> None:
        labels = [published.label for published in self.published]
        for published in self.published:
            if labels.count(published.label) > 1:
                raise InputError(
                    f"published: label {published.label!r} must stand once"
                )
            with named(f"published: {published.label}"):
                with_values(self.separation, published.values)

    def in_failure(self, failure: FailureCase) -> Self:
        """Return the case in which something has failed.

        What has failed does not vary. Ellipsoids and correlations lose it: what else is
        in them goes together as before. There are no published worst cases of it.

        Args:
            failure: what has.

        Raises:
            ValueError: a value is not physical.
        """
        free = {k: t for k, t in self.tolerances.items() if k not in failure.values}
        return replace(
            self,
            separation=with_values(self.separation, failure.values),
            tolerances=free,
            ellipsoids=tuple(
                kept
                for ellipsoid in self.ellipsoids
                if (kept := ellipsoid.without(failure.values)) is not None
            ),
            correlations=tuple(
                rest
                for correlation in self.correlations
                if (rest := correlation.without(failure.values)) is not None
            ),
            published=(),
            failure_cases=(),
            failure_probabilities={},
        )

    @property
    def box(self) -> ToleranceBox:
        """The tolerances, without ellipsoids and without what can exist."""
        return self.tolerance_set.box

    @property
    def deviation_limits(self) -> tuple[float, ...]:
        """(3,) limits of roll, pitch and yaw, rad; infinite where there is none.

        Those of the first pair.
        """
        return deviation_limits(self.requirements)

    @property
    def limits_of_pairs(self) -> dict[str, tuple[float, ...]]:
        """The same of each pair, by its B; those of the first by an empty name."""
        pairs = ["", *(pair.B for pair in self.separation.others)]
        return {pair: deviation_limits(self.requirements, pair) for pair in pairs}

    @property
    def has_clearance(self) -> bool:
        """Whether parts of two bodies may come near each other."""
        of = self.clearance
        return bool(pairs_apart(self.separation, of.pairs, of.touching))

    @functools.cached_property
    def share_unphysical(self) -> float:
        """The share of the tolerances whose inertias no body can have."""
        return self.tolerance_set.share_unphysical()

    @property
    def objective_names(self) -> tuple[str, ...]:
        """Names of the case's objectives: the paper's, and of each requirement."""
        names = [objective.name for objective in self.paper_objectives]
        names += [name for r in self.requirements for name in self.names_towards(r)]
        names += [o.name for o in (*self._until_violation, *self.ends_of_windows)]
        return tuple(dict.fromkeys(names))

    @property
    def paper_objectives(self) -> tuple[Objective, ...]:
        """The paper's, Eq. 11-14, if the case asks for them."""
        return tuple(OBJECTIVES.values()) if self.objectives else ()

    @property
    def requirement_objectives(self) -> tuple[Objective, ...]:
        """What leads out of each requirement.

        Beside the paper's objectives also the time to a deviation's limit, which the
        paper's Table 4 has, of each pair that has one. And of clearances that matter
        until B has moved so far, what keeps it back: where it does not get there, there
        is no verdict.
        """
        objectives = [o for limit in self.requirements for o in self.towards(limit)]
        objectives += [*self._until_violation, *self.ends_of_windows]
        return tuple({objective.name: objective for objective in objectives}.values())

    @property
    def _until_violation(self) -> tuple[Objective, ...]:
        if not self.objectives:
            return ()
        return tuple(
            lowest(f"{pair}.{WITHIN}" if pair else WITHIN)
            for pair, limits in self.limits_of_pairs.items()
            if any(map(math.isfinite, limits))
        )

    @property
    def ends_of_windows(self) -> tuple[Objective, ...]:
        """What keeps bodies from the ends of clearances' windows."""
        required = [r.metric for r in self.requirements if r.measured_apart]
        windows = [
            one
            for one in map(_clearance_named, required)
            if one.until_separation is not None
        ]
        moving = {B for one in windows for B in self._leaving(one)}
        first, *others = (pair.B for pair in self.separation.pairs)
        return tuple(
            lowest(f"{prefix}{_PROGRESS}")
            for B, prefix in ((first, ""), *((B, f"{B}.") for B in others))
            if B in moving
        )

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of the metrics of every run that judge the requirements."""
        judges = [r.judged_by for r in self.requirements if not r.measured_apart]
        return tuple(dict.fromkeys(judges))

    def tells(self, requirement: Requirement) -> bool:
        """Return whether runs tell of a requirement: see `Metric.told_by`."""
        found = find_metric(requirement.judged_by)
        return found is not None and found[0].told_by(self.separation)

    def towards(self, requirement: Requirement) -> tuple[Objective, ...]:
        """Return the objectives that lead out of a requirement.

        None, if no run tells of it.
        """
        if requirement.measured_apart:
            return (self.lowest_clearance(requirement.metric),)
        return towards(requirement) if self.tells(requirement) else ()

    def names_towards(self, requirement: Requirement) -> tuple[str, ...]:
        """Return the names of the objectives that lead out of a requirement."""
        if requirement.measured_apart:  # without importing what measures it
            return (f"lowest_{requirement.metric}",)
        return tuple(objective.name for objective in self.towards(requirement))

    def lowest_clearance(self, metric: str = CLEARANCE) -> "LowestClearance":
        """Return a new objective that makes the smallest distance small.

        Args:
            metric: name of the clearance, which says of what and until when; see
                `drakesep.analysis.metrics.clearances`.

        Raises:
            ValueError: there is no such clearance, or there are no parts of such bodies
                that do not touch while mated.
        """
        # Here, since it imports Drake: a case is read without.
        from drakesep.analysis.clearance.objective import LowestClearance

        self._check_parts(metric)
        asked = _clearance_named(metric)
        return LowestClearance(
            self.separation,
            self._parts_apart(asked),
            touching=self.clearance.touching,
            until_separation=asked.until_separation,
            leaving=self._leaving(asked),
            metric=metric,
        )


_PROGRESS = "longitudinal_displacement_at_end"
"""Metric of how far B of a pair gets in its direction."""


def _clearance_named(metric: str) -> Metric:
    """Return the metric of a clearance.

    Raises:
        ValueError: there is none of this name.
    """
    found = find_metric(metric)
    if found is None or found[0].of_every_run:
        raise InputError(unknown("clearance", metric, [CLEARANCE]))
    return found[0]
