"""What every command says with `--json` and with `--quiet`.

The shape of the JSON object is a promise: keys and types are those of the declarations
in `drakesep.cli.summaries`, and rows say what the CSV files say.
"""

import json
import math
import typing
import warnings

import pandas as pd
import pytest
from batches import compiled_once
from command_line import run
from outcomes import (
    BAD_FILE,
    CODES,
    GOOD,
    INTERRUPTED,
    NO_FOLDER,
    NOT_MET,
    OTHER_RUN_FAILED,
    RUN_FAILED,
    SEARCH,
    arguments,
    case_for,
    interrupt,
)
from small_case import write_case

from drakesep.cli.answer import Answer, print_json
from drakesep.cli.summaries import SUMMARIES


ALWAYS = ["format", "command", "exit_code", "error", "warnings"]
VERDICTS = {
    ("verify", GOOD): "met",
    ("verify", NOT_MET): "not met",
    ("campaign", GOOD): "met",
    ("campaign", NOT_MET): "not met",
    ("prove", GOOD): "proven met",
    ("prove", NOT_MET): "not proven",
    ("clearance", GOOD): "clear",
    ("clearance", NOT_MET): "contact",
    ("report", GOOD): "no verdict",  # of a campaign that is planned
}


@pytest.fixture(scope="module", autouse=True)
def quick():
    """A batch is compiled once for all campaigns of a case."""
    with pytest.MonkeyPatch.context() as patch:
        compiled_once(patch, "drakesep.analysis.campaigns.flights")
        yield


@pytest.fixture
def said(capsys, monkeypatch, tmp_path):
    """What a command says as JSON, and its exit code."""

    def call(command, outcome, *more):
        if outcome == INTERRUPTED:
            interrupt(monkeypatch)
        words = [
            *command.split(),
            *arguments(command, outcome, tmp_path),
            "--json",
            *more,
        ]
        code, out, err = run(capsys, monkeypatch, *words)
        told = json.loads(out, parse_constant=pytest.fail)  # no NaN, no Infinity
        return code, told, err

    return call


def fits(value, hint):
    """Whether a value that JSON had is of a declared type."""
    if typing.get_origin(hint) is list:
        return isinstance(value, list) and all(
            fits(entry, *typing.get_args(hint)) for entry in value
        )
    if typing.get_origin(hint) is dict:
        key, entry = typing.get_args(hint)
        return isinstance(value, dict) and all(
            isinstance(k, key) and (entry is typing.Any or fits(x, entry))
            for k, x in value.items()
        )
    return isinstance(value, typing.get_args(hint) or hint)


@pytest.mark.parametrize(
    ("command", "outcome"),
    [
        (command, outcome)
        for command, codes in CODES.items()
        for outcome in (GOOD, NOT_MET)
        if outcome in codes
    ],
)
def test_shape_of_what_is_done(command, outcome, said):
    code, told, _ = said(command, outcome)
    hints = typing.get_type_hints(SUMMARIES[command])
    assert [*told][:5] == ALWAYS
    assert set(told) == {*ALWAYS, *hints}
    for key, hint in hints.items():
        assert fits(told[key], hint), key
    assert code == told["exit_code"] == CODES[command][outcome]
    assert (told["format"], told["command"]) == (1, command)
    assert told.get("verdict") == VERDICTS.get((command, outcome))
    contact = "there is contact; see clearance_summary.csv"
    assert told["error"] == (contact if told.get("verdict") == "contact" else None)


@pytest.mark.parametrize(
    ("command", "outcome"),
    [
        (command, outcome)
        for command, codes in CODES.items()
        for outcome in (BAD_FILE, NO_FOLDER, RUN_FAILED, INTERRUPTED)
        if outcome in codes
    ],
)
def test_shape_of_an_error(command, outcome, said):
    """Whatever goes wrong, there is an object that says so, beside the usual lines."""
    code, told, err = said(command, outcome)
    assert [*told][:5] == ALWAYS
    assert set(told) <= {*ALWAYS, *typing.get_type_hints(SUMMARIES[command])}
    assert code == told["exit_code"] == CODES[command][outcome]
    lines = [line for line in err.splitlines() if line.startswith("drakesep: ")]
    assert [f"drakesep: {line}" for line in told["error"].splitlines()] == lines
    assert lines
    if outcome != BAD_FILE and command != "cases":
        assert told.get("case", "small") == "small"


def test_simulate_tells_what_its_run_meets_and_gives_no_verdict(
    capsys, monkeypatch, tmp_path
):
    """A clearance is not measured; the exit code says that the run was flown."""
    data = case_for(NOT_MET, "simulate")
    data["requirements"].append({"quantity": "clearance_mm", "at_least": 1.0})
    words = ["simulate", write_case(tmp_path, data), "-o", tmp_path / "out"]
    code, out, _ = run(capsys, monkeypatch, *words, "--json")
    told = json.loads(out)
    assert code == told["exit_code"] == 0
    assert told["verdict"] is None
    verdicts = [row["verdict"] for row in told["requirements"]]
    assert verdicts == ["not met", "not looked at"]
    assert told["requirements"][0]["limit"] == 5.0
    assert told["requirements"][1]["value"] is None
    _, out, _ = run(capsys, monkeypatch, *words)
    assert "Requirements in this run alone" in out
    assert "not looked at" in out


def test_a_violation_is_told_beside_a_run_that_failed(capsys, monkeypatch, tmp_path):
    data = case_for(OTHER_RUN_FAILED, "verify")
    data["requirements"][0]["at_least"] = 5.0
    case = write_case(tmp_path, data)
    words = ["verify", case, "-o", tmp_path / "out", *SEARCH, "--json"]
    code, out, _ = run(capsys, monkeypatch, *words)
    told = json.loads(out)
    assert code == told["exit_code"] == 1
    assert told["verdict"] == "not met"
    assert told["error"].startswith("a run or a search failed")
    record = json.loads((tmp_path / "out" / "study.json").read_text())
    assert (record["ended"], record["verdict"]) == ("failed", "not met")
    assert "theirs: failed: " in record["message"]
    _, out, _ = run(capsys, monkeypatch, *words[:-1])
    assert "Not every requirement is met." in out


def test_every_command_has_a_shape():
    assert set(SUMMARIES) == set(CODES)


@pytest.mark.parametrize(
    ("command", "tables"),
    [
        ("verify", {"requirements": "requirements", "runs": "worst_cases"}),
        ("worst-case", {"worst_cases": "evidence"}),
        ("prove", {"proofs": "proofs"}),
        ("clearance", {"clearances": "clearance_summary"}),
        ("campaign", {"requirements": "campaign"}),
        ("campaign sensitivity", {"indices": "sobol_indices"}),
        ("campaign rare-events", {"rare_events": "rare_events"}),
    ],
)
def test_rows_are_those_of_the_tables(command, tables, said, tmp_path):
    """Floats to the last digit; what is empty is null."""
    _, told, _ = said(command, GOOD)
    for key, name in tables.items():
        frame = pd.read_csv(tmp_path / "out" / f"{name}.csv")
        assert len(told[key]) == len(frame) > 0
        for row, expected in zip(told[key], frame.to_dict("records"), strict=True):
            assert [*row] == [*expected]
            for column, value in expected.items():
                empty = isinstance(value, float) and not math.isfinite(value)
                assert (row[column] or None if empty else row[column]) == (
                    None if empty else value
                ), column


def test_metrics_of_a_run_are_those_of_its_table(said, tmp_path):
    _, told, _ = said("simulate", GOOD)
    [row] = pd.read_csv(tmp_path / "out" / "summary.csv").to_dict("records")
    metrics = told["metrics"]
    assert len(metrics) > 20
    assert metrics == {name: row[name] for name in metrics}


def test_words_that_make_no_sense_are_an_error_too(capsys, monkeypatch):
    code, out, err = run(capsys, monkeypatch, "verify", "vega", "--serch", "--json")
    told = json.loads(out)
    assert code == told["exit_code"] == 2
    assert told["command"] is None
    assert "--serch" in told["error"]
    assert "--serch" in err


@pytest.mark.parametrize("command", CODES)
def test_quiet(command, capsys, monkeypatch, tmp_path):
    """What was asked is said, and nothing else: results of studies are in folders."""
    words = [*command.split(), *arguments(command, GOOD, tmp_path), "--quiet"]
    code, out, err = run(capsys, monkeypatch, *words)
    assert code == 0
    assert err == ""
    asked = {"cases": "vega", "show": "upper.mass_kg"}
    if command in asked:
        assert asked[command] in out
    else:
        assert out == ""


@pytest.mark.parametrize("command", [c for c in CODES if BAD_FILE in CODES[c]])
def test_quiet_commands_tell_errors(command, capsys, monkeypatch, tmp_path):
    words = [*command.split(), *arguments(command, BAD_FILE, tmp_path), "--quiet"]
    code, out, err = run(capsys, monkeypatch, *words)
    assert code == 2
    assert out == ""
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("quiet", [False, True])
def test_warnings_are_in_the_object(quiet, capsys):
    with Answer("show", quiet=quiet, as_json=True):
        warnings.showwarning("of a mesh", UserWarning, "file", 1)
    captured = capsys.readouterr()
    assert json.loads(captured.out)["warnings"] == ["of a mesh"]
    lines = captured.err.splitlines()
    assert lines == ([] if quiet else ["drakesep: warning: of a mesh"])


def test_numbers_that_json_has_not_are_null(capsys):
    values = {"a": math.nan, "b": [math.inf, -math.inf, 1.5], "c": {"d": (2, "x")}}
    print_json("show", 0, "", [], values)
    told = json.loads(capsys.readouterr().out)
    assert told["a"] is None
    assert told["b"] == [None, None, 1.5]
    assert told["c"] == {"d": [2, "x"]}


def test_an_error_of_ours_keeps_its_traceback(capsys):
    with (
        pytest.raises(ZeroDivisionError),
        Answer("show", quiet=False, as_json=True),
    ):
        1 / 0  # noqa: B018
    assert capsys.readouterr().out == ""


def test_a_study_that_is_terminated_says_so(capsys):
    with pytest.raises(SystemExit), Answer("verify", quiet=False, as_json=True):
        raise SystemExit(143)  # as SIGTERM does
    told = json.loads(capsys.readouterr().out)
    assert (told["exit_code"], told["error"]) == (143, "terminated")


def test_another_exit_is_left_alone(capsys):
    """Such as that of a console whose reader has left."""
    with pytest.raises(SystemExit), Answer("show", quiet=False, as_json=True):
        raise SystemExit(1)
    assert capsys.readouterr().out == ""
