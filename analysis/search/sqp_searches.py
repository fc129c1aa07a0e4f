"""Searches that go uphill: from the nominal, and from many starts at once."""

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np

from drakesep.analysis.metrics.objectives import LargestOfParts
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.linearised_corners import different, linearised_corners
from drakesep.analysis.search.problem import (
    FROM_BEST,
    FROM_NOMINAL,
    Candidate,
    Iterate,
    Known,
    OnProgress,
    Problem,
    Searched,
    SearchProgress,
)
from drakesep.analysis.search.sqp import Iteration, SearchStatus, Start, ascend
from drakesep.systems.arrays import Array


_PATIENCE = 12
"""Iterations of one of many starts: what creeps on is none of the best."""
_ENOUGH = 1e-8
"""Tolerance of one of many starts: maxima that differ by 1e-6 are told apart."""
_CORNERS, _WORST = 256, 2
"""That are looked at where nothing sweeps an objective, and those kept as starts."""


def sqp_from_nominal(
    problem: Problem, settings: SearchSettings, known: Known, on_progress: OnProgress
) -> Searched:
    """Go up by sequential quadratic programming from the nominal, as the paper does."""
    nominal = [np.zeros(len(problem.tolerances))]
    starts = dict.fromkeys(problem.asked, nominal)
    return _search(FROM_NOMINAL, problem, settings, on_progress, starts)


def sqp_from_many(
    problem: Problem, settings: SearchSettings, known: Known, on_progress: OnProgress
) -> Searched:
    """Go up from many starts: nominal, corners, the best known points, random ones.

    An earlier ascent from the nominal is one of them.
    """
    settings, set_ = _patient(settings), problem.tolerances
    done = any(candidate.search == FROM_NOMINAL for candidate in known)
    count = settings.starts - 1 if done else settings.starts
    nominal = [] if done else [np.zeros(len(set_))]
    starts = {}
    for k in problem.asked:
        mine = sorted(
            (c for c in known if c.objective == k and c.ascent is None),
            key=lambda c: -c.value,
        )
        found = linearised_corners(problem, k)
        unswept = _worst_corners(problem, settings, k)
        best = [*nominal, *found, *unswept, *(np.array(c.u) for c in mine)]
        # All such corners; around the nominal, what is near has another side.
        best += [set_.draw_back(set_.box.opposite(u)) for u in found]
        best = different(best)[: max(count, len(nominal) + len(found))]
        # The same for each objective: what others there are changes nothing.
        rng = np.random.default_rng(settings.seed)
        drawn = set_.draw(max(count - len(best), 0), rng)
        starts[k] = [*best, *drawn]
    return _search("multistart", problem, settings, on_progress, starts)


def sqp_from_best(
    problem: Problem, settings: SearchSettings, known: Known, on_progress: OnProgress
) -> Searched:
    """Go up from the best point of each search, and from a likely one if it is better.

    Of what nothing sweeps, from the corners where it may be worst; where nothing is
    known, from the nominal.
    """
    likely, starts = _likely(problem), {}
    for k in problem.asked:
        mine = sorted(
            (c for c in known if c.objective == k), key=lambda c: c.value, reverse=True
        )
        by_search = {c.search: c for c in reversed(mine)}
        points = [np.array(c.u) for c in by_search.values()]
        if k in likely and all(likely[k].value > c.value for c in mine):
            points.append(np.array(likely[k].u))
        points += linearised_corners(problem, k) + _worst_corners(problem, settings, k)
        starts[k] = different(points) or [np.zeros(len(problem.tolerances))]
    return _search(FROM_BEST, problem, _patient(settings, 3), on_progress, starts)


def _likely(problem: Problem) -> dict[int, Candidate]:
    """Return the likely points; with their values, unless these take long to tell."""
    which = [k for k in problem.asked if k in problem.likely]
    objectives, set_ = problem.evaluator.objectives, problem.tolerances
    told = dict.fromkeys(which, math.inf)
    cheap = [k for k in which if not objectives[k].expensive]
    if cheap:
        rows = set_.rows(np.array([problem.likely[k] for k in cheap]))
        values = problem.evaluator.one(rows, cheap).values
        told |= zip(cheap, values.tolist(), strict=True)
    return {
        k: Candidate(objective=k, u=problem.likely[k], value=value, search=FROM_BEST)
        for k, value in told.items()
    }


def _patient(settings: SearchSettings, times: int = 1) -> SearchSettings:
    """Return the settings of one of many ascents; of fewer, some times as patient."""
    patience = dataclasses.replace(
        settings.ascent,
        max_iterations=min(settings.ascent.max_iterations, times * _PATIENCE),
        tolerance=max(settings.ascent.tolerance, _ENOUGH),
    )
    return dataclasses.replace(settings, ascent=patience)


def _worst_corners(problem: Problem, settings: SearchSettings, k: int) -> list[Array]:
    """Return the worst (n,) of some corners, all if they are few; the worst first.

    For an objective that no search sweeps and of which nothing is known but its values,
    such as a user's function of a run: its slopes may lead astray.
    """
    objective, set_ = problem.evaluator.objectives[k], problem.tolerances
    if not objective.expensive or isinstance(objective, LargestOfParts):
        return []
    n, most = len(set_), min(_CORNERS, settings.samples)
    if 2**n <= most:
        signs = (np.arange(2**n)[:, None] >> np.arange(n)) & 1
    else:
        signs = np.random.default_rng(settings.seed).integers(2, size=(most, n))
    corners = set_.draw_back(set_.box.corners(2.0 * signs - 1.0))
    told = problem.evaluator.one(set_.rows(corners), [k] * len(corners))
    order = np.argsort(-np.where(np.isnan(told.values), -np.inf, told.values))
    return [corners[i] for i in order[:_WORST].tolist()]


def _search(
    search: str,
    problem: Problem,
    settings: SearchSettings,
    on_progress: OnProgress,
    points: Mapping[int, Sequence[Array]],
) -> Searched:
    """Go up from the points of each objective."""
    starts = [
        Start(objective=k, tolerances=problem.tolerances, u=u)
        for k, mine in points.items()
        for u in mine
    ]
    numbers = [j for mine in points.values() for j in range(1, len(mine) + 1)]
    best: dict[int, float] = {}
    iterates = 0

    def tell(i: int, iteration: Iteration) -> None:
        nonlocal iterates
        iterates += 1
        k = starts[i].objective
        best[k] = max(best.get(k, -math.inf), iteration.value)
        on_progress(
            SearchProgress(
                search=search,
                done=iterates,
                total=None,
                best=dict(best),
                iterate=Iterate(k, numbers[i], iteration),
            )
        )

    ascents = ascend(starts, problem.evaluator, settings.ascent, tell)
    failures: dict[str, int] = {}
    for ascent in ascents:
        if ascent.status is SearchStatus.FAILED:
            failures[ascent.message] = failures.get(ascent.message, 0) + 1
    more = max(map(len, points.values()))
    origin = {
        FROM_NOMINAL: "the nominal",
        FROM_BEST: "the best point known",
    }.get(search, f"{more} more start{'' if more == 1 else 's'}")
    exact = any(map(problem.evaluator.exact, points))
    note = f"SQP from {origin}" + ("" if exact else ", slopes by differences")
    return Searched(
        search=search,
        candidates=tuple(
            Candidate(
                objective=a.objective,
                u=a.u,
                value=a.value,
                search=search,
                ascent=a,
                start=number,
            )
            for a, number in zip(ascents, numbers, strict=True)
            if math.isfinite(a.value)
        ),
        points=sum(a.evaluations for a in ascents),
        failures=failures,
        what={note: len(problem.asked)},
        objectives=problem.asked,
        of=len(problem.evaluator.objectives),
    )
