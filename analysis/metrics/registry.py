"""The metrics that runs are judged by: what each of them is, said once.

A metric is a functional of a signal at some time of the run, such as the largest
magnitude of B's rate after separation. Two interpreters know the functionals:
`drakesep.analysis.metrics.of_run`, on a run's samples, and
`drakesep.analysis.engines.jax.metrics_fold`, on the steps of a batch. All else reads
these entries: requirements, objectives, tables, plots and docs. A new metric is one
entry more.
"""

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, overload

from drakesep.systems.checks import InputError
from drakesep.systems.model.parameter_table import ROLL_PITCH_YAW, XYZ, with_axis


Sense: TypeAlias = Literal["<=", ">="]


class Kind(enum.Enum):
    """What a metric's number is: its unit at the edges follows from it."""

    RATE = "rate"
    ANGLE = "angle"
    NORM_OF_RATE = "root of the integral of a squared rate"
    SPEED = "speed"
    TIME = "time"
    CLEARANCE = "clearance"


class Moment(enum.Enum):
    """A time of a run."""

    START = "the start"
    RELEASE = "the first release"
    """When the first attachment of B lets go."""
    SEPARATION = "separation"
    """When all attachments of B have let go, and the last spring has reached its
    stroke."""
    END = "the end"


class Window(NamedTuple):
    """A time of a run from one moment to another."""

    start: Moment
    end: Moment
    words: str


WHOLE_RUN = Window(Moment.START, Moment.END, "over the whole run")
SINCE_RELEASE = Window(Moment.RELEASE, Moment.END, "since the first release")
AFTER_SEPARATION = Window(Moment.SEPARATION, Moment.END, "after separation")


class Functional(enum.Enum):
    """What is made of a signal."""

    VALUE = "value"
    MAGNITUDE = "magnitude"
    SMALLEST = "smallest value"
    LARGEST = "largest value"
    SMALLEST_MAGNITUDE = "smallest magnitude"
    LARGEST_MAGNITUDE = "largest magnitude"
    INTEGRAL_OF_MAGNITUDE = "integral of the magnitude"
    INTEGRAL_OF_SQUARE = "integral of the square"
    TIME_WITHIN = "time within limits"
    TIME = "time"
    """Of a moment, without a signal."""
    DISTANCE = "smallest distance between parts"
    """Measured apart, of some runs only."""


AT_A_MOMENT = frozenset({Functional.VALUE, Functional.MAGNITUDE, Functional.TIME})
_OF_NO_SIGNAL = frozenset({Functional.TIME, Functional.DISTANCE})
_SIGNED = frozenset({Functional.VALUE, Functional.SMALLEST, Functional.LARGEST})
_MAGNITUDES = frozenset(
    {Functional.MAGNITUDE, Functional.SMALLEST_MAGNITUDE, Functional.LARGEST_MAGNITUDE}
)


class Combined(enum.Enum):
    """What is made of the components of a signal."""

    EACH = "each"
    SUM = "sum"
    ROOT_OF_SUM = "root of the sum"
    SMALLEST = "smallest"


class Signal(NamedTuple):
    """Components of the motion of B over time."""

    words: str
    quantity: str
    """Field of `Motion`, and of `RelativeMotion`."""
    axes: tuple[str, ...] = XYZ
    """What the components are called in names; empty for one alone."""
    components: tuple[int, ...] = (0, 1, 2)


RATE = Signal("rate of B in W (w_WB_B)", "rate")
RELATIVE_RATE = Signal("rate of B relative to A (w_AB_B)", "relative_rate")
ANGLE = Signal("roll, pitch and yaw of B in W", "angle", ROLL_PITCH_YAW)
LONGITUDINAL_SPEED = Signal(
    "longitudinal speed of B's CG as seen from A", "relative_velocity", ("",), (0,)
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Metric:
    """A number that judges a run, or one for each component of its signal.

    Raises:
        ValueError: the functional does not go with the signal or the time.
    """

    stem: str
    """Its name; that of a component ends with its axis."""
    kind: Kind
    functional: Functional
    signal: Signal | None = None
    when: Window | Moment = WHOLE_RUN
    """A window, or a moment for what is looked at once."""
    combined: Combined = Combined.EACH
    sign: float = 1.0
    """-1 for less the functional."""
    at_most: str = ""
    """Stem of the metric that tells whether a limit from above is kept at all times;
    itself if empty."""
    at_least: str = ""
    """Of the one that tells of a limit from below."""
    directions: tuple[str, str] | None = None
    """Of a magnitude: stems of what is large where it is large upwards, and of what is
    small where it is large downwards."""
    objective: str = ""
    """Name of the paper's objective that it is."""

    def __post_init__(self) -> None:
        """Check that the fields go together."""
        if (self.signal is None) != (self.functional in _OF_NO_SIGNAL):
            wanted = "no signal" if self.signal else "a signal"
            raise InputError(f"{self.stem}: {self.functional.value} needs {wanted}")
        if isinstance(self.when, Moment) != (self.functional in AT_A_MOMENT):
            wanted = "a window" if isinstance(self.when, Moment) else "a moment"
            raise InputError(f"{self.stem}: {self.functional.value} needs {wanted}")
        if self.functional is Functional.TIME_WITHIN and (
            self.signal != ANGLE or self.when != WHOLE_RUN
        ):
            raise InputError(
                f"{self.stem}: limits are those of the angles, over the whole run"
            )

    @property
    def axes(self) -> tuple[str, ...]:
        """Of its names; one that is empty if it is a single number."""
        if self.signal is None or self.combined is not Combined.EACH:
            return ("",)
        return self.signal.axes

    @property
    def names(self) -> tuple[str, ...]:
        """Of its numbers, in the order of its axes."""
        return tuple(with_axis(self.stem, axis) for axis in self.axes)

    @property
    def of_every_run(self) -> bool:
        """Whether it is told of each run; else it is measured apart, of some."""
        return self.functional is not Functional.DISTANCE

    @property
    def windowed(self) -> bool:
        """Whether it can look at another part of a run."""
        at_once = self.functional in AT_A_MOMENT
        within = self.functional is Functional.TIME_WITHIN
        return self.of_every_run and not at_once and not within

    @property
    def is_magnitude(self) -> bool:
        """Whether it is of a signal's magnitude, whose limits have two sides."""
        return self.functional in _MAGNITUDES

    @property
    def is_of_signal_itself(self) -> bool:
        """Whether it is a value or magnitude that one component of its signal has."""
        return self.combined is Combined.EACH and (
            self.is_magnitude or self.functional in _SIGNED
        )

    @property
    def never_negative(self) -> bool:
        """Whether it cannot be below zero."""
        return self.sign > 0.0 and self.functional not in _SIGNED

    @property
    def words(self) -> str:
        """What it is, in words."""
        text: str = self.functional.value
        if self.functional is Functional.DISTANCE:
            return text
        if self.signal is not None:
            text = f"{text} of the {self.signal.words},"
        if isinstance(self.when, Moment):
            text = f"{text} at {self.when.value}"
        else:
            text = f"{text} {self.when.words}"
        if self.combined is not Combined.EACH:
            text = f"{self.combined.value} over the axes: {text}"
        return text if self.sign > 0.0 else f"less the {text}"

    def judged_by(self, sense: Sense) -> str:
        """Return the stem of the metric that tells whether a limit is kept."""
        return (self.at_most if sense == "<=" else self.at_least) or self.stem


_PAPER = (
    Metric(
        stem="G_L1",  # Eq. 11
        objective="L1",
        kind=Kind.ANGLE,
        functional=Functional.INTEGRAL_OF_MAGNITUDE,
        signal=RELATIVE_RATE,
        when=SINCE_RELEASE,
        combined=Combined.SUM,
    ),
    Metric(
        stem="G_L2",  # Eq. 12
        objective="L2",
        kind=Kind.NORM_OF_RATE,
        functional=Functional.INTEGRAL_OF_SQUARE,
        signal=RELATIVE_RATE,
        when=SINCE_RELEASE,
        combined=Combined.ROOT_OF_SUM,
    ),
    Metric(
        stem="G_Linf",  # Eq. 13
        objective="Linf",
        kind=Kind.RATE,
        functional=Functional.LARGEST_MAGNITUDE,
        signal=RELATIVE_RATE,
        when=SINCE_RELEASE,
        combined=Combined.SUM,
    ),
    Metric(
        stem="G_PM",  # Eq. 14
        objective="PM",
        kind=Kind.SPEED,
        functional=Functional.LARGEST,
        signal=LONGITUDINAL_SPEED,
        when=SINCE_RELEASE,
        sign=-1.0,
    ),
)

_RATES = (
    Metric(
        stem="final_rate",
        kind=Kind.RATE,
        functional=Functional.VALUE,
        signal=RATE,
        when=Moment.END,
    ),
    Metric(
        stem="rate_after_separation",
        kind=Kind.RATE,
        functional=Functional.LARGEST_MAGNITUDE,
        signal=RATE,
        when=AFTER_SEPARATION,
        at_least="rate_magnitude_min_after_separation",
        directions=("rate_max_after_separation", "rate_min_after_separation"),
    ),
    Metric(
        stem="rate_min_after_separation",
        kind=Kind.RATE,
        functional=Functional.SMALLEST,
        signal=RATE,
        when=AFTER_SEPARATION,
    ),
    Metric(
        stem="rate_max_after_separation",
        kind=Kind.RATE,
        functional=Functional.LARGEST,
        signal=RATE,
        when=AFTER_SEPARATION,
    ),
    Metric(
        stem="rate_magnitude_min_after_separation",
        kind=Kind.RATE,
        functional=Functional.SMALLEST_MAGNITUDE,
        signal=RATE,
        when=AFTER_SEPARATION,
    ),
)

DEVIATION = "deviation_at_separation"
"""Stem of the metric whose limits `TIME_WITHIN` looks at."""
_ANGLES = (
    Metric(
        stem=DEVIATION,
        kind=Kind.ANGLE,
        functional=Functional.MAGNITUDE,
        signal=ANGLE,
        when=Moment.SEPARATION,
        directions=("angle_at_separation", "angle_at_separation"),
    ),
    Metric(
        stem="angle_at_separation",
        kind=Kind.ANGLE,
        functional=Functional.VALUE,
        signal=ANGLE,
        when=Moment.SEPARATION,
    ),
    Metric(
        stem="deviation_within_limits_until",
        kind=Kind.TIME,
        functional=Functional.TIME_WITHIN,
        signal=ANGLE,
        combined=Combined.SMALLEST,
    ),
)

_SPEEDS = (
    Metric(
        stem="longitudinal_speed_max",
        kind=Kind.SPEED,
        functional=Functional.LARGEST,
        signal=LONGITUDINAL_SPEED,
    ),
    Metric(
        stem="longitudinal_speed_after_separation",
        kind=Kind.SPEED,
        functional=Functional.SMALLEST,
        signal=LONGITUDINAL_SPEED,
        when=AFTER_SEPARATION,
        at_most="longitudinal_speed_max_after_separation",
    ),
    Metric(
        stem="longitudinal_speed_max_after_separation",
        kind=Kind.SPEED,
        functional=Functional.LARGEST,
        signal=LONGITUDINAL_SPEED,
        when=AFTER_SEPARATION,
    ),
)

_OTHERS = (
    Metric(
        stem="separation_end",
        kind=Kind.TIME,
        functional=Functional.TIME,
        when=Moment.SEPARATION,
    ),
    Metric(stem="clearance", kind=Kind.CLEARANCE, functional=Functional.DISTANCE),
)

_registry: dict[str, Metric] = {}


class _Names(Sequence[str]):
    """Names of the metrics of every run, in order: what is registered appears here."""

    @overload
    def __getitem__(self, index: int) -> str: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[str, ...]: ...

    def __getitem__(self, index: int | slice) -> str | tuple[str, ...]:
        return self._now()[index]

    def __len__(self) -> int:
        return len(self._now())

    def __repr__(self) -> str:
        return f"METRICS{self._now()}"

    def _now(self) -> tuple[str, ...]:
        every = (metric for metric in _registry.values() if metric.of_every_run)
        return tuple(name for metric in every for name in metric.names)


METRICS: Sequence[str] = _Names()
"""Names of the metrics of every run, in order."""


def register_metric(metric: Metric) -> None:
    """Add a metric: engines made from now on tell it, and all that reads them knows it.

    Args:
        metric: to be added.

    Raises:
        ValueError: there is one of that name, or it says to be an objective of the
            paper.
    """
    if _built_in and metric.objective:
        raise InputError(
            f"metric {metric.stem!r}: objective must be empty: it is of the paper's, "
            f"got {metric.objective!r}"
        )
    for name in (metric.stem, *metric.names):
        if find_metric(name) is not None:
            raise InputError(f"metric {name!r} is registered already")
    _registry[metric.stem] = metric


def forget_metric(stem: str) -> None:
    """Remove a metric that was registered.

    Args:
        stem: of the metric.

    Raises:
        ValueError: there is none, or it is one of drakesep's own.
    """
    if stem not in _registry or stem in _built_in:
        mine = [name for name in _registry if name not in _built_in]
        raise InputError(
            f"metric: must be one that was registered ({', '.join(mine) or 'none'}), "
            f"got {stem!r}"
        )
    del _registry[stem]


def registered_metrics() -> tuple[Metric, ...]:
    """Return the metrics, in order."""
    return tuple(_registry.values())


def find_metric(name: str) -> tuple[Metric, str] | None:
    """Return the metric of a name or a stem, and the axis that is in the name.

    Args:
        name: such as ``rate_after_separation_x``; the axis of a stem is empty.

    Returns:
        None if there is no such metric.
    """
    if name in _registry:
        return _registry[name], ""
    stem, _, axis = name.rpartition("_")
    metric = _registry.get(stem)
    if metric is None or not axis or axis not in metric.axes:
        return None
    return metric, axis


_built_in: frozenset[str] = frozenset()
"""Stems of drakesep's own metrics."""
for _metric in (*_PAPER, *_RATES, *_ANGLES, *_SPEEDS, *_OTHERS):
    register_metric(_metric)
_built_in = frozenset(_registry)
