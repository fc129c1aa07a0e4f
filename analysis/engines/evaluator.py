"""What tells a search the objectives at points: the batch engine, or run by run."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, TypeAlias

from drakesep.analysis.metrics.objectives import Objective
from drakesep.systems.arrays import Array
from drakesep.systems.model.run import Run


Progress: TypeAlias = Callable[[int, int], None]
"""Told how many rows are done, and of how many."""


class Evaluated(NamedTuple):
    """What was found at rows of parameter values."""

    values: Array
    """(n,) of one objective for each row, or (n, m) of all; NaN where a run failed."""
    failures: dict[int, str]
    """Why runs failed, by row."""
    unended: frozenset[int] = frozenset()
    """Rows whose run ends before what is looked at does: their values may rise yet."""


class Evaluator(Protocol):
    """Tells objectives at rows (n, n_p) of parameter values, in SI."""

    names: tuple[str, ...]
    """(n_p,) of the parameters."""
    objectives: tuple[Objective, ...]
    concurrent: bool
    """Whether several threads may ask at once."""

    def exact(self, k: int) -> bool:
        """Return whether `slopes` knows those of an objective."""
        ...

    def all(
        self,
        rows: Array,
        on_progress: Progress | None = None,
        of: Sequence[int] | None = None,
    ) -> Evaluated:
        """Return every objective at every row; NaN for those that are not asked for.

        Args:
            rows: (n, n_p) of the parameters, in SI.
            on_progress: called now and then.
            of: which objectives; all if None.
        """
        ...

    def one(self, rows: Array, which: Sequence[int]) -> Evaluated:
        """Return one objective at each row: the which[i]-th at row i."""
        ...

    def near(self, rows: Array, k: int) -> Evaluated:
        """Return an objective at the first row, and about it at the others."""
        ...

    def slopes(self, rows: Array, which: Sequence[int]) -> tuple[Evaluated, Array]:
        """Return one objective at each row, and its derivatives (n, n_p)."""
        ...

    def runs(self, rows: Array, k: int) -> list[Run]:
        """Return the run of each row, completed or failed, for an objective."""
        ...

    def run_by_run(self, k: int) -> int | None:
        """Return how many whole runs were flown until now to tell an objective.

        None if metrics tell it.
        """
        ...
