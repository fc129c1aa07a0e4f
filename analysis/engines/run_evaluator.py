"""Tells a search the objectives run by run, whoever flies."""

import math
from collections import Counter, OrderedDict
from collections.abc import Callable, Sequence
from typing import TypeAlias, TypeVar

import numpy as np

from drakesep.analysis.engines.evaluator import Evaluated, Progress
from drakesep.analysis.metrics.objectives import (
    About,
    LargestOfParts,
    Limits,
    Needs,
    Objective,
)
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.run import Run, RunStatus


_Key: TypeAlias = tuple[int, bytes]
_T = TypeVar("_T")


class RunEvaluator:
    """Flies run by run, whoever flies; knows no derivatives."""

    concurrent = False

    def __init__(
        self,
        fly: Callable[[Array], list[Run]],
        names: Sequence[str],
        objectives: Sequence[Objective],
        limits: Limits = (math.inf,) * 3,
    ):
        """Prepare.

        Args:
            fly: returns the runs of rows (n, n_p).
            names: (n_p,) of the parameters.
            objectives: to be told.
            limits: (3,) of the deviations, as `metrics_of_run` takes them.
        """
        self._fly = fly
        self._limits = limits
        self.names = tuple(names)
        self.objectives = tuple(objectives)
        self._flown: Counter[int] = Counter()
        # What is asked for at a row and, a little later, about it; or once more.
        self._last: OrderedDict[_Key, About] = OrderedDict()
        self._last_near: OrderedDict[_Key, Evaluated] = OrderedDict()

    def exact(self, k: int) -> bool:
        """Return False: differences must do."""
        return False

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
        asked = range(len(self.objectives)) if of is None else of
        self._flown.update(dict.fromkeys(asked, len(rows)))
        values = np.full((len(rows), len(self.objectives)), np.nan)
        failures: dict[int, str] = {}
        slow = any(self.objectives[k].needs is Needs.MEASUREMENT for k in asked)
        size = 1 if slow else _ROWS
        for first in range(0, len(rows), size):
            part = rows[first : first + size]
            for i, run in enumerate(self._fly(part), first):
                if why := _why_not(run):
                    failures[i] = why
                else:
                    values[i, asked] = [self._tell(k, run, rows[i]) for k in asked]
            if on_progress is not None:
                on_progress(first + len(part), len(rows))
        return Evaluated(values, failures)

    def one(self, rows: Array, which: Sequence[int]) -> Evaluated:
        """Return one objective at each row: the which[i]-th at row i."""
        failures = {}
        self._flown.update(which)
        told = {i: self._known(k, rows[i]) for i, k in enumerate(which)}
        asked = [i for i, about in told.items() if about is None]
        for i, run in zip(asked, self._fly(rows[asked]) if asked else (), strict=True):
            if why := _why_not(run):
                failures[i] = why
            else:
                told[i] = self._about(which[i], run, rows[i])
        values = [np.nan if about is None else about.value for about in told.values()]
        unended = {i for i, about in told.items() if about and not about.ended}
        return Evaluated(np.array(values), failures, frozenset(unended))

    def near(self, rows: Array, k: int) -> Evaluated:
        """Return an objective at the first row, and about it at the others."""
        key = k, rows.tobytes()
        if key in self._last_near:
            return self._last_near[key]
        values = np.full(len(rows), np.nan)
        about = self._known(k, rows[0])
        first = 0 if about is None else 1
        self._flown[k] += len(rows)
        runs = self._fly(rows[first:])
        failures = {
            i: why for i, run in enumerate(runs, first) if (why := _why_not(run))
        }
        if not failures:
            if about is None:
                about = self._about(k, runs.pop(0), rows[0])
            values[:] = [about.value, *map(about.near, runs)]
        told = Evaluated(values, failures)
        _keep(self._last_near, key, told)
        return told

    def slopes(self, rows: Array, which: Sequence[int]) -> tuple[Evaluated, Array]:
        """Refuse."""
        raise TypeError("there are no derivatives run by run")

    def runs(self, rows: Array, k: int) -> list[Run]:
        """Return the run of each row, completed or failed, for an objective."""
        self._flown[k] += len(rows)
        return self._fly(rows)

    def run_by_run(self, k: int) -> int:
        """Return how many runs were flown until now to tell an objective.

        Those that are known count again: how many are, a search that goes on with
        others' does not know.
        """
        return self._flown[k]

    def _tell(self, k: int, run: Run, row: Array) -> float:
        return self._about(k, run, row).value

    def _known(self, k: int, row: Array) -> About | None:
        return self._last.get((k, row.tobytes()))

    def _about(self, k: int, run: Run, row: Array) -> About:
        known = self._known(k, row)
        if known is not None:
            return known
        objective = self.objectives[k]
        point = ", ".join(
            f"{name} = {x:.9g}" for name, x in zip(self.names, row, strict=True)
        )
        try:
            if isinstance(objective, LargestOfParts):
                least = self._at_least(k, run)
                about = objective.about(run, self._limits, least)
            else:
                about = objective.about(run, self._limits)
        except InputError:
            raise
        except Exception as error:  # whatever a user's function raises
            raise InputError(
                f"objective {objective.name} must give a number for every run, got "
                f"{type(error).__name__}: {error}, at {point}"
            ) from error
        if not math.isfinite(about.value):
            raise InputError(
                f"objective {objective.name} must be finite for every run, got "
                f"{about.value} at {point}; let it return a number for such a run too, "
                "a low one if the run is harmless"
            )
        if objective.expensive:
            _keep(self._last, (k, row.tobytes()), about)
        return about

    def _at_least(self, k: int, run: Run) -> float:
        """Return what an objective is not below in a run, by other runs' answers."""
        told = [about.at_least for (j, _), about in self._last.items() if j == k]
        bounds = [bound(run) for bound in told[-_ASKED:] if bound is not None]
        return max(bounds, default=-math.inf)


def _keep(last: OrderedDict[_Key, _T], key: _Key, answer: _T) -> None:
    """Keep an answer among the last that were given."""
    last[key] = answer
    if len(last) > _KEPT:
        last.popitem(last=False)


def _why_not(run: Run) -> str:
    """Return why a run tells no objective; empty if it does.

    One whose bodies do not separate does not, as the batch engine has it, too.
    """
    return run.message if run.status is RunStatus.FAILED else run.not_separated


_ROWS = 64
"""Between two tellings of progress."""
_ASKED = 8
"""Of the last answers, those that bound the next."""
_KEPT = 1024
"""Answers to expensive questions."""
