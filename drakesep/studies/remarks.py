"""What a user should be told of a run, although nothing in it has failed."""

import numpy as np

from drakesep.systems.equations.mated_stack import mated_places, place_in_stack
from drakesep.systems.equations.pair_signals import PairFacts
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair, Separation


_STILL = 1e-6
"""Speed below which nothing moves, m/s."""


def remarks(run: Run) -> list[str]:
    """Return what should be told of a run, in sentences; nothing if it failed."""
    if run.motion is None:
        return []
    return [said for pair in run.separation.pairs for said in _of_direction(run, pair)]


def _of_direction(run: Run, pair: Pair) -> list[str]:
    """Return whether a body leaves in its direction, and away from the other."""
    speed = _speed_at_end(run, pair)
    written = f"[{', '.join(f'{x:g}' for x in pair.direction)}]"
    if speed < -_STILL:
        return [
            f"{pair.B} moves against its direction {written}, at {speed:.6g} m/s at "
            "the end: see the direction of its pair."
        ]
    if speed > _STILL and _place_along(run.separation, pair) < 0.0:
        return [
            f"{pair.B} moves in its direction {written} and stands behind {pair.A} "
            "while mated, by their CGs: it passes through, if nothing leads it past."
        ]
    return []


def _speed_at_end(run: Run, pair: Pair) -> float:
    velocity = run.motion_of(pair.B).relative_velocity[-1]
    return float(velocity @ np.array(pair.direction))


def _place_along(separation: Separation, pair: Pair) -> float:
    """Return how far B's CG stands from A's in the direction while mated, m."""
    places = mated_places(separation)
    from_A, to_B = (
        np.array(place_in_stack(places[name], separation.body(name).p_BoBcm_B))
        for name in (pair.A, pair.B)
    )
    return float((to_B - from_A) @ np.array(PairFacts.of(separation, pair).direction_S))
