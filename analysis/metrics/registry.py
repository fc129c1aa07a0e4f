"""The metrics that runs are judged by: what each of them is, said once.

Both engines read these entries, and so do requirements, objectives, tables, plots and
docs. A new metric is one entry more; what an entry may say stands in
`drakesep.analysis.metrics.metric`.
"""

from collections.abc import Sequence
from typing import overload

from drakesep.analysis.metrics.clearances import CLEARANCE, metric_of_clearance
from drakesep.analysis.metrics.metric import (
    ANGLE,
    LONGITUDINAL_SPEED,
    RATE,
    RELATIVE_RATE,
    SINCE_RELEASE,
    Combined,
    Functional,
    Kind,
    Metric,
    Moment,
)
from drakesep.analysis.metrics.quantities import metric_of_quantity
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.model.separation import RESERVED_NAMES


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

DEVIATION = "deviation_at_separation"
"""Stem of the metric whose limits `TIME_WITHIN` looks at."""
WITHIN = "deviation_within_limits_until"
"""Stem of the metric that does."""
_OTHERS = (
    Metric(
        stem="final_rate",
        kind=Kind.RATE,
        functional=Functional.VALUE,
        signal=RATE,
        when=Moment.END,
    ),
    "rate_after_separation",
    "rate_min_after_separation",
    "rate_max_after_separation",
    "rate_magnitude_min_after_separation",
    DEVIATION,
    "angle_at_separation",
    Metric(
        stem=WITHIN,
        kind=Kind.TIME,
        functional=Functional.TIME_WITHIN,
        signal=ANGLE,
        combined=Combined.SMALLEST,
    ),
    "longitudinal_speed_max",
    "longitudinal_speed_after_separation",
    "longitudinal_speed_max_after_separation",
    Metric(
        stem="separation_end",
        kind=Kind.TIME,
        functional=Functional.TIME,
        when=Moment.SEPARATION,
    ),
    Metric(stem=CLEARANCE, kind=Kind.CLEARANCE, functional=Functional.DISTANCE),
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


@typed
def register_metric(metric: Metric) -> None:
    """Add a metric: engines made from now on tell it, and all that reads them knows it.

    Args:
        metric: to be added.

    Raises:
        ValueError: there is one of that name, or it says to be an objective of the
            paper.
    """
    if not metric.stem.isidentifier():
        raise InputError(
            f"metric: stem must be of letters, digits and _, got {metric.stem!r}"
        )
    if _built_in and metric.objective:
        raise InputError(
            f"metric {metric.stem!r}: objective must be empty: it is of the paper's, "
            f"got {metric.objective!r}"
        )
    for name in (metric.stem, *metric.names):
        if _registered(name) is not None:
            raise InputError(f"metric {name!r} is registered already")
    _registry[metric.stem] = metric


@typed
def forget_metric(stem: str) -> None:
    """Remove a metric that was registered; what was made before still tells it.

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


def own_metrics() -> tuple[Metric, ...]:
    """Return the metrics that are not drakesep's own, in order."""
    return tuple(one for one in _registry.values() if one.stem not in _built_in)


def find_metric(name: str) -> tuple[Metric, str] | None:
    """Return the metric of a name or a stem, and the axis that is in the name.

    One that is registered, or of a quantity at some time of the run, or a clearance; of
    the first pair, or of that of the body whose name stands before it.

    Args:
        name: such as ``rate_after_separation_x`` or ``satellite.rate_at_end_x``; the
            axis of a stem is empty.

    Returns:
        None if there is no such metric.
    """
    found = _of_first_pair(name)
    if found is not None:
        return found
    body, _, rest = name.partition(".")
    found = _of_first_pair(rest)
    if found is None or body in ("", *RESERVED_NAMES):
        return None
    metric, axis = found
    return metric.of(body), axis


def _of_first_pair(name: str) -> tuple[Metric, str] | None:
    return _registered(name) or metric_of_quantity(name) or metric_of_clearance(name)


def _registered(name: str) -> tuple[Metric, str] | None:
    if name in _registry:
        return _registry[name], ""
    stem, _, axis = name.rpartition("_")
    metric = _registry.get(stem)
    if metric is None or not axis or axis not in metric.axes:
        return None
    return metric, axis


_built_in: frozenset[str] = frozenset()
"""Stems of drakesep's own metrics."""
for _entry in (*_PAPER, *_OTHERS):
    if isinstance(_entry, str):  # of a quantity
        _found = metric_of_quantity(_entry)
        assert _found is not None
        _entry = _found[0]
    register_metric(_entry)
_built_in = frozenset(_registry)
