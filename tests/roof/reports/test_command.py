"""The command `report`: what it writes, and where."""

import json

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
