"""What a study will do, and how long that takes: planned by measured speed.

Effort comes in a few grades, each a quarter of the one before, so that a plan does not
follow every whim of a machine: what takes less than four minutes is searched with all
of it, VEGA on a machine ten times as slow too. Of what takes longer, the first grade is
taken that does not, by the speed of one core: the number of workers changes nothing.
Where two machines plan otherwise, the options that a plan tells make them agree.

What takes more than ten minutes is done if it is asked for: by the names of searches,
or by granting more time, which has it searched harder too. Else it is refused.
"""

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.objectives import OBJECTIVES, Needs, Objective
from drakesep.analysis.search.effort import Effort, SearchSettings, fewer_starts
from drakesep.analysis.search.problem import FROM_BEST, FROM_NOMINAL
from drakesep.studies.worst_case.searches import (
    DRAKE,
    WantedSearches,
    default_searches,
)
from drakesep.studies.worst_case.speed import Speed
from drakesep.systems.checks import InputError, check_positive


GROWTH, CONFIRMATION = "growth", "confirmation"
PROOF, CAMPAIGN, FAILURES = "proof", "campaign", "failure cases"
"""What follows the searches."""
_ASKED_FOR = (PROOF, CAMPAIGN, FAILURES)
"""What is asked for, however long it takes."""
_MOST_FLIPS, _MOST_SAMPLES = 4, 2048
"""Of a failure case: there are many of these, and the design's worst are known."""
_SHARE, _LEAST_SAMPLES = 16, 32
"""Times fewer samples than of the design, but not fewer than so many."""
_GRADES = 8
MINUTES = 10.0
"""That a study may take, unasked: beyond these, something is left out."""
_AIM = 0.4
"""Beyond this share of them, the next grade is taken."""
_LEFT_OUT_FIRST = {
    "multistart": "starts",
    "corners": "flips",
    "vertices": "vertices",
    "samples": "samples",
}
"""After growth; and the setting of each: what is asked for is not left out."""
_CORES = 2
"""With which grades are reckoned, whatever the machine has; what is left out, with one.
"""
_GRANTED = 1.5
"""Times what is reckoned, that a user is told to grant: tomorrow it may take longer."""

# What searches ask for, as it was counted for VEGA and a smallsat.
_ITERATIONS = 8
"""Of an ascent."""
_ROUNDS = 1.5
"""Of flips of bounds; one is flown whatever is affordable."""
_STAGES, _OF_LIMIT, _ROOT_CALLS = 7, 50, 80
"""Of growth: stages in which all tolerances grow, runs of a limit, and calls in which
those of all limits are flown."""
_ASCENT, _LIMIT = 2e-3, 6e-3
"""What the optimiser takes itself for an iteration, and for a limit, s."""
_MEASUREMENTS, _LOOKS, _ON_RAY = 8, 0.3, 12
"""Of an ascent by measurements; of a run that may come nearer than all others; and of
growth along the ray to a worst case."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyEffort:
    """What a study will do."""

    objectives: int
    parameters: int
    searches: tuple[str, ...]
    """In the order in which they go."""
    settings: SearchSettings
    growth: bool
    """Whether it is looked how far tolerances may grow."""
    failures: int = 0
    """Failure cases that are searched beside the design."""
    draws: int = 0
    """Of the campaign that is flown beside the searches."""
    proofs: int = 0
    """Bounds that are proven beside them."""
    seconds: Mapping[str, float]
    """That each search takes, and what follows them, in their order."""
    left_out: tuple[str, ...] = ()
    """What takes too long."""
    minutes: float = MINUTES
    """That it may take, if not all of it is asked for by name."""
    run_by_run: tuple[str, ...] = ()
    """Objectives for which whole runs are flown, since the batch cannot tell them by
    metrics; or all, if Drake flies alone."""
    whole_runs: float = 0.0
    """How many that takes, about."""
    drake_alone: bool = False
    """Whether Drake flies them, and no batch engine."""

    @property
    def total(self) -> float:
        """Seconds."""
        return sum(self.seconds.values())

    def __str__(self) -> str:
        """Return it in a line."""
        settings = self.settings
        what = {
            "samples": f"{_spaced(settings.samples)} samples",
            "vertices": f"{_spaced(2**self.parameters)} vertices",
            "corners": "corners by flips of bounds",
            FROM_NOMINAL: "SQP from the nominal",
            "multistart": f"SQP from {settings.starts} starts",
            "evolution": "differential evolution",
        }
        if "multistart" in self.searches and FROM_NOMINAL in self.searches:
            del what[FROM_NOMINAL]  # one of the starts
        steps = [what[name] for name in self.searches if name in what]
        if self.growth:
            steps.append("growth of tolerances")
        if self.proofs:
            at_most = in_time(self.seconds[PROOF])
            bounds = _counted(self.proofs, "bound")
            steps.append(f"proof of {bounds} in at most {at_most}")
        if self.draws:
            steps.append(f"{_spaced(self.draws)} draws of a campaign")
        if self.failures:
            steps.append(_counted(self.failures, "failure case"))
        text = (
            f"worst cases of {_counted(self.objectives, 'objective')} over "
            f"{_counted(self.parameters, 'parameter')}: {', '.join(steps)}; about "
            f"{in_time(self.total)}"
        )
        if self.run_by_run:
            text += (
                f"; flown run by run{' in Drake' if self.drake_alone else ''}, some "
            )
            text += f"{_rounded(self.whole_runs)} runs: {', '.join(self.run_by_run)}"
        if self.left_out:
            text += f"; left out, to stay within {self.minutes:g} min: "
            text += ", ".join(self.left_out)
        return text

    @property
    def options(self) -> dict[str, int | bool | tuple[str, ...]]:
        """What plans the same on any machine, by the arguments' names."""
        settings = self.settings
        return {
            "searches": (DRAKE,) if self.drake_alone else self.searches,
            "samples": settings.samples,
            # Of fewer parameters there are no more.
            "vertices": min(2**self.parameters, settings.vertices),
            "flips": settings.flips,
            "starts": settings.starts,
            "corners": settings.corners,
            "growth": self.growth,
        }


def planned_effort(
    case: AnalysisCase,
    objectives: Sequence[Objective],
    wanted: WantedSearches,
    effort: Effort,
    growth: bool | None,
    speed: Speed,
    minutes: float | None = None,
    failures: int = 0,
    draws: int = 0,
    draws_in_drake: int = 0,
    proofs: int = 0,
    proof_seconds: float = 0.0,
) -> StudyEffort:
    """Return what a study will do.

    Args:
        case: that is searched.
        objectives: that are searched.
        wanted: the searches that are asked for.
        effort: settings that are asked for, which are kept.
        growth: whether to look how far tolerances may grow; None: if there is time.
        speed: how fast the case flies.
        minutes: that it may take; None: `MINUTES`, or as long as searches take that are
            asked for.
        failures: failure cases that are searched beside the design.
        draws: of the campaign that is flown beside the searches.
        draws_in_drake: of them, those that Drake flies.
        proofs: bounds that are proven beside the searches.
        proof_seconds: that these take together, at most.

    Raises:
        ValueError: it takes longer, with the least effort.
    """
    granted = MINUTES if minutes is None else minutes
    costs = _Costs(
        case,
        objectives,
        speed,
        failures=failures,
        draws=draws,
        draws_in_drake=draws_in_drake,
        proof_seconds=proof_seconds,
        drake_alone=wanted.drake_alone,
    )
    growth_is_wanted = (not wanted.drake_alone) if growth is None else growth

    def of_grade(grade: int, without: Collection[str]) -> _Steps:
        settings = _settings(objectives, grade, effort)
        names = wanted.names or default_searches(len(case.box), settings, objectives)
        kept = tuple(name for name in names if name not in without)
        return kept, settings, growth_is_wanted and GROWTH not in without

    least = _GRADES - 1
    searched, _, grown = of_grade(least, ())
    unasked = [
        name
        for name in _unasked(wanted, effort, growth)
        if name in searched or (name == GROWTH and grown)
    ]
    without = _too_long(
        unasked, lambda out: costs.minutes(*of_grade(least, out), 1) <= granted
    )
    for grade in range(_GRADES):
        names, settings, grows = of_grade(grade, without)
        if costs.minutes(names, settings, grows, _CORES) <= _AIM * granted:
            break
    planned = StudyEffort(
        objectives=len(objectives),
        parameters=len(case.box),
        searches=names,
        settings=settings,
        growth=grows,
        failures=failures,
        draws=draws,
        proofs=proofs,
        seconds=costs.of(names, settings, grows, speed.cores),
        left_out=without,
        minutes=granted,
        run_by_run=costs.run_by_run,
        whole_runs=costs.whole_runs(names, settings, grows),
        drake_alone=wanted.drake_alone,
    )
    if minutes is not None:
        _check_granted(planned, planned.total)
    elif wanted.names is None:
        _check_granted(planned, _unless_asked_for(planned.seconds))
    return planned


def _unless_asked_for(seconds: Mapping[str, float]) -> float:
    """Return the seconds of a study, without what is done however long it takes."""
    return sum(s for step, s in seconds.items() if step not in _ASKED_FOR)


_Steps: TypeAlias = tuple[tuple[str, ...], SearchSettings, bool]
"""Searches, how hard they are, and whether growth follows."""


def _too_long(
    unasked: Sequence[str], fits: Callable[[Collection[str]], bool]
) -> tuple[str, ...]:
    """Return what is left out: what would take too long with the least effort.

    Args:
        unasked: what may be, in the order in which it is.
        fits: whether there is time for the rest without some of it.
    """
    out: list[str] = []
    for name in unasked:
        if fits(out):
            break
        out.append(name)
    for name in tuple(reversed(out)):  # it may have gone in vain
        rest = [other for other in out if other != name]
        if fits(rest):
            out = rest
    return tuple(out)


def of_failure(
    searches: Sequence[str], settings: SearchSettings, objectives: Sequence[Objective]
) -> tuple[tuple[str, ...], SearchSettings]:
    """Return how a failure case is searched: from where the design is worst.

    Args:
        searches: of the design.
        settings: how hard they are.
        objectives: of the failure case.
    """
    cheap = not all(objective.expensive for objective in objectives)
    instead = {
        "samples": {"samples"},
        "corners": {"vertices", "corners"} if cheap else set(),
        FROM_BEST: {FROM_NOMINAL, "multistart"},
    }
    few = tuple(name for name, of in instead.items() if not of.isdisjoint(searches))
    share = max(settings.samples // _SHARE, _LEAST_SAMPLES)
    samples = min(settings.samples, share, _MOST_SAMPLES)
    flips = min(settings.flips, _MOST_FLIPS)
    return few or tuple(searches), replace(settings, samples=samples, flips=flips)


def _unasked(
    wanted: WantedSearches, effort: Effort, growth: bool | None
) -> Iterator[str]:
    """Yield what may be left out, in the order in which it is."""
    if growth is None:
        yield GROWTH
    if wanted.names is None:
        yield from (s for s, number in _LEFT_OUT_FIRST.items() if number not in effort)


def check_minutes(minutes: float | None) -> None:
    """Raise InputError unless it is a time that a study may take."""
    if minutes is not None:
        check_positive("minutes", minutes)


def _check_granted(planned: StudyEffort, seconds: float) -> None:
    takes = seconds / 60.0
    if takes <= planned.minutes:
        return
    enough = _GRANTED * takes
    step = 5 if enough > 5 else 10 ** math.floor(math.log10(enough))
    enough = step * math.ceil(enough / step)
    raise InputError(
        f"minutes: must be {enough:g} or more on this machine, got "
        f"{planned.minutes:g}, for {planned}"
    )


def _settings(
    objectives: Sequence[Objective], grade: int, effort: Effort
) -> SearchSettings:
    """Return the settings of a grade of effort; 0 is all of it."""
    chosen = SearchSettings.of_grade(grade)
    given: Effort = effort
    if all(objective.expensive for objective in objectives):
        given = {"samples": min(32, chosen.samples), "vertices": 32, **effort}
    return SearchSettings.of_grade(grade, **given)


class _Costs:
    """What searches take, s."""

    def __init__(
        self,
        case: AnalysisCase,
        objectives: Sequence[Objective],
        speed: Speed,
        *,
        failures: int,
        draws: int,
        draws_in_drake: int,
        proof_seconds: float,
        drake_alone: bool,
    ):
        self._n = len(case.box)
        self.run_by_run = tuple(
            o.name for o in objectives if drake_alone or o.needs is not Needs.METRICS
        )
        self._speed = speed
        self._failures = failures
        self._draws, self._draws_in_drake = draws, draws_in_drake
        self._proof_seconds = proof_seconds
        self._drake_alone = drake_alone
        self._cheap = [o for o in objectives if not o.expensive]
        self._expensive = [o for o in objectives if o.expensive]
        self._dear = len(self._expensive)
        self._runs = sum(o.needs is Needs.RUN for o in self._cheap)
        needs = {o.name: o.needs for o in objectives}
        self._ends = len(needs.keys() & set(OBJECTIVES)) + len(objectives)
        towards = [
            name
            for requirement in case.requirements
            if not requirement.measured_apart
            for name in case.names_towards(requirement)
            if name in needs
        ]
        self._directions = len(towards)
        self._directions_of_runs = sum(needs[name] is Needs.RUN for name in towards)

    def minutes(
        self, names: Sequence[str], settings: SearchSettings, growth: bool, cores: int
    ) -> float:
        """Return the minutes that it takes, without what is asked for."""
        return _unless_asked_for(self.of(names, settings, growth, cores)) / 60.0

    def of(
        self, names: Sequence[str], settings: SearchSettings, growth: bool, cores: int
    ) -> dict[str, float]:
        """Return the seconds of searches, and of what follows them."""
        seconds = {name: self._search(name, settings, cores) for name in names}
        if self._dear and self._cheap:  # beside the others, in a thread
            fewer = [_starts(name, fewer_starts(settings.starts)) for name in names]
            took = sum(fewer) * self._of_measurements
            last = max((n for n in names if _starts(n, 1)), key=names.index)
            others = sum(seconds.values())
            on_one = sum(self._search(name, settings, 1) for name in names)
            seconds[last] += max(0.0, took - others, (took + on_one) / cores - others)
        look = _LOOKS * self._speed.measurement
        each = self._speed.drake + look + self._speed.recording
        seconds[CONFIRMATION] = self._ends * each
        if growth:
            seconds[GROWTH] = self._growth(settings, cores)
        if self._proof_seconds:
            seconds[PROOF] = self._proof_seconds
        if self._draws:  # whatever searches fly with, the batch engine flies them
            flown = self._draws * self._speed.run / self._speed.cores
            seconds[CAMPAIGN] = flown + self._draws_in_drake * self._speed.drake
        if self._failures:
            few, less = of_failure(names, settings, (*self._cheap, *self._expensive))
            searched = sum(self._search(name, less, cores) for name in few)
            if self._cheap:  # else they are in it
                starts = [_starts(name, less.starts) for name in few]
                searched += sum(starts) * self._of_measurements
            flown = self._speed.drake + 0.5 * seconds[CONFIRMATION]  # one side of two
            seconds[FAILURES] = self._failures * (searched + flown)
        return seconds

    @property
    def _of_measurements(self) -> float:
        """An ascent by measurements, and by the runs that are measured."""
        whole = (self._n + 2) * self._whole_run
        return self._dear * _MEASUREMENTS * (self._speed.measurement + whole)

    @property
    def _whole_run(self) -> float:
        return self._speed.drake if self._drake_alone else self._speed.whole_run

    def whole_runs(
        self, names: Sequence[str], settings: SearchSettings, growth: bool
    ) -> float:
        """Return how many runs are flown one by one, for what metrics do not tell."""
        cheap = len(self._cheap) if self._drake_alone else self._runs
        swept = bool(cheap) or not self._cheap
        beside = fewer_starts(settings.starts) if self._cheap else settings.starts
        runs = self._whole_runs_of_growth(settings) if growth else 0.0
        for name in names:
            ascents = cheap * _starts(name, settings.starts)
            ascents += self._dear * _starts(name, beside)
            runs += ascents * _ITERATIONS * (self._n + 2)
            runs += self._points(name, settings) if swept else 0.0
        return runs

    def _points(self, name: str, settings: SearchSettings) -> float:
        """Return how many points a sweep looks at; 0 of an ascent."""
        n, m = self._n, len(self._cheap)
        corners = min(16, settings.flips)
        a_round = 4 * corners * n + min(4, corners) * n**2 // 2
        flips = min(max(settings.flips, a_round), _ROUNDS * a_round, 2.0**n)
        points = {
            "samples": settings.samples,
            "vertices": min(2.0**n, settings.vertices),
            "corners": m * flips,
            "evolution": m * 8 * n * settings.generations,
        }
        return points.get(name, 0.0)

    def _flown(self, runs: float, cores: int, calls: float = 1.0) -> float:
        """Runs on the batch engine, in so many calls that wait for each other."""
        speed = self._speed
        if self._drake_alone:
            return runs * speed.drake
        return max(runs * speed.run / cores, calls * speed.call)

    def _search(self, name: str, settings: SearchSettings, cores: int) -> float:
        n, m = self._n, len(self._cheap)
        if not m:  # measurements alone, one after the other
            sweeps = {"samples": settings.samples, "vertices": 2.0**n}
            once = self._speed.measurement + self._whole_run
            return (
                self._dear * sweeps.get(name, 0.0) * once
                + _starts(name, settings.starts) * self._of_measurements
            )
        points = self._points(name, settings)
        if points:
            share = 1.0 if name in ("samples", "vertices") else self._runs / m
            whole = points * share * self._speed.whole_run if self._runs else 0.0
            return self._flown(points, cores) + whole
        iterations = m * _starts(name, settings.starts) * _ITERATIONS
        each = iterations * (n + 2)
        whole = each * self._runs / m * self._speed.whole_run
        return self._flown(each, cores, 2 * _ITERATIONS) + whole + iterations * _ASCENT

    def _growth(self, settings: SearchSettings, cores: int) -> float:
        limits = self._directions * (self._n + 1)
        stages = self._flown(_STAGES * settings.corners, cores)
        roots = self._flown(_OF_LIMIT * limits, cores, _ROOT_CALLS)
        whole = self._whole_runs_of_growth(settings) * self._speed.whole_run
        once = self._speed.measurement + self._whole_run
        rays = self._dear * _ON_RAY * once
        return stages + roots + whole + limits * _LIMIT + rays

    def _whole_runs_of_growth(self, settings: SearchSettings) -> float:
        if not self._directions_of_runs:
            return 0.0
        limits = self._directions_of_runs * (self._n + 1)
        return _STAGES * settings.corners + _OF_LIMIT * limits


def _starts(name: str, starts: int) -> int:
    """Return from how many starts a search goes up; 0 if it is a sweep."""
    return {FROM_NOMINAL: 1, FROM_BEST: 1, "multistart": starts}.get(name, 0)


def in_time(seconds: float) -> str:
    """Return a time in words, no finer than it is known."""
    if seconds < 10.0:
        return f"{max(1, round(seconds))} s"
    if seconds < 100.0:
        return f"{5 * round(seconds / 5)} s"
    return f"{round(seconds / 60)} min"


def _counted(number: int, name: str) -> str:
    return f"{number} {name}{'' if number == 1 else 's'}"


def _rounded(number: float) -> str:
    """Return a number to its first digit, in words."""
    size = 10 ** max(0, len(str(round(number))) - 1)
    return _spaced(size * max(1, round(number / size)))


def _spaced(number: int) -> str:
    return f"{number:,}".replace(",", " ")
