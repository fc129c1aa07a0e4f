"""Every command by every outcome: its exit code, and one line of what went wrong.

0: done, and all is well. 1: done, and something is not, or a run failed. 2: what was
asked cannot be done. 130: interrupted.
"""

import pytest
import typer
from command_line import run
from small_case import small_case, write_case

from drakesep.cli.app import app
from drakesep.systems.simulation.simulation import Simulation


GOOD, NOT_MET, RUN_FAILED, OTHER_RUN_FAILED, BAD_FILE, BAD_SETTING, NO_FOLDER = (
    *("good", "not met", "run failed", "another run failed"),
    *("bad file", "bad setting", "folder in the way"),
)
INTERRUPTED = "interrupted"
SEARCH = ("--search", "drake", "--workers", "1")
"""Drake alone: no program to compile."""
OF_STUDY = {
    GOOD: 0,
    RUN_FAILED: 1,
    BAD_FILE: 2,
    BAD_SETTING: 2,
    NO_FOLDER: 2,
    INTERRUPTED: 130,
}
CODES = {
    "cases": {GOOD: 0, INTERRUPTED: 130},
    "show": {GOOD: 0, BAD_FILE: 2, INTERRUPTED: 130},
    "simulate": OF_STUDY,
    "clearance": {**OF_STUDY, NOT_MET: 1},
    "animate": {**OF_STUDY, OTHER_RUN_FAILED: 1},
    "worst-case": {**OF_STUDY, OTHER_RUN_FAILED: 1},
    "verify": {**OF_STUDY, NOT_MET: 1, OTHER_RUN_FAILED: 1},
}
"""What else there is does not come about: no requirement is asked of `simulate`."""
SETTINGS = {
    "simulate": ("--set", "upper.mass_kg=heavy"),
    "clearance": ("--set", "upper.mas_kg=1200"),
    "animate": ("--run", "worst_L1"),
    "worst-case": ("--objective", "L3"),
    "verify": ("--samples", "0"),
}
LAST = {
    (NOT_MET, "clearance"): "drakesep: there is contact; see clearance_summary.csv",
    (RUN_FAILED, "simulate"): "drakesep: failed: ",
    (RUN_FAILED, "clearance"): "drakesep: the run failed: ",
    (RUN_FAILED, "animate"): "drakesep: the run failed: ",
    (RUN_FAILED, "worst-case"): "drakesep: the nominal run failed: ",
    (RUN_FAILED, "verify"): "drakesep: the nominal run failed: ",
    (OTHER_RUN_FAILED, "animate"): "drakesep: the run failed: s2 has not reached its",
    (OTHER_RUN_FAILED, "worst-case"): "drakesep: a run or a search failed; see status",
    (OTHER_RUN_FAILED, "verify"): "drakesep: a run or a search failed; see status",
}
"""With which the one line begins; a verdict is told on standard output."""


def case_for(outcome, command):
    """The small case, so that it comes to the outcome."""
    if outcome == BAD_FILE:
        return small_case(pair={"A": "lower", "B": "uper"})
    data = small_case(dispersions={"upper.mass_kg": 20.0}, published=None)
    data["requirements"] = data["requirements"][:1]
    if outcome == NOT_MET:
        data["requirements"][0]["at_least"] = 5.0
        data["bodies"]["lower"]["geometry"]["post"]["position_mm"][1] = 300.0
    if outcome == RUN_FAILED:  # no step can follow such joints
        for attachment in data["attachments"].values():
            attachment["joint"] = dict.fromkeys(attachment["joint"], 1e30)
            attachment["release_time_s"] = 0.3
    if outcome == OTHER_RUN_FAILED:
        spring = data["attachments"]["two"]["spring"]
        del spring["design_mass_kg"]
        spring["law"] = "displacement"
        [published] = small_case()["published"]
        published["values"] = {"s2.stroke_mm": 5000.0}
        data["published"] = [published]
    return data


def arguments(command, outcome, folder):
    if command == "cases":
        return []
    case = write_case(folder, case_for(outcome, command))
    if command == "show":
        return [case]
    output = folder / "out"
    if outcome == NO_FOLDER:
        output.write_text("")
    if command == "animate":
        output = output / "page.html"
    more = [*SEARCH, "--objective", "PM"] if command == "worst-case" else []
    more = [*SEARCH] if command == "verify" else more
    setting = SETTINGS[command] if outcome == BAD_SETTING else ()
    return [case, "-o", output, *more, *setting]


@pytest.mark.parametrize(
    ("command", "outcome"),
    [(command, outcome) for command, codes in CODES.items() for outcome in codes],
)
def test_exit_code(command, outcome, tmp_path, capsys, monkeypatch):
    if outcome == INTERRUPTED:
        interrupt(monkeypatch)
    # As the user has it: a warning is a line on standard error.
    code, out, err = run(
        capsys, monkeypatch, command, *arguments(command, outcome, tmp_path)
    )
    assert code == CODES[command][outcome], (out, err)
    # Other lines are what a study plans and is at, where there is no terminal.
    lines = [line for line in err.splitlines() if line.startswith("drakesep: ")]
    if outcome == GOOD:
        assert not lines
    elif (outcome, command) == (NOT_MET, "verify"):
        assert not lines
        assert out.splitlines()[-1] == "Not every requirement is met."
    elif outcome == INTERRUPTED:
        # Nothing is to be said of those that write nothing before their end.
        told = f"drakesep: interrupted; what was done is in {tmp_path / 'out'}"
        assert lines == ([told] if command in ("worst-case", "verify") else [])
    else:
        assert len(lines) == 1, err
        assert lines[0].startswith(LAST.get((outcome, command), "drakesep: "))


def interrupt(monkeypatch):
    """Ctrl-C as the first run flies, or as a case is read where none flies."""

    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(Simulation, "run", stop)
    monkeypatch.setattr("drakesep.cli.console.print_cases", stop)
    monkeypatch.setattr("drakesep.cli.console.print_case", stop)


def test_every_command_is_here():
    assert set(CODES) == set(typer.main.get_command(app).commands)


def test_no_command_and_no_such_command(capsys, monkeypatch):
    assert run(capsys, monkeypatch, "verifi")[0] == 2
    assert run(capsys, monkeypatch)[0] == 2
    assert run(capsys, monkeypatch, "--help")[0] == 0
    assert run(capsys, monkeypatch, "--version")[0] == 0
