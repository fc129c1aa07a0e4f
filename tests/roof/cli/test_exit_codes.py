"""Every command by every outcome: its exit code, and one line of what went wrong.

0: done, and all is well. 1: done, and something is not. 2: what was asked cannot be
done. 4: a run failed. 130: interrupted. What else there is: `test_bad_luck.py`.
"""

import pytest
import typer
from batches import compiled_once
from command_line import run
from outcomes import (
    CODES,
    GOOD,
    INTERRUPTED,
    NOT_MET,
    OTHER_RUN_FAILED,
    RUN_FAILED,
    arguments,
    interrupt,
)

from drakesep.cli.app import app


LAST = {
    (NOT_MET, "clearance"): "drakesep: there is contact; see clearance_summary.csv",
    (RUN_FAILED, "simulate"): "drakesep: failed: ",
    (RUN_FAILED, "sweep"): "drakesep: 3 of 3 variants failed; first number 1: ",
    (OTHER_RUN_FAILED, "sweep"): (
        "drakesep: 1 of 2 variants failed; first number 2: s2 has not reached its"
    ),
    (RUN_FAILED, "campaign"): "drakesep: the nominal run failed: ",
    (RUN_FAILED, "clearance"): "drakesep: the run failed: ",
    (RUN_FAILED, "animate"): "drakesep: the run failed: ",
    (RUN_FAILED, "worst-case"): "drakesep: the nominal run failed: ",
    (RUN_FAILED, "verify"): "drakesep: the nominal run failed: ",
    (OTHER_RUN_FAILED, "animate"): "drakesep: the run failed: s2 has not reached its",
    (OTHER_RUN_FAILED, "worst-case"): "drakesep: a run or a search failed; see status",
    (OTHER_RUN_FAILED, "verify"): "drakesep: a run or a search failed; see status",
}
"""With which the one line begins; a verdict is told on standard output."""
BEGUN = (
    *("simulate", "sweep", "campaign", "clearance", "replay", "prove"),
    *("campaign sensitivity", "campaign rare-events"),
)
"""Whose folder is begun when the first run is interrupted."""


@pytest.fixture(scope="module", autouse=True)
def quick():
    """A batch is compiled once for all campaigns of a case."""
    with pytest.MonkeyPatch.context() as patch:
        compiled_once(patch, "drakesep.analysis.campaigns.flights")
        yield


@pytest.mark.parametrize(
    ("command", "outcome"),
    [(command, outcome) for command, codes in CODES.items() for outcome in codes],
)
def test_exit_code(command, outcome, tmp_path, capsys, monkeypatch):
    if outcome == INTERRUPTED:
        interrupt(monkeypatch)
    # As the user has it: a warning is a line on standard error.
    words = [*command.split(), *arguments(command, outcome, tmp_path)]
    code, out, err = run(capsys, monkeypatch, *words)
    assert code == CODES[command][outcome], (out, err)
    # Other lines are what a study plans and is at, where there is no terminal.
    lines = [line for line in err.splitlines() if line.startswith("drakesep: ")]
    if outcome == GOOD:
        assert not lines
    elif outcome == NOT_MET and command in ("verify", "campaign"):
        assert not lines
        assert out.splitlines()[-1] == "Not every requirement is met."
    elif outcome == NOT_MET and command == "check-proof":
        assert not lines
        assert out.splitlines()[-1] == "0 of 1 claims are verified."
    elif outcome == NOT_MET and command == "prove":
        assert not lines
        assert "It is proven of 0 of 1 requirements that they are met." in out
    elif outcome == NOT_MET and command == "compare":
        assert not lines
        assert "The answers differ: 1 by more than 1e-06." in out
    elif outcome == INTERRUPTED:
        told = "drakesep: interrupted"
        if command in BEGUN:
            told += f"; what was done is in {tmp_path / 'out'}"
        assert lines == [told]
    else:
        assert len(lines) == 1, err
        assert lines[0].startswith(LAST.get((outcome, command), "drakesep: "))


def test_every_command_is_here():
    known = {command.split()[0] for command in CODES}
    known |= {"ui"}  # which serves until it is ended: roof/page
    assert known == set(typer.main.get_command(app).commands)


def test_no_command_and_no_such_command(capsys, monkeypatch):
    assert run(capsys, monkeypatch, "verifi")[0] == 2
    assert run(capsys, monkeypatch)[0] == 2
    assert run(capsys, monkeypatch, "--help")[0] == 0
    assert run(capsys, monkeypatch, "--version")[0] == 0


def test_no_path_is_not_the_working_directory(tmp_path, capsys, monkeypatch):
    """As of a shell's variable that is not set."""
    monkeypatch.chdir(tmp_path)
    code, _, err = run(capsys, monkeypatch, "simulate", "vega", "-o", "")
    assert code == 2 and "output: must be a path, got ''" in err
    assert not [*tmp_path.iterdir()]
