"""What a metric is: a functional of a signal at some time of the run.

Such is the largest magnitude of B's rate after separation. Two interpreters know the
functionals: `drakesep.analysis.metrics.of_run`, on a run's samples, and
`drakesep.analysis.engines.jax.metrics_fold`, on the steps of a batch.
"""

import enum
import functools
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, NamedTuple, TypeAlias

from drakesep.systems.argument_types import typed
from drakesep.systems.checks import (
    InputError,
    check_not_negative,
    check_positive,
    unknown,
)
from drakesep.systems.equations import pair_signals
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.equations.relative_motion import RelativeMotion
from drakesep.systems.model.magnitudes import check_size
from drakesep.systems.model.parameter_table import ROLL_PITCH_YAW, XYZ, with_axis
from drakesep.systems.model.part_pairs import Names
from drakesep.systems.model.run import Motion
from drakesep.systems.model.separation import Separation
from drakesep.systems.sampling import NANOSECOND, tells_loads
from drakesep.systems.vectors import Ops, Scalar


Sense: TypeAlias = Literal["<=", "<", ">=", ">"]
"""Of a limit: from above or from below, which a value at the limit meets or not."""
SENSES: tuple[Sense, ...] = ("<=", "<", ">=", ">")


def is_from_above(sense: Sense) -> bool:
    """Return whether a limit of a sense is one from above."""
    return sense in ("<=", "<")


def is_strict(sense: Sense) -> bool:
    """Return whether a value at a limit of a sense does not meet it."""
    return sense in ("<", ">")


class Kind(enum.Enum):
    """What a metric's number is: its unit at the edges follows from it."""

    RATE = "rate"
    ANGLE = "angle"
    NORM_OF_RATE = "root of the integral of a squared rate"
    SPEED = "speed"
    TIME = "time"
    CLEARANCE = "clearance"
    DISPLACEMENT = "displacement"
    ACCELERATION = "acceleration"
    FORCE = "force"
    TORQUE = "torque"
    MOMENTUM = "momentum"
    ANGULAR_MOMENTUM = "angular momentum"


@functools.total_ordering
class Moment(enum.Enum):
    """A time of a run; they are in order."""

    START = "the start"
    RELEASE = "the first release"
    """When the first attachment of B lets go."""
    SEPARATION = "separation"
    """When all attachments of B have let go, and the last spring has reached its
    stroke."""
    END = "the end"

    def __lt__(self, other: "Moment") -> bool:
        """Return whether it comes before another."""
        order = list(type(self))
        return order.index(self) < order.index(other)


Time: TypeAlias = Moment | float
"""A moment of a run, or so many seconds from its start."""


class Window(NamedTuple):
    """A stretch of a run from one time to another."""

    start: Time
    end: Time
    words: str

    @property
    def moments(self) -> bool:
        """Whether it goes from moment to moment."""
        return isinstance(self.start, Moment) and isinstance(self.end, Moment)

    def check(self, name: str) -> None:
        """Raise InputError unless it goes from one time to a later.

        Args:
            name: of what has the window.
        """
        start, end = self.start, self.end
        if isinstance(start, float):
            check_not_negative(f"{name}: start of the window", start)
        if isinstance(end, float):
            check_positive(f"{name}: end of the window", end)
        alike = isinstance(start, Moment) == isinstance(end, Moment)
        if alike and not start < end:  # type: ignore[operator]
            raise InputError(
                f"{name}: window must be from one moment to a later, got from "
                f"{_said(start)} to {_said(end)}"
            )


def _said(time: Time) -> str:
    return time.value if isinstance(time, Moment) else f"{time:g} s"


When: TypeAlias = Window | Time
WHOLE_RUN = Window(Moment.START, Moment.END, "over the whole run")
UNTIL_SEPARATION = Window(Moment.START, Moment.SEPARATION, "until separation")
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


class Outer(enum.Enum):
    """What makes a quantity of its signal, which is smooth where the quantity is not.

    It grows with the signal: what is largest of the one is largest of the other.
    """

    ITSELF = "the signal"
    ROOT = "the square root of the signal"
    CONE = "twice the arcsine of the square root of the signal"


class Owner(enum.Enum):
    """Whose a quantity is; the value says it."""

    PAIR = "body that leaves"
    ATTACHMENT = "attachment"
    SPRING = "spring"


JOINT_LOAD, SPRING_FORCE = "joint_load", "spring_force"
_OWNERS = {JOINT_LOAD: Owner.ATTACHMENT, SPRING_FORCE: Owner.SPRING}
Law: TypeAlias = Callable[[Any, PairFacts, Ops], tuple[Scalar, ...]]
"""Makes components of a vector of the motion, or of a load; see
`equations.pair_signals`."""


class Signal(NamedTuple):
    """Components of the motion of B over time."""

    words: str
    quantity: str
    """Field of `Motion`, of which the batch engine tells those of `RelativeMotion`; or
    the load of a joint or the force of a spring."""
    axes: tuple[str, ...] = XYZ
    """What the components are called in names; empty for one alone."""
    components: tuple[int, ...] = (0, 1, 2)
    """Of the field, or of what the law makes of it."""
    turns: bool = False
    """Whether it is an angle: over time it goes on beyond half a turn, from the start
    of the run; at a moment it lies within half a turn."""
    law: Law | None = None
    """Makes the components of the field; None: they are its own."""
    outer: Outer = Outer.ITSELF
    jumps: bool = False
    """Whether it leaps at releases and ends of strokes: it is told at samples, with
    straight lines between."""
    summed: bool = False
    """Whether it is the integral of what the field or the law tells, over time from the
    start of the run."""

    @property
    def owner(self) -> Owner:
        """Whose it is."""
        return _OWNERS.get(self.quantity, Owner.PAIR)

    @property
    def rings(self) -> bool:
        """Whether it rings with the joints that hold, and only samples tell it."""
        return self.quantity in (JOINT_LOAD, "acceleration")

    @property
    def of_steps(self) -> bool:
        """Whether the batch engine tells it, from its steps."""
        return self.quantity in RelativeMotion._fields

    def check(self, name: str) -> None:
        """Raise InputError unless there are such components, each with its axis.

        Args:
            name: of what has the signal.
        """
        known = [*_OWNERS, *(f.name for f in fields(Motion) if f.name != "time")]
        if self.quantity not in known:
            message = unknown("field", self.quantity, known)
            raise InputError(f"{name}: signal: {message}")
        components, axes = set(self.components), set(self.axes)
        if not components or not components <= {0, 1, 2}:
            raise InputError(
                f"{name}: signal: components must be of 0, 1, 2, got {self.components}"
            )
        if not len(axes) == len(self.axes) == len(components) == len(self.components):
            raise InputError(
                f"{name}: signal: each component must have an axis of its own, got "
                f"{self.components} and {self.axes}"
            )


RATE = Signal("rate of B in W (w_WB_B)", "rate")
RELATIVE_RATE = Signal("rate of B relative to A (w_AB_B)", "relative_rate")
ANGLE = Signal(
    "roll, pitch and yaw of B from its mated attitude in the nominal stack",
    "angle",
    ROLL_PITCH_YAW,
    turns=True,
    law=pair_signals.from_mated,
)
LONGITUDINAL_SPEED = Signal(
    "longitudinal speed of B's CG as seen from A",
    "relative_velocity",
    ("",),
    (0,),
    law=pair_signals.along,
)
_OF_VALUES = frozenset(
    {
        *(Functional.VALUE, Functional.SMALLEST, Functional.LARGEST),
        *(Functional.MAGNITUDE, Functional.LARGEST_MAGNITUDE),
        Functional.SMALLEST_MAGNITUDE,
    }
)
"""Functionals that keep the order of values: what grows with a signal may follow."""


@typed
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
    when: When = WHOLE_RUN
    """A window, or a time for what is looked at once."""
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
    pair: str = ""
    """B of the pair that it is of, or the attachment or spring, which begins its name;
    empty: the first one."""
    to: str = ""
    """Of a distance: the body to which B's parts are measured; empty: all parts of
    different bodies are measured to each other, or two of them."""
    parts: Names | None = None
    """Of a distance: these two parts."""
    until_separation: float | None = None
    """Of a distance: how far B moves in its direction until it does not matter, m."""

    @property
    def owner(self) -> Owner:
        """Whose it is."""
        return Owner.PAIR if self.signal is None else self.signal.owner

    def of(self, body: str) -> "Metric":
        """Return the same of another body that leaves, attachment or spring."""

        def named(stem: str) -> str:
            return f"{body}.{stem}" if stem else ""

        ways = self.directions
        return replace(
            self,
            stem=named(self.stem),
            at_most=named(self.at_most),
            at_least=named(self.at_least),
            directions=None if ways is None else (named(ways[0]), named(ways[1])),
            objective="",
            pair=body,
        )

    @property
    def stem_of_any(self) -> str:
        """Its stem, whichever pair it is of."""
        return self.stem.removeprefix(f"{self.pair}.") if self.pair else self.stem

    def __post_init__(self) -> None:
        """Check that the fields go together."""
        if self.sign not in (1.0, -1.0):
            raise InputError(f"{self.stem}: sign must be 1 or -1, got {self.sign}")
        if self.signal is not None:
            self.signal.check(self.stem)
        if isinstance(self.when, Window):
            self.when.check(self.stem)
        if isinstance(self.when, float):
            check_not_negative(f"{self.stem}: time", self.when)
        if self.until_separation is not None:
            name = f"{self.stem}: until_separation"
            check_size("length", name, self.until_separation)
        if (self.signal is None) != (self.functional in _OF_NO_SIGNAL):
            wanted = "no signal" if self.signal else "a signal"
            raise InputError(f"{self.stem}: {self.functional.value} needs {wanted}")
        if isinstance(self.when, Window) == (self.functional in AT_A_MOMENT):
            wanted = "a moment" if isinstance(self.when, Window) else "a window"
            raise InputError(f"{self.stem}: {self.functional.value} needs {wanted}")
        outer = Outer.ITSELF if self.signal is None else self.signal.outer
        if outer is not Outer.ITSELF and self.functional not in _OF_VALUES:
            raise InputError(
                f"{self.stem}: {self.functional.value} cannot be told of {outer.value}"
            )
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

    def reached(self, duration: float) -> bool:
        """Return whether a run of such a length goes on for as long as it looks, s.

        A window that begins where the run ends has no length: it is not reached.
        """
        if not isinstance(self.when, Window):
            return isinstance(self.when, Moment) or self.when <= duration
        start, end, _ = self.when
        begins = isinstance(start, Moment) or start < duration - NANOSECOND
        return begins and (isinstance(end, Moment) or end <= duration)

    def told_by(self, separation: Separation) -> bool:
        """Return whether a run of a separation tells it.

        It goes on for as long as it looks, and its samples follow what rings.
        """
        rings = self.signal is not None and self.signal.rings
        return self.comes_about(separation) and (not rings or tells_loads(separation))

    def comes_about(self, separation: Separation) -> bool:
        """Return whether that at which it looks comes about in runs of a separation.

        They go on for as long as it looks, and its body lets go, or separates.
        """
        if not self.reached(separation.duration):
            return False
        times = self.when[:2] if isinstance(self.when, Window) else (self.when,)
        body = self.pair or separation.B
        if self.owner is not Owner.PAIR:
            held = separation.owners_of_forces(springs=self.owner is Owner.SPRING)
            part = held.get(self.pair)
            if part is None:
                return True  # of no separation like this
            own = self.owner is Owner.SPRING or self.when is Moment.RELEASE
            if own and Moment.RELEASE in times and not part.lets_go:
                return False
            body = separation.leaving_at(part)
        if Moment.SEPARATION in times and not separation.separates(body):
            return False
        return Moment.RELEASE not in times or separation.lets_go_of(body)

    @property
    def of_steps(self) -> bool:
        """Whether the batch engine tells it: else whole runs are flown for it."""
        return self.of_every_run and (self.signal is None or self.signal.of_steps)

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
    def is_largest_magnitude(self) -> bool:
        """Whether it is the largest magnitude of one component of its signal."""
        largest = self.functional is Functional.LARGEST_MAGNITUDE
        return largest and self.combined is Combined.EACH

    @property
    def is_of_signal_itself(self) -> bool:
        """Whether it is a value or magnitude that one component of its signal has."""
        return self.combined is Combined.EACH and (
            self.is_magnitude or self.functional in _SIGNED
        )

    @property
    def never_negative(self) -> bool:
        """Whether it cannot be below zero."""
        outer = Outer.ITSELF if self.signal is None else self.signal.outer
        signed = self.functional in _SIGNED and outer is Outer.ITSELF
        return self.sign > 0.0 and not signed

    @property
    def words(self) -> str:
        """What it is, in words."""
        text: str = self.functional.value
        if self.functional is Functional.DISTANCE:
            if self.to:
                text = f"{text} of {self.pair or 'B'} and of {self.to}"
            if self.parts:
                text = f"{text} of {' and of '.join(self.parts)}"
            if self.until_separation is not None:
                text = f"{text}, until B has moved {self.until_separation:g} m"
            return text
        if self.signal is not None:
            text = f"{text} of the {self.signal.words},"
        if isinstance(self.when, Window):
            text = f"{text} {self.when.words}"
        else:
            text = f"{text} at {_said(self.when)}"
        if self.combined is not Combined.EACH:
            text = f"{self.combined.value} over the axes: {text}"
        return text if self.sign > 0.0 else f"less the {text}"

    def judged_by(self, sense: Sense) -> str:
        """Return the stem of the metric that tells whether a limit is kept."""
        return (self.at_most if is_from_above(sense) else self.at_least) or self.stem
