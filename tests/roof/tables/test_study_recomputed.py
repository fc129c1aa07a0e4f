"""Every table of a study of worst cases, column by column, computed anew.

From the runs' motion, from runs flown in Drake at the points that a table names, and
from the definitions of its columns; never by what makes the table.
"""

import math
import re

import numpy as np
import pandas as pd
import pytest
from recomputed import MM, metrics

from drakesep.systems.model.integration import Integration
from drakesep.systems.simulation.simulation import Simulation


PARAMETERS = ["s1.force_max_N", "upper.cg_y_mm", "upper.mass_kg"]
"""In the order of the case file."""
NOMINAL = {"s1.force_max_N": 1200.0, "upper.cg_y_mm": -20.0, "upper.mass_kg": 1200.0}
TOLERANCE = {"upper.mass_kg": 50.0, "s1.force_max_N": 60.0, "upper.cg_y_mm": 8.0}
IN_SI = {"upper.mass_kg": 1.0, "s1.force_max_N": 1.0, "upper.cg_y_mm": 1.0 / MM}
LIMITS = tuple(np.radians([2.1, 2.87, 4.0]))
SAMPLES, STARTS = 200, 3
EQUAL = 1300.0 * 100.0 / 110.0
"""Force of the first spring at which both end together, Eq. 5, N."""
MADE_OF = {
    "L1": ("G_L1_deg", 1.0),
    "L2": ("G_L2_deg_per_sqrt_s", 1.0),
    "Linf": ("G_Linf_deg_s", 1.0),
    "PM": ("G_PM_m_s", 1.0),
    "lowest_longitudinal_speed_after_separation": (
        "longitudinal_speed_after_separation_m_s",
        -1.0,
    ),
    "lowest_deviation_within_limits_until": ("deviation_within_limits_until_s", -1.0),
    **{
        f"rate_after_separation_{axis}_{way}": (
            f"rate_{which}_after_separation_{axis}_deg_s",
            sign,
        )
        for axis in "xyz"
        for way, which, sign in (("up", "max", 1.0), ("down", "min", -1.0))
    },
    **{
        f"deviation_at_separation_{axis}_{way}": (
            f"angle_at_separation_{axis}_deg",
            sign,
        )
        for axis in ("roll", "pitch", "yaw")
        for way, sign in (("up", 1.0), ("down", -1.0))
    },
}
"""Of each objective the metric that tables show for it; -1 where it is made small."""
SYMBOLS = {"_deg": "deg", "_deg_s": "deg/s", "_m_s": "m/s", "_s": "s"}
SYMBOLS["_deg_per_sqrt_s"] = "deg/√s"
REQUIREMENTS = [
    ("longitudinal speed after separation", "", ">=", 0.49),
    *(
        ("rate after separation", axis, "<=", limit)
        for axis, limit in zip("xyz", (0.66, 1.72, 1.25), strict=True)
    ),
    *(
        ("deviation at separation", axis, "<=", limit)
        for axis, limit in (("roll", 2.1), ("pitch", 2.87), ("yaw", 4.0))
    ),
]


def symbol(column):
    suffix = max((s for s in SYMBOLS if column.endswith(s)), key=len)
    return SYMBOLS[suffix]


def column_of(requirement, axis):
    """The column of worst_cases.csv that a requirement is judged by."""
    stem = "_".join(filter(None, [requirement.replace(" ", "_"), axis]))
    if stem.startswith("rate"):
        return f"{stem}_deg_s"
    return f"{stem}_m_s" if "speed" in stem else f"{stem}_deg"


def without_gaps(frame):
    """Texts that are empty read as such."""
    texts = [c for c in frame if c in ("axis", "status", "first_tolerance")]
    return frame.assign(**{c: frame[c].astype(object).fillna("") for c in texts})


@pytest.fixture(scope="module")
def tables(small_study):
    _, folder = small_study
    read = {path.stem: pd.read_csv(path) for path in folder.glob("*.csv")}
    assert set(read) == {
        *("worst_cases", "iterates", "comparison", "requirements", "table_4"),
        *("evidence", "searches", "candidates", "worst_points", "sensitivities"),
        *("tolerances", "remarks"),  # these by test_springs_over_time
    }
    return read


@pytest.fixture(scope="module")
def in_drake(small_study):
    """Metrics, computed anew, of a run in Drake at parameters in their units."""
    study, _ = small_study
    simulation = Simulation(study.case.separation, Integration(accuracy=1e-9))
    known = {}

    def fly(values):
        si = {
            name.removesuffix("_kg").removesuffix("_N").removesuffix("_mm"): float(
                values[name] * IN_SI[name]
            )
            for name in PARAMETERS
        }
        key = tuple(si.values())
        if key not in known:
            known[key] = metrics(simulation.run(si), LIMITS)
        return known[key]

    return fly


def test_worst_cases(small_study, tables):
    """Rows of all runs: their own parameters, and metrics from their motion."""
    study, _ = small_study
    frame = tables["worst_cases"].set_index("label")
    searched = list(MADE_OF)
    assert sorted(frame.index) == sorted(
        ["nominal", "theirs"]
        + [f"sqp_{name}" for name in ("L1", "L2", "Linf", "PM")]
        + [f"worst_{name}" for name in searched]
    )
    for one in study.runs:
        row, run = frame.loc[one.label], one.run
        spring, body = run.separation.springs[0], run.separation.body("upper")
        assert row["upper.mass_kg"] == pytest.approx(body.mass, rel=1e-15)
        assert row["s1.force_max_N"] == pytest.approx(spring.force_max, rel=1e-15)
        assert row["upper.cg_y_mm"] == pytest.approx(MM * body.p_BoBcm_B[1], rel=1e-14)
        told = metrics(run, LIMITS)
        assert set(told) == set(frame.columns) - {
            *("role", "iterations", "evaluations", "status"),
            *PARAMETERS,
        }
        for name, value in told.items():
            # Times of crossings are of 1001 moments between kinks.
            room = 2e-4 if name.endswith("until_s") else 1e-6
            assert row[name] == pytest.approx(value, rel=room, abs=1e-6), name
        role = next(
            (r for r in ("worst", "sqp") if one.label.startswith(f"{r}_")),
            "published" if one.label == "theirs" else "nominal",
        )
        assert row["role"] == role
        assert row["status"] in {
            "worst": ["confirmed"],
            "sqp": ["converged", "stopped without further ascent"],
        }.get(role, ["completed"])
        assert pd.isna(row["iterations"]) == (role != "sqp")
    flown = tables["searches"]["points"].sum()
    assert (frame.loc[frame["role"] == "worst", "evaluations"] == flown).all()
    assert (frame.loc[["nominal", "theirs"], "evaluations"] == 1).all()
    # M is the upper bound, m the lower.
    theirs = frame.loc["theirs", PARAMETERS].tolist()
    assert theirs == pytest.approx([1140.0, -20.0, 1250.0])


def test_worst_points(tables):
    frame = tables["worst_points"].set_index("parameter")
    runs = tables["worst_cases"].set_index("label")
    assert frame.index.tolist() == PARAMETERS
    assert sorted(frame.columns) == sorted(MADE_OF)
    for name, marks in frame.items():
        for parameter, mark in marks.items():
            value = runs.loc[f"worst_{name}", parameter]
            u = (value - NOMINAL[parameter]) / TOLERANCE[parameter]
            if mark in ("M", "m"):
                assert u == pytest.approx({"M": 1.0, "m": -1.0}[mark], abs=5e-3)
            else:
                assert abs(u) < 1.0 - 4e-3
                assert float(mark) == pytest.approx(value, rel=1e-5)


def test_candidates(tables, in_drake):
    """The best point of each search: its value is that of a run in Drake there."""
    frame = tables["candidates"]
    assert frame.columns.tolist() == [
        "objective",
        "search",
        "value",
        "unit",
        *PARAMETERS,
    ]
    searches = ["samples", "vertices", "sqp", "multistart"]
    assert sorted(zip(frame["objective"], frame["search"], strict=True)) == sorted(
        (name, search) for name in MADE_OF for search in searches
    )
    for _, row in frame.iterrows():
        metric, _ = MADE_OF[row["objective"]]
        assert row["unit"] == symbol(metric)
        room = 2e-4 if metric.endswith("until_s") else 2e-6
        expected = in_drake(row)[metric]
        assert row["value"] == pytest.approx(expected, rel=room, abs=1e-6), metric


def test_evidence(small_study, tables, in_drake):
    frame = tables["evidence"].set_index("objective")
    runs = tables["worst_cases"].set_index("label")
    best = tables["candidates"].pivot(
        index="objective", columns="search", values="value"
    )
    points = tables["worst_points"].set_index("parameter")
    assert sorted(frame.index) == sorted(MADE_OF)
    for name, row in frame.iterrows():
        metric, sign = MADE_OF[name]
        assert row["unit"] == symbol(metric)
        worst = (sign * best.loc[name]).max() * sign
        assert row["worst"] == pytest.approx(worst, rel=1e-12)
        assert row["in_drake"] == pytest.approx(
            runs.loc[f"worst_{name}", metric], rel=1e-12
        )
        assert row["difference"] == pytest.approx(
            row["in_drake"] - row["worst"], abs=1e-12
        )
        for search in best.columns:
            assert row[search] == pytest.approx(best.loc[name, search], rel=1e-15)
        # The first search that found as much.
        as_bad = [
            search
            for search in ("samples", "vertices", "sqp", "multistart")
            if abs(row[search] - worst) <= 1e-12 * abs(worst)
        ]
        assert row["found_by"] == as_bad[0]
        assert row["starts"] == 1 + STARTS - 1 or row["starts"] >= STARTS
        listed = re.findall(r"([-\d.e]+) \((\d+)\)", str(row["local_maxima"]))
        counted = sum(int(count) for _, count in listed)
        assert counted + row["unfinished"] == row["starts"]
        values = [sign * float(value) for value, _ in listed]
        assert values == sorted(values, reverse=True)
        at_the_top = [
            int(n) for v, n in listed if abs(float(v) - worst) <= 1e-6 * abs(worst)
        ]
        assert row["ended_there"] == sum(at_the_top)
        assert row["at_bounds"] == points[name].isin(["M", "m"]).sum()
        assert pd.isna(row["active_constraints"])
        assert (row["random_samples"], row["failed_samples"]) == (SAMPLES, 0)
        # Clopper and Pearson, none beyond: 1 - 0.05^(1/n).
        assert row["fraction_beyond_at_95_percent"] == pytest.approx(
            1.0 - 0.05 ** (1.0 / SAMPLES), rel=1e-12
        )


def test_searches(tables):
    frame = tables["searches"]
    assert frame.columns.tolist() == [
        *("search", "what", "points", "failed", "first_failure"),
        "unphysical_share_of_tolerances",
    ]
    assert frame["search"].tolist() == ["samples", "vertices", "sqp", "multistart"]
    assert frame["points"].tolist()[:2] == [SAMPLES, 2**3]
    assert frame["what"].tolist()[:3] == [
        f"{SAMPLES} random samples",
        "all 8 vertices",
        "SQP from the nominal, slopes by differences",
    ]
    assert (frame["failed"] == 0).all()
    assert frame["first_failure"].isna().all()
    assert (frame["unphysical_share_of_tolerances"] == 0.0).all()


def test_iterates(tables, in_drake):
    frame, runs = tables["iterates"], tables["worst_cases"].set_index("label")
    ends = tables["candidates"].set_index(["objective", "search"])["value"]
    evidence = tables["evidence"].set_index("objective")
    assert frame.columns.tolist() == [
        *("objective", "search", "start", "iteration", "value", "unit", "evaluations"),
        *PARAMETERS,
    ]
    assert list(dict.fromkeys(frame["search"])) == ["sqp", "multistart"]
    for search, rows in frame.groupby("search"):  # objective after objective
        assert [*dict.fromkeys(rows["objective"])] == [*evidence.index], search
    for (name, search), rows in frame.groupby(["objective", "search"]):
        metric, sign = MADE_OF[name]
        starts = rows["start"].drop_duplicates().tolist()
        assert starts == list(range(1, len(starts) + 1))
        if search == "multistart":
            assert 1 + len(starts) == evidence.loc[name, "starts"]
        # At a kink an iterate may be lower: the search ends at the best it has seen.
        best = sign * ends[name, search]
        assert (sign * rows["value"]).max() <= best + 1e-12 * abs(best)
        assert set(rows["unit"]) == {symbol(metric)}
        for _, mine in rows.groupby("start"):
            assert mine["iteration"].tolist() == list(range(len(mine)))
            assert mine["evaluations"].is_monotonic_increasing
        if search == "multistart":
            continue
        assert starts == [1]
        assert rows.iloc[0][PARAMETERS].tolist() == pytest.approx([*NOMINAL.values()])
        for _, row in rows.iterrows():
            room = 2e-4 if metric.endswith("until_s") else 2e-6
            assert row["value"] == pytest.approx(
                in_drake(row)[metric], rel=room, abs=1e-6
            )
        if f"sqp_{name}" in runs.index:
            end = runs.loc[f"sqp_{name}"]
            assert end["iterations"] == len(rows) - 1
            assert end[PARAMETERS].tolist() == pytest.approx(
                rows.iloc[-1][PARAMETERS].tolist(), rel=1e-14
            )


def test_comparison(tables):
    frame = tables["comparison"].set_index("objective")
    runs = tables["worst_cases"].set_index("label")
    assert frame.index.tolist() == ["G_L1", "G_L2", "G_Linf", "G_PM"]
    for name, row in frame.iterrows():
        metric, _ = MADE_OF[name.removeprefix("G_")]
        column = runs[metric]
        assert row["unit"] == symbol(metric)
        assert row["nominal"] == column["nominal"]
        assert row["worst"] == column.max()
        assert column[row["which_run"]] == column.max()
        assert row["sqp"] == column[f"sqp_{name.removeprefix('G_')}"]
        above = 100.0 * (row["worst"] - row["nominal"]) / abs(row["nominal"])
        assert row["above_nominal_percent"] == pytest.approx(above, rel=1e-9)
        if name in ("G_L1", "G_PM"):  # which "theirs" is said to be the worst of
            assert row["published"] == column["theirs"]
            above = 100.0 * (row["worst"] - column["theirs"]) / abs(column["theirs"])
            assert row["above_published_percent"] == pytest.approx(above, abs=1e-9)
        else:
            assert pd.isna(row["published"])
            assert pd.isna(row["above_published_percent"])


def test_requirements(tables):
    frame, runs = tables["requirements"], tables["worst_cases"].set_index("label")
    assert len(frame) == len(REQUIREMENTS)
    singles = without_gaps(tables["tolerances"])
    for (_, row), (what, axis, sense, limit) in zip(
        without_gaps(frame).iterrows(),
        REQUIREMENTS,
        strict=True,
    ):
        metric = column_of(what, axis)
        column = runs[metric]
        worst = column.max() if sense == "<=" else column.min()
        got = [row[key] for key in ("requirement", "axis", "unit", "sense")]
        assert got == [what, axis, symbol(metric), sense]
        assert row["limit"] == pytest.approx(limit, rel=1e-14)
        assert row["nominal"] == pytest.approx(column["nominal"], rel=1e-14)
        assert row["worst"] == pytest.approx(worst, rel=1e-14)
        assert column[row["which_run"]] == worst
        margin = limit - worst if sense == "<=" else worst - limit
        assert row["margin"] == pytest.approx(margin, rel=1e-9)
        assert row["verdict"] == ("met" if margin >= 0.0 else "not met") == "met"
        assert (row["growth_by"], row["looked_up_to"]) == ("search", 5.0)
        mine = singles[(singles["requirement"] == what) & (singles["axis"] == axis)]
        first = mine.loc[mine["factor"].idxmin()]
        assert row["its_growth_factor"] == first["factor"]
        named = first["parameter"] if math.isfinite(first["factor"]) else ""
        assert row["first_tolerance"] == named


def test_table_4(small_study, tables):
    """As the paper prints it: conditions to two decimals, then M, m, Nom or values."""
    frame = tables["table_4"].set_index("condition or property")
    runs = tables["worst_cases"].set_index("label")
    of_paper = ["L1", "L2", "Linf", "PM"]
    assert sorted(frame.columns) == sorted(
        ["nominal", "theirs"] + [f"{r}_{n}" for r in ("sqp", "worst") for n in of_paper]
    )
    conditions = {
        **{f"rate {axis} (deg/s)": f"final_rate_{axis}_deg_s" for axis in "xyz"},
        "deviation within limits until (s)": "deviation_within_limits_until_s",
        "longitudinal speed, max (m/s)": "longitudinal_speed_max_m_s",
    }
    printed = dict(zip(conditions, ("0.5", "2.1", "1.1", "0.7", "0.52"), strict=True))
    properties = {
        "upper mass (kg)": "upper.mass_kg",
        "s1 force max (N)": "s1.force_max_N",
        "upper cg y (mm)": "upper.cg_y_mm",
    }
    assert set(frame.index) == {*conditions, *properties, "solver iterations"}
    for label in frame.columns:
        cells, row = frame[label], runs.loc[label]
        for title, metric in conditions.items():
            theirs = f" ({printed[title]})" if label == "theirs" else ""
            assert cells[title] == f"{row[metric]:.2f}{theirs}"
        for title, name in properties.items():
            u = (row[name] - NOMINAL[name]) / TOLERANCE[name]
            marks = {-1: "m", 0: "Nom", 1: "M"}
            near = abs(u - round(u)) <= 5e-3
            assert cells[title] == (marks[round(u)] if near else f"{row[name]:.6g}")
        wanted = "-" if pd.isna(row["iterations"]) else f"{row['iterations']:.0f}"
        assert cells["solver iterations"] == ("(6)" if label == "theirs" else wanted)


def test_sensitivities(tables, in_drake):
    """Slopes with whole tolerances, by differences of runs in Drake."""
    frame = tables["sensitivities"]
    runs = tables["worst_cases"].set_index("label")
    assert len(frame) == len(MADE_OF) * len(PARAMETERS)

    def slope(at, parameter, metric):
        step = 0.02 * TOLERANCE[parameter]
        ends = (
            in_drake(at | {parameter: at[parameter] + way * step})[metric]
            for way in (1.0, -1.0)
        )
        return (next(ends) - next(ends)) / 0.04

    checked = 0
    for name, rows in frame.groupby("objective", sort=False):
        metric, sign = MADE_OF[name]
        assert set(rows["unit"]) == {symbol(metric)}
        assert sorted(rows["parameter"]) == sorted(PARAMETERS)
        assert rows["per_tolerance_at_worst"].abs().is_monotonic_decreasing
        worst = runs.loc[f"worst_{name}", PARAMETERS].astype(float).to_dict()
        for _, row in rows.iterrows():
            parameter = row["parameter"]
            for side in ("tolerance", "minus", "plus"):
                assert row[side] == pytest.approx(TOLERANCE[parameter], rel=1e-14)
            for at in ("nominal", "worst"):
                assert row[f"upward_at_{at}"] == row[f"per_tolerance_at_{at}"]
                assert row[f"downward_at_{at}"] == -row[f"per_tolerance_at_{at}"]
            u = (worst[parameter] - NOMINAL[parameter]) / TOLERANCE[parameter]
            at_worst = "" if pd.isna(row["at_worst"]) else row["at_worst"]
            assert at_worst == ("M" if u > 1 - 1e-6 else "m" if u < -1 + 1e-6 else "")
            gain = sign * u * row["per_tolerance_at_worst"] if at_worst else 0.0
            # All held by bounds: what the objective gains beyond them.
            assert row["multiplier"] == pytest.approx(max(gain, 0.0), abs=1e-7)
            if metric.endswith("until_s") or name in ("L1", "Linf"):
                continue  # kinks, of crossings and of magnitudes
            if metric.startswith("angle") and abs(worst["s1.force_max_N"] - EQUAL) < 5:
                continue  # another, of the end of separation
            checked += 1
            for column, at in (
                ("per_tolerance_at_nominal", NOMINAL),
                ("per_tolerance_at_worst", worst),
            ):
                expected = slope(at, parameter, metric)
                # Of the step's square; where separation ends changes smoothly too.
                room = 1e-5 * max(1.0, abs(expected)) if name != "PM" else 1e-6
                assert row[column] == pytest.approx(expected, abs=3 * room), (
                    name,
                    parameter,
                    column,
                )
    assert checked > 30


def test_tolerances(tables):
    frame = without_gaps(tables["tolerances"])
    assert len(frame) == len(REQUIREMENTS) * len(PARAMETERS)
    named = [(what, axis) for what, axis, *_ in REQUIREMENTS]
    assert [*dict.fromkeys(zip(frame["requirement"], frame["axis"], strict=True))] == (
        named
    )
    for _, row in frame.iterrows():
        tolerance = TOLERANCE[row["parameter"]]
        for side in ("minus", "plus"):
            assert row[side] == pytest.approx(tolerance, rel=1e-14)
            violated = pytest.approx(tolerance * row["factor"], rel=1e-12)
            assert row[f"violated_{side}"] == violated
        assert row["looked_up_to"] == 5.0
        assert row["status"] == ""
    assert np.isfinite(frame["factor"]).sum() > 6
