"""A run as the page shows it: signals over time, their limits, what is required.

It is flown as `drakesep simulate` flies it, in whatever process calls this.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.plots.limits import limit_words
from drakesep.plots.panels import ROTATION, TRANSLATION, Panel, panels_of
from drakesep.plots.shown_runs import Decided, ShownRuns
from drakesep.studies.simulate import Simulated, simulate
from drakesep.systems.arrays import Array
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair


_ALWAYS = ("rate", "angle", "relative velocity")
"""What is shown of each body that leaves; anything else where it is required."""


class Limit(NamedTuple):
    """A limit on a signal, while it holds."""

    values: tuple[float, ...]
    """In the unit of the signal; two of a limit on a magnitude."""
    start: float
    end: float
    words: str


@dataclass(frozen=True, kw_only=True)
class Signal:
    """A signal over the time of a run.

    Attributes:
        body: that leaves.
        quantity: such as ``rate``.
        axis: of its component; empty if it has none.
        unit: symbol.
        values: (n,) in that unit, at the times of the body.
        limits: required of it.
    """

    body: str
    quantity: str
    axis: str
    unit: str
    values: Array
    limits: tuple[Limit, ...]


class Fares(NamedTuple):
    """How a run fares by one requirement and axis."""

    requirement: str
    axis: str
    pair: str
    unit: str
    sense: str
    limit: float
    value: float
    """NaN if it was not looked at."""
    verdict: str


@dataclass(frozen=True, kw_only=True)
class Flown:
    """A run, flown.

    Attributes:
        message: why it failed; empty if it did not.
        times: (n,) of each body that leaves, s.
        separated: when each body has separated, s; infinite if it does not.
        signals: of all bodies that leave.
        fares: by all requirements.
    """

    message: str
    times: Mapping[str, Array]
    separated: Mapping[str, float]
    signals: tuple[Signal, ...]
    fares: tuple[Fares, ...]


def fly(case: AnalysisCase, values: Mapping[str, float], *, measure: bool) -> Flown:
    """Fly a case with some of its parameters changed.

    Args:
        case: in SI.
        values: by parameter name with unit, ``payload.mass_kg``.
        measure: whether to measure how near parts come, where that is required.

    Raises:
        ValueError: a value is none that can be flown.
    """
    result = simulate(case, values, measure=measure)
    if not result.completed:
        why = result.labelled.outcome.message
        return Flown(message=why, times={}, separated={}, signals=(), fares=())
    run = result.run
    bodies = [pair.B for pair in case.separation.pairs]
    return Flown(
        message="",
        times={body: run.motion_of(body).time for body in bodies},
        separated={body: run.end_of(body) for body in bodies},
        signals=tuple(_signals(result)),
        fares=tuple(_fares(result)),
    )


def _signals(result: Simulated) -> Iterator[Signal]:
    shown = ShownRuns.of([result.labelled], result.case)
    separation = result.run.separation
    for pair in separation.pairs:
        for topic in (ROTATION, TRANSLATION):
            for panel in panels_of(topic, separation, pair, shown.decided):
                if panel.decided or panel.title.startswith(_ALWAYS):
                    yield _signal(panel, pair, result.run)


def _signal(panel: Panel, pair: Pair, run: Run) -> Signal:
    quantity, _, axis = panel.title.partition(", ")
    return Signal(
        body=pair.B,
        quantity=quantity,
        axis=axis,
        unit=panel.unit.symbol,
        values=panel.unit.per_si * panel.values(run),
        limits=tuple(_limit(panel, decided) for decided in panel.decided),
    )


def _limit(panel: Panel, decided: Decided) -> Limit:
    requirement = decided.finding.requirement
    limit = decided.metric.sign * panel.unit.from_si(requirement.limit)
    both = decided.metric.is_magnitude and panel.column is not None
    start, end = decided.window
    return Limit(
        values=(limit, -limit) if both else (limit,),
        start=start if start < end else 0.0,
        end=end,
        words=limit_words(requirement),
    )


def _fares(result: Simulated) -> Iterator[Fares]:
    table = result.requirements
    for row in table.to_dict("records"):
        yield Fares(**{key: row[key] for key in Fares._fields})
