"""The search by scipy's differential evolution, a generation flown at once."""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import differential_evolution

from drakesep.analysis.search.ask_tell import side_by_side
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import (
    Known,
    OnProgress,
    Problem,
    Searched,
    SearchProgress,
)
from drakesep.analysis.search.sweeps import Best
from drakesep.systems.arrays import Array


def evolve(
    problem: Problem, settings: SearchSettings, known: Known, on_progress: OnProgress
) -> Searched:
    """Let scipy's differential evolution search, a generation flown at once."""
    best = Best("evolution", problem)
    tolerances = problem.tolerances

    def task(k: int) -> Callable[[Callable[[_Points], Array]], None]:
        def run(ask: Callable[[_Points], Array]) -> None:
            def cost(points: Array) -> Array:
                u = tolerances.draw_back(points.T)
                values = ask((k, u))
                return np.where(np.isnan(values), np.inf, -values)

            differential_evolution(
                cost,
                [*zip(tolerances.box.lower, tolerances.box.upper, strict=True)],
                maxiter=settings.generations,
                popsize=_POPULATION,
                rng=np.random.default_rng(settings.seed),
                polish=False,
                updating="deferred",
                vectorized=True,
            )

        return run

    def answer(asked: list[_Points]) -> list[Array | None]:
        rows = tolerances.rows(np.concatenate([u for _, u in asked]))
        told = problem.evaluator.one(rows, [k for k, u in asked for _ in u])
        answers: list[Array | None] = []
        first = 0
        for k, u in asked:
            part = slice(first, first + len(u))
            first = part.stop
            best.add_of(k, u, told.values[part])
            answers.append(told.values[part])
        best.fail(told.failures)
        on_progress(
            SearchProgress(
                search="evolution", done=best.points, total=None, best=best.values
            )
        )
        return answers

    side_by_side([task(k) for k in problem.asked], answer)
    return best.searched(
        f"differential evolution, at most {settings.generations} generations more of "
        f"{_POPULATION * len(tolerances)}"
    )


_POPULATION = 8
"""Points of a generation, for each parameter."""
_Points: TypeAlias = tuple[int, Any]
"""An objective, and points (p, n) at which it is wanted."""
