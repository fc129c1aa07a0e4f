"""Metrics that tests add through the registry alone."""

import contextlib
from collections.abc import Iterator

from drakesep.analysis.metrics.metric import (
    AFTER_SEPARATION,
    ANGLE,
    RATE,
    RELATIVE_RATE,
    Combined,
    Functional,
    Kind,
    Metric,
    Moment,
    Signal,
    Window,
)
from drakesep.analysis.metrics.registry import forget_metric, register_metric


RELATIVE = Metric(
    stem="toy_rate_after_separation",
    kind=Kind.RATE,
    functional=Functional.LARGEST_MAGNITUDE,
    signal=RELATIVE_RATE,
    when=AFTER_SEPARATION,
    at_least="toy_rate_magnitude_min_after_separation",
)
RELATIVE_MIN = Metric(
    stem="toy_rate_magnitude_min_after_separation",
    kind=Kind.RATE,
    functional=Functional.SMALLEST_MAGNITUDE,
    signal=RELATIVE_RATE,
    when=AFTER_SEPARATION,
)
TRANSVERSE = Signal("transverse speed", "relative_velocity", ("y", "z"), (1, 2))
WHILE_PUSHED = Window(Moment.RELEASE, Moment.SEPARATION, "while it is pushed")
OTHERS = (
    Metric(
        stem="transverse_speed_while_pushed",
        kind=Kind.SPEED,
        functional=Functional.LARGEST_MAGNITUDE,
        signal=TRANSVERSE,
        when=WHILE_PUSHED,
        combined=Combined.SUM,
    ),
    Metric(
        stem="turned_while_pushed",
        kind=Kind.ANGLE,
        functional=Functional.INTEGRAL_OF_MAGNITUDE,
        signal=RATE,
        when=WHILE_PUSHED,
    ),
    Metric(
        stem="most_turned_to",
        kind=Kind.ANGLE,
        functional=Functional.LARGEST,
        signal=ANGLE,
    ),
    Metric(
        stem="rate_at_release",
        kind=Kind.RATE,
        functional=Functional.VALUE,
        signal=RATE,
        when=Moment.RELEASE,
    ),
    Metric(
        stem="deviation_at_start",
        kind=Kind.ANGLE,
        functional=Functional.MAGNITUDE,
        signal=ANGLE,
        when=Moment.START,
    ),
    Metric(
        stem="separation_start",
        kind=Kind.TIME,
        functional=Functional.TIME,
        when=Moment.RELEASE,
    ),
    Metric(
        stem="length_of_run",
        kind=Kind.TIME,
        functional=Functional.TIME,
        when=Moment.END,
    ),
)
"""One of each functional, time and combination that the built-in ones have not got."""


@contextlib.contextmanager
def registered(*metrics: Metric) -> Iterator[None]:
    """Register metrics for a while."""
    for metric in metrics:
        register_metric(metric)
    try:
        yield
    finally:
        for metric in metrics:
            forget_metric(metric.stem)
