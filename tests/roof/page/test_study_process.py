"""Commands in processes of their own: watched, stopped, killed, and gone on with."""

import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pandas as pd
import pytest
from small_case import small_case, write_case

from drakesep.cli import watched
from drakesep.page.study_process import StudyProcess


ENDS = ("ended", "stopped", "died")
IN_DRAKE = ("worst-case", "case.yaml", "--objective", "PM", "--workers", "1")
ALONE = (*IN_DRAKE, "--search", "drake", "--json", "--quiet")
ON_BATCH = (
    *("verify", "case.yaml", "--search", "sqp", "--search", "multistart"),
    *("--starts", "2", "--workers", "1", "--json", "--quiet"),
)


@pytest.fixture
def study(tmp_path):
    """What starts a process that runs a command in the folder, and ends all at last."""
    data = small_case(published=None, objectives=None)
    write_case(tmp_path, data)
    begun = []

    def start(*arguments):
        process = StudyProcess()
        begun.append(process)
        process.wait_for("ready", timeout=60.0)
        process.run(arguments, where=tmp_path)
        return process

    yield start
    for process in begun:
        process.close()


def tables(folder):
    """Every table, to the byte."""
    found = {file.name: file.read_bytes() for file in sorted(folder.glob("*.csv"))}
    assert "iterates.csv" in found
    return found


def of(kind, told):
    return [event for event in told if event["event"] == kind]


def test_killed_is_told_and_resumed_loses_nothing(study, tmp_path):
    """Every iterate is told as the folder holds it; and a kill changes no byte."""
    killed = study(*ALONE, "-o", "killed")
    killed.wait_for("iterate", timeout=60.0)
    os.kill(killed.id, signal.SIGKILL)
    *_, last = killed.wait_for(*ENDS, timeout=10.0)
    assert last["event"] == "died"
    assert "SIGKILL" in last["reason"]
    told = study(*ALONE, "-o", "killed", "--resume").wait_for(*ENDS, timeout=60.0)
    assert (told[-1]["event"], told[-1]["exit_code"]) == ("ended", 0)
    held = pd.read_csv(tmp_path / "killed" / "iterates.csv")
    rows = pd.DataFrame(event["row"] for event in of("iterate", told))
    pd.testing.assert_frame_equal(rows, held, check_exact=True)
    whole = [sys.executable, "-c", "from drakesep.cli.entry import main; main()"]
    subprocess.run([*whole, *ALONE, "-o", "whole"], cwd=tmp_path, check=True)
    assert tables(tmp_path / "killed") == tables(tmp_path / "whole")


@pytest.mark.slow
def test_stopped_between_searches_goes_on(study, tmp_path):
    stopped = study(*ON_BATCH, "-o", "stopped")
    told = []
    while not any(e["row"]["search"] == "multistart" for e in of("iterate", told)):
        told += stopped.wait_for("iterate", timeout=120.0)
    began = time.monotonic()
    stopped.stop()
    *_, last = stopped.wait_for(*ENDS, timeout=10.0)
    assert last["event"] == "stopped"
    assert time.monotonic() - began < 5.0
    first = of("iterate", told)
    again = study(*ON_BATCH, "-o", "stopped", "--resume")
    told = again.wait_for(*ENDS, timeout=120.0)
    assert told[-1]["event"] == "ended"
    # What has been finished is not searched again.
    assert {e["row"]["search"] for e in of("iterate", told)} == {"multistart"}
    whole = study(*ON_BATCH, "-o", "whole").wait_for(*ENDS, timeout=120.0)
    assert tables(tmp_path / "stopped") == tables(tmp_path / "whole")
    every = of("iterate", whole)
    assert first == every[: len(first)]
    held = pd.read_csv(tmp_path / "whole" / "iterates.csv")
    rows = pd.DataFrame(event["row"] for event in every)
    key = ["search", "objective", "start", "iteration"]
    pd.testing.assert_frame_equal(
        rows.sort_values(key, ignore_index=True),
        held.sort_values(key, ignore_index=True),
        check_exact=True,
    )


def test_it_dies_with_its_parent(tmp_path):
    """Killed itself, the parent can tell it nothing."""
    write_case(tmp_path, small_case())
    script = (
        "from drakesep.page.study_process import StudyProcess\n"
        "p = StudyProcess()\n"
        "print(p.id, flush=True)\n"
        "import time; time.sleep(60)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    child = int(parent.stdout.readline())
    assert os.getpgid(child) == child
    parent.kill()
    parent.wait()
    parent.stdout.close()
    for _ in range(200):
        if not is_alive(child):
            break
        time.sleep(0.05)
    assert not is_alive(child)


def is_alive(process):
    try:
        os.kill(process, 0)
        with open(f"/proc/{process}/stat") as status:
            return status.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_what_is_wrong_is_told(study, tmp_path):
    """As the command line says it."""
    process = study("worst-case", "none.yaml", "--json", "--quiet")
    [ended] = process.wait_for(*ENDS, timeout=60.0)
    assert ended["exit_code"] == 2
    assert "none.yaml" in ended["summary"]["error"]


def test_a_command_that_says_it_was_stopped_has_not_ended(monkeypatch):
    """It was asked to stop as it could leave in order: no other word than the exit."""

    def interrupted():
        raise SystemExit(130)

    monkeypatch.setattr("drakesep.cli.app.main", interrupted)
    told = []
    events = SimpleNamespace(tell=lambda event, **_: told.append(event))
    assert watched._run(["metrics"], events) == 130
    assert not told
