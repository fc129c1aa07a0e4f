"""What `compare` tells of two folders: all that was changed, and nothing else.

Changes are made by hand, in a case or in a copy of a folder, so that they are known.
"""

import json
import shutil

import numpy as np
import pandas as pd
import pytest
import trimesh
from command_line import run
from hypothesis import given
from hypothesis import strategies as st
from small_case import small_case, write_case

import drakesep
from drakesep.reports.differences import Tolerated, differences, keyed
from drakesep.tables.columns import write_csv


@pytest.fixture(autouse=True, scope="module")
def nothing_drawn():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("drakesep.plots.motion.save_motion", lambda *_, **__: None)
        yield


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """The small case, flown once; nobody may change the folder."""
    home = tmp_path_factory.mktemp("flown")
    drakesep.simulate(write_case(home, small_case()), output=home / "out")
    return home / "out"


@pytest.fixture
def copy(flown, tmp_path):
    return shutil.copytree(flown, tmp_path / "copy")


def changed_cell(folder, table, column, change, row=0):
    frame = pd.read_csv(folder / table)
    frame[column] = frame[column].astype(object)
    frame.loc[row, column] = change(frame.loc[row, column])
    write_csv(frame, folder / table)


def told(comparison):
    """Where changes are, and in which columns."""
    return set(zip(comparison.table["where"], comparison.table["column"], strict=True))


def test_the_same_study_done_again(flown, tmp_path):
    """When, how long and in which process is no change."""
    case = flown.parent / "case.yaml"
    drakesep.simulate(case, output=tmp_path)
    for tolerance in (None, 0.0):
        found = drakesep.compare(flown, tmp_path, tolerance=tolerance)
        assert found.table.empty
        assert found.same


def test_inputs_are_told_by_their_keys(flown, tmp_path):
    data = small_case(description="another")
    data["bodies"]["upper"]["mass_kg"] = 1201.0
    data["requirements"][1]["at_most"][2] = 1.3
    del data["failure_cases"]
    case = write_case(tmp_path, data)
    drakesep.simulate(case, {"s1.force_max_N": 1210.0}, output=tmp_path / "out")
    found = drakesep.compare(flown, tmp_path / "out", tolerance=0.5)
    rows = found.inputs[["column", "first", "second"]].values.tolist()
    assert {key: (was, got) for key, was, got in rows} == {
        "description": ("absent", "another"),
        "bodies.upper.mass_kg": (1200.0, 1201.0),
        "requirements (entry 2).at_most": ("0.66, 1.72, 1.25", "0.66, 1.72, 1.3"),
        "failure_cases.s1_worn.s1.force_max_N": (1180.0, "absent"),
        "values.s1.force_max_N": ("absent", 1210.0),
    }
    assert set(found.inputs["where"]) == {"case", "arguments"}
    mass = found.answers.query("column == 'upper.mass_kg'").iloc[0]
    assert (mass["difference"], mass["relative_difference"]) == (1.0, 1 / 1201.0)
    # A run alone is held against a run alone, whatever it is called.
    assert "runs/nominal.csv.gz" in set(found.answers["where"])
    assert not found.answers["first"].isin(["present", "absent"]).any()


@pytest.mark.parametrize(
    ("by", "tolerance", "same"),
    [
        (1e-9, None, False),
        (1e-9, 1e-8, True),
        (1e-9, 1e-10, True),  # the round-off of a run integrated to 1e-6
        (2e-6, 1e-8, False),
        (2e-6, 1e-5, True),
        (np.nan, 1.0, False),
    ],
)
def test_tolerance(by, tolerance, same, flown, copy):
    speed = "longitudinal_speed_max_m_s"
    changed_cell(copy, "summary.csv", speed, lambda x: x * (1.0 + by))
    found = drakesep.compare(flown, copy, tolerance=tolerance)
    assert told(found) == {("summary.csv", speed)}
    assert found.same is same
    [row] = found.table.to_dict("records")
    assert row["row"] == "nominal"
    if by == by:
        # One rounding of the product, one of the difference.
        assert row["relative_difference"] == pytest.approx(by, rel=1e-5)


def test_what_is_no_number_must_be_the_same(flown, copy):
    changed_cell(copy, "requirements_of_run.csv", "verdict", lambda _: "not met")
    found = drakesep.compare(flown, copy, tolerance=1.0)
    assert not found.same
    [row] = found.table.to_dict("records")
    assert row["row"] == "upper, longitudinal speed after separation, >="
    assert (row["first"], row["second"]) == ("met", "not met")


def test_of_tables_over_time_the_greatest_difference_is_told(flown, copy):
    changed_cell(copy, "motion.csv", "rate_x_deg_s", lambda x: x + 0.1, row=5)
    changed_cell(copy, "motion.csv", "rate_x_deg_s", lambda x: x + 0.3, row=9)
    changed_cell(copy, "motion.csv", "rate_x_deg_s", lambda x: x + 0.2, row=11)
    found = drakesep.compare(flown, copy)
    [row] = found.table.to_dict("records")
    assert row["difference"] == pytest.approx(0.3, rel=1e-12)
    time = pd.read_csv(flown / "motion.csv")["time_s"][9]
    assert float(row["row"]) == time


def test_rows_columns_and_tables_on_one_side(flown, copy):
    frame = pd.read_csv(copy / "requirements_of_run.csv")
    write_csv(frame.drop(index=2, columns="source"), copy / "requirements_of_run.csv")
    frame = pd.read_csv(copy / "motion.csv")
    write_csv(frame.iloc[:-3], copy / "motion.csv")
    record = json.loads((copy / "study.json").read_text())
    record["files"] = [f for f in record["files"] if f["name"] != "remarks.csv"]
    record["verdict"] = "met"
    (copy / "study.json").write_text(json.dumps(record))
    found = drakesep.compare(flown, copy)
    rows = found.table[["where", "row", "column", "first", "second"]].values.tolist()
    limit = "upper, rate after separation, y, <="
    count = len(frame)
    assert rows == [
        ["study", "", "verdict", "absent", "met"],
        ["remarks.csv", "", "", "present", "absent"],
        ["requirements_of_run.csv", limit, "", "present", "absent"],
        ["requirements_of_run.csv", "", "source", "present", "absent"],
        ["motion.csv", "", "rows", count, count - 3],
    ]
    assert not found.same


def test_how_hard_it_was_is_no_answer(flown, copy):
    changed_cell(copy, "summary.csv", "evaluations", lambda n: n + 7)
    found = drakesep.compare(flown, copy, tolerance=0.0)
    assert told(found) == {("summary.csv", "evaluations")}
    assert found.same


def test_meshes_are_told_by_what_they_hold(tmp_path, monkeypatch):
    """Not by where they are."""
    data = small_case(requirements=[], published=None)
    ball = {"mesh": {"file": "ball.stl"}, "position_mm": [900.0, 0.0, 0.0]}
    data["bodies"]["upper"]["geometry"]["ball"] = ball
    for name, radius in (("a", 0.1), ("b", 0.1), ("c", 0.2)):
        home = tmp_path / name
        home.mkdir()
        trimesh.creation.icosphere(1, radius).export(home / "ball.stl")
        drakesep.simulate(write_case(home, data), output=home / "out")
    folders = [tmp_path / name / "out" for name in "abc"]
    assert drakesep.compare(*folders[:2]).table.empty
    found = drakesep.compare(*folders[1:])
    assert told(found) == {("named_files", "ball.stl")}
    assert found.same  # it is measured by nothing


def test_cases_made_in_python(flown, tmp_path):
    """Have no text: both cases are compared in SI."""
    case = drakesep.read_results(flown).case
    drakesep.simulate(case, output=tmp_path)
    found = drakesep.compare(drakesep.read_results(flown), tmp_path)
    assert found.table.empty


def test_what_is_refused(flown, copy, tmp_path):
    def refused(*folders, **how):
        with pytest.raises(drakesep.InputError) as caught:
            drakesep.compare(*folders, **how)
        return str(caught.value)

    assert refused(flown, flown) == f"folders must be two, got {flown} twice"
    assert "must be a folder of results, got no study.json" in refused(flown, tmp_path)
    assert refused(flown, copy, tolerance=-1.0).startswith("tolerance must be")
    (copy / "motion.csv").write_text('a,b\n1,2,3\n"')
    assert f"{copy / 'motion.csv'}: must be a table, got: " in refused(flown, copy)
    record = json.loads((copy / "study.json").read_text())
    text = json.dumps(record | {"ended": "under way"})
    (copy / "study.json").write_text(text)
    assert "must have ended, got under way" in refused(flown, copy)
    text = json.dumps(record | {"study": "campaign", "files": []})
    (copy / "study.json").write_text(text)
    assert "must have a table in common, got none" in refused(flown, copy)


def test_command(flown, copy, tmp_path, capsys, monkeypatch):
    """What it prints, writes and says by its exit code."""
    monkeypatch.setenv("COLUMNS", "300")
    file = tmp_path / "there" / "changes.csv"
    changed_cell(copy, "summary.csv", "final_rate_x_deg_s", lambda x: 2.0 * x)
    words = ["compare", flown, copy]
    code, out, _ = run(capsys, monkeypatch, *words, "-o", file)
    assert code == 0  # told, and not checked
    assert "Inputs that changed: none" in out
    assert "final_rate_x_deg_s" in out
    by_command = pd.read_csv(file, keep_default_na=False)
    assert by_command["relative_difference"].astype(float).tolist() == [0.5]
    for tolerance, wanted in ((0.4, 1), (0.6, 0)):
        code, out, _ = run(capsys, monkeypatch, *words, "--tolerance", tolerance)
        assert code == wanted
        same = "The answers are the same." in out
        assert same == (wanted == 0)


_CELLS = st.none() | st.floats(allow_nan=False) | st.sampled_from(["met", "", "3"])


@given(st.lists(st.tuples(st.sampled_from("abc"), _CELLS), max_size=6), st.data())
def test_any_table(rows, data):
    """No change against itself; one changed cell is told, in either order."""
    frame = pd.DataFrame(rows, columns=["name", "value"], dtype=object)
    table = keyed(frame, ["name"], {})
    assert differences(table, table, Tolerated(), is_long=False) == []
    if rows:
        i = data.draw(st.integers(0, len(rows) - 1))
        other = frame.copy()
        other.loc[i, "value"] = "changed"
        sides = [table, keyed(other, ["name"], {})]
        for order in (sides, sides[::-1]):
            for is_long in (False, True):
                [found] = differences(*order, Tolerated(1.0, 1.0), is_long=is_long)
                assert found.beyond
                assert "changed" in (found.first, found.second)


def test_units_of_rows():
    """Round-off is a part of the largest number of the same unit."""
    rows = {"unit": ["N", "mm", "mm", ""], "value": [1e6, 1.0, 0.0, 0.0]}
    sides = [pd.DataFrame(rows), pd.DataFrame(rows)]
    sides[1]["value"] += [0.9, 0.9e-6, 0.9e-6, 1e-30]
    tables = [keyed(x, [], {"value": "as `unit` says"}) for x in sides]
    found = differences(*tables, Tolerated(0.0, 1e-6), is_long=False)
    assert [one.beyond for one in found] == [False, False, False, True]


def test_numbers_of_draws_are_names():
    """Draw 986 is not a hundred times draw 9, nor nearly draw 987."""
    first = pd.DataFrame({"metric": ["a", "b", "c"], "worst_draw": [986.0, 9.0, None]})
    second = first.assign(worst_draw=[987.0, 9.0, 4.0])
    tables = [keyed(each, ["metric"], {}) for each in (first, second)]
    found = differences(*tables, Tolerated(relative=0.1), is_long=False)
    assert [(one.row, one.first, one.second, one.beyond) for one in found] == [
        ("a", "number 986", "number 987", True),
        ("c", None, "number 4", True),
    ]
