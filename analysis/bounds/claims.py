"""From metrics to what bounds are proven of, and back to numbers of metrics.

A bound on a metric from above is proven, or one from below. What no bound covers is
refused by name.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

from drakesep.analysis.bounds.grid import Grid, last_stroke, pieces_between
from drakesep.analysis.bounds.problem import BoundProblem, NotCovered
from drakesep.analysis.bounds.quantities import (
    LESS_MAGNITUDE,
    Field,
    Kind,
    Law,
    Quantity,
    Signal,
    Term,
)
from drakesep.analysis.metrics import metric as metrics
from drakesep.analysis.metrics.metric import (
    Combined,
    Functional,
    Metric,
    Moment,
    Outer,
    Time,
    Window,
)
from drakesep.analysis.metrics.of_run import metric_named
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.systems.checks import Vector3
from drakesep.systems.equations import pair_signals as laws
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.model.separation import Separation


Side: TypeAlias = Literal["highest", "lowest"]


def side_of(requirement: Requirement) -> Side:
    """Return to which side a requirement limits its metric."""
    return "highest" if requirement.from_above else "lowest"


def claim_name(metric: str, side: Side) -> str:
    """Return the name of a claim: as of the objective that leads there."""
    return f"{side}_{metric}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """That a metric is nowhere above, or below, some number."""

    metric: str
    side: Side
    quantity: Quantity
    outer: Outer = Outer.ITSELF
    squared: bool = False
    """Whether the metric is the root of what is bounded."""
    sign: float = 1.0
    """-1: less the metric is bounded from above."""

    @property
    def name(self) -> str:
        """As of the objective that leads there."""
        return claim_name(self.metric, self.side)

    def value(self, bound: float) -> float:
        """Return the metric at a bound of the quantity, rounded outward.

        Args:
            bound: from above, of the quantity.
        """
        x = self.sign * bound  # of the signal, or of the sum
        if self.outer is Outer.ITSELF and not self.squared:
            return x
        made = math.sqrt(max(x, 0.0))
        if self.outer is Outer.CONE:
            made = 2.0 * math.asin(min(made, 1.0))
        return made + self.sign * 1e-15 * made


_FIELDS: dict[str, Field] = {
    "rate": "rate",
    "relative_rate": "relative_rate",
    "relative_velocity": "relative_velocity",
    "relative_position": "relative_position",
}
_LAWS: dict[
    Callable[..., object], tuple[Law, Callable[[PairFacts], Vector3] | None]
] = {
    laws.along: ("along", lambda facts: facts.direction_A),
    laws.across_squared: ("across_squared", lambda facts: facts.direction_A),
    laws.about: ("along", lambda facts: facts.direction_B),
    laws.transverse_squared: ("across_squared", lambda facts: facts.direction_B),
    laws.length_squared: ("length_squared", None),
}
_INTEGRALS: dict[Functional, Kind] = {
    Functional.INTEGRAL_OF_MAGNITUDE: "integral_of_magnitude",
    Functional.INTEGRAL_OF_SQUARE: "integral_of_square",
}
_SIGNS: dict[tuple[Functional, Side], tuple[int, ...]] = {
    (Functional.VALUE, "highest"): (1,),
    (Functional.VALUE, "lowest"): (-1,),
    (Functional.MAGNITUDE, "highest"): (1, -1),
    (Functional.MAGNITUDE, "lowest"): (LESS_MAGNITUDE,),
    (Functional.LARGEST, "highest"): (1,),
    (Functional.LARGEST, "lowest"): (-1,),
    (Functional.SMALLEST, "highest"): (1,),
    (Functional.SMALLEST, "lowest"): (-1,),
    (Functional.LARGEST_MAGNITUDE, "highest"): (1, -1),
    (Functional.LARGEST_MAGNITUDE, "lowest"): (LESS_MAGNITUDE,),
    (Functional.SMALLEST_MAGNITUDE, "highest"): (1, -1),
    (Functional.SMALLEST_MAGNITUDE, "lowest"): (LESS_MAGNITUDE,),
}
_AT_ONCE = {
    (Functional.LARGEST, "lowest"),
    (Functional.SMALLEST, "highest"),
    (Functional.LARGEST_MAGNITUDE, "lowest"),
    (Functional.SMALLEST_MAGNITUDE, "highest"),
}
"""What is bounded by the signal at any one time of the window."""


def claim_of(
    separation: Separation, problem: BoundProblem, grid: Grid, name: str, side: Side
) -> Claim:
    """Return what is to be proven of a metric.

    Args:
        separation: whose metric it is.
        problem: of the separation.
        grid: of time, with the moments of the metric (see `moments`).
        name: of the metric.
        side: whether it is bounded from above or from below.

    Raises:
        NotCovered: nothing can be proven of it.
        ValueError: there is no such metric.
    """
    metric = metric_named(name)
    _check(metric, name)
    assert metric.signal is not None
    body = metric.pair or separation.B
    B = [b.name for b in problem.bodies].index(body)
    [pair] = [j for j, p in enumerate(problem.pairs) if p.B == B]
    facts = PairFacts.of(separation, separation.pair_of(body))
    signals = _signals(metric, name, pair, facts)
    if metric.combined is Combined.EACH:
        signals = [signals[metric.names.index(name)]]
    wanted: Side = side if metric.sign > 0.0 else _OTHER[side]
    kind, signs, at_once = _how(metric.functional, wanted, name)
    if at_once and len(signals) > 1:
        raise NotCovered(f"{side} {name}: bounds cover its other side alone")
    window = over = _window(metric, problem, grid, pair)
    if at_once:
        window = (_one_piece(metric, problem, grid, pair, over[0]),) * 2
    if kind != "peak" and window != (0, len(grid.times) - 2):
        raise NotCovered(f"{name}: bounds cover integrals over whole runs")
    of_sum = kind == "peak" and len(signals) > 1
    blocks = _blocks(window, grid) if of_sum else ()
    return Claim(
        metric=name,
        side=side,
        quantity=Quantity(
            kind=kind,
            terms=tuple(
                Term(
                    signal=signal,
                    signs=signs,
                    first=window[0],
                    last=window[1],
                    blocks=blocks,
                    since="separation" if _since_separation(metric) else "first",
                    until="separation" if _until_separation(metric) else "last",
                    moment=not isinstance(metric.when, Window),
                    window=over if at_once else None,
                )
                for signal in signals
            ),
        ),
        outer=metric.signal.outer,
        squared=metric.combined is Combined.ROOT_OF_SUM,
        sign=1.0 if side == "highest" else -1.0,
    )


_OTHER: dict[Side, Side] = {"highest": "lowest", "lowest": "highest"}


def _check(metric: Metric, name: str) -> None:
    signal = metric.signal
    if signal is None or metric.functional is Functional.TIME_WITHIN:
        raise NotCovered(f"{name}: bounds do not cover times")
    if signal.summed or signal.jumps or signal.quantity not in (*_FIELDS, "angle"):
        raise NotCovered(f"{name}: bounds do not cover the {signal.words}")
    if metric.combined is Combined.SMALLEST:
        raise NotCovered(f"{name}: bounds do not cover the smallest of components")


def _signals(metric: Metric, name: str, pair: int, facts: PairFacts) -> list[Signal]:
    """Return the signals of a metric, one for each of its components."""
    signal = metric.signal
    assert signal is not None
    if signal == metrics.ANGLE:
        return [
            Signal(field="angle", pair=pair, law="component", component=c)
            for c in signal.components
        ]
    if signal.law is None:
        return [
            Signal(
                field=_FIELDS[signal.quantity], pair=pair, law="component", component=c
            )
            for c in signal.components
        ]
    if signal.law not in _LAWS or signal.quantity not in _FIELDS:
        raise NotCovered(f"{name}: bounds do not cover the {signal.words}")
    law, vector = _LAWS[signal.law]
    given = (1.0, 0.0, 0.0) if vector is None else vector(facts)
    return [Signal(field=_FIELDS[signal.quantity], pair=pair, law=law, vector=given)]


def _how(
    functional: Functional, side: Side, name: str
) -> tuple[Kind, tuple[int, ...], bool]:
    """Return the kind of quantity, its signs, and whether one time is enough."""
    if functional in _INTEGRALS:
        if side == "lowest":
            raise NotCovered(f"{name}: bounds cover integrals from above")
        return _INTEGRALS[functional], (1,), False
    return "peak", _SIGNS[functional, side], (functional, side) in _AT_ONCE


_SHARES = (0.33, 0.6, 0.8, 1.0)
"""Of the pieces of the push, at which blocks begin: in each, rates grow little."""


def _blocks(window: tuple[int, int], grid: Grid) -> tuple[int, ...]:
    """Return where blocks of time begin within a window, and the end of the last."""
    first, last = window
    pieces = len(grid.times) - 1
    begins = [round(share * grid.push) for share in _SHARES]
    begins += [grid.push + (pieces - grid.push) // 2]
    inner = {b for b in begins if first < b <= last}
    return tuple(b - first for b in sorted({first, *inner, last + 1}))


def _since_separation(metric: Metric) -> bool:
    when = metric.when[0] if isinstance(metric.when, Window) else metric.when
    return when is Moment.SEPARATION


def _until_separation(metric: Metric) -> bool:
    return isinstance(metric.when, Window) and metric.when.end is Moment.SEPARATION


def _window(
    metric: Metric, problem: BoundProblem, grid: Grid, pair: int
) -> tuple[int, int]:
    """Return the first and last piece that may belong to a metric's time."""
    stroke = last_stroke(problem, [pair])

    def early(when: Time) -> float:
        return _seconds(when, problem.duration, stroke.earliest)

    def late(when: Time) -> float:
        return _seconds(when, problem.duration, stroke.latest)

    if not isinstance(metric.when, Window):
        return pieces_between(grid, early(metric.when), late(metric.when))
    start, end = metric.when.start, metric.when.end
    return pieces_between(grid, early(start), late(end))


def _one_piece(
    metric: Metric, problem: BoundProblem, grid: Grid, pair: int, first: int
) -> int:
    """Return a piece with a time that belongs to a window whatever parameters are.

    As springs have pushed, if that is in it.

    Args:
        metric: of the window.
        problem: of the separation.
        grid: of time.
        pair: the metric's.
        first: piece that may belong to it.
    """
    when = metric.when
    assert isinstance(when, Window)
    earliest = last_stroke(problem, [pair]).earliest
    end = _seconds(when.end, problem.duration, earliest)
    surely, _ = pieces_between(grid, end, end)
    return min(max(first, grid.push), surely)


def _seconds(when: Time, duration: float, separation: float) -> float:
    match when:
        case Moment.START | Moment.RELEASE:
            return 0.0
        case Moment.SEPARATION:
            return separation
        case Moment.END:
            return duration
        case _:
            return float(when)


def moments(names: Iterable[str]) -> list[float]:
    """Return the times, in seconds, at which metrics look, where they are known.

    Args:
        names: of metrics.
    """
    found = []
    for name in names:
        when = metric_named(name).when
        if when in (Moment.START, Moment.RELEASE):
            found.append(0.0)
        times = when[:2] if isinstance(when, Window) else (when,)
        found += [t for t in times if isinstance(t, float)]
    return sorted({*found})
