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
    *(f"rotation_{a}_deg" for a in AXES),
    "total_rotation_deg",
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
    *("requirement", "axis", "unit", "sense", "limit", "share", "confidence", "sides"),
    *("nominal", "worst", "which_run", "margin", "growth_factor", "growth_by"),
    *("looked_up_to", "first_tolerance", "its_growth_factor"),
    *("proven_bound", "gap_percent", "proven", "verdict"),
    *("pair", "id", "source"),
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
    assert columns[:2] == ["label", "role"]
    assert columns[2:20] == PARAMETERS
    assert columns[20:24] == OBJECTIVES
    assert columns[-3:] == ["iterations", "evaluations", "status"]
    assert vega_verification.table["label"].tolist() == [
        *("nominal", "paper_L1_Linf", "paper_L2", "paper_PM"),
        *("sqp_L1", "sqp_L2", "sqp_Linf", "sqp_PM"),
        *("worst_L1", "worst_L2", "worst_Linf", "worst_PM"),
        *(
            f"worst_rate_after_separation_{axis}_{way}"
            for axis in AXES
            for way in ("up", "down")
        ),
        *(
            f"worst_deviation_at_separation_{angle}_{way}"
            for angle in ("roll", "pitch", "yaw")
            for way in ("up", "down")
        ),
        "worst_lowest_longitudinal_speed_after_separation",
        "worst_lowest_clearance_until_0.5_m",
        "worst_lowest_deviation_within_limits_until",
        "worst_lowest_longitudinal_displacement_at_end",
    ]


def test_requirements(vega_verification):
    frame = vega_verification.requirements
    assert list(frame.columns) == REQUIREMENTS
    beyond = frame["limit"] - frame["worst"]
    signed = np.where(frame["sense"] == "<=", beyond, -beyond)
    assert frame["margin"].to_numpy() == pytest.approx(signed, abs=1e-12)


def test_iterates(vega_verification):
    iterates = vega_verification.iterates
    columns = [
        *("objective", "search", "start", "iteration", "value", "unit", "evaluations"),
        *PARAMETERS,
    ]
    assert list(iterates.columns) == columns
    assert list(dict.fromkeys(iterates["search"])) == ["sqp", "multistart"]
    from_nominal = iterates[iterates["search"] == "sqp"]
    assert (from_nominal["start"] == 1).all()
    for objective, rows in from_nominal.groupby("objective"):
        assert rows["iteration"].tolist() == list(range(len(rows)))
        assert rows["evaluations"].is_monotonic_increasing
        if objective in ("L1", "L2", "Linf", "PM"):
            found = vega_verification.table.set_index("label").loc[f"sqp_{objective}"]
            assert found["iterations"] == rows["iteration"].iloc[-1]
            assert found["evaluations"] >= rows["evaluations"].iloc[-1]
    first = from_nominal[from_nominal["iteration"] == 0]
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


OBJECTIVE_NAMES = [
    *("L1", "L2", "Linf", "PM"),
    *(f"rate_after_separation_{a}_{way}" for a in AXES for way in ("up", "down")),
    *(
        f"deviation_at_separation_{angle}_{way}"
        for angle in ("roll", "pitch", "yaw")
        for way in ("up", "down")
    ),
    "lowest_longitudinal_speed_after_separation",
    "lowest_clearance_until_0.5_m",
    "lowest_deviation_within_limits_until",
    "lowest_longitudinal_displacement_at_end",
]


def test_evidence(vega_verification):
    evidence = vega_verification.evidence
    assert list(evidence.columns) == [
        *("objective", "unit", "worst", "in_drake", "difference", "beaten_by"),
        *("found_by", "flown_by", "run_by_run"),
        *("sqp", "multistart", "vertices", "samples"),
        *("starts", "ended_there", "local_maxima", "unfinished"),
        *("at_bounds", "active_constraints", "optimality_residual"),
        *("random_samples", "failed_samples"),
        "fraction_beyond_at_95_percent",
    ]
    assert evidence["objective"].tolist() == OBJECTIVE_NAMES
    assert {*evidence["beaten_by"]} == {""}
    difference = evidence["in_drake"] - evidence["worst"]
    assert evidence["difference"].to_numpy() == pytest.approx(
        difference.to_numpy(), abs=1e-12
    )


def test_searches_and_candidates(vega_verification):
    searches = vega_verification.searches
    assert searches["search"].tolist() == ["samples", "vertices", "sqp", "multistart"]
    assert searches["points"].iloc[:2].tolist() == [50_000, 2**18]
    assert (searches["failed"] == 0).all()
    assert searches["unphysical_share_of_tolerances"].unique() == [
        vega_verification.share_unphysical
    ]
    candidates = vega_verification.candidates
    assert list(candidates.columns) == [
        *("objective", "search", "value", "unit"),
        *PARAMETERS,
    ]
    # Sweeps leave the clearance out.
    assert len(candidates) == 4 * len(OBJECTIVE_NAMES) - 2


def test_worst_points_are_bounds_or_values(vega_verification):
    points = vega_verification.worst_points.set_index("parameter")
    assert list(points.columns) == OBJECTIVE_NAMES
    assert list(points.index) == PARAMETERS
    for name, marks in points.items():
        row = vega_verification.table.set_index("label").loc[f"worst_{name}"]
        for parameter, mark in marks.items():
            if mark not in ("M", "m"):
                assert float(mark) == pytest.approx(row[parameter], rel=1e-5)
    assert points.loc["payload.cg_z_mm", "L1"] == "M"


def test_sensitivities(vega_verification):
    frame = vega_verification.sensitivities
    assert list(frame.columns) == [
        *("objective", "unit", "parameter", "tolerance", "minus", "plus"),
        *("per_tolerance_at_nominal", "per_tolerance_at_worst"),
        *("downward_at_nominal", "downward_at_worst"),
        *("upward_at_nominal", "upward_at_worst"),
        *("at_worst", "multiplier"),
    ]
    for _, rows in frame.groupby("objective"):
        assert rows["per_tolerance_at_worst"].abs().is_monotonic_decreasing
        assert set(rows["parameter"]) == set(PARAMETERS)
    assert (frame["multiplier"] >= 0.0).all()


def test_tolerances(vega_verification):
    frame = vega_verification.tolerances
    assert list(frame.columns) == [
        *("requirement", "axis", "unit", "sense", "limit"),
        *("share", "confidence", "sides", "parameter"),
        *("minus", "plus", "violated_minus", "violated_plus", "factor"),
        *("looked_up_to", "status", "pair", "id", "source"),
    ]
    assert len(frame) == 7 * len(PARAMETERS)
    assert (frame["status"] == "").all()
    finite = frame[np.isfinite(frame["factor"])]
    for side in ("minus", "plus"):
        assert finite[f"violated_{side}"].to_numpy() == pytest.approx(
            (finite[side] * finite["factor"]).to_numpy()
        )
