"""The command `report`: what it writes, and where."""

import json

import pandas as pd
from command_line import run
from small_case import small_case, write_case

import drakesep


def without_geometry(folder):
    """A case that is drawn at once."""
    data = small_case()
    for body in data["bodies"].values():
        del body["geometry"]
    return write_case(folder, data)


def test_report_writes_what_python_writes(capsys, monkeypatch, tmp_path):
    drakesep.plan_campaign(without_geometry(tmp_path), 300, output=tmp_path / "plan")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")  # a path of any length is one word
    code, out, _ = run(capsys, monkeypatch, "report", "plan")
    page = tmp_path / "plan_report.html"
    assert code == 0
    assert out.split() == f"The report is {page}: open it in a browser".split()
    for option in ("-o", "--output"):
        code, out, _ = run(capsys, monkeypatch, "report", "plan", option, "x/y.html")
        assert code == 0
        assert (tmp_path / "x" / "y.html").read_bytes() == page.read_bytes()
    python = drakesep.report("plan", output=tmp_path / "python.html")
    assert python.read_bytes() == page.read_bytes()


def test_a_campaign_under_way_gives_no_verdict(capsys, monkeypatch, tmp_path):
    drakesep.plan_campaign(without_geometry(tmp_path), 300, output=tmp_path / "plan")
    words = ("report", tmp_path / "plan", "--json")
    _, out, _ = run(capsys, monkeypatch, *words)
    assert json.loads(out)["verdict"] == "no verdict"


def test_check_does_the_study_again(capsys, monkeypatch, tmp_path):
    """It comes to the same; a number that somebody has changed is found."""
    case = without_geometry(tmp_path)
    folder = tmp_path / "run"
    drakesep.simulate(case, {"upper.mass_kg": 1190.0}, output=folder)
    words = ("report", folder, "--check", "--json", "--quiet")
    code, out, _ = run(capsys, monkeypatch, *words)
    told = json.loads(out)
    assert code == 0
    [checked] = told["checked"]
    assert checked == {"folder": str(folder), "same": True, "differences": 0}

    table = folder / "summary.csv"
    frame = pd.read_csv(table)
    frame["final_rate_x_deg_s"] *= 1.0 + 1e-6
    frame.to_csv(table, index=False)
    code, out, _ = run(capsys, monkeypatch, *words)
    told = json.loads(out)
    assert (code, told["checked"][0]["same"]) == (1, False)
    code, _, _ = run(capsys, monkeypatch, *words, "--tolerance", "1e-5")
    assert code == 0


def test_a_study_under_way_is_not_checked(capsys, monkeypatch, tmp_path):
    drakesep.plan_campaign(without_geometry(tmp_path), 300, output=tmp_path / "plan")
    code, _, err = run(capsys, monkeypatch, "report", tmp_path / "plan", "--check")
    assert code == 2
    assert "must be of a study that came to its end, to be done again" in err


def test_tolerance_needs_check(capsys, monkeypatch, tmp_path):
    words = ("report", tmp_path, "--tolerance", "1e-6")
    code, _, err = run(capsys, monkeypatch, *words)
    assert code == 2
    assert "--check" in err
