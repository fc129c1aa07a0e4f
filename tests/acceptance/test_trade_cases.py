"""Inputs of the trade, each with a value that a closed form or a symmetry tells."""

import copy
import math

import pytest

import drakesep
from drakesep.case_file.case import Case


LITTLE = {"samples": 100, "starts": 2, "growth": False}
"""Effort: extremes of these cases lie in a corner."""
JOINT = {
    "stiffness_N_m": 1e6,
    "damping_N_s_m": 5e3,
    "angular_stiffness_N_m_rad": 1e5,
    "angular_damping_N_m_s_rad": 500.0,
}
PAD = 400.0 / math.sqrt(2.0)
PADS = [(PAD, PAD), (-PAD, PAD), (-PAD, -PAD), (PAD, -PAD)]
BODIES = {
    "lv": {
        "mass_kg": 2000.0,
        "cg_mm": [-1200.0, 0.0, 0.0],
        "inertia_kg_m2": {"xx": 1500.0, "yy": 2500.0, "zz": 2500.0},
    },
    "sc": {
        "mass_kg": 500.0,
        "cg_mm": [600.0, 0.0, 0.0],
        "inertia_kg_m2": {"xx": 180.0, "yy": 120.0, "zz": 120.0},
    },
}
SPEED = math.sqrt(2.0 * (4.0 * 0.5 * 500.0 * 0.08) / 400.0)
"""Four springs of 500 N over 80 mm on a reduced mass of 400 kg: sqrt(2 E / mu), m/s."""


def symmetric_design(**changes: object) -> Case:
    """Four equal springs by displacement, all CGs on the axis: nothing turns."""
    data: dict[str, object] = {
        "name": "symmetric",
        "pair": {"A": "lv", "B": "sc"},
        "bodies": BODIES,
        "attachments": {
            f"a{i}": {
                "A": "lv",
                "B": "sc",
                "position_mm": [0.0, y, z],
                "joint": JOINT,
                "spring": {
                    "name": f"s{i}",
                    "law": "displacement",
                    "force_max_N": 500.0,
                    "stroke_mm": 80.0,
                },
                "release_time_s": 0.0,
            }
            for i, (y, z) in enumerate(PADS, 1)
        },
        "run": {"duration_s": 1.0, "accuracy": 1e-8},
    }
    return Case.model_validate(copy.deepcopy(data | changes))


def test_largest_speed_over_its_limit_is_not_met():
    """A retro-rocket pulls the launcher away after separation: 1000 N s on 2000 kg."""
    case = symmetric_design(
        loads={
            "retro": {
                "body": "lv",
                "position_mm": [-1200.0, 0.0, 0.0],
                "direction": [-1.0, 0.0, 0.0],
                "times_s": [1.0, 1.01, 2.0, 2.01],
                "thrusts_N": [0.0, 1000.0, 1000.0, 0.0],
            }
        },
        dispersions={"s1.force_max_N": 5.0},
        requirements=[
            {"quantity": "longitudinal_speed_after_separation_m_s", "at_most": 1.0}
        ],
        run={"duration_s": 3.0, "accuracy": 1e-8},
    )
    study = drakesep.verify(case, **LITTLE)
    [row] = study.requirements.to_dict("records")
    # 100 times the accuracy, of a run of some thousand steps.
    assert row["nominal"] == pytest.approx(SPEED + 0.5, abs=1e-6)
    assert row["worst"] > row["nominal"]
    assert row["verdict"] == "not met"
    assert study.completed and not study.passed


def test_smallest_rate_below_its_limit_is_not_met():
    """A payload that must spin at 3 deg/s is braked from 5 to 2: too slow."""
    w, impulse = math.radians(5.0), 180.0 * math.radians(3.0)
    case = symmetric_design(
        before_separation={"rate_deg_s": [5.0, 0.0, 0.0]},
        loads={
            "brake": {
                "body": "sc",
                "times_s": [0.5, 0.51, 0.7, 0.71],
                "torques_N_m": [[m, 0.0, 0.0] for m in (0.0, *[-impulse / 0.2] * 2, 0)],
            }
        },
        dispersions={"sc.inertia_xx_kg_m2": 1.0},
        requirements=[
            {"quantity": "rate_after_separation_deg_s", "at_least": [3.0, 0.0, 0.0]}
        ],
    )
    study = drakesep.verify(case, **LITTLE)
    x, y, _ = study.requirements.to_dict("records")
    assert x["nominal"] == pytest.approx(math.degrees(w) - 3.0, abs=1e-5)
    # The lightest is braked most.
    lightest = math.degrees(w - impulse / 179.0)
    assert x["worst"] == pytest.approx(lightest, abs=1e-5)
    assert (x["verdict"], y["verdict"]) == ("not met", "met")
    assert study.completed and not study.passed


def test_symmetric_design_is_met_and_confirmed():
    """All rates are zero but for round-off, which is no difference of two engines."""
    case = symmetric_design(
        dispersions={"sc.mass_kg": 10.0},
        requirements=[
            {"quantity": "rate_after_separation_deg_s", "at_most": [1.0, 1.0, 1.0]}
        ],
        run={"duration_s": 1.0, "accuracy": 1e-6},
    )
    study = drakesep.verify(case, **LITTLE)
    assert study.passed
    of_rates = study.evidence[study.evidence["objective"].str.startswith("rate")]
    # What is zero everywhere is as bad everywhere: one maximum, and nothing to gain.
    assert (of_rates["optimality_residual"] == 0.0).all()
    assert (of_rates["ended_there"] == of_rates["starts"]).all()


@pytest.mark.parametrize("largest", [1.0, 5e-4])
def test_largest_step_of_a_run(largest):
    case = symmetric_design(
        run={"duration_s": 0.3, "accuracy": 1e-6, "max_step_s": largest}
    )
    run = drakesep.simulate(case).run
    assert run.steps >= 0.3 / largest
    speed = run.completed_motion.relative_velocity[-1, 0]
    assert speed == pytest.approx(SPEED, abs=1e-5)  # ten times the accuracy


def test_largest_step_where_bodies_may_touch_again():
    """As the guide asks for short blows; these bodies leave each other untouched."""
    bodies = copy.deepcopy(BODIES)
    bodies["lv"]["geometry"] = {
        "deck": {"box": {"size_mm": [100, 600, 600]}, "position_mm": [-50, 0, 0]}
    }
    bodies["sc"]["geometry"] = {
        "base": {"sphere": {"radius_mm": 200}, "position_mm": [210, 0, 0]}
    }
    case = symmetric_design(
        bodies=bodies,
        recontact={"stiffness_N_m": 1e5, "dissipation_s_m": 0.2, "friction": 0.0},
        run={"duration_s": 0.3, "accuracy": 1e-8, "max_step_s": 5e-4},
    )
    run = drakesep.simulate(case).run
    speed = run.completed_motion.relative_velocity[-1, 0]
    assert speed == pytest.approx(SPEED, abs=1e-6)  # 100 times the accuracy
