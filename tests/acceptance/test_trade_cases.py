"""Inputs of the trade, each with a value that a closed form or a symmetry tells."""

import copy
import math

import pytest
from trade import BODIES, SPEED, symmetric_design

import drakesep
from drakesep.studies.before_flight import check_verifiable
from drakesep.systems import sampling


LITTLE = {"samples": 100, "starts": 2, "growth": False}
"""Effort: extremes of these cases lie in a corner."""


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


def test_band_of_a_speed_by_two_sources():
    """0.63 m/s lies within 0.3 to 1.0 m/s of the one, and not within 0.1 of 0.7."""
    speed = {"quantity": "longitudinal_speed_m_s", "when": "after_separation"}
    wide = {
        "at_least": 0.3,
        "at_most": 1.0,
        "id": "UM-4.2",
        "source": "rideshare guide",
    }
    narrow = {"at_least": 0.65, "at_most": 0.75, "id": "ICD-7"}
    late = {"when": {"from_s": 2.0, "to_s": 5.0}, "at_most": 9.0, "id": "late"}
    case = symmetric_design(
        dispersions={"s1.force_max_N": 50.0},
        requirements=[speed | wide, speed | narrow, speed | late],
        run={"duration_s": 3.0, "accuracy": 1e-8},
    )
    study = drakesep.verify(case, **LITTLE)
    columns = ["id", "source", "sense", "limit", "verdict"]
    assert study.requirements[columns].to_numpy().tolist() == [
        ["UM-4.2", "rideshare guide", ">=", 0.3, "met"],
        ["UM-4.2", "rideshare guide", "<=", 1.0, "met"],
        ["ICD-7", "", ">=", 0.65, "not met"],
        ["ICD-7", "", "<=", 0.75, "met"],
        # The run ends at 3 s: what is then is not known.
        ["late", "", "<=", 9.0, "not looked at"],
    ]
    # One spring of 550 N or 450 N: a tenth of a quarter of the energy.
    extremes = study.requirements["worst"].to_numpy()[:4]
    slow, fast = (SPEED * math.sqrt(1.0 + x / 40.0) for x in (-1.0, 1.0))
    # What the pushes turn, 3 m from the axis of 3 t m2, takes a few thousandths.
    assert extremes == pytest.approx([slow, fast, slow, fast], rel=5e-3)
    assert study.completed and not study.passed


@pytest.mark.parametrize("dispersions", [{}, {"s1.force_max_N": 50.0}])
@pytest.mark.parametrize(
    "late",
    [
        {"quantity": "rate_modulus_deg_s", "when": {"from_s": 3.0}},
        {"quantity": "rate_deg_s", "when": {"from_s": 2.9999999999}},
        {"quantity": "joint_force_N", "when": {"from_s": 3.0}},
        {"quantity": "rate_modulus_deg_s", "when": {"from_s": 4.0}},
        {"quantity": "rate_modulus_deg_s", "when": {"at_s": 3.000001}},
    ],
)
def test_what_is_required_from_the_end_on_alone_is_not_looked_at(late, dispersions):
    """The run ends at 3 s: nothing is searched, and nothing is met."""
    required = late | {"at_most": [1.0] * 3 if "rate_deg" in str(late) else 1.0}
    case = symmetric_design(
        dispersions=dispersions,
        requirements=[required],
        run={"duration_s": 3.0, "accuracy": 1e-8},
    )
    study = drakesep.verify(case, **LITTLE)
    assert {*study.requirements["verdict"]} == {"not looked at"}
    assert study.completed and not study.passed
    assert not study.searched
    assert any("it looks beyond the end" in note for note in check_verifiable(case))
    with pytest.raises(ValueError, match=r"no requirement that its runs tell|none"):
        drakesep.worst_case(case)


def test_a_window_that_begins_at_the_end_has_no_value_in_a_sweep():
    case = symmetric_design(
        requirements=[
            {"quantity": "rate_deg_s", "when": {"from_s": 3.0}, "at_most": [1.0] * 3}
        ],
        run={"duration_s": 3.0, "accuracy": 1e-8},
    )
    for engine in ("drake", "batch"):
        study = drakesep.sweep(case, {"s1.force_max_N": [490.0, 500.0]}, engine=engine)
        assert {*study.table["verdict"]} == {"not looked at"}


def rung_joints(duration, **changes):
    """Four joints without damping, of 1e7 N/m in all, hold until near the end.

    1000 N on 2000 kg from 0.1 s on: they carry 200 N to 500 kg, each 50 N, and ring
    with a period of 2 pi sqrt(400 kg / 1e7 N/m), 40 ms.
    """
    case = symmetric_design().model_dump(mode="json", exclude_none=True)
    for pad in case["attachments"].values():
        pad["release_time_s"] = duration - 0.5
        del pad["spring"]  # whose preload they would carry too
        pad["joint"] = {
            "stiffness_N_m": 2.5e6,
            "damping_N_s_m": 0.0,
            "angular_stiffness_N_m_rad": 0.0,
            "angular_damping_N_m_s_rad": 0.0,
        }
    engine = {
        "body": "lv",
        "position_mm": [-1200.0, 0.0, 0.0],
        "direction": [1.0, 0.0, 0.0],
        "times_s": [0.1, duration],
        "thrusts_N": [1000.0, 1000.0],
    }
    return symmetric_design(
        attachments=case["attachments"],
        loads={"engine": engine},
        run={"duration_s": duration, "accuracy": 1e-6},
        **changes,
    )


FORCE = {"quantity": "joint_force_N", "of": "a1"}


@pytest.mark.parametrize("engine", ["drake", "batch"])
@pytest.mark.parametrize("duration", [1.2, pytest.param(2.5, marks=pytest.mark.slow)])
def test_a_step_on_joints_without_damping_is_carried_twice(duration, engine):
    case = rung_joints(duration, requirements=[FORCE | {"at_most": 99.0}])
    study = drakesep.sweep(case, {"sc.mass_kg": [500.0]}, engine=engine)
    [row] = study.table.to_dict("records")
    # Twenty samples a period: 1.2 % of the amplitude, which is half of the peak.
    assert row["a1.joint_force_N"] == pytest.approx(100.0, rel=0.007)
    assert row["verdict"] == "not met"


def test_joints_that_ring_for_more_periods_than_are_followed_have_no_verdict(
    monkeypatch,
):
    """Of some 17 periods, samples for 10: what lies between them is not known."""
    monkeypatch.setattr(sampling, "_ROWS_OF_RINGING", 100)
    late = {"quantity": "acceleration_m_s2", "when": {"from_s": 1.0}, "at_most": 9.0}
    case = rung_joints(1.2, requirements=[FORCE | {"at_most": 1e6}, late])
    study = drakesep.verify(case, **LITTLE)
    assert {*study.requirements["verdict"]} == {"not looked at"}
    [one, two, *_] = check_verifiable(case)
    assert "joints ring" in one and "joints ring" in two


@pytest.mark.slow
def test_forces_of_joints_and_springs_have_limits():
    """1000 N on 2500 kg: four joints carry 200 N to 500 kg until they let go.

    Against the 500 N with which each spring presses its pad.
    """
    plain = symmetric_design().model_dump(mode="json", exclude_none=True)
    attachments = plain["attachments"]
    for pad in attachments.values():
        pad["release_time_s"] = 0.6
    thrust = {
        "body": "lv",
        "position_mm": [-1200.0, 0.0, 0.0],
        "direction": [1.0, 0.0, 0.0],
        "times_s": [0.0, 0.6],
        "thrusts_N": [1000.0, 1000.0],
    }
    at = {"when": {"at_s": 0.5}}
    case = symmetric_design(
        attachments=attachments,
        loads={"engine": thrust},
        dispersions={"sc.mass_kg": 50.0},
        requirements=[
            {"quantity": "joint_force_N", "at_most": 451.0, "of": "a2"} | at,
            {"quantity": "joint_torque_N_m", "at_most": 1.0, "of": "a2"} | at,
            {"quantity": "spring_force_N", "at_most": 490.0, "of": "s3"},
            {"quantity": "acceleration_m_s2", "at_least": 0.1} | at,
        ],
        run={"duration_s": 1.0, "accuracy": 1e-8},
    )
    study = drakesep.verify(case, samples=50, starts=1, growth=False)
    force, torque, spring, acceleration = study.requirements.to_dict("records")
    # Joints swing at 100 rad/s with a quarter of critical damping: gone by e^-12.
    assert force["nominal"] == pytest.approx(500.0 - 50.0, abs=5e-3)
    least, most = (1000.0 * m / (2000.0 + m) / 4.0 for m in (450.0, 550.0))
    assert force["worst"] == pytest.approx(500.0 - least, abs=5e-3)
    assert (force["pair"], force["verdict"]) == ("a2", "not met")
    assert torque["worst"] == pytest.approx(0.0, abs=1e-3)
    # Joints give by 50 N / 1e6 N/m meanwhile, of a stroke of 80 mm.
    pressed = 500.0 * (1.0 + most / 1e6 / 0.08)
    assert spring["worst"] == pytest.approx(pressed, rel=1e-4)
    assert spring["verdict"] == "not met"
    assert acceleration["worst"] == pytest.approx(1000.0 / 2550.0, rel=1e-4)
    assert study.completed


@pytest.mark.slow
def test_growth_of_a_band_to_both_sides():
    """Forces go together: speed grows as the root of their energy, up and down."""
    names = [f"s{i}.force_max_N" for i in range(1, 5)]
    case = symmetric_design(
        dispersions=dict.fromkeys(names, 25.0),
        requirements=[
            {
                "quantity": "longitudinal_speed_m_s",
                "when": "at_end",
                "at_least": 0.59,
                "at_most": 0.67,
            }
        ],
    )
    study = drakesep.verify(case, samples=100, starts=2, growth=True)
    assert study.passed
    for row in study.requirements.to_dict("records"):
        # (v / v0)^2 = 1 +- k 25 / 500
        share = abs((row["limit"] / SPEED) ** 2 - 1.0)
        assert row["growth_factor"] == pytest.approx(share / 0.05, rel=1e-3)
        worst = SPEED * math.sqrt(0.95 if row["sense"] == ">=" else 1.05)
        assert row["worst"] == pytest.approx(worst, abs=1e-6)


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
            {"quantity": "rate_after_separation_deg_s", "at_least": [3.0, None, None]}
        ],
    )
    study = drakesep.verify(case, **LITTLE)
    [x] = study.requirements.to_dict("records")
    assert x["nominal"] == pytest.approx(math.degrees(w) - 3.0, abs=1e-5)
    # The lightest is braked most.
    lightest = math.degrees(w - impulse / 179.0)
    assert x["worst"] == pytest.approx(lightest, abs=1e-5)
    assert (x["axis"], x["verdict"]) == ("x", "not met")
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
