"""Probabilities far out, by subset simulation (Au and Beck 2001).

What is beyond a far limit is reached by levels, each beyond the one before with a
probability that few draws tell; their product is that of the limit. Draws beyond a
level come by Markov chains from those that the level before has found there.

S.-K. Au and J. L. Beck, Probabilistic Engineering Mechanics 16(4), 2001,
doi:10.1016/S0266-8920(01)00019-4; the chains are those of I. Papaioannou, W. Betz,
K. Zwirglmaier and D. Straub, same journal 41, 2015,
doi:10.1016/j.probengmech.2015.06.006.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from drakesep.analysis.campaigns.statistics import Estimate
from drakesep.analysis.search.ask_tell import side_by_side
from drakesep.systems.argument_types import typed
from drakesep.systems.arrays import Array
from drakesep.systems.checks import InputError, check_finite, check_share


Values: TypeAlias = Callable[[Array], Array]
"""Of points (N, n), whose entries are independent and standard normal, (N,) values."""
Admits: TypeAlias = Callable[[Array], NDArray[np.bool_]]
"""Of points (N, n), (N,) whether there are such: others are drawn again."""

_FIRST_STEP = 0.6
"""Of a chain, as a share of what would forget where it comes from; Papaioannou's."""
_ACCEPTED = 0.44
"""The share of steps that are to be taken: then chains forget soonest; the same."""
_TIED = 0.5
"""So many draws that equal a level are no draws beyond it: the values go no higher."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RareProbability:
    """The probability that a value is beyond a limit, and how sure that is."""

    replicates: tuple[float, ...]
    """What independent simulations found."""
    levels: tuple[tuple[float, ...], ...]
    """Of each, the values that it has gone up by."""
    runs: int
    """That all took."""
    untold: int
    """Of them, those that had no value: each is counted as beyond the limit."""
    unreached: int
    """Simulations that have not reached the limit: they count with the least
    probability that was looked for, so that the whole is no smaller."""

    @property
    def probability(self) -> float:
        """The mean of the simulations."""
        return float(np.mean(self.replicates))

    @property
    def variation(self) -> float:
        """Its coefficient of variation, by what the simulations differ."""
        deviation = float(np.std(self.replicates, ddof=1))
        return deviation / (self.probability * math.sqrt(len(self.replicates)))

    def within(self, confidence: float) -> Estimate:
        """Return the probability with its interval, Student's."""
        check_share("confidence", confidence)
        times = float(stdtrit(len(self.replicates) - 1, (1.0 + confidence) / 2.0))
        low, high = (
            self.probability * (1.0 + sign * times * self.variation)
            for sign in (-1.0, 1.0)
        )
        return Estimate(self.probability, max(low, 0.0), high)


@typed
def subset_simulation(
    values: Values,
    parameters: int,
    limit: float,
    *,
    per_level: int = 1800,
    level_share: float = 0.1,
    replicates: int = 10,
    least: float = 1e-9,
    seed: int = 0,
    admits: Admits | None = None,
) -> RareProbability:
    """Return the probability that a value is beyond a limit, however small it is.

    Independent simulations go up side by side; what they differ by tells the error, of
    all that chains do, too. A region that none has found is in none of them: whoever
    has two ways to go wrong looks at each by itself.

    Args:
        values: of points (N, n) in the space of independent standard normal numbers,
            (N,); the larger the worse, NaN where a run does not tell.
        parameters: n.
        limit: beyond which, not at which, a value is.
        per_level: draws of each simulation at each level; 1800 take some 9000 for 1e-5.
        level_share: of a level's draws that are beyond the next; the number that are
            must be whole, and divide the others.
        replicates: simulations, two or more.
        least: probability below which a simulation ends.
        seed: of all numbers, drawn by Philox; the same with one version of numpy.
        admits: which points there are; all, if None. The probability is of these.

    Raises:
        ValueError: a setting makes no sense.
    """
    check_finite("limit", limit)
    chains = chains_of(per_level, level_share, replicates, least)
    simulations = [
        _Simulation(
            rng=np.random.Generator(np.random.Philox(each)),
            parameters=parameters,
            limit=limit,
            chains=chains,
            length=per_level // chains,
            least=least,
            admits=admits or _all_of_them,
        )
        for each in np.random.SeedSequence(seed).spawn(replicates)
    ]
    # Of one simulation a step of its chains is a few hundred runs: together, thousands.
    found = side_by_side(
        [simulation.run for simulation in simulations], partial(_answers, values)
    )
    return RareProbability(
        replicates=tuple(found),
        levels=tuple(tuple(one.levels) for one in simulations),
        runs=sum(one.runs for one in simulations),
        untold=sum(one.untold for one in simulations),
        unreached=sum(not one.reached for one in simulations),
    )


def chains_of(per_level: int, level_share: float, replicates: int, least: float) -> int:
    """Return how many chains begin at each level, of settings of `subset_simulation`.

    Raises:
        ValueError: a setting makes no sense.
    """
    check_share("level_share", level_share)
    check_share("least", least)
    if replicates < 2:
        raise InputError(f"replicates must be >= 2, got {replicates}")
    chains = round(per_level * level_share)
    if chains < 2 or per_level % chains:
        raise InputError(
            "per_level times level_share must be two or more and divide per_level, got "
            f"{per_level} and {level_share}"
        )
    return chains


def most_runs(per_level: int, replicates: int, least: float) -> int:
    """Return how many runs `subset_simulation` takes at most, about.

    Of levels that each are a tenth as probable as the one before.

    Args:
        per_level: draws of each simulation at each level.
        replicates: simulations.
        least: probability below which a simulation ends.
    """
    levels = 1 + math.ceil(-math.log10(least))
    return replicates * per_level * levels


def _all_of_them(points: Array) -> NDArray[np.bool_]:
    return np.ones(len(points), bool)


def _answers(values: Values, points: list[Array]) -> list[Array | None]:
    """Return the values of the points of several simulations, at once."""
    found = np.asarray(values(np.concatenate(points)), float)
    ends = np.cumsum([len(each) for each in points])[:-1]
    return [*np.split(found, ends)]


@dataclass(slots=True, kw_only=True)
class _Simulation:
    """One simulation, as it goes up."""

    rng: np.random.Generator
    parameters: int
    limit: float
    chains: int
    length: int
    least: float
    admits: Admits
    step: float = _FIRST_STEP
    runs: int = 0
    untold: int = 0
    reached: bool = True
    levels: list[float] = field(default_factory=list)

    def run(self, ask: Values) -> float:
        """Return the probability that it finds.

        Args:
            ask: tells values of points.
        """
        points = self._draws(self.chains * self.length)
        found = self._values(ask, points)
        probability = 1.0
        while probability >= self.least:
            level = float(np.sort(found)[-self.chains])
            if level > self.limit:
                return probability * float((found > self.limit).mean())
            beyond = np.flatnonzero(found >= level)
            if len(beyond) > _TIED * len(found):
                break
            self.levels.append(level)
            probability *= len(beyond) / len(found)
            seeds = self.rng.permutation(beyond)[: self.chains]
            points, found = self._beyond(ask, level, points[seeds], found[seeds])
        self.reached = False
        return self.least

    def _beyond(
        self, ask: Values, level: float, points: Array, found: Array
    ) -> tuple[Array, Array]:
        """Return draws beyond a level, by chains from some that are."""
        all_points, all_found = [points], [found]
        for count in range(1, self.length):
            # What is standard normal and independent stays so.
            kept = math.sqrt(1.0 - self.step**2)
            noise = self.rng.standard_normal(points.shape)
            proposed = kept * points + self.step * noise
            there = self.admits(proposed)
            values = np.full(len(points), -math.inf)
            values[there] = self._values(ask, proposed[there])
            taken = values >= level
            points = np.where(taken[:, None], proposed, points)
            found = np.where(taken, values, found)
            all_points.append(points)
            all_found.append(found)
            # Ever less, so that chains come to rest.
            change = (float(taken.mean()) - _ACCEPTED) / math.sqrt(count)
            self.step = min(self.step * math.exp(change), 1.0)
        return np.concatenate(all_points), np.concatenate(all_found)

    def _values(self, ask: Values, points: Array) -> Array:
        """Return values; of those that do not tell, infinity."""
        found = ask(points) if len(points) else np.zeros(0)
        missing = np.isnan(found)
        self.runs += len(points)
        self.untold += int(missing.sum())
        return np.where(missing, math.inf, found)

    def _draws(self, count: int) -> Array:
        """Return draws (count, n) of points that there are."""
        points = np.empty((0, self.parameters))
        while len(points) < count:
            more = self.rng.standard_normal((count, self.parameters))
            points = np.concatenate([points, more[self.admits(more)]])
        return points[:count]
