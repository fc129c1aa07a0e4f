"""The searches by name.

See `drakesep.analysis.search.problem` for what they have in common.
"""

import dataclasses
from collections.abc import Iterable, Mapping
from types import MappingProxyType

from drakesep.analysis.search.corners import flip_bounds
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.evolution import evolve
from drakesep.analysis.search.problem import (
    FROM_BEST,
    FROM_NOMINAL,
    Known,
    OnProgress,
    Problem,
    Search,
    Searched,
)
from drakesep.analysis.search.sqp_searches import (
    sqp_from_best,
    sqp_from_many,
    sqp_from_nominal,
)
from drakesep.analysis.search.sweeps import sample, sweep_vertices
from drakesep.systems.checks import InputError, unknown


SEARCHES: Mapping[str, Search] = MappingProxyType(
    {
        FROM_NOMINAL: sqp_from_nominal,
        "multistart": sqp_from_many,
        FROM_BEST: sqp_from_best,
        "vertices": sweep_vertices,
        "corners": flip_bounds,
        "samples": sample,
        "evolution": evolve,
    }
)
"""The searches by name."""
SQP_SEARCHES = (FROM_NOMINAL, "multistart", FROM_BEST)
"""Those that go uphill; the others sweep: they fly very many runs."""


def check_search(name: str, also: Iterable[str] = ()) -> None:
    """Raise ValueError if there is no such search; others that are known are named."""
    if name not in SEARCHES:
        raise InputError(unknown("search", name, [*SEARCHES, *also]))


def run_search(
    name: str,
    problem: Problem,
    settings: SearchSettings,
    known: Known,
    on_progress: OnProgress,
) -> Searched:
    """Return what comes of a search, with how many whole runs it has taken."""
    before = _run_by_run(problem)
    found = SEARCHES[name](problem, settings, known, on_progress)  # Eq. 10
    now = _run_by_run(problem)
    taken = tuple((k, count - before[k]) for k, count in now.items())
    return dataclasses.replace(found, run_by_run=taken)


def _run_by_run(problem: Problem) -> dict[int, int]:
    """Return how many whole runs were flown until now, by objective."""
    counts = {k: problem.evaluator.run_by_run(k) for k in problem.asked}
    return {k: count for k, count in counts.items() if count is not None}
