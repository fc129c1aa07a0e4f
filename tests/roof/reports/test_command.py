"""The command `report`, and `verify --report`: what they write, and where."""

import json

from command_line import run
from outcomes import GOOD, SEARCH, case_for
from small_case import write_case

import drakesep


def test_report_writes_what_python_writes(capsys, monkeypatch, tmp_path):
    case = write_case(tmp_path, case_for(GOOD, "campaign"))
    drakesep.plan_campaign(case, 300, output=tmp_path / "plan")
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
    case = write_case(tmp_path, case_for(GOOD, "campaign"))
    drakesep.plan_campaign(case, 300, output=tmp_path / "plan")
    words = ("report", tmp_path / "plan", "--json")
    _, out, _ = run(capsys, monkeypatch, *words)
    assert json.loads(out)["verdict"] == "no verdict"


def test_verify_writes_its_report_at_once(capsys, monkeypatch, tmp_path):
    case = write_case(tmp_path, case_for(GOOD, "verify"))
    words = ("verify", case, "-o", tmp_path / "out", *SEARCH, "--report", "--json")
    code, out, _ = run(capsys, monkeypatch, *words)
    told = json.loads(out)
    page = tmp_path / "out_report.html"
    assert code == 0
    assert told["report"] == str(page)
    again = drakesep.report(tmp_path / "out", output=tmp_path / "again.html")
    assert again.read_bytes() == page.read_bytes()
