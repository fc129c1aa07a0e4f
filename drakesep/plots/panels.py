"""What plots of the motion show: signals of a body that leaves, and their limits."""

import functools
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from drakesep.analysis.metrics.metric import Kind, Metric, Outer, Owner, Signal
from drakesep.analysis.metrics.of_run import body_of, signal_of_run
from drakesep.analysis.metrics.quantities import QUANTITIES
from drakesep.plots.shown_runs import Decided, metrics_shown_by
from drakesep.systems.arrays import Array
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.model.parameter_table import ROLL_PITCH_YAW, XYZ
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair, Separation
from drakesep.tables.labelled_run import LabelledRun
from drakesep.units import Unit, unit_of


class Row(NamedTuple):
    """A vector of the motion, whose components stand beside each other."""

    quantity: str
    title: str
    axes: tuple[str, ...]


class Topic(NamedTuple):
    """What a figure is about."""

    title: str
    """With the names of A and B left open."""
    rows: tuple[Row, ...]
    kinds: frozenset[Kind]
    """Of the metrics whose signals it shows."""

    def concerns(self, one: LabelledRun, separation: Separation, body: str) -> bool:
        """Return whether a run is the worst by anything that is shown.

        Args:
            one: the run.
            separation: with the body.
            body: that leaves.
        """
        metrics = metrics_shown_by(one)
        return not metrics or any(self.shows(m, separation, body) for m in metrics)

    def shows(self, metric: Metric, separation: Separation, body: str) -> bool:
        """Return whether a metric is of what is shown."""
        return metric.kind in self.kinds and body_of(metric, separation) == body


TRANSLATION = Topic(
    "Translation of {B} from {A}",
    (
        Row("relative_velocity", "relative velocity", XYZ),
        Row("acceleration", "acceleration of the CG", XYZ),
        Row("linear_momentum_change", "linear momentum change", XYZ),
    ),
    frozenset(
        {Kind.SPEED, Kind.DISPLACEMENT, Kind.ACCELERATION, Kind.FORCE, Kind.MOMENTUM}
    ),
)
ROTATION = Topic(
    "Rotation of {B}",
    (
        Row("angle", "angle", ROLL_PITCH_YAW),
        Row("rate", "rate", XYZ),
        Row("angular_momentum_change", "angular momentum change", XYZ),
    ),
    frozenset(
        {Kind.RATE, Kind.ANGLE, Kind.NORM_OF_RATE, Kind.TORQUE, Kind.ANGULAR_MOMENTUM}
    ),
)
OVERVIEW = Topic(
    "Motion of {B}",
    (ROTATION.rows[1], ROTATION.rows[0], TRANSLATION.rows[0]),
    ROTATION.kinds | TRANSLATION.kinds,
)
"""Rates, angles and speeds; of the rest what is required."""


@dataclass(frozen=True, kw_only=True)
class Panel:
    """A signal over time."""

    title: str
    unit: Unit
    values: Callable[[Run], Array]
    """(n,) of a run at the times of its motion, in SI."""
    column: int | None
    """Of the component; None: it is none of those that stand beside each other."""
    decided: tuple[Decided, ...]
    """The requirements on it."""


_Place: TypeAlias = tuple[Hashable, ...]
"""What tells one signal from another."""


def panels_of(
    topic: Topic, separation: Separation, pair: Pair, decided: Iterable[Decided]
) -> list[Panel]:
    """Return the panels of a figure: components of the motion, and what is required.

    Args:
        topic: of the figure.
        separation: with the pair.
        pair: whose B leaves.
        decided: requirements; those on other topics or bodies are left out.
    """
    facts = PairFacts.of(separation, pair)
    placed: dict[_Place, list[Decided]] = {}
    for each in decided:
        if topic.shows(each.metric, separation, pair.B):
            placed.setdefault(_place(topic, each, facts), []).append(each)
    panels = [
        Panel(
            title=f"{row.title}, {axis}",
            unit=unit_of(f"{row.quantity}_{axis}"),
            values=functools.partial(_component, pair.B, row.quantity, i),
            column=i,
            decided=tuple(placed.pop((row.quantity, i), ())),
        )
        for row in topic.rows
        for i, axis in enumerate(row.axes)
    ]
    return panels + [_of_requirements(tuple(each)) for each in placed.values()]


def _component(body: str, quantity: str, i: int, run: Run) -> Array:
    """Return a component of a body's motion; an angle goes on beyond half a turn."""
    values: Array = getattr(run.motion_of(body), quantity)[:, i]
    return np.unwrap(values) if quantity == "angle" else values


def _of_requirements(decided: tuple[Decided, ...]) -> Panel:
    """Return the panel of a signal that some requirements are about."""
    metric, axis, finding, _ = decided[0]
    signal = metric.signal
    assert signal is not None
    names = [q.name for q in QUANTITIES.values() if q.signal == signal]
    title = (names or [signal.words])[0].replace("_", " ")
    of = "" if metric.owner is Owner.PAIR else f" of {metric.pair}"
    return Panel(
        title=f"{title}{of}, {axis}" if axis else f"{title}{of}",
        unit=unit_of(finding.requirement.metric),
        values=lambda run: signal_of_run(run, metric)[:, metric.axes.index(axis)],
        column=None,
        decided=decided,
    )


def _place(topic: Topic, decided: Decided, facts: PairFacts) -> _Place:
    metric, axis = decided.metric, decided.axis
    signal = metric.signal
    assert signal is not None
    component = signal.components[metric.axes.index(axis)]
    if signal.quantity in [row.quantity for row in topic.rows]:
        i = _field_component(signal, component, facts)
        if i is not None:
            return signal.quantity, i
    return metric.owner, metric.pair, signal, component


def _field_component(signal: Signal, component: int, facts: PairFacts) -> int | None:
    """Return which component of its field a signal's is; None if it is none of them."""
    if signal.summed:
        return None
    if signal.law is None:
        return component
    if signal.outer is not Outer.ITSELF:
        return None
    # What the law makes of each unit vector tells which of them it takes.
    taken = [
        i
        for i, unit in enumerate(np.eye(3))
        if signal.law(tuple(unit), facts, np)[component] == 1.0
    ]
    return taken[0] if len(taken) == 1 else None
