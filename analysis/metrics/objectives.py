"""What makes a separation bad: objectives, to be maximised.

An objective is a metric of a run, in either direction, or any function of a `Run`; or a
sum, a multiple or the largest of such. The four of the paper look at the motion of B
relative to A from release to the end of the run.
"""

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple, Self, TypeAlias

import numpy as np

from drakesep.analysis.metrics.of_run import (
    ANGLES,
    AXES,
    METRICS,
    WINDOWED,
    metric_within,
    metrics_of_run,
)
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, unknown
from drakesep.systems.model.run import Run


ObjectiveName: TypeAlias = Literal["L1", "L2", "Linf", "PM"]
"""Of the paper."""
Limits: TypeAlias = Sequence[float]
"""(3,) of roll, pitch and yaw, rad; see `metrics_of_run`."""
Window: TypeAlias = tuple[float, float]
"""From when to when, s."""


class About(NamedTuple):
    """An objective at a run, and what it is like around."""

    value: float
    """Of the objective, in SI."""
    near: "Callable[[Run], float]"
    """Of runs all but equal: of the same value there, and the same slope."""


class Objective(ABC):
    """A number for each run, to be maximised.

    Objectives add up, take factors, and negate: ``highest("G_L1") + 2.0 * mine``.

    Attributes:
        name: in tables.
        of_metrics_alone: whether the metrics of a run tell the objective, so that no
            motion is needed, and its derivatives are exact.
        metric: that it is, or less it; None if it is something else.
        sign: 1, or -1 if it is less its metric.
        expensive: whether it takes longer to tell than its run to fly: searches that
            fly very many runs leave it out, beside others.
        has_parts: whether it is the largest of parts that `parts` tells.
    """

    name: str
    of_metrics_alone: bool
    metric: str | None = None
    sign: float = 1.0
    expensive: bool = False
    has_parts: bool = False

    def __call__(self, run: Run) -> float:
        """Return the objective of a completed run, with no limits of deviations."""
        return self.of_run(run, (math.inf,) * 3)

    @abstractmethod
    def of_run(self, run: Run, limits: Limits) -> float:
        """Return the objective of a completed run.

        Args:
            run: a completed run.
            limits: (3,) of the deviations, as `metrics_of_run` takes them.
        """

    def about(self, run: Run, limits: Limits) -> About:
        """Return the objective of a completed run, and what it is like around.

        Itself, unless something smoother or sooner told has the same slope.

        Args:
            run: a completed run.
            limits: (3,) of the deviations, as `metrics_of_run` takes them.
        """
        return About(self.of_run(run, limits), lambda near: self.of_run(near, limits))

    def resolution(self, accuracy: float) -> float:
        """Return by how much it may differ in two runs that are equal but for errors.

        Args:
            accuracy: of the runs' motion, in SI.
        """
        return accuracy

    def parts(self, run: Run, around: Sequence[Run]) -> tuple[Array, Array]:
        """Return what the objective is the largest of, if it `has_parts`.

        Args:
            run: a completed run.
            around: (r,) completed runs with other values.

        Returns:
            (p, t) values of p parts at t moments; and (p, t, r) their changes, to first
            order.
        """
        raise TypeError(f"{self.name} has no parts")

    def of_metrics(self, metrics: Array) -> Array:
        """Return the objective (...,) of metrics (..., n_m), in the order of METRICS.

        Raises:
            TypeError: it needs the whole run.
        """
        raise TypeError(f"{self.name} is a function of a whole run")

    def weights(self, metrics: Array) -> Array:
        """Return the derivatives (..., n_m) of the objective with the metrics.

        Raises:
            TypeError: it needs the whole run.
        """
        raise TypeError(f"{self.name} is a function of a whole run")

    def named(self, name: str) -> Self:
        """Return the same objective under another name."""
        new = copy.copy(self)
        new.name = name
        return new

    def __add__(self, other: "AnyObjective") -> "Objective":
        return _Sum([self, as_objective(other)], [1.0, 1.0])

    def __radd__(self, other: "AnyObjective | int") -> "Objective":
        # sum() begins with 0
        return self if isinstance(other, int) else as_objective(other) + self

    def __mul__(self, factor: float) -> "Objective":
        return _Sum([self], [float(factor)])

    __rmul__ = __mul__

    def __neg__(self) -> "Objective":
        return _Sum([self], [-1.0])

    def __sub__(self, other: "AnyObjective") -> "Objective":
        return _Sum([self, as_objective(other)], [1.0, -1.0])


AnyObjective: TypeAlias = Objective | str | Callable[[Run], float]
"""An objective, its name, or a function of a run; see `as_objective`."""


class _OfMetric(Objective):
    """A metric of a run, or less it."""

    def __init__(self, metric: str, sign: float, name: str, window: Window | None):
        if metric not in METRICS:
            raise InputError(unknown("metric", metric, METRICS))
        if window is not None and metric not in WINDOWED:
            raise InputError(
                f"window: must be of one of {', '.join(WINDOWED)}, got {metric}"
            )
        self.name = name
        self.of_metrics_alone = window is None
        self.metric, self.sign, self._window = metric, sign, window
        self._column = METRICS.index(metric)

    def of_run(self, run: Run, limits: Limits) -> float:
        metric = str(self.metric)
        if self._window is not None:
            return self.sign * metric_within(run, metric, self._window)
        return self.sign * metrics_of_run(run, limits)[metric]

    def of_metrics(self, metrics: Array) -> Array:
        return self.sign * metrics[..., self._column]

    def weights(self, metrics: Array) -> Array:
        weights = np.zeros_like(metrics)
        weights[..., self._column] = self.sign
        return weights


class _OfRun(Objective):
    """Any function of a run."""

    of_metrics_alone = False

    def __init__(self, function: Callable[[Run], float], name: str):
        self.name = name
        self._function = function

    def of_run(self, run: Run, limits: Limits) -> float:
        return float(self._function(run))


class _Together(Objective):
    """Something made of several objectives."""

    def __init__(self, terms: Sequence[Objective], name: str):
        self.name = name
        self._terms = tuple(terms)
        self.of_metrics_alone = all(term.of_metrics_alone for term in terms)
        self.expensive = any(term.expensive for term in terms)

    def _each_of_metrics(self, metrics: Array) -> Array:
        return np.stack([term.of_metrics(metrics) for term in self._terms], axis=-1)

    def _each_of_run(self, run: Run, limits: Limits) -> list[float]:
        return [term.of_run(run, limits) for term in self._terms]

    def _each_weights(self, metrics: Array) -> Array:
        return np.stack([term.weights(metrics) for term in self._terms], axis=-2)


class _Sum(_Together):
    """A weighted sum of objectives."""

    def __init__(
        self, terms: Sequence[Objective], factors: Sequence[float], name: str = ""
    ):
        factors = [float(factor) for factor in factors]
        if not np.isfinite(factors).all():
            raise InputError(f"factors of a sum must be finite, got {factors}")
        super().__init__(terms, name or _written(terms, factors))
        self._factors = np.array(factors)

    def resolution(self, accuracy: float) -> float:
        each = [term.resolution(accuracy) for term in self._terms]
        return float(np.abs(self._factors) @ each)

    def of_run(self, run: Run, limits: Limits) -> float:
        return float(self._factors @ self._each_of_run(run, limits))

    def about(self, run: Run, limits: Limits) -> About:
        each = [term.about(run, limits) for term in self._terms]

        def near(other: Run) -> float:
            return float(self._factors @ [one.near(other) for one in each])

        return About(float(self._factors @ [one.value for one in each]), near)

    def of_metrics(self, metrics: Array) -> Array:
        return np.asarray(self._each_of_metrics(metrics) @ self._factors)

    def weights(self, metrics: Array) -> Array:
        each = self._each_weights(metrics)
        return np.asarray(np.einsum("...tm,t->...m", each, self._factors))


class _Largest(_Together):
    """The largest of objectives; where two are as large, the slope of the first."""

    def __init__(self, terms: Sequence[Objective], name: str):
        super().__init__(terms, name)

    def resolution(self, accuracy: float) -> float:
        return max(term.resolution(accuracy) for term in self._terms)

    def of_run(self, run: Run, limits: Limits) -> float:
        return max(self._each_of_run(run, limits))

    def about(self, run: Run, limits: Limits) -> About:
        each = [term.about(run, limits) for term in self._terms]
        return max(each, key=lambda one: one.value)

    def of_metrics(self, metrics: Array) -> Array:
        return np.asarray(self._each_of_metrics(metrics).max(axis=-1))

    def weights(self, metrics: Array) -> Array:
        which = self._each_of_metrics(metrics).argmax(axis=-1)
        each = self._each_weights(metrics)
        picked = np.take_along_axis(each, which[..., None, None], axis=-2)
        return np.asarray(picked[..., 0, :])


def _written(terms: Iterable[Objective], factors: Iterable[float]) -> str:
    text = ""
    for term, factor in zip(terms, factors, strict=True):
        sign = "-" if factor < 0.0 else "+" if text else ""
        size = "" if abs(factor) == 1.0 else f"{abs(factor):g}*"
        text += f"{sign}{size}{term.name}"
    return text


def highest(metric: str, *, window: Window | None = None) -> Objective:
    """Return the objective that makes a metric large.

    Args:
        metric: one of `METRICS`.
        window: from when to when the metric looks instead, s; see `metric_within`.

    Raises:
        ValueError: the metric is unknown, or takes no window.
    """
    return _OfMetric(metric, 1.0, f"highest_{metric}{_suffix(window)}", window)


def lowest(metric: str, *, window: Window | None = None) -> Objective:
    """Return the objective that makes a metric small: less its value.

    Args:
        metric: one of `METRICS`.
        window: from when to when the metric looks instead, s; see `metric_within`.

    Raises:
        ValueError: the metric is unknown, or takes no window.
    """
    return _OfMetric(metric, -1.0, f"lowest_{metric}{_suffix(window)}", window)


def of_run(function: Callable[[Run], float], name: str = "") -> Objective:
    """Return the objective that is any function of a run.

    Args:
        function: of a completed `Run`; it must give a finite number.
        name: in tables; that of the function if empty.

    Raises:
        ValueError: it is no function.
    """
    if not callable(function):
        raise InputError(f"objective: must be a function of a run, got {function!r}")
    return _OfRun(function, name or getattr(function, "__name__", "objective"))


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
    return _Largest(terms, name or f"largest({listed})")


def _suffix(window: Window | None) -> str:
    if window is None:
        return ""
    if np.shape(window) != (2,) or not (
        math.isfinite(window[0]) and window[0] < window[1]
    ):
        raise InputError(f"window: must be from one time to a later, got {window} s")
    start, end = window
    return f"_{start:g}_to_{end:g}_s"


OBJECTIVES: Mapping[str, Objective] = MappingProxyType(
    {
        name.removeprefix("G_"): _OfMetric(name, 1.0, name.removeprefix("G_"), None)
        for name in METRICS
        if name.startswith("G_")
    }
)
"""The paper's objectives by name: L1, L2, Linf, PM."""

TWO_SIDED = {
    **{
        f"rate_after_separation_{axis}": (
            f"rate_max_after_separation_{axis}",
            f"rate_min_after_separation_{axis}",
        )
        for axis in AXES
    },
    **{
        f"deviation_at_separation_{angle}": (f"angle_at_separation_{angle}",) * 2
        for angle in ANGLES
    },
}
"""Metrics that are magnitudes, with the metrics of their two directions."""


def towards(requirement: Requirement) -> tuple[Objective, ...]:
    """Return the objectives that lead out of a requirement.

    A limit on a magnitude has two, one for each direction; each is smooth where the
    magnitude has a kink, and finds the other side from the wrong one.
    """
    metric = requirement.judged_by
    if requirement.sense == ">=":
        return (lowest(metric),)
    if metric not in TWO_SIDED:
        return (highest(metric),)
    up, down = TWO_SIDED[metric]
    return (
        highest(up).named(f"{metric}_up"),
        lowest(down).named(f"{metric}_down"),
    )


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
