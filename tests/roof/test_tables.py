"""Columns that scripts depend on."""

import numpy as np
import pandas as pd
import pytest

import drakesep


AXES = ("x", "y", "z")
MOTION = [
    "time_s",
    *(f"rate_{a}_deg_s" for a in AXES),
    *(f"relative_rate_{a}_deg_s" for a in AXES),
    *(f"angle_{a}_deg" for a in ("roll", "pitch", "yaw")),
    *(f"relative_position_{a}_m" for a in AXES),
    *(f"relative_velocity_{a}_m_s" for a in AXES),
    *(f"acceleration_{a}_m_s2" for a in AXES),
    *(f"linear_momentum_change_{a}_N_s" for a in AXES),
    *(f"angular_momentum_change_{a}_N_m_s" for a in AXES),
]
PARAMETERS = [
    "payload.mass_kg",
    *(f"payload.cg_{a}_mm" for a in AXES),
    *(f"payload.inertia_{a}_kg_m2" for a in ("xx", "yy", "zz", "xy", "xz", "yz")),
    *(f"spring_{i}.force_max_N" for i in (1, 2, 3, 4)),
    *(f"spring_{i}.stroke_mm" for i in (1, 2, 3, 4)),
]
OBJECTIVES = ["G_L1_deg", "G_L2_deg_per_sqrt_s", "G_Linf_deg_s", "G_PM_m_s"]
REQUIREMENTS = [
    *("requirement", "axis", "unit", "sense", "limit"),
    *("nominal", "worst", "which_run", "margin", "verdict"),
]


def test_motion():
    motion = drakesep.simulate("vega").motion
    assert list(motion.columns) == MOTION
    assert len(motion) > 300
    assert motion["time_s"].iloc[0] == 0.0
    assert motion["time_s"].iloc[-1] == 3.0
    assert np.isfinite(motion).all().all()
    # Table 3, in degrees and body axes
    first = motion.iloc[0]
    assert first[MOTION[1:4]].tolist() == pytest.approx([0.576, 0.327, 0.327])
    assert first[MOTION[7:10]].tolist() == pytest.approx([0.466, 0.479, 0.461])
    assert first[MOTION[10:16]].tolist() == pytest.approx([0.0] * 6, abs=1e-15)


def test_worst_cases(vega_verification):
    columns = list(vega_verification.table.columns)
    assert columns[0] == "label"
    assert columns[1:19] == PARAMETERS
    assert columns[19:23] == OBJECTIVES
    assert columns[-3:] == ["iterations", "evaluations", "status"]
    assert vega_verification.table["label"].tolist() == [
        *("nominal", "paper_L1_Linf", "paper_L2", "paper_PM"),
        *("worst_L1", "worst_L2", "worst_Linf", "worst_PM"),
    ]


def test_requirements(vega_verification):
    frame = vega_verification.requirements
    assert list(frame.columns) == REQUIREMENTS
    beyond = frame["limit"] - frame["worst"]
    signed = np.where(frame["sense"] == "<=", beyond, -beyond)
    assert frame["margin"].to_numpy() == pytest.approx(signed, abs=1e-12)


def test_history(vega_verification):
    history = vega_verification.history
    columns = ["objective", "iteration", "value", "unit", "evaluations", *PARAMETERS]
    assert list(history.columns) == columns
    for objective, rows in history.groupby("objective"):
        assert rows["iteration"].tolist() == list(range(len(rows)))
        assert rows["evaluations"].is_monotonic_increasing
        found = vega_verification.table.set_index("label").loc[f"worst_{objective}"]
        assert found["iterations"] == rows["iteration"].iloc[-1]
        assert found["evaluations"] >= rows["evaluations"].iloc[-1]
    first = history[history["iteration"] == 0]
    assert (first["payload.mass_kg"] == 1860.0).all()


def test_summary_is_a_row_of_worst_cases():
    changed = drakesep.simulate(
        "vega", {"payload.mass_kg": 1880.0, "spring_1.stroke_mm": 120.0}
    )
    [row] = changed.summary.to_dict("records")
    assert row["payload.mass_kg"] == 1880.0
    assert row["spring_1.stroke_mm"] == 120.0
    assert row["status"] == "completed"
    assert pd.isna(row["iterations"])


def test_summary_holds_what_was_changed():
    changed = drakesep.simulate("vega", {"launch_vehicle.mass_kg": 800.0})
    assert changed.summary["launch_vehicle.mass_kg"].tolist() == [800.0]
