"""How far tolerances may grow before a requirement is first violated.

First, corners of sets that grow in a few stages say which of them are worst where a
limit is first passed. Along the ray on which such a point moves as tolerances grow, the
growth at which it reaches the limit is a root; there the worst case is searched anew,
which moves the ray. By the envelope theorem the ray matters to second order only: a few
rounds settle it. Roots and searches of all limits go side by side.

What is found is a violation, so that the growth is at most this; that nothing is
violated before it rests on the searches.

What takes long to tell, as a clearance does, is followed along the ray to its worst
case alone (`grow_along_rays`), and found to a hundredth by halving.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from drakesep.analysis.engines.evaluator import Evaluated
from drakesep.analysis.search.problem import Problem
from drakesep.analysis.search.sqp import AscentSettings, Start, ascend
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.model.parameters import declarations, with_values


MOST = 5.0
"""Beyond this growth is not looked at: tolerances five times as large are another
design."""
_STAGES = (1.25, 1.5, 2.0, 2.5, 3.0, 4.0, MOST)
_WORST = 4
"""Corners of a stage along which a limit is looked for."""
_SETTLED = 1e-3
"""Relative change of a growth at which its ray has settled."""
_ROUNDS = 4
_SQP = AscentSettings(tolerance=1e-6, max_iterations=2, differences=True)
"""In a round: the next one goes on from there. Differences of a batch cost less than
its derivatives, and settle a growth as well."""
_GRID = (0.0, 0.5, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, MOST)
"""Growths between which a limit is first passed on a ray."""
_ROOT = 1e-5
"""To which a growth is found on its ray."""
_COARSE = (0.0, 1.0, 1.5, 2.0, 3.0, MOST)
"""The grid where each point takes long to tell."""
_HALVED = 1e-2
"""To which a growth is found there."""


@typed
@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """A value of an objective that it must not exceed, with where to begin."""

    objective: int
    """Which of the evaluator's."""
    value: float
    """In SI."""
    u: tuple[float, ...]
    """A scaled point of the set, at or near its worst case."""
    parameter: int | None = None
    """The only one whose tolerance grows; all do if None."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """How far tolerances may grow."""

    limit: Limit
    factor: float
    """At which the limit is reached; infinite if it was not found to be; 0 if the
    nominal is beyond it, or the other tolerances without this one; NaN if nothing was
    told at all: runs failed, or ended too soon."""
    most: float
    """Up to which growth was looked at: less where runs fail from there on, or end too
    soon. A parameter that does not exist so far grows as far as it does, while others
    go on."""
    values: dict[str, float]
    """Of the parameters where the limit is reached, in SI; empty if it is not."""
    message: str = ""
    """Why a run failed."""
    along_ray: bool = False
    """Whether it was looked for along the ray to the worst case alone."""

    @property
    def looked_up_to(self) -> float:
        """Largest factor that was looked at; NaN if none was."""
        return math.nan if math.isnan(self.factor) else self.most

    @property
    def order(self) -> tuple[float, float]:
        """The least of several, of the same limit, is what they say together.

        A limit that is reached comes first, the sooner; then what was not looked at as
        far as another.
        """
        if math.isfinite(self.factor):
            return self.factor, 0.0
        return math.inf, 0.0 if math.isnan(self.factor) else self.most


@typed
def grow(
    problem: Problem,
    limits: Sequence[Limit],
    *,
    corners: int = 4096,
    seed: int = 0,
    on_progress: Callable[[int, int], None] = lambda *_: None,
) -> list[Growth]:
    """Return for each limit by what factor tolerances may grow until it is reached.

    Args:
        problem: the objectives and the set.
        limits: values that objectives must not exceed.
        corners: of the box, drawn at random, from which to begin.
        seed: of the corners.
        on_progress: told at every evaluation how many limits are settled, and of how
            many.
    """
    if not limits:
        return []
    settled = 0

    def tell() -> None:
        on_progress(settled, len(limits))

    tell()
    caps = _caps(problem)
    unknown = [
        Growth(
            limit=limit,
            factor=math.nan,
            most=MOST if limit.parameter is None else float(caps[limit.parameter]),
            values={},
        )
        for limit in limits
    ]
    signs = np.random.default_rng(seed).choice(
        [-1.0, 1.0], size=(corners, len(problem.tolerances))
    )
    which, points = _beginnings(problem, limits, caps, signs)
    found = _roots(problem, [unknown[i] for i in which], points, caps, tell)
    growths, rays = found[: len(limits)], points[: len(limits)].copy()  # their own
    for i, growth, point in zip(which, found, points, strict=True):
        if growth.order < growths[i].order:
            growths[i], rays[i] = growth, point
    moving = [i for i, growth in enumerate(growths) if growth.factor != 0.0]
    for _ in range(_ROUNDS):
        settled = len(limits) - len(moving)
        tell()
        if not moving:
            break
        mine = [growths[i] for i in moving]
        tried = _search(problem, mine, rays[moving], caps, tell)
        found = _roots(problem, [unknown[i] for i in moving], tried, caps, tell)
        still = []
        for i, growth, point in zip(moving, found, tried, strict=True):
            before = growths[i].factor
            if growth.order < growths[i].order:
                growths[i], rays[i] = growth, point
                if not before - growth.factor <= _SETTLED * growth.factor:
                    still.append(i)
        moving = still
    on_progress(len(limits), len(limits))
    return [
        replace(growth, values=_point(problem, growth, ray, caps))
        for growth, ray in zip(growths, rays, strict=True)
    ]


def grow_along_rays(problem: Problem, limits: Sequence[Limit]) -> list[Growth]:
    """Return by what factor tolerances may grow along the rays of limits' own points.

    As the worst case moves out with all tolerances; it is not searched anew, so that
    the limit may be reached sooner elsewhere. Only values on the ray are asked for,
    and none of them need be smooth: one that stays at the limit, as a clearance does at
    contact, is reached where it gets there.

    Args:
        problem: the objectives and the set.
        limits: values that objectives must not exceed, of all tolerances together.
    """
    if not limits:
        return []
    caps = _caps(problem)
    rays = np.array([limit.u for limit in limits])
    failures: dict[int, str] = {}

    def excess(factors: Array, index: NDArray[np.intp]) -> Array:
        told = _excess(problem, [limits[i] for i in index], rays[index], factors, caps)
        for j, why in told.failures.items():
            failures.setdefault(int(index[j]), why)
        return told.values

    n = len(limits)
    lower, upper = np.zeros(n), np.full(n, np.inf)
    open_, all_told, most = np.arange(n), np.ones(n, dtype=bool), np.full(n, np.nan)
    for factor in _COARSE:
        if not len(open_):
            break
        beyond = excess(np.full(len(open_), factor), open_)
        all_told[open_] &= ~np.isnan(beyond)
        most[open_[all_told[open_]]] = factor
        upper[open_[beyond >= 0.0]] = factor
        lower[open_[beyond < 0.0]] = factor
        open_ = open_[~(beyond >= 0.0)]
    halving = np.isfinite(upper)
    while True:
        halving &= upper - lower > _HALVED
        index = np.flatnonzero(halving)
        if not len(index):
            break
        middle = 0.5 * (lower[index] + upper[index])
        beyond = excess(middle, index)
        upper[index] = np.where(beyond >= 0.0, middle, upper[index])
        lower[index] = np.where(beyond < 0.0, middle, lower[index])
        halving[index[np.isnan(beyond)]] = False  # above it is a violation all the same
    found = [
        Growth(
            limit=limit,
            factor=_factor(upper[i], most[i]),
            most=MOST if math.isfinite(upper[i]) else float(most[i]),
            values={},
            message=failures.get(i, ""),
            along_ray=True,
        )
        for i, limit in enumerate(limits)
    ]
    return [
        replace(growth, values=_point(problem, growth, ray, caps))
        for growth, ray in zip(found, rays, strict=True)
    ]


def _factor(reached: float, most: float) -> float:
    """Return where a limit is reached: NaN if nowhere, and not even 0 was told."""
    return math.nan if math.isinf(reached) and math.isnan(most) else float(reached)


def _excess(
    problem: Problem,
    limits: Sequence[Limit],
    rays: Array,
    factors: Array,
    caps: Array,
) -> Evaluated:
    """Return by how much limits are exceeded on rays (k, n) of grown tolerances.

    What ends too soon to be told is a violation if it is beyond its limit by then; else
    it is not known, NaN.
    """
    told = _told_on_rays(problem, limits, rays, factors, caps)
    beyond = told.values - np.array([limit.value for limit in limits])
    for i in told.unended:
        if beyond[i] < 0.0:
            beyond[i] = math.nan
    return told._replace(values=beyond)


def _told_on_rays(
    problem: Problem,
    limits: Sequence[Limit],
    rays: Array,
    factors: Array,
    caps: Array,
) -> Evaluated:
    """Return the objectives of limits where tolerances have grown along rays (k, n)."""
    set_ = problem.tolerances
    each = [_factors(limit, s, caps) for limit, s in zip(limits, factors, strict=True)]
    rows = set_.rows(set_.grown_points(rays, np.array(each)))
    return problem.evaluator.one(rows, [limit.objective for limit in limits])


def _beginnings(
    problem: Problem, limits: Sequence[Limit], caps: Array, signs: Array
) -> tuple[list[int], Array]:
    """Return for which limits, and from which points (k, n) before growth, to begin.

    From each limit's own; and for all tolerances together, from what is worst where the
    limit is first passed, of the points of all limits and of corners with signs (c, n).
    """
    set_, n = problem.tolerances, len(problem.tolerances)
    which = list(range(len(limits)))
    own = np.array([limit.u for limit in limits]).reshape(len(limits), n)
    points = [own]
    searching = [i for i, limit in enumerate(limits) if limit.parameter is None]
    asked = sorted({limit.objective for limit in limits})
    at_bounds = set_.draw_back(set_.box.corners(signs))
    known = np.concatenate([np.unique(own, axis=0), at_bounds])
    for stage in _STAGES:
        if not searching:
            break
        factors = np.minimum(stage, caps)
        rows = set_.rows(set_.grown_points(known, factors))
        told = problem.evaluator.all(rows, of=asked)
        values = np.where(np.isnan(told.values), -np.inf, told.values)
        for i in list(searching):
            column = values[:, limits[i].objective]
            if column.max() >= limits[i].value or stage == MOST:
                worst = np.argsort(-column, kind="stable")[:_WORST]
                which += [i] * len(worst)
                points.append(known[worst])
                searching.remove(i)
    return which, np.concatenate(points)


def _factors(limit: Limit, growth: float, caps: Array) -> Array:
    """Return (n,) by what each tolerance grows: up to its cap, if all do."""
    if limit.parameter is None:
        return np.minimum(growth, caps)
    factors = np.ones(len(caps))
    factors[limit.parameter] = growth
    return factors


def _caps(problem: Problem) -> Array:
    """Return (n,) how far each tolerance may grow while its bounds exist."""
    box = problem.tolerances.box
    declared = declarations(problem.tolerances.separation)
    caps = np.full(len(box), MOST)
    for i, d in enumerate(box.dispersions):
        if declared[d.name].kind == "inertia":
            continue  # drawn back to what exists

        def exists(factor: float, name: str = d.name, i: int = i) -> bool:
            try:
                for bound in (box.lower[i], box.upper[i]):
                    value = box.nominal[i] + bound * factor * box.tolerance[i]
                    with_values(problem.tolerances.separation, {name: float(value)})
            except ValueError:
                return False
            return True

        if not exists(MOST):
            lower, upper = 1.0, MOST
            while upper - lower > 1e-3:
                middle = 0.5 * (lower + upper)
                lower, upper = (middle, upper) if exists(middle) else (lower, middle)
            caps[i] = lower
    return caps


def _roots(
    problem: Problem,
    growths: Sequence[Growth],
    rays: Array,
    caps: Array,
    tell: Callable[[], None],
) -> list[Growth]:
    """Return the growths at which limits are first reached along rays."""
    limits = [growth.limit for growth in growths]
    failures: dict[int, str] = {}

    def excess(factor: Array, which: Array) -> Array:
        index = which.astype(int)
        told = _excess(problem, [limits[i] for i in index], rays[index], factor, caps)
        for j, why in told.failures.items():
            failures.setdefault(int(index[j]), why)
        tell()
        return told.values

    every = np.arange(len(growths), dtype=float)
    most = np.array([growth.most for growth in growths])
    grid = np.minimum(np.array(_GRID)[:, None], most)
    on_grid = excess(grid.ravel(), np.tile(every, len(grid))).reshape(grid.shape)
    factors = np.full(len(growths), np.nan)
    brackets = []
    for i, column in enumerate(on_grid.T):
        flown = np.flatnonzero(~np.isnan(column))
        beyond = flown[column[flown] >= 0.0]
        if not len(beyond):
            told = np.append(np.isnan(column), True).argmax()  # from 0 on, without gaps
            if told:
                factors[i], most[i] = np.inf, grid[told - 1, i]
        else:
            # Already a violation, should the root between fail.
            factors[i] = grid[beyond[0], i]
            before = flown[flown < beyond[0]]
            if len(before):
                brackets.append((i, grid[before[-1], i], grid[beyond[0], i]))
    if brackets:
        index, lower, upper = map(np.array, zip(*brackets, strict=True))
        result = find_root(
            excess,
            (lower, upper),
            args=(index.astype(float),),
            tolerances={"xatol": _ROOT, "xrtol": _ROOT},
        )
        factors[index] = np.where(result.success, result.x, factors[index])
    return [
        replace(
            growth,
            factor=float(factors[i]),
            most=float(most[i]),
            message=failures.get(i, ""),
        )
        for i, growth in enumerate(growths)
    ]


def _search(
    problem: Problem,
    growths: Sequence[Growth],
    rays: Array,
    caps: Array,
    tell: Callable[[], None],
) -> Array:
    """Return the worst points of the grown sets, scaled by their own tolerances."""
    starts = []
    for growth, ray in zip(growths, rays, strict=True):
        factor = growth.factor
        if not math.isfinite(factor):
            factor = max(growth.most, _GRID[1])  # a set of one point has no slopes
        grown = problem.tolerances.grown(_factors(growth.limit, factor, caps))
        starts.append(
            Start(
                objective=growth.limit.objective,
                tolerances=grown,
                u=grown.draw_back(ray),
            )
        )
    ascents = ascend(starts, problem.evaluator, _SQP, lambda *_: tell())
    worst = [
        ascent.u if math.isfinite(ascent.value) else tuple(ray)
        for ascent, ray in zip(ascents, rays, strict=True)
    ]
    return np.array(worst).reshape(rays.shape)


def _point(
    problem: Problem, growth: Growth, ray: Array, caps: Array
) -> dict[str, float]:
    if not math.isfinite(growth.factor):
        return {}
    factors = _factors(growth.limit, growth.factor, caps)
    set_ = problem.tolerances
    return set_.values(set_.grown_points(ray, factors))
