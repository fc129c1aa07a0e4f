"""How near a body that leaves comes to another, and until when: names of clearances.

``clearance`` is that of all parts of different bodies to each other, over the whole
run. ``clearance_to_ring_until_0.5_m`` is that of B's parts to those of one body, until
B has moved so far in its direction; of another pair than the first it begins with its
B's name, as all metrics do. ``clearance_of_nozzle+flange`` is that of two parts. They
are measured apart, of some runs only: see `drakesep.analysis.clearance`.
"""

import functools
import re

from drakesep.analysis.metrics.metric import Functional, Kind, Metric
from drakesep.analysis.metrics.quantities import NUMBER, written
from drakesep.systems.model.part_pairs import Names


CLEARANCE = "clearance"
"""The metric: how near the nearest parts come, m."""
NO_CONTACT = "no_contact"
"""What is said of a clearance that is above 0."""
_PARTS = "+"
"""Between names of parts: no name has it."""
_NAME = re.compile(
    rf"{CLEARANCE}(?:_to_(?P<to>.+?)|_of_(?P<first>[^+]+)\+(?P<second>[^+]+?))?"
    rf"(?:_until_{NUMBER}_m)?"
)


def clearance_name(
    to: str = "", until_separation: float | None = None, *, parts: Names | None = None
) -> str:
    """Return the name of a clearance, of the first pair.

    Args:
        to: the body to which B's parts are measured; empty: all to each other.
        until_separation: how far B moves in its direction until it does not matter,
            m; None: it matters to the end.
        parts: the two that alone are measured, if they are; then there is no `to`.
    """
    name = f"{CLEARANCE}_to_{to}" if to else CLEARANCE
    if parts is not None:
        name = f"{CLEARANCE}_of_{_PARTS.join(parts)}"
    if until_separation is None:
        return name
    return f"{name}_until_{written(until_separation)}_m"


@functools.lru_cache(maxsize=4096)
def metric_of_clearance(name: str) -> tuple[Metric, str] | None:
    """Return the metric of a name, and its axis, which is empty.

    Args:
        name: such as ``clearance_to_ring_until_0.5_m``.

    Returns:
        None if it is no clearance.
    """
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    *_, until = found.groups()
    first, second = found["first"], found["second"]
    metric = Metric(
        stem=name,
        kind=Kind.CLEARANCE,
        functional=Functional.DISTANCE,
        to=found["to"] or "",
        parts=(first, second) if first else None,
        until_separation=None if until is None else float(until),
    )
    return metric, ""
