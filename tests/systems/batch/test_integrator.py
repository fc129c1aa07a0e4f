"""How lanes fare, in words."""

import jax.numpy as jnp
import numpy as np
import pytest

from drakesep.systems.batch.integrator import LaneStatus


@pytest.mark.parametrize(
    ("status", "message"),
    [
        (LaneStatus.FLYING, ""),
        (LaneStatus.COMPLETED, "a metric, or a derivative of one, is not finite"),
        (
            LaneStatus.STILL_HELD,
            "hinge_2 has not let go: its joint has not moved far enough",
        ),
        (LaneStatus.STROKE_LEFT, "spring_3 has not reached its stroke"),
        (LaneStatus.STEP_COLLAPSED, "the step size collapsed (at t = 0.25 s)"),
        (
            LaneStatus.TOO_MANY_STEPS,
            "more than 70 integration steps (at t = 0.25 s)",
        ),
    ],
)
def test_a_status_says_why_a_lane_has_no_metrics(status, message):
    got = status.message.format(
        held=["hinge_2", "hinge_4"],
        left=["spring_3"],
        time=np.float64(0.25),
        max_steps=70,
    )
    assert got == message


def test_a_status_comes_back_from_its_lane():
    lanes = np.asarray(jnp.array([int(status) for status in LaneStatus]))
    assert [LaneStatus(int(lane)) for lane in lanes] == list(LaneStatus)
