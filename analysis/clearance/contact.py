"""When two parts first touch, and how fast they close."""

from dataclasses import dataclass

import numpy as np

from drakesep.analysis.clearance.part_distance import PartDistance
from drakesep.systems.geometry.distance import TOUCHING


_INSTANT = 1e-7
"""To which the time of a contact is found, s."""
_APART = 1e-5
"""From which the normal is told well enough for a closing speed, m."""
_MOMENTS = (1e-6, 1e-5, 1e-4, 1e-3)
"""Before a contact, at which its closing speed may be told, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Where two parts first touch."""

    time: float
    """s."""
    closing_speed: float
    """At which they approach along the normal, m/s."""


def first_contact(parts: PartDistance, start: float, end: float) -> Contact | None:
    """Return the first contact between two times, s; None if there is none."""
    stack, touching = [(start, end)], None
    while stack:
        a, b = stack.pop()
        nearest = parts.may_come_below(a, b, TOUCHING)
        if nearest is None:
            continue
        if b - a < _INSTANT:
            return contact_at(parts, a)
        middle = 0.5 * (a + b)
        if nearest.distance <= TOUCHING:
            stack, touching = [(a, middle)], middle
        else:
            stack += [(middle, b), (a, middle)]
    # What is earlier is apart by less than round-off.
    return None if touching is None else contact_at(parts, touching)


def contact_at(parts: PartDistance, t: float) -> Contact:
    """Return the contact of two parts that touch, or overlap, at a time, s."""
    return Contact(time=t, closing_speed=_closing_speed(parts, t))


def _closing_speed(parts: PartDistance, t: float) -> float:
    # A moment before: shapes that touch have no normal.
    for before in _MOMENTS:
        time = max(t - before, 0.0)
        nearest = parts.at(time)
        if nearest.distance > _APART:
            break
    pose = parts.path.at(time)
    r_A = pose.R_AB @ nearest.p_BoCb_B
    velocity = pose.v_ABo_A + np.cross(pose.w_AB_A, r_A)
    return float(-nearest.n_A @ velocity)
