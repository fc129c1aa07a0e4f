"""States of bodies over a run, in W and in the inertial frame of its orbit."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from drakesep.systems.arrays import Array
from drakesep.systems.equations.kepler import (
    ellipse_of,
    orbit_position,
    orbit_velocity,
)
from drakesep.systems.model.orbit import Orbit
from drakesep.systems.model.run import Run


@dataclass(frozen=True, kw_only=True)
class BodyStates:
    """The motion of a body over n samples: of its CG, and of its axes."""

    time: Array
    """(n,), since the start of the run, s."""
    position: Array
    """(n, 3) of the CG, from the frame's origin, m."""
    velocity: Array
    """(n, 3) of the CG, m/s."""
    orientation: Array
    """(n, 4), unit quaternion of the body's axes in the frame, w first; it takes
    components in the body into those in the frame."""
    rate: Array
    """(n, 3), angular velocity in the frame, in the body's axes, rad/s."""


def states_in_W(run: Run, body: str) -> BodyStates:
    """Return the motion of a body in W.

    Args:
        run: a completed run.
        body: its name.

    Raises:
        RuntimeError: the run failed.
    """
    trajectory = run.completed_trajectory
    state = trajectory.of(body)
    R_WB = _rotations(state[:, :4])
    w_WB, v_WBo = state[:, 7:10], state[:, 10:]
    p_BoBcm_W = R_WB.apply(run.separation.body(body).p_BoBcm_B)
    return BodyStates(
        time=trajectory.time,
        position=state[:, 4:7] + p_BoBcm_W,
        velocity=v_WBo + np.cross(w_WB, p_BoBcm_W),
        orientation=R_WB.as_quat(scalar_first=True),
        rate=R_WB.inv().apply(w_WB),
    )


def in_inertial_frame(states: BodyStates, orbit: Orbit) -> BodyStates:
    """Return a motion about the centre of the Earth, in the orbit's inertial frame.

    The reference orbit is added in W, where it is summed once, and turned then: what is
    lost is the round-off of a radius.

    Args:
        states: in W.
        orbit: that has axes.
    """
    assert orbit.axes is not None
    R_FW = np.array(orbit.axes).T
    reference = ellipse_of(orbit)
    r_W, v_W = (
        np.stack(of(states.time, reference, np), axis=1)
        for of in (orbit_position, orbit_velocity)
    )
    R_FB = Rotation.from_matrix(R_FW) * _rotations(states.orientation)
    return BodyStates(
        time=states.time,
        position=(r_W + states.position) @ R_FW.T,
        velocity=(v_W + states.velocity) @ R_FW.T,
        orientation=R_FB.as_quat(scalar_first=True),
        rate=states.rate,
    )


def _rotations(orientation: Array) -> Rotation:
    return Rotation.from_quat(orientation, scalar_first=True)
