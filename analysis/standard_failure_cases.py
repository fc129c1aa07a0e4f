"""The failure cases that are customarily looked at, made for a separation.

Of each spring: it is out, or stuck at half of its stroke. All springs at the lower or
the upper end of their tolerances, as in the cold and in the heat. Of each attachment
among several of the same two bodies: it lets go late, or never. One whose joint holds
nothing has a spring that is late, if it has one, and cannot hold for ever.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping

from drakesep.analysis.failure_cases import FailureCase, check_failure_cases
from drakesep.analysis.tolerances.sides import Tolerance, ends_of
from drakesep.systems.argument_types import typed
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.separation import Separation


LATE = 0.010
"""By which an attachment lets go late, s."""
STUCK_AT = 0.5
"""Of its stroke, where a spring sticks."""


@typed
def standard_failure_cases(
    separation: Separation, tolerances: Mapping[str, Tolerance]
) -> tuple[FailureCase, ...]:
    """Return the customary failure cases of a separation.

    Args:
        separation: the design.
        tolerances: about its values, by parameter name, in SI.
    """
    usual = (
        *_of_springs(separation),
        *_of_all_springs(separation, tolerances),
        *_of_attachments(separation),
    )
    return tuple(case for case in usual if _may_be(separation, case))


def _may_be(separation: Separation, case: FailureCase) -> bool:
    """Return whether a failure case changes something, and is physical."""
    try:
        check_failure_cases(separation, (case,))
    except InputError:
        return False
    return True


def _that_push(separation: Separation) -> list[Pusher]:
    """Return the springs, without what resists and pushes nothing."""
    known = parameters(separation)
    return [s for s in separation.springs if f"{s.name}.lost_stroke" in known]


def _of_springs(separation: Separation) -> Iterator[FailureCase]:
    for spring in _that_push(separation):
        for what, field, value in (
            ("out", "force_max", 0.0),
            ("stuck", "lost_stroke", 1.0 - STUCK_AT),
        ):
            values = {f"{spring.name}.{field}": value}
            yield FailureCase(name=f"{spring.name}_{what}", values=values)


def _of_all_springs(
    separation: Separation, tolerances: Mapping[str, Tolerance]
) -> Iterator[FailureCase]:
    nominal = parameters(separation)
    wanted = [f"{spring.name}.force_max" for spring in _that_push(separation)]
    ends = {
        name: ends_of(nominal[name], tolerances[name])
        for name in wanted
        if name in tolerances
    }
    if ends:
        for case, end in (("springs_cold", 0), ("springs_hot", 1)):
            values = {name: both[end] for name, both in ends.items()}
            yield FailureCase(name=case, values=values)


def _of_attachments(separation: Separation) -> Iterator[FailureCase]:
    known = parameters(separation)
    pushing = _that_push(separation)
    joins = Counter(frozenset((a.A, a.B)) for a in separation.attachments)
    for attachment in separation.attachments:
        name, time = attachment.name, f"{attachment.name}.release_time"
        if time not in known or joins[frozenset((attachment.A, attachment.B))] == 1:
            continue
        holds = attachment.joint.holds
        if holds or attachment.spring in pushing:
            late = {time: known[time] + LATE}
            yield FailureCase(name=f"{name}_late", values=late)
        if holds:
            yield FailureCase(name=f"{name}_held", values={time: math.inf})
