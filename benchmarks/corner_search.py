"""Corners that are worst: flips of bounds against differential evolution.

Random problems of thirty parameters whose worst corner is known without a search: by
half of the parameters against the other half where pairs of parameters act together, in
closed form where magnitudes add up. Prints in how many each search has found it, how
far it was off, and how many runs and seconds it took; the functions cost nothing, so
that seconds are those of the search itself.

    python benchmarks/corner_search.py [PROBLEMS]
"""

import sys
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from drakesep import load_case
from drakesep.analysis import (
    SEARCHES,
    Problem,
    SearchSettings,
    ToleranceBox,
    ToleranceSet,
    of_run,
)
from drakesep.analysis.engines.evaluator import Evaluated
from drakesep.systems.model.parameters import parameters


PARAMETERS = 30
CLOSE = 1e-9
"""Of the worst value, in which two of them are the same: sums of thirty terms."""


class Known(NamedTuple):
    """A function of corners (c, n), and its largest value."""

    family: str
    function: Callable[[np.ndarray], np.ndarray]
    largest: float


def pairs(rng: np.random.Generator, strength: float) -> Known:
    """Linear terms, and a term for each pair of parameters, of either sign.

    Its slopes change their signs over the box; in each parameter alone it is linear, so
    that it is largest in a corner.
    """
    b = rng.normal(size=PARAMETERS)
    C = np.triu(rng.normal(size=(PARAMETERS, PARAMETERS)), 1)
    C *= strength / np.sqrt(PARAMETERS)

    def function(u: np.ndarray) -> np.ndarray:
        return u @ b + ((u @ C) * u).sum(axis=-1)

    return Known(f"pairs, {strength:g}", function, largest_of_pairs(b, C))


def largest_of_pairs(b: np.ndarray, C: np.ndarray) -> float:
    """Return the largest value in a corner: each half's corners against the other's.

    Those of the first half by what they can reach at most, until none reaches more than
    what has been found: exact, whatever is left out.
    """
    half = len(b) // 2
    corners = 2.0 * ((np.arange(2**half)[:, None] >> np.arange(half)) & 1) - 1.0
    first = corners @ b[:half] + ((corners @ C[:half, :half]) * corners).sum(axis=1)
    second = corners @ b[half:] + ((corners @ C[half:, half:]) * corners).sum(axis=1)
    across = corners @ C[:half, half:]
    at_most = first + np.abs(across).sum(axis=1) + second.max()
    # What the second half adds by itself, as one parameter more that is always 1.
    across = np.column_stack([across, np.ones(len(corners))])
    others = np.column_stack([corners, second]).T
    largest = -np.inf
    order = np.argsort(-at_most)
    for i in range(0, len(order), 32):
        mine = order[i : i + 32]
        if at_most[mine[0]] < largest:
            break
        found = ((across[mine] @ others).max(axis=1) + first[mine]).max()
        largest = max(largest, float(found))
    return largest


def magnitudes(rng: np.random.Generator, terms: int) -> Known:
    """The sum of magnitudes of linear terms, as a sum of peaks is: convex.

    Its largest value is that of the signs of the terms for which it is: 2^terms.
    """
    A, b = rng.normal(size=(terms, PARAMETERS)), rng.normal(size=terms)
    signs = 2.0 * ((np.arange(2**terms)[:, None] >> np.arange(terms)) & 1) - 1.0

    def function(u: np.ndarray) -> np.ndarray:
        return np.abs(u @ A.T + b).sum(axis=-1)

    largest = (np.abs(signs @ A).sum(axis=1) + signs @ b).max()
    return Known(f"magnitudes, {terms}", function, float(largest))


class OfFunction:
    """An evaluator that tells a function of the scaled point, and counts."""

    concurrent = False

    def __init__(self, function: Callable, tolerances: ToleranceSet):
        self.objectives = (of_run(lambda run: 0.0, "function"),)
        self.names = tolerances.names
        self._function, self._box = function, tolerances.box

    def exact(self, k: int) -> bool:
        """Return False."""
        return False

    def one(self, rows: np.ndarray, which) -> Evaluated:
        """Return the function at each row."""
        u = (rows - self._box.nominal) / self._box.tolerance
        return Evaluated(self._function(u), {})


def problems(count: int) -> Iterator[Known]:
    makers = [
        lambda rng: pairs(rng, 1.0),
        lambda rng: pairs(rng, 2.0),
        lambda rng: pairs(rng, 5.0),
        lambda rng: magnitudes(rng, 4),
        lambda rng: magnitudes(rng, 10),
    ]
    for number in range(count):
        yield makers[number % len(makers)](np.random.default_rng(number))


def tolerances() -> ToleranceSet:
    """A box of thirty parameters of VEGA, without inertias: all of it exists."""
    separation = load_case("vega").separation
    left_out = ("inertia", "release_time")  # not all of these exist
    names = [
        name
        for name in parameters(separation)
        if not any(part in name for part in left_out)
    ]
    box = ToleranceBox.around(separation, dict.fromkeys(names[:PARAMETERS], 1e-3))
    return ToleranceSet(separation, box)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    set_ = tolerances()
    found: dict[tuple[str, str], list[tuple[float, int, float]]] = {}
    for known in problems(count):
        problem = Problem(tolerances=set_, evaluator=OfFunction(known.function, set_))
        for search in ("corners", "evolution"):
            began = time.perf_counter()
            searched = SEARCHES[search](problem, SearchSettings(), (), lambda _: None)
            seconds = time.perf_counter() - began
            short = 1.0 - searched.best(0).value / known.largest
            for family in (known.family, "all"):
                told = found.setdefault((family, search), [])
                told.append((short, searched.points, seconds))
    print(
        f"{'problems':16} {'search':10} {'found':>9} {'short':>8} {'runs':>8} {'s':>7}"
    )
    for (family, search), told in sorted(found.items()):
        short, points, seconds = np.array(told).T
        print(
            f"{family:16} {search:10} {(short <= CLOSE).sum():4} of {len(told):3}"
            f" {short.mean():8.2%} {points.mean():8.0f} {seconds.mean():7.2f}"
        )


if __name__ == "__main__":
    main()
