"""The worst cases over a set of tolerances, each with its evidence.

Several searches look for them, each from what the ones before have found; the worst of
all is the worst case. See `drakesep.analysis.search.registry` and `.evidence`.
"""

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.expensive_objectives import ExpensiveSearches, by_cost
from drakesep.analysis.search.optimality import (
    Optimality,
    fraction_beyond,
    local_maxima,
    optimality,
    same,
)
from drakesep.analysis.search.problem import (
    Candidate,
    Problem,
    Searched,
    SearchProgress,
    candidates_of,
)
from drakesep.analysis.search.registry import check_search, run_search
from drakesep.analysis.search.sqp import SearchStatus, Start, slopes_at
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError


CONFIDENCE = 0.95
"""Of the bound that random samples put on what could be worse."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """What speaks for a worst case."""

    optimality: Optimality
    starts: int
    """Ascents, from as many starts."""
    ended_there: int
    """Of them, at the worst value found."""
    local_maxima: tuple[tuple[float, int], ...]
    """Values at which ascents ended, from the largest, and how many did."""
    unfinished: int
    """Ascents that ended at their limit of iterations, or by a failed run."""
    by_search: Mapping[str, float]
    """The best value of each search, in SI."""
    samples: int
    """Random samples that were drawn."""
    failed_samples: int
    """Of them, those whose runs failed: they could be worse."""
    fraction: float
    """Of the set that could be worse, at most, at `CONFIDENCE`; 1 without samples."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorstCase:
    """The worst point found for one objective."""

    name: str
    """Of the objective."""
    objective: int
    """Its place among the evaluator's."""
    u: tuple[float, ...]
    """The point, scaled."""
    values: Mapping[str, float]
    """The same as parameter values, in SI."""
    value: float
    """Of the objective there, in SI."""
    search: str
    """That found it; the first of those that found as much."""
    evidence: Evidence = field(repr=False)


@typed
def find_worst_cases(
    problem: Problem,
    searches: Sequence[str],
    settings: SearchSettings | None = None,
    *,
    finished: Sequence[Searched] = (),
    on_progress: Callable[[SearchProgress], None] = lambda _: None,
    on_search: Callable[[Searched], None] = lambda _: None,
) -> list[WorstCase]:
    """Maximise every objective of a problem.

    Args:
        problem: the objectives and the set.
        searches: names out of `SEARCHES`, in the order in which they go; later ones
            start where earlier ones ended.
        settings: how hard to search.
        finished: what came of the first of them, of the same problem and settings, if
            that is known: the others go on from there.
        on_progress: called as each search goes on.
        on_search: called with what comes of each search.

    Returns:
        A worst case for each objective.

    Raises:
        ValueError: a search is unknown or cannot be afforded, or an objective is not
            finite.
        RuntimeError: no run completed for an objective.
    """
    done = search_for_worst(
        problem,
        searches,
        settings or SearchSettings(),
        finished=finished,
        on_progress=on_progress,
        on_search=on_search,
    )
    return judge(problem, done)


def search_for_worst(
    problem: Problem,
    searches: Sequence[str],
    settings: SearchSettings,
    *,
    finished: Sequence[Searched] = (),
    on_progress: Callable[[SearchProgress], None] = lambda _: None,
    on_search: Callable[[Searched], None] = lambda _: None,
) -> list[Searched]:
    """Return what comes of searches, as `find_worst_cases` takes them, unjudged."""
    if not searches:
        raise InputError("searches: must be one or more, got none")
    for name in searches:
        check_search(name)
    names = list(dict.fromkeys(searches))
    cheap, expensive = by_cost(problem)
    done = list(finished)
    _check_finished(done, names)
    with contextlib.ExitStack() as stack:
        beside = None
        if expensive is not None:
            beside = ExpensiveSearches(expensive, names, settings, on_progress, done)
            stack.enter_context(beside)
        known = candidates_of(cheap, done)
        for name in names[len(done) :]:
            found = run_search(name, cheap, settings, known, on_progress)
            known.extend(found.candidates)
            done.append(found if beside is None else beside.join(found))
            on_search(done[-1])
    return done


def _check_finished(finished: Sequence[Searched], names: Sequence[str]) -> None:
    got = [found.search for found in finished]
    if got != list(names[: len(got)]):
        raise InputError(
            f"finished: must be the first of the searches {', '.join(names)}, got "
            f"{', '.join(got)}"
        )


def judge(problem: Problem, done: Sequence[Searched]) -> list[WorstCase]:
    """Return the worst case of each objective among what searches found.

    Raises:
        RuntimeError: no run completed for an objective.
    """
    winners = [_winner(problem, done, k) for k in problem.asked]
    points = [
        Start(
            objective=c.objective,
            tolerances=problem.tolerances,
            u=np.array(c.u),
            value=c.value,
        )
        for c in winners
    ]
    slopes = slopes_at(points, problem.evaluator)
    cases = []
    for winner, point, slope in zip(winners, points, slopes, strict=True):
        objective = problem.evaluator.objectives[winner.objective]
        round_off = objective.resolution(_ROUND_OFF)
        first_order = optimality(problem.tolerances, point.u, slope, round_off)
        cases.append(
            WorstCase(
                name=objective.name,
                objective=winner.objective,
                u=winner.u,
                values=problem.tolerances.values(winner.u),
                value=winner.value,
                search=winner.search,
                evidence=_evidence(winner, done, first_order, round_off),
            )
        )
    return cases


def _winner(problem: Problem, done: Sequence[Searched], k: int) -> Candidate:
    best = [found for found in (search.best(k) for search in done) if found]
    if not best:
        reasons = [why for search in done for why in search.failures]
        raise RuntimeError(
            f"{problem.evaluator.objectives[k].name}: no run of any search completed: "
            + "; ".join(dict.fromkeys(reasons))
        )
    top = max(candidate.value for candidate in best)
    # An earlier search has it if a later one gained no more than round-off.
    enough = top - _ROUND_OFF * abs(top)
    return next(candidate for candidate in best if candidate.value >= enough)


_ROUND_OFF = 1e-12
"""Of a value as a part of it; and of the motion of a run, in SI."""


def _evidence(
    winner: Candidate,
    done: Sequence[Searched],
    first_order: Optimality,
    round_off: float,
) -> Evidence:
    k = winner.objective
    ascents = [
        candidate.ascent
        for search in done
        for candidate in search.candidates
        if candidate.objective == k and candidate.ascent is not None
    ]
    ended = (SearchStatus.CONVERGED, SearchStatus.STALLED)
    ends = [ascent.value for ascent in ascents if ascent.status in ended]
    best = {search.search: search.best(k) for search in done}
    drawn = [
        search
        for search in done
        if search.search == "samples" and k in search.objectives
    ]
    samples = sum(search.points for search in drawn)
    failed = sum(sum(search.failures.values()) for search in drawn)
    there = sum(same(end, winner.value, round_off) for end in ends)
    return Evidence(
        optimality=first_order,
        starts=len(ascents),
        ended_there=there,
        local_maxima=local_maxima(ends, round_off),
        unfinished=len(ascents) - len(ends),
        by_search={
            name: math.nan if found is None else found.value
            for name, found in best.items()
        },
        samples=samples,
        failed_samples=failed,
        fraction=fraction_beyond(failed, samples, CONFIDENCE) if samples else 1.0,
    )
