"""The draws of a campaign: launches at random, each by its number.

Draw i of a case depends on nothing but the seed and i: not on how many are drawn, on
which worker, or in which order. Its bits are those of

    np.random.Philox(counter=[d // 4, attempt, i, 0], key=seed).random_raw(4)[d % 4]

where d is 0 for what fails, and 1, 2, ... for the dispersed parameters in their order.
The upper 53 bits are a share of the distribution. Values that cannot be, such as an
inertia that no body can have, are drawn again with the next attempt.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.campaigns.philox import Words, philox
from drakesep.analysis.failure_cases import FailureCase
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import declarations


Whole = NDArray[np.int64]
"""Whole numbers."""

DESIGN = -1
"""In place of the number of a failure case: nothing fails."""
_BLOCK = 4
"""Words of a counter."""
_AT_ONCE = 16384
"""Rows that are drawn together: they fit the cache."""
_LEAST_SHARE = 1e-3
"""Of values that must be possible for draws to be found among them."""
_ENOUGH = 10_000
"""Values after which it is judged."""
_MOST = 100_000
"""Attempts at one draw: of a thousandth possible, 1e-43 of draws need more."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """What was drawn: a row for each launch."""

    indices: Whole
    """(N,) their numbers."""
    values: Array
    """(N, n) of the dispersed parameters, in SI; of what has failed, those of the
    failure case."""
    failure: Whole
    """(N,) what fails, by its place in `Draws.failures`; -1: nothing. What it changes
    and is not dispersed, the case has `in_failure`."""
    attempts: Whole
    """(N,) how often values were drawn that cannot be, before these."""
    independent: bool = True
    """Whether rows are independent of each other, as order statistics need them."""

    def __len__(self) -> int:
        return len(self.indices)

    @property
    def share_impossible(self) -> float:
        """The share of all attempts whose values cannot be."""
        again = int(self.attempts.sum())
        return again / (again + len(self)) if again else 0.0


@typed
class Draws:
    """Independent draws of a case, each by its number.

    Attributes:
        case: whose dispersed parameters are drawn.
        seed: of all draws.
        names: (n,) of the dispersed parameters.
        failures: the failure cases that may happen, in their order in the case.
    """

    def __init__(self, case: AnalysisCase, seed: int):
        """Prepare.

        Args:
            case: with distributions, correlations and probabilities of failures.
            seed: 0 or more.

        Raises:
            ValueError: the seed is negative.
        """
        if seed < 0:
            raise InputError(f"seed must be >= 0, got {seed}")
        self.case, self.seed = case, seed
        self.names = case.tolerance_set.names
        self.failures = tuple(
            one for one in case.failure_cases if one.name in case.failure_probabilities
        )
        shares = [case.failure_probabilities[one.name] for one in self.failures]
        self._until = np.cumsum(shares)
        self._design = _Launch(case, self.names)
        self._failed = [
            _Launch(case.in_failure(one), self.names, one) for one in self.failures
        ]

    def at(self, indices: Sequence[int] | Whole) -> Drawn:
        """Return the draws of some numbers.

        Args:
            indices: (N,) the numbers, 0 or more, in any order.

        Raises:
            ValueError: a number is negative, or hardly any values can be.
        """
        numbers = _numbers(indices)
        values = np.empty((len(self.names), len(numbers))).T  # by columns
        failure, attempts = np.empty_like(numbers), np.empty_like(numbers)
        for first in range(0, len(numbers), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            values[some], failure[some], attempts[some] = self._possible(numbers[some])
        return Drawn(numbers, values, failure, attempts)

    def changed_by(self, indices: Sequence[int] | Whole) -> list[dict[str, float]]:
        """Return what draws change of the separation, by name, in SI.

        What has failed has its failed value, and does not vary.

        Args:
            indices: (N,) numbers of the draws.
        """
        drawn = self.at(indices)
        return [
            dict(zip(self.names, row.tolist(), strict=True))
            | (dict(self.failures[which].values) if which >= 0 else {})
            for row, which in zip(drawn.values, drawn.failure.tolist(), strict=True)
        ]

    def shares(self, indices: Sequence[int] | Whole, attempt: int = 0) -> Array:
        """Return the shares (N, n) of the parameters' distributions, in 0 to 1.

        Independent and uniform: of parameters that depend on each other, those of the
        normal numbers that their values are made of.

        Args:
            indices: (N,) numbers of draws.
            attempt: which of each.
        """
        numbers = _numbers(indices)
        shares = np.empty((len(self.names), len(numbers))).T  # by columns
        for block in range(len(self.names) // _BLOCK + 1):
            words = self._words(numbers, attempt, block)
            for d, word in enumerate(words, block * _BLOCK):
                if 1 <= d <= len(self.names):
                    shares[:, d - 1] = _share(word)
        return shares

    def can_be(self, values: Array) -> NDArray[np.bool_]:
        """Return (N,) which values (N, n) can be, where nothing fails.

        Args:
            values: of the dispersed parameters, in SI.
        """
        return self._design.can_be(values)

    def _possible(self, numbers: Whole) -> tuple[Array, Whole, Whole]:
        """Return values (N, n) that can be, what fails, and attempts before them."""
        failure = self._failures(numbers)
        values, possible = self._attempt(numbers, failure, 0)
        attempts = np.zeros_like(numbers)
        open_, tried = np.flatnonzero(~possible), len(numbers)
        while len(open_):
            found = len(numbers) - len(open_)
            hardly = tried >= _ENOUGH and found < _LEAST_SHARE * tried
            attempts[open_] += 1
            attempt = int(attempts[open_[0]])
            if hardly or attempt > _MOST:
                raise InputError(
                    "dispersions: a campaign needs values of which a thousandth can "
                    f"be, got {found} of {tried}; narrow the tolerances of the inertia"
                )
            values[open_], possible = self._attempt(
                numbers[open_], failure[open_], attempt
            )
            open_, tried = open_[~possible], tried + len(open_)
        return values, failure, attempts

    def _words(
        self, numbers: Whole, attempt: int, block: int
    ) -> tuple[Words, Words, Words, Words]:
        """Return the words (N,) of four dimensions."""
        of_all = [np.full(len(numbers), x, dtype=np.uint64) for x in (block, attempt)]
        none = np.zeros(len(numbers), dtype=np.uint64)
        of_all[0] += np.uint64(1)  # numpy counts on before its first block
        counter = (of_all[0], of_all[1], numbers.astype(np.uint64), none)
        return philox(self.seed, counter)

    def _failures(self, numbers: Whole) -> Whole:
        """Return what fails in each, whatever its values."""
        if not self.failures:
            return np.full(len(numbers), DESIGN, dtype=np.int64)
        q = _share(self._words(numbers, 0, 0)[0])
        which = np.searchsorted(self._until, q, side="right")
        return np.where(which < len(self.failures), which, DESIGN)

    def _attempt(
        self, numbers: Whole, failure: Whole, attempt: int
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the values (N, n) of an attempt, and (N,) which of them can be."""
        rows = self.case.joint_distribution.values(self.shares(numbers, attempt))
        possible = self._design.can_be(rows)
        for which, launch in enumerate(self._failed):
            mine = np.flatnonzero(failure == which)
            rows[mine] = launch.fixed(rows[mine])
            possible[mine] = launch.can_be(rows[mine])
        return rows, possible


class _Launch:
    """What values can be in launches of a case, in which something may have failed."""

    def __init__(
        self,
        case: AnalysisCase,
        names: Sequence[str],
        failure: FailureCase | None = None,
    ):
        """Prepare.

        Args:
            case: in which it has failed.
            names: of all parameters that are drawn.
            failure: what has.
        """
        self._set = case.tolerance_set
        self._columns = [names.index(name) for name in self._set.names]
        declared = declarations(case.separation)
        self._limits = [declared[name].limits for name in self._set.names]
        changed = {} if failure is None else failure.values
        self._fixed = {
            names.index(name): value for name, value in changed.items() if name in names
        }

    def fixed(self, rows: Array) -> Array:
        """Return rows with what has failed at its values."""
        for column, value in self._fixed.items():
            rows[:, column] = value
        return rows

    def can_be(self, rows: Array) -> NDArray[np.bool_]:
        """Return (N,) which rows have values that their parameters can have."""
        columns, box = rows.T[self._columns], self._set.box
        possible = np.full(len(rows), True)
        for column, (least, most) in zip(columns, self._limits, strict=True):
            possible &= (column >= least) & (column <= most)
        with np.errstate(over="ignore", invalid="ignore"):  # beyond the limits
            u = (columns - box.nominal[:, None]) / box.tolerance[:, None]
            return possible & self._set.can_exist(u.T)


def _share(words: Words) -> Array:
    """Return numbers in 0 to 1, both left out, of the upper 53 bits of words."""
    return np.asarray(np.maximum(words >> np.uint64(11), np.uint64(1)) * 2.0**-53)


def _numbers(indices: Sequence[int] | Whole) -> Whole:
    numbers = np.asarray(indices)
    if numbers.ndim != 1 or (numbers.size and numbers.dtype.kind not in "iu"):
        raise InputError(f"indices must be whole numbers (N,), got {indices!r}")
    if numbers.size and int(numbers.min()) < 0:
        raise InputError(f"indices must be >= 0, got {int(numbers.min())}")
    return numbers.astype(np.int64)
