"""The motion of a body that leaves over a run, from that of all bodies."""

import math

import numpy as np

from drakesep.systems.arrays import Array
from drakesep.systems.equations.mated_stack import (
    mated_motion,
    mated_places,
    place_in_A,
)
from drakesep.systems.equations.relative_motion import body_state, relative_motion
from drakesep.systems.model.run import Trajectory
from drakesep.systems.model.separation import Pair, Separation


def relative_motion_of(
    separation: Separation, pair: Pair, trajectory: Trajectory
) -> dict[str, Array]:
    """Return the motion of B in W and relative to A, (n, 3) each.

    Args:
        separation: as it was flown.
        pair: in which B leaves.
        trajectory: of its bodies at n times.

    Returns:
        By the names of `RelativeMotion`'s fields.
    """
    A, B = (body_state(trajectory.of(name).T, 0, 7) for name in (pair.A, pair.B))
    body, places = separation.body(pair.B), mated_places(separation)
    mated = place_in_A(places[pair.A], places[pair.B], body.p_BoBcm_B)
    motion = relative_motion(A, B, body.p_BoBcm_B, mated, np)
    return {name: np.stack(v, axis=1) for name, v in motion._asdict().items()}


def mated_trajectory(separation: Separation) -> Trajectory:
    """Return that of the mated stack at rest, for a second."""
    rest = (0.0, 0.0, 0.0)
    motions = mated_motion(mated_places(separation).values(), rest, rest, rest, math)
    states = np.array([[*m.q_WB, *m.p_WBo, *m.w_WB, *m.v_WBo] for m in motions])
    return Trajectory(
        names=tuple(body.name for body in separation.bodies),
        time=np.array([0.0, 1.0]),
        states=np.stack([states, states]),
    )
