"""The momentum that springs give over a run, summed from the motion of its bodies."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.equations.forces_of_run import force_within_stroke
from drakesep.systems.equations.pushers import push_place, push_wrenches
from drakesep.systems.equations.relative_motion import BodyState, momentum_rate
from drakesep.systems.model.pushers import Pusher
from drakesep.systems.model.separation import Attachment, Separation


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)


def momentum_given(
    separation: Separation,
    times: Array,
    steps: Array,
    bodies_at: Callable[[Array], Sequence[BodyState]],
    releases: Mapping[str, float],
    stroke_ends: Mapping[str, float],
) -> dict[str, Array]:
    """Return the momentum given by springs to each body that leaves (Eq. 6 and 7).

    By Gauss's quadrature between samples and steps, both: error control has made steps
    short where the force has a kink, and a push has samples enough.

    Args:
        separation: as it was flown.
        times: (n,) sample times, s, with every release and end of a stroke.
        steps: times of the integration's steps, s.
        bodies_at: returns the bodies' motion, in their order, at increasing times.
        releases: when each attachment let go, s, by its name; infinite if never.
        stroke_ends: when each spring reached its stroke, s, by its name, or infinity.

    Returns:
        By the bodies' names (n, 6): linear momentum, N s, and angular momentum about
        the CG, N m s, in the body's axes.
    """
    edges = np.union1d(times, steps)
    half = 0.5 * np.diff(edges)
    middle = edges[:-1] + half
    given = {pair.B: np.zeros((len(edges), 6)) for pair in separation.pairs}
    for (a, b), pushing in _pushing_pairs(separation, releases).items():
        spans = [(releases[x.name], stroke_ends[s.name]) for x, s in pushing]
        pushed = np.any([(t0 <= middle) & (middle < t1) for t0, t1 in spans], axis=0)
        nodes = (middle[pushed, None] + half[pushed, None] * _NODES).ravel()
        bodies = bodies_at(nodes)
        pushes = []
        for (attachment, spring), (t0, t1) in zip(pushing, spans, strict=True):
            place = push_place(separation, attachment, spring)
            force = force_within_stroke(
                separation, attachment, bodies[a], bodies[b], nodes - t0
            )
            force = np.where((t0 <= nodes) & (nodes < t1), force, 0.0)
            pushes.append((force, place.p_BoPad_B, place.axis_A))
        for i, wrench in zip(
            (a, b), push_wrenches(bodies[a], bodies[b], pushes), strict=True
        ):
            body = separation.bodies[i]
            if body.name in given:
                rates: Array = np.concatenate(
                    momentum_rate(bodies[i], body.p_BoBcm_B, wrench)
                )
                gained = rates.reshape(6, -1, len(_NODES)) @ _WEIGHTS * half[pushed]
                given[body.name][1:][pushed] += gained.T
    at = np.searchsorted(edges, times)
    return {body: np.cumsum(gains, axis=0)[at] for body, gains in given.items()}


def _pushing_pairs(
    separation: Separation, releases: Mapping[str, float]
) -> dict[tuple[int, int], list[tuple[Attachment, Pusher]]]:
    """Return the attachments whose springs push, by the indices of their bodies."""
    pairs: dict[tuple[int, int], list[tuple[Attachment, Pusher]]] = {}
    for attachment, spring in separation.pushing:
        if math.isfinite(releases[attachment.name]):
            ends = separation.ends(attachment)
            pairs.setdefault(ends, []).append((attachment, spring))
    return pairs
