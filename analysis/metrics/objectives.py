"""What makes a separation bad: objectives, to be maximised.

An objective is a metric of a run, in either direction, or any function of a `Run`; or a
sum, a multiple or the largest of such. The four of the paper look at the motion of B
relative to A from release to the end of the run.
"""

import copy
import enum
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple, Self, TypeAlias

import numpy as np

from drakesep.analysis.metrics.combining_rules import Largest, Rule, WeightedSum
from drakesep.analysis.metrics.of_run import (
    check_windowed,
    metric_named,
    metric_of_run,
    metric_within,
)
from drakesep.analysis.metrics.registry import METRICS, find_metric, registered_metrics
from drakesep.analysis.metrics.requirements import Limits as Limits
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.parameter_table import with_axis
from drakesep.systems.model.run import Run


ObjectiveName: TypeAlias = Literal["L1", "L2", "Linf", "PM"]
"""Of the paper."""
Metrics: TypeAlias = Mapping[str, Array]
"""Of one run or of many, by name."""
Window: TypeAlias = tuple[float, float]
"""From when to when, s."""


class About(NamedTuple):
    """An objective at a run, and what it is like around."""

    value: float
    """Of the objective, in SI."""
    near: "Callable[[Run], float]"
    """Of runs all but equal: of the same value there, and the same slope."""
    ended: bool = True
    """Whether all that is looked at is within the run; else the value may rise yet."""
    at_least: "Callable[[Run], float] | None" = None
    """Of runs with other values: what the objective is not below, if that is known."""


class Needs(enum.IntEnum):
    """What an objective is told from, the cheapest first."""

    METRICS = 0
    """The metrics of a run: no motion is needed, and derivatives are exact."""
    RUN = 1
    """A whole run, with its motion."""
    MEASUREMENT = 2
    """A measurement of a run that takes longer than to fly it."""


class SignedMetric(NamedTuple):
    """A metric, or less it; or a function of a run."""

    name: str
    sign: float
    unit: str | None = None
    """Of what is no metric of the registry, but a function of a run."""

    def value(self, objective: float) -> float:
        """Return the metric where an objective that is this has a value."""
        return self.sign * objective


class Objective(ABC):
    """A number for each run, to be maximised.

    Objectives add up, take factors, and negate: ``highest("G_L1") + 2.0 * mine``.

    Attributes:
        name: in tables.
        needs: what it is told from.
        shown_as: the metric that tables show for it; None: its own value, in SI.
    """

    name: str
    needs: Needs = Needs.RUN
    shown_as: SignedMetric | None = None

    @property
    def expensive(self) -> bool:
        """Whether it takes longer to tell than its run to fly.

        Searches that fly very many runs leave it out, beside others.
        """
        return self.needs is Needs.MEASUREMENT

    def __call__(self, run: Run) -> float:
        """Return the objective of a completed run, with no limits of deviations."""
        return self.of_run(run, (math.inf,) * 3)

    @abstractmethod
    def of_run(self, run: Run, limits: Limits) -> float:
        """Return the objective of a completed run.

        Args:
            run: a completed run.
            limits: of the deviations, as `metrics_of_run` takes them.
        """

    def about(self, run: Run, limits: Limits) -> About:
        """Return the objective of a completed run, and what it is like around.

        Itself, unless something smoother or sooner told has the same slope.

        Args:
            run: a completed run.
            limits: of the deviations, as `metrics_of_run` takes them.
        """
        return About(self.of_run(run, limits), lambda near: self.of_run(near, limits))

    def resolution(self, accuracy: float) -> float:
        """Return by how much it may differ in two runs that are equal but for errors.

        Args:
            accuracy: of the runs' motion, in SI.
        """
        return accuracy

    def named(self, name: str) -> Self:
        """Return the same objective under another name."""
        new = copy.copy(self)
        new.name = name
        return new

    def __add__(self, other: "AnyObjective") -> "Objective":
        return _sum([self, as_objective(other)], [1.0, 1.0])

    def __radd__(self, other: "AnyObjective | int") -> "Objective":
        # sum() begins with 0
        return self if isinstance(other, int) else as_objective(other) + self

    def __mul__(self, factor: float) -> "Objective":
        return _sum([self], [float(factor)])

    __rmul__ = __mul__

    def __neg__(self) -> "Objective":
        return _sum([self], [-1.0])

    def __sub__(self, other: "AnyObjective") -> "Objective":
        return _sum([self, as_objective(other)], [1.0, -1.0])


@typed
class MetricObjective(Objective):
    """An objective that the metrics of a run alone tell."""

    needs = Needs.METRICS

    @property
    @abstractmethod
    def reads(self) -> frozenset[str]:
        """Names of the metrics that it is made of."""

    @abstractmethod
    def of_metrics(self, metrics: Metrics) -> Array:
        """Return the objective (...,) of metrics.

        Args:
            metrics: (...,) each, in SI; those it is made of, or more.
        """

    @abstractmethod
    def weights(self, metrics: Metrics) -> dict[str, Array]:
        """Return its derivatives (...,) with the metrics that it is made of.

        Args:
            metrics: (...,) each, in SI; those it is made of, or more.
        """


class LargestOfParts(Objective):
    """An objective that is the largest of parts, which can be looked at apart."""

    @abstractmethod
    def about(self, run: Run, limits: Limits, at_least: float = -math.inf) -> About:
        """Return the objective of a completed run, and what it is like around.

        Args:
            run: a completed run.
            limits: of the deviations, as `metrics_of_run` takes them.
            at_least: a value that it is known to have, or to exceed: then it is sooner
                told.
        """

    @abstractmethod
    def linearised_parts(
        self, run: Run, around: Sequence[Run], reach: Array | None = None
    ) -> tuple[Array, Array]:
        """Return the parts at some moments of a run, and their changes around it.

        Args:
            run: a completed run.
            around: (r,) completed runs with other values.
            reach: (r,) how many times such changes may add up: what stays below the
                largest even so need not be told, and is -inf.

        Returns:
            (p, t) values of p parts at t moments; and (p, t, r) their changes, to first
            order.
        """


AnyObjective: TypeAlias = Objective | str | Callable[[Run], float]
"""An objective, its name, or a function of a run; see `as_objective`."""


class _OfMetric(MetricObjective):
    """A metric of a run, or less it."""

    def __init__(self, metric: str, sign: float, name: str):
        metric_named(metric)
        self.name = name
        self.shown_as = SignedMetric(metric, sign)
        self._metric, self._sign = metric, sign

    def of_run(self, run: Run, limits: Limits) -> float:
        return self._sign * metric_of_run(run, self._metric, limits)

    @property
    def reads(self) -> frozenset[str]:
        return frozenset([self._metric])

    def of_metrics(self, metrics: Metrics) -> Array:
        return np.asarray(self._sign * metrics[self._metric])

    def weights(self, metrics: Metrics) -> dict[str, Array]:
        return {self._metric: np.full_like(metrics[self._metric], self._sign)}


class _OfRunMetric(Objective):
    """A metric that whole runs tell, or less it."""

    def __init__(self, metric: str, sign: float, name: str):
        metric_named(metric)
        self.name = name
        self.shown_as = SignedMetric(metric, sign)
        self._metric, self._sign = metric, sign

    def of_run(self, run: Run, limits: Limits) -> float:
        return self._sign * metric_of_run(run, self._metric, limits)


class _OfWindow(Objective):
    """A metric of a part of a run, or less it."""

    def __init__(self, metric: str, sign: float, name: str, window: Window):
        check_windowed(metric_named(metric), metric)
        self.name = name
        self.shown_as = SignedMetric(metric, sign)
        self._metric, self._sign, self._window = metric, sign, window

    def of_run(self, run: Run, limits: Limits) -> float:
        return self._sign * metric_within(run, self._metric, self._window)


class _OfRun(Objective):
    """Any function of a run."""

    def __init__(self, function: Callable[[Run], float], name: str):
        self.name = name
        self._function = function

    def of_run(self, run: Run, limits: Limits) -> float:
        return float(self._function(run))


class _Composite(Objective):
    """What a rule makes of several objectives."""

    def __init__(self, terms: Sequence[Objective], rule: Rule, name: str):
        self.name = name
        self.needs = max(term.needs for term in terms)
        self._terms, self._rule = tuple(terms), rule

    def resolution(self, accuracy: float) -> float:
        each = [term.resolution(accuracy) for term in self._terms]
        return self._rule.resolution(np.array(each))

    def of_run(self, run: Run, limits: Limits) -> float:
        each = [term.of_run(run, limits) for term in self._terms]
        return float(self._rule.value(np.array(each)))

    def about(self, run: Run, limits: Limits) -> About:
        each = [term.about(run, limits) for term in self._terms]
        values = np.array([one.value for one in each])
        slopes = self._rule.slopes(values)
        felt = np.flatnonzero(slopes)  # what is not the largest need not be told

        def near(other: Run) -> float:
            return float(slopes[felt] @ [each[i].near(other) for i in felt])

        ended = all(one.ended for one in each)
        return About(float(self._rule.value(values)), near, ended)


class _CompositeOfMetrics(_Composite, MetricObjective):
    """What a rule makes of objectives that metrics alone tell."""

    def __init__(self, terms: Sequence[MetricObjective], rule: Rule, name: str):
        super().__init__(terms, rule, name)
        self._told = tuple(terms)

    @property
    def reads(self) -> frozenset[str]:
        return frozenset[str]().union(*(term.reads for term in self._told))

    def _each(self, metrics: Metrics) -> Array:
        return np.stack([term.of_metrics(metrics) for term in self._told], axis=-1)

    def of_metrics(self, metrics: Metrics) -> Array:
        return self._rule.value(self._each(metrics))

    def weights(self, metrics: Metrics) -> dict[str, Array]:
        slopes = self._rule.slopes(self._each(metrics))
        total: dict[str, Array] = {}
        for k, term in enumerate(self._told):
            for name, weight in term.weights(metrics).items():
                total[name] = total.get(name, 0.0) + slopes[..., k] * weight
        return total


def _composite(terms: Sequence[Objective], rule: Rule, name: str) -> Objective:
    of_metrics = [term for term in terms if isinstance(term, MetricObjective)]
    if len(of_metrics) == len(terms):
        return _CompositeOfMetrics(of_metrics, rule, name)
    return _Composite(terms, rule, name)


def _sum(terms: Sequence[Objective], factors: Sequence[float]) -> Objective:
    if not np.isfinite(factors).all():
        raise InputError(f"factors of a sum must be finite, got {factors}")
    return _composite(terms, WeightedSum(np.array(factors)), _written(terms, factors))


def _written(terms: Iterable[Objective], factors: Iterable[float]) -> str:
    text = ""
    for term, factor in zip(terms, factors, strict=True):
        sign = "-" if factor < 0.0 else "+" if text else ""
        size = "" if abs(factor) == 1.0 else f"{abs(factor):g}*"
        text += f"{sign}{size}{term.name}"
    return text


@typed
def highest(metric: str, *, window: Window | None = None) -> Objective:
    """Return the objective that makes a metric large.

    Args:
        metric: one of `METRICS`, or of a quantity.
        window: from when to when the metric looks instead, s; see `metric_within`.

    Raises:
        ValueError: the metric is unknown, or takes no window.
    """
    return _of_metric(metric, 1.0, "highest", window)


@typed
def lowest(metric: str, *, window: Window | None = None) -> Objective:
    """Return the objective that makes a metric small: less its value.

    Args:
        metric: one of `METRICS`, or of a quantity.
        window: from when to when the metric looks instead, s; see `metric_within`.

    Raises:
        ValueError: the metric is unknown, or takes no window.
    """
    return _of_metric(metric, -1.0, "lowest", window)


@typed
def of_run(function: Callable[[Run], float], name: str = "") -> Objective:
    """Return the objective that is any function of a run.

    Args:
        function: of a completed `Run`; it must give a finite number.
        name: in tables; that of the function if empty.
    """
    return _OfRun(function, name or getattr(function, "__name__", "objective"))


@typed
def largest(*objectives: AnyObjective, name: str = "") -> Objective:
    """Return the largest of objectives, in SI.

    Args:
        objectives: one or more, as `as_objective` takes them.
        name: in tables; made of theirs if empty.

    Raises:
        ValueError: there is none.
    """
    if not objectives:
        raise InputError("largest: must have an objective or more, got none")
    terms = [as_objective(objective) for objective in objectives]
    listed = ", ".join(term.name for term in terms)
    return _composite(terms, Largest(), name or f"largest({listed})")


def _of_metric(
    metric: str, sign: float, which: str, window: Window | None
) -> Objective:
    name = f"{which}_{metric}"
    if window is None:
        told = _OfMetric if metric_named(metric).of_steps else _OfRunMetric
        return told(metric, sign, name)
    return _OfWindow(metric, sign, f"{name}{_suffix(window)}", window)


def _suffix(window: Window) -> str:
    if np.shape(window) != (2,) or not (
        math.isfinite(window[0]) and window[0] < window[1]
    ):
        raise InputError(f"window: must be from one time to a later, got {window} s")
    start, end = window
    return f"_{start:g}_to_{end:g}_s"


OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {
        metric.objective: _OfMetric(metric.stem, 1.0, metric.objective)
        for metric in registered_metrics()
        if metric.objective
    }
)
"""The paper's objectives by name: L1, L2, Linf, PM."""


def towards(requirement: Requirement) -> tuple[Objective, ...]:
    """Return the objectives that lead out of a requirement.

    A limit on a magnitude has two, one for each direction; each is smooth where the
    magnitude has a kink, and finds the other side from the wrong one.

    Args:
        requirement: on a metric of every run.

    Raises:
        ValueError: there is no such metric.
    """
    name = requirement.judged_by
    if not requirement.from_above:
        return (lowest(name),)
    metric, axis = find_metric(name) or (None, "")
    if metric is None or metric.directions is None:
        return (highest(name),)
    up, down = (with_axis(stem, axis) for stem in metric.directions)
    return highest(up).named(f"{name}_up"), lowest(down).named(f"{name}_down")


def as_objective(objective: AnyObjective, also: Iterable[str] = ()) -> Objective:
    """Return an objective from its name, or from a function of a run.

    Args:
        objective: an objective; a name of the paper's; ``highest_`` or ``lowest_`` and
            a metric of `METRICS`; or a function of a run.
        also: other names that are known, to be suggested.

    Raises:
        ValueError: no such objective.
    """
    if isinstance(objective, Objective):
        return objective
    if not isinstance(objective, str):
        return of_run(objective)
    if objective in OBJECTIVES:
        return OBJECTIVES[objective]
    for prefix, make in (("highest_", highest), ("lowest_", lowest)):
        if objective.startswith(prefix):
            return make(objective.removeprefix(prefix))
    metrics = [f"{p}_{name}" for name in METRICS for p in ("highest", "lowest")]
    known = list(dict.fromkeys([*OBJECTIVES, *also, *metrics]))
    raise InputError(unknown("objective", objective, known))
