"""Sequential quadratic programming from given starts, side by side.

The paper's method: SLSQP from one start finds a local maximum. Many starts go up at
the same time; what they ask for is flown together. Derivatives are exact where the
evaluator knows them, and one-sided differences where it does not.
"""

import enum
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import Bounds, minimize

from drakesep.analysis.engines.evaluator import Evaluator
from drakesep.analysis.search.ask_tell import side_by_side
from drakesep.analysis.tolerances.tolerance_set import ToleranceSet
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_positive


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
    """Points asked for so far; one with its derivatives counts once."""


class SearchStatus(enum.Enum):
    """How a search ended; the value says it in words."""

    CONVERGED = "converged"
    STALLED = "stopped without further ascent"
    ITERATION_LIMIT = "stopped at the iteration limit"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Ascent:
    """What came of one start."""

    objective: int
    """Which of the evaluator's."""
    u: tuple[float, ...]
    """The best point found, scaled; the start if that failed."""
    value: float
    """Of the objective there, in SI; NaN if the start failed."""
    history: tuple[Iteration, ...] = field(repr=False)
    """Every iterate, from the start."""
    evaluations: int
    """Points asked for; one with its derivatives counts once."""
    status: SearchStatus
    message: str
    """What the optimiser said at its end, or why a run failed."""

    @property
    def iterations(self) -> int:
        """Number of iterations."""
        return max(len(self.history) - 1, 0)


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """From where to maximise what over which set."""

    objective: int
    """Which of the evaluator's."""
    tolerances: ToleranceSet
    u: Array
    """(n,) scaled."""
    value: float = math.nan
    """Of the objective there, in SI; NaN if it is not known, and to be flown."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class AscentSettings:
    """How SLSQP goes up.

    Raises:
        ValueError: a number is out of range.
    """

    tolerance: float = 1e-9
    """Change of the objective at which it ends, as a part of its value at the start, or
    of what the first step promises."""
    max_iterations: int = 50
    """At which it gives up."""
    step: float = 1e-3
    """Of differences, where there are no derivatives, scaled. Large against the
    integration's error, 1e-8 of an objective; small against its curvature."""
    differences: bool = False
    """Whether they must do even where there are derivatives."""

    def __post_init__(self) -> None:
        """Check the values."""
        check_positive("tolerance", self.tolerance)
        check_positive("max_iterations", self.max_iterations)
        check_positive("step", self.step)


@typed
def ascend(
    starts: Sequence[Start],
    evaluator: Evaluator,
    settings: AscentSettings | None = None,
    on_iteration: Callable[[int, Iteration], None] | None = None,
) -> list[Ascent]:
    """Maximise from each start.

    Every point that is flown is in the start's set: a trial point beyond it is flown
    where the line from the nominal to it leaves the set, and the set's margins
    constrain the search.

    Args:
        starts: any number, each with its objective and its set.
        evaluator: tells the objectives.
        settings: how to go up.
        on_iteration: called with the number of the start and its iterate.

    Raises:
        ValueError: a start is outside its set.
    """
    settings = settings or AscentSettings()
    for start in starts:
        if np.shape(start.u) != (len(start.tolerances),) or not bool(
            start.tolerances.contains(start.u)
        ):
            raise InputError("start must be in the box and physical")

    untold: list[tuple[int, Iteration]] = []

    def tell() -> None:
        for told in sorted(untold, key=lambda told: (told[0], told[1].number)):
            if on_iteration is not None:
                on_iteration(*told)
        untold.clear()

    def task(i: int) -> Callable[[_Ask], Ascent]:
        def log(iteration: Iteration) -> None:
            untold.append((i, iteration))

        return lambda ask: _Sqp(starts[i], settings, evaluator, ask, log).run()

    def answer(questions: list[_Question]) -> list[_Answer | None]:
        tell()  # here, where one thread at a time comes by
        return _answer(questions, evaluator)

    ascents = side_by_side([task(i) for i in range(len(starts))], answer)
    tell()
    return ascents


def slopes_at(
    points: Sequence[Start],
    evaluator: Evaluator,
    settings: AscentSettings | None = None,
) -> Array:
    """Return the slopes (k, n) at k points, with the scaled parameters; NaN if unknown.

    Args:
        points: with their objectives and sets.
        evaluator: tells the objectives.
        settings: with the step of differences, where they must do.
    """
    settings = settings or AscentSettings()

    def task(point: Start) -> Callable[[_Ask], Array]:
        def slopes(ask: _Ask) -> Array:
            sqp = _Sqp(point, settings, evaluator, ask)
            try:
                return sqp.gradient(np.asarray(point.u, dtype=float))
            except _RunFailedError:
                return np.full(len(point.tolerances), np.nan)

        return slopes

    found = side_by_side(
        [task(point) for point in points], lambda asked: _answer(asked, evaluator)
    )
    return np.array(found).reshape(len(points), -1)


class _Question(NamedTuple):
    objective: int
    rows: Array
    """(r, n)."""
    kind: "_Kind"


class _Kind(enum.Enum):
    """What is asked for."""

    VALUES = enum.auto()
    NEAR = enum.auto()
    """Values about the first row, which have its slope."""
    SLOPES = enum.auto()


class _Answer(NamedTuple):
    values: Array
    """(r,)."""
    slopes: Array | None
    """(r, n), in SI."""
    failure: str
    """Why a row failed; empty if none did."""


_Ask: TypeAlias = Callable[[_Question], _Answer]


def _answer(
    questions: Sequence[_Question], evaluator: Evaluator
) -> list[_Answer | None]:
    """Answer all questions for values; if there are none, one about a row, or slopes.

    Slopes cost far more, and less for each the more there are of them.
    """
    kind = next(
        kind for kind in _Kind if any(question.kind is kind for question in questions)
    )
    asked = [i for i, question in enumerate(questions) if question.kind is kind]
    if kind is _Kind.NEAR:
        asked = asked[:1]
    rows = np.concatenate([questions[i].rows for i in asked])
    which = [questions[i].objective for i in asked for _ in questions[i].rows]
    slopes = None
    match kind:
        case _Kind.SLOPES:
            told, slopes = evaluator.slopes(rows, which)
        case _Kind.NEAR:
            told = evaluator.near(rows, which[0])
        case _:
            told = evaluator.one(rows, which)
    answers: list[_Answer | None] = [None] * len(questions)
    first = 0
    for i in asked:
        part = range(first, first + len(questions[i].rows))
        first = part.stop
        answers[i] = _Answer(
            told.values[part.start : part.stop],
            None if slopes is None else slopes[part.start : part.stop],
            next((told.failures[j] for j in part if j in told.failures), ""),
        )
    return answers


_FIRST_STEP = 3.0
_OF_DIFFERENCES = 1e-6
"""Least tolerance without derivatives: below it, differences are noise."""
_LEAST_SLOPE = 1e-6
"""That counts, as a part of the largest."""
_STATUS = {
    0: SearchStatus.CONVERGED,
    8: SearchStatus.STALLED,  # the line search finds no ascent beyond the noise
    9: SearchStatus.ITERATION_LIMIT,
}


class _RunFailedError(Exception):
    """A run that the search needs has failed."""


class _Sqp:
    """One search: asks for an objective and its slopes, and keeps the record."""

    def __init__(
        self,
        start: Start,
        settings: AscentSettings,
        evaluator: Evaluator,
        ask: _Ask,
        tell: Callable[[Iteration], None] = lambda _: None,
    ):
        self._start = start
        self._set = start.tolerances
        self._settings = settings
        self._exact = evaluator.exact(start.objective) and not settings.differences
        self._expensive = evaluator.objectives[start.objective].expensive
        self._ask = ask
        self._tell = tell
        self._evaluations = 0
        self._values: tuple[Array, float] | None = None
        self._slopes: tuple[Array, Array] | None = None
        self._best: tuple[Array, float] | None = None
        self._history: list[Iteration] = []
        if math.isfinite(start.value):
            self._keep(start.u, self._set.draw_back(start.u), start.value)

    def run(self) -> Ascent:
        u0, box = np.array(self._start.u, dtype=float), self._set.box
        try:
            scale, stretch = self._scales(u0)
            self._log(u0)
            rise = max(1.0, abs(self._value(u0)) / scale)
            result = minimize(
                lambda x: -self._value(x / stretch) / scale,
                u0 * stretch,
                jac=lambda x: -self.gradient(x / stretch) / (scale * stretch),
                method="SLSQP",
                bounds=Bounds(box.lower * stretch, box.upper * stretch),
                constraints=self._constraints(stretch),
                callback=lambda x: self._log(x / stretch),
                options={
                    "ftol": self._tolerance * rise,
                    "maxiter": self._settings.max_iterations,
                },
            )
            status = _STATUS.get(result.status, SearchStatus.STALLED)
            return self._end(status, result.message)
        except _RunFailedError as error:
            return self._end(SearchStatus.FAILED, str(error))

    @property
    def _tolerance(self) -> float:
        least = 0.0 if self._exact else _OF_DIFFERENCES
        return max(self._settings.tolerance, least)

    def _constraints(self, stretch: Array) -> list[dict[str, Any]]:
        if not self._set.constraints:
            return []
        return [
            {
                "type": "ineq",
                "fun": lambda x: self._set.margins(x / stretch),
                "jac": lambda x: self._set.jacobian(x / stretch) / stretch,
            }
        ]

    def _evaluate(self, points: Array, kind: _Kind = _Kind.VALUES) -> _Answer:
        rows = self._set.rows(points)
        answer = self._ask(_Question(self._start.objective, rows, kind))
        self._evaluations += len(points)
        if answer.failure:
            raise _RunFailedError(f"a run failed: {answer.failure}")
        return answer

    def _keep(self, u: Array, point: Array, value: float) -> None:
        self._values = (np.array(u), value)
        if self._best is None or value > self._best[1]:
            self._best = (point, value)

    def _value(self, u: Array) -> float:
        if self._values is None or not np.array_equal(self._values[0], u):
            point = self._set.draw_back(u)
            self._keep(u, point, float(self._evaluate(point[None]).values[0]))
        assert self._values is not None
        return self._values[1]

    def gradient(self, u: Array) -> Array:
        """Return (n,) the slopes with the scaled parameters."""
        if self._slopes is None or not np.array_equal(self._slopes[0], u):
            slopes = self._slopes_at(u) if self._exact else self._differences(u)
            self._slopes = (np.array(u), slopes)
        return self._slopes[1]

    def _slopes_at(self, u: Array) -> Array:
        point = self._set.draw_back(u)
        answer = self._evaluate(point[None], _Kind.SLOPES)
        assert answer.slopes is not None
        self._keep(u, point, float(answer.values[0]))
        return np.asarray(answer.slopes[0] * self._set.box.tolerance)

    def _differences(self, u: Array) -> Array:
        """Return one-sided differences, each taken into the set."""
        value = self._value(u)
        point = self._set.draw_back(u)
        probes = self._probes(point)
        steps = probes - point
        if self._expensive:
            together = np.concatenate([point[None], probes])
            rises = self._evaluate(together, _Kind.NEAR).values[1:] - value
        else:
            rises = self._evaluate(probes).values - value
        diagonal = np.diagonal(steps)
        if np.array_equal(steps, np.diag(diagonal)):
            slopes = np.zeros(len(point))
            np.divide(rises, diagonal, out=slopes, where=diagonal != 0.0)
            return slopes
        # Along a curved edge a probe moves other parameters too.
        return np.asarray(np.linalg.lstsq(steps, rises, rcond=None)[0])

    def _probes(self, point: Array) -> Array:
        """Return (n, n) points of the set, each a step away in one parameter.

        To the side where there is more room: less than a step, at a curved edge.
        """
        step = self._settings.step * np.eye(len(point))
        sides = self._set.draw_back(np.array([point + step, point - step]))
        moved = np.abs(np.diagonal(sides - point, axis1=1, axis2=2))
        # All but equal rooms are equal: round-off must not decide.
        side = (moved[1] > moved[0] + 1e-9 * self._settings.step).astype(int)
        return np.asarray(sides[side, np.arange(len(point))])

    def _scales(self, u: Array) -> tuple[float, Array]:
        """Return what to divide the objective by, and to multiply the parameters with.

        SLSQP starts from a unit Hessian: scaled so, its first step is of length
        `_FIRST_STEP` in each parameter, beyond the farther bound. What matters little
        would else creep towards its bound.
        """
        slopes = np.abs(self.gradient(u))
        largest = float(slopes.max(initial=0.0)) or 1.0
        stretch = np.sqrt(np.maximum(slopes / largest, _LEAST_SLOPE))
        return largest / _FIRST_STEP, stretch

    def _log(self, u: Array) -> None:
        """Record an iterate; called by the optimiser after each iteration."""
        iteration = Iteration(
            number=len(self._history),
            value=self._value(u),
            u=tuple(self._set.draw_back(u).tolist()),
            evaluations=self._evaluations,
        )
        self._history.append(iteration)
        self._tell(iteration)

    def _end(self, status: SearchStatus, message: str) -> Ascent:
        point, value = self._best or (self._start.u, math.nan)
        return Ascent(
            objective=self._start.objective,
            u=tuple(point.tolist()),
            value=value,
            history=tuple(self._history),
            evaluations=self._evaluations,
            status=status,
            message=message,
        )
