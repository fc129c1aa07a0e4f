"""A body that tumbles through many turns: how far it has turned, in both engines."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from trade import JOINT

import drakesep
from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.case_file.case import Case


DEG = math.degrees(1.0)
NAMES = [
    *("rotation_value_at_end_x", "rotation_value_at_end_y", "rotation_value_at_end_z"),
    *("total_rotation_at_separation", "total_rotation_at_end", "total_rotation"),
    *("rotation_max_from_30_s_y", "relative_rotation_value_at_end_y"),
]


def tumbling(spring_y: float = 0.0) -> Case:
    """A stack that pitches by 40 deg/s lets go of a body, for 60 s."""
    return Case.model_validate(
        {
            "name": "tumbling",
            "pair": {"A": "lv", "B": "sc"},
            "bodies": {
                "lv": {
                    "mass_kg": 2000.0,
                    "cg_mm": [-1200.0, 0.0, 0.0],
                    "inertia_kg_m2": {"xx": 1500.0, "yy": 2500.0, "zz": 2500.0},
                },
                "sc": {
                    "mass_kg": 500.0,
                    "cg_mm": [600.0, 0.0, 0.0],
                    "inertia_kg_m2": {"xx": 180.0, "yy": 120.0, "zz": 150.0},
                },
            },
            "attachments": {
                "a": {
                    "A": "lv",
                    "B": "sc",
                    "position_mm": [0.0, spring_y, 0.0],
                    "joint": JOINT,
                    "spring": {
                        "name": "s",
                        "law": "displacement",
                        "force_max_N": 500.0,
                        "stroke_mm": 80.0,
                    },
                    "release_time_s": 0.0,
                }
            },
            "before_separation": {"rate_deg_s": [0.1, 40.0, 0.05]},
            "requirements": [
                {"quantity": "total_rotation_deg", "at_most": 2500.0},
                {"quantity": "rotation_deg", "at_most": [9.0, 2500.0, 9.0]},
            ],
            "run": {"duration_s": 60.0, "accuracy": 1e-9},
        }
    )


@pytest.fixture(scope="module")
def simulated():
    return drakesep.simulate(tumbling())


def test_turns_are_counted(simulated):
    """40 deg/s for 60 s, which Euler's equations change by little: 2400 deg."""
    end = simulated.motion.iloc[-1]
    # About the axis of the smallest inertia a rotation is stable.
    assert end["rate_y_deg_s"] == pytest.approx(39.9998, abs=1e-3)
    assert end["rotation_y_deg"] == pytest.approx(2400.0, abs=0.02)
    assert end["total_rotation_deg"] == pytest.approx(2400.0, abs=0.02)
    # By attitudes alone: angles between samples, each less than half a turn. That the
    # axis moves within a sample is of the second order of what it moves.
    quaternions = simulated.run.trajectory.of("sc")[:, [1, 2, 3, 0]]
    R = Rotation.from_quat(quaternions)
    turned = (R[:-1].inv() * R[1:]).magnitude()
    assert turned.max() < 0.5 * math.pi
    steps = np.diff(simulated.motion["total_rotation_deg"])
    assert steps == pytest.approx(DEG * turned, abs=1e-4)
    assert simulated.requirements["verdict"].tolist() == ["met"] * 4


def test_angles_that_swing_are_remarked(simulated):
    """And nothing of the direction: it leaves in it, and the launcher turns later."""
    [remark] = simulated.remarks
    assert remark.about == ("sc",)
    assert "sc turns by 2400 deg in all and comes to a pitch of 88 deg" in remark.text
    assert simulated.motion["angle_pitch_deg"].abs().max() < 90.0


def test_both_engines_count_alike():
    """With a spring aside, which turns it about z too."""
    case = tumbling(spring_y=30.0)
    run = drakesep.simulate(case).run
    drake = metrics_of_run(run, (math.inf,) * 3, NAMES)
    batch = Batch(case.separation, ["sc.mass"], metrics=NAMES, tolerance=1e-9)
    told = batch.run([[500.0]]).metrics.iloc[0]
    for name in NAMES:
        # Attitudes within 1e-9 a step, of a thousand steps over 42 rad.
        assert told[name] == pytest.approx(drake[name], abs=2e-6), name
    assert abs(told["rotation_value_at_end_z"]) > 0.1
