"""How near two parts come to each other in a run, over continuous time.

Moments bound how near they can come in the stretches between; stretches that this does
not settle are halved.
"""

import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from drakesep.analysis.clearance.contact import Contact, contact_at, first_contact
from drakesep.analysis.clearance.part_distance import PartDistance
from drakesep.systems.geometry.distance import TOUCHING, Nearest


ACCURACY = 5e-5
"""By which a smallest distance may miss that over continuous time, m."""
_LOOKS = 12
"""Moments that are looked at before the stretches between them are settled."""
_SHORTEST = 1e-7
"""Stretch of time in which nothing moves by the accuracy, s."""
_POLISHED = 1e-6
"""To which the time of a smallest distance is found, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Clearance:
    """How near two parts come in a run."""

    first: str
    second: str
    minimum: float
    """Smallest distance, m; 0 if they touch."""
    time: float
    """When, s; of contact, if they touch."""
    p_AoCa_A: tuple[float, ...]
    """Nearest point of the first then, in its body, m."""
    p_BoCb_B: tuple[float, ...]
    """Nearest point of the second then, in its body, m."""
    contact: Contact | None = None
    """None: they do not touch."""

    @property
    def pair(self) -> str:
        """The names of both, as tables and plots have them."""
        return f"{self.first} to {self.second}"


class _Moment(NamedTuple):
    time: float
    nearest: Nearest


def smallest_below(
    parts: PartDistance, start: float, end: float, than: float
) -> Clearance | None:
    """Return how near two parts come between two times; None if not as near.

    Args:
        parts: of one run.
        start: s.
        end: s.
        than: distance, m, below which they must come by more than `ACCURACY`.
    """
    best = _smallest_below(parts, start, end, than)
    if best is None:
        return None
    contact = None
    if best.nearest.distance <= TOUCHING + ACCURACY:
        contact = first_contact(parts, start, end)
    if contact is None:
        return _clearance(parts, _polished(parts, best, start, end), None)
    return _touching(parts, contact)


def overlapping(parts: PartDistance, t: float) -> Clearance:
    """Return that of two parts that overlap, or one in the other, at a time, s."""
    return _touching(parts, contact_at(parts, t))


def _touching(parts: PartDistance, contact: Contact) -> Clearance:
    touching = parts.at(contact.time)._replace(distance=0.0)
    return _clearance(parts, _Moment(contact.time, touching), contact)


def _smallest_below(
    parts: PartDistance, start: float, end: float, than: float
) -> _Moment | None:
    """Return a moment whose distance is the smallest, to `ACCURACY`."""
    times = np.linspace(start, end, _LOOKS).tolist()
    best: _Moment | None = None
    if math.isinf(than):
        for t in times:
            nearer = parts.at_below(t, than)
            if nearer is not None:
                best, than = _Moment(t, nearer), nearer.distance
    stack = list(itertools.pairwise(times))
    while stack and than > TOUCHING:
        a, b = stack.pop()
        there = parts.may_come_below(a, b, than - ACCURACY)
        if there is None:
            continue
        middle = 0.5 * (a + b)
        if there.distance < than:
            best, than = _Moment(middle, there), there.distance
        if b - a > _SHORTEST:
            stack += [(a, middle), (middle, b)]
    return best


def _polished(parts: PartDistance, best: _Moment, start: float, end: float) -> _Moment:
    """Return the smallest distance near a moment that is all but it."""
    sampled = parts.path.time
    i = int(np.searchsorted(sampled, best.time))
    low = max(start, float(sampled[max(i - 1, 0)]))
    high = min(end, float(sampled[min(i + 1, len(sampled) - 1)]))
    if low >= high:
        return best
    found = minimize_scalar(
        lambda t: parts.at(float(t)).distance,
        bounds=(low, high),
        method="bounded",
        options={"xatol": _POLISHED},
    )
    # Which ends it never looks at: where the smallest is there, it is nowhere else.
    times = (low, high, float(found.x))
    return _nearest_of([*(_Moment(t, parts.at(t)) for t in times), best])


def _nearest_of(moments: list[_Moment]) -> _Moment:
    return min(moments, key=lambda moment: moment.nearest.distance)


def _clearance(
    parts: PartDistance, moment: _Moment, contact: Contact | None
) -> Clearance:
    first, second = parts.names
    time, best = moment.time, parts.in_bodies(moment.nearest)
    return Clearance(
        first=first,
        second=second,
        minimum=best.distance,
        time=time,
        p_AoCa_A=tuple(best.p_AoCa_A.tolist()),
        p_BoCb_B=tuple(best.p_BoCb_B.tolist()),
        contact=contact,
    )
