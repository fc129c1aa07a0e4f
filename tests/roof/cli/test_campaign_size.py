"""How many runs a campaign needs, as the command line tells it."""

import json

import pytest
from command_line import run


@pytest.fixture
def said(capsys, monkeypatch):
    return lambda *words: run(capsys, monkeypatch, "campaign", "size", *words)


def sizes(said, *words):
    code, out, _ = said(*words, "--json")
    told = json.loads(out)
    assert (told["command"], told["exit_code"]) == ("campaign size", code)
    return told, code


def test_runs_for_failures(said):
    """Hanson and Beard's, by default for 0 to 5 failures."""
    told, code = sizes(said, "--share", 0.99865)
    runs = [row["runs"] for row in told["sizes"]]
    assert runs[:4] == [1705, 2880, 3941, 4947] and code == 0
    assert [row["failures_allowed"] for row in told["sizes"]] == list(range(6))
    assert all(row["consumers_risk"] <= 0.1 for row in told["sizes"])
    assert (told["share"], told["confidence"]) == (0.99865, 0.9)
    told, _ = sizes(said, "--share", 0.9973, "--confidence", 0.9, "--failures", 2)
    assert [row["runs"] for row in told["sizes"]] == [1970]


def test_what_runs_show(said):
    told, _ = sizes(said, "--share", 0.9973, "--runs", 2000)
    [row] = told["sizes"]
    assert (row["runs"], row["failures_allowed"]) == (2000, 2)
    # One that may fail as seldom as the binomial sum of two failures says.
    q = 1.0 - row["share_that_passes"]
    passes = sum(
        choose * q**k * (1.0 - q) ** (2000 - k)
        for k, choose in enumerate((1, 2000, 2000 * 1999 / 2))
    )
    assert passes == pytest.approx(0.9, rel=1e-9)
    code, out, _ = said("--share", 0.9973, "--runs", 2000)
    assert code == 0
    assert "Runs that show 99.73 % of launches at a confidence of 90 %" in out
    assert "passes with a chance of 90 %." in out


def test_too_few_runs(said):
    told, code = sizes(said, "--share", 0.99865, "--runs", 1704)
    assert (code, told["error"]) == (1, None)
    assert told["sizes"][0]["failures_allowed"] is None
    code, out, _ = said("--share", 0.99865, "--runs", 1704)
    assert code == 1
    assert "1705 are needed, of which none may fail." in " ".join(out.split())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--share", 99.865), "share must be > 0 and < 1, got 99.865"),
        (
            ("--share", 0.9, "--confidence", 1),
            "confidence must be > 0 and < 1, got 1.0",
        ),
        (("--share", 0.9, "--failures", -1), "failures must be >= 0, got -1"),
        (("--share", 0.9, "--runs", 0), "runs must be >= 1, got 0"),
        (
            ("--share", 0.9, "--runs", 5, "--failures", 1),
            "--failures and --runs: must be one of them, got both",
        ),
    ],
)
def test_what_makes_no_sense(said, words, message):
    code, _, err = said(*words)
    assert (code, err) == (2, f"drakesep: {message}\n")
