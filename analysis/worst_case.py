"""The worst case over the tolerances, by sequential quadratic programming (Eq. 10).

As in the paper: from one start, with gradients by finite differences, n_p + 1 runs
an iteration. It finds a local maximum, not always the global one.
"""

import enum
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import Bounds, minimize

from drakesep.analysis.dispersions import Array, Box
from drakesep.analysis.objectives import Objective
from drakesep.analysis.physical_set import PhysicalSet
from drakesep.systems.checks import InputError
from drakesep.systems.run import Run, RunStatus


Fly: TypeAlias = Callable[[Sequence[Mapping[str, float]]], list[Run]]
"""Flies variations, given as parameter values in SI; see `Fleet.fly`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Iteration:
    """One iterate of a search."""

    number: int
    """0 is the start."""
    value: float
    """Of the objective, in SI."""
    u: tuple[float, ...]
    """The scaled point."""
    evaluations: int
    """Runs flown so far."""


class SearchStatus(enum.Enum):
    """How a search ended; the value says it in words."""

    CONVERGED = "converged"
    STALLED = "stopped without further ascent"
    ITERATION_LIMIT = "stopped at the iteration limit"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class WorstCase:
    """The result of a search."""

    u: tuple[float, ...]
    """The worst point found, scaled."""
    values: Mapping[str, float]
    """The same as parameter values, in SI."""
    value: float
    """Of the objective there, in SI."""
    run: Run = field(repr=False)
    """The run there."""
    history: tuple[Iteration, ...] = field(repr=False)
    """Every iterate, from the start."""
    evaluations: int
    """Runs flown."""
    status: SearchStatus
    message: str
    """What the optimiser said at its end."""

    @property
    def iterations(self) -> int:
        """Number of iterations."""
        return self.history[-1].number


def find_worst_case(
    objective: Objective,
    box: Box,
    physical: PhysicalSet,
    fly: Fly,
    *,
    start: Array | None = None,
    step: float = 1e-3,
    tolerance: float = 1e-6,
    max_iterations: int = 50,
    on_iteration: Callable[[Iteration], None] | None = None,
) -> WorstCase:
    """Maximise an objective over the physical part of a box.

    Every point that is flown is in the box and physical: a trial point with an
    impossible inertia is flown where the line from the nominal inertia to it leaves
    the physical set, and the set's margins constrain the search.

    Args:
        objective: to be maximised.
        box: the tolerances.
        physical: the physical part of the box.
        fly: flies variations.
        start: (n,) scaled start; the nominal if None.
        step: of the finite differences, scaled. Large against the integration's
            error, 1e-8 of an objective; small against its curvature.
        tolerance: change of the objective at which the search ends, as a part of
            its value at the start, or of what the first step promises.
        max_iterations: at which the search gives up.
        on_iteration: called with every iterate.

    Raises:
        RuntimeError: the run at the start failed.
        ValueError: the start is outside the box or not physical.
    """
    search = _Search(objective, box, physical, fly, step, on_iteration)
    u0 = np.zeros(len(box)) if start is None else np.asarray(start, dtype=float)
    if not (np.abs(u0) <= 1.0).all() or not physical.contains(u0):
        raise InputError("start must be in the box and physical")
    search.begin(u0)
    try:
        scale = search.scale(u0)
        ftol = tolerance * max(1.0, abs(search.value(u0)) / scale)
        result = minimize(
            lambda u: -search.value(u) / scale,
            u0,
            jac=lambda u: -search.gradient(u) / scale,
            method="SLSQP",
            bounds=Bounds(-1.0, 1.0),
            constraints=_constraints(physical, u0),
            callback=search.log,
            options={"ftol": ftol, "maxiter": max_iterations},
        )
        status = _STATUS.get(result.status, SearchStatus.FAILED)
        return search.end(status, result.message)
    except _RunFailedError as error:
        return search.end(SearchStatus.FAILED, str(error))


def _constraints(physical: PhysicalSet, u: Array) -> list[dict[str, Any]]:
    if not physical.margins(u).size:
        return []
    return [
        {
            "type": "ineq",
            "fun": physical.margins,
            "jac": physical.margins_jacobian,
        }
    ]


_FIRST_SLOPE = 3.0
_SMALLEST_PROBE = 1e-2
_STATUS = {
    0: SearchStatus.CONVERGED,
    8: SearchStatus.STALLED,  # the line search finds no ascent beyond the noise
    9: SearchStatus.ITERATION_LIMIT,
}


class _RunFailedError(Exception):
    """A run that the search needs has failed."""


class _Search:
    """Evaluates an objective and its gradient, and keeps the record."""

    def __init__(
        self,
        objective: Objective,
        box: Box,
        physical: PhysicalSet,
        fly: Fly,
        step: float,
        on_iteration: Callable[[Iteration], None] | None,
    ):
        self._objective = objective
        self._box = box
        self._physical = physical
        self._fly = fly
        self._step = step
        self._on_iteration = on_iteration
        self._evaluations = 0
        self._last: tuple[Array, float, Run] | None = None
        self._slopes: tuple[Array, Array] | None = None
        self._best: tuple[Array, float, Run] | None = None
        self._history: list[Iteration] = []

    def _evaluate(self, points: Sequence[Array]) -> list[tuple[float, Run]]:
        runs = self._fly([self._box.values(point) for point in points])
        self._evaluations += len(points)
        results = []
        for point, run in zip(points, runs, strict=True):
            if run.status is RunStatus.FAILED:
                raise _RunFailedError(
                    f"a run failed: {run.message}; at {self._box.values(point)}"
                )
            value = self._objective(run)
            if not math.isfinite(value):
                raise _RunFailedError(
                    f"the objective must be finite, got {value} "
                    f"at {self._box.values(point)}"
                )
            results.append((value, run))
        return results

    def _flyable(self, u: Array) -> Array:
        return self._physical.draw_back(np.clip(u, -1.0, 1.0))

    def begin(self, u: Array) -> None:
        try:
            self.log(u)
        except _RunFailedError as error:
            raise RuntimeError(f"the start of the search: {error}") from error

    def value(self, u: Array) -> float:
        if self._last is None or not np.array_equal(self._last[0], u):
            point = self._flyable(u)
            [(value, run)] = self._evaluate([point])
            self._last = (np.array(u), value, run)
            if self._best is None or value > self._best[1]:
                self._best = (point, value, run)
        return self._last[1]

    def gradient(self, u: Array) -> Array:
        """Return (n,) one-sided differences, each taken into the physical box."""
        if self._slopes is not None and np.array_equal(self._slopes[0], u):
            return self._slopes[1]
        value = self.value(u)
        point = self._flyable(u)
        probes = [self._probe(point, i) for i in range(len(point))]
        results = self._evaluate(probes)
        steps = np.diagonal(np.array(probes) - point)
        rises = np.array([probe_value - value for probe_value, _ in results])
        slopes = np.zeros(len(point))
        np.divide(rises, steps, out=slopes, where=steps != 0.0)
        self._slopes = (np.array(u), slopes)
        return slopes

    def _probe(self, point: Array, i: int) -> Array:
        step = self._step
        while step > _SMALLEST_PROBE * self._step:
            for side in (step, -step):
                probe = point.copy()
                probe[i] += side
                if abs(probe[i]) <= 1.0 and self._physical.contains(probe):
                    return probe
            step *= 0.5  # near the edge of the physical inertias
        return point  # no room at all: the slope is taken as zero

    def scale(self, u: Array) -> float:
        """Return what to divide the objective by.

        SLSQP starts from a unit Hessian: with a largest slope of `_FIRST_SLOPE`, its
        first step takes the parameters that matter to their bounds.
        """
        return float(np.abs(self.gradient(u)).max(initial=0.0)) / _FIRST_SLOPE or 1.0

    def log(self, u: Array) -> None:
        """Record an iterate; called by the optimiser after each iteration."""
        iteration = Iteration(
            number=len(self._history),
            value=self.value(u),
            u=tuple(self._flyable(u).tolist()),
            evaluations=self._evaluations,
        )
        self._history.append(iteration)
        if self._on_iteration is not None:
            self._on_iteration(iteration)

    def end(self, status: SearchStatus, message: str) -> WorstCase:
        assert self._best is not None  # begin() has evaluated the start
        point, value, run = self._best
        return WorstCase(
            u=tuple(point.tolist()),
            values=self._box.values(point),
            value=value,
            run=run,
            history=tuple(self._history),
            evaluations=self._evaluations,
            status=status,
            message=message,
        )
