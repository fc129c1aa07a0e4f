"""How far a study has come, in a log: lines that it can bear."""

import io
import threading
import time

import pytest
from rich.console import Console

from drakesep.analysis.metrics.objectives import OBJECTIVES
from drakesep.analysis.search.effort import SearchSettings
from drakesep.analysis.search.problem import SearchProgress
from drakesep.analysis.tolerances.box import ToleranceBox
from drakesep.cli.progress import _lines, _Log, _Steps, progress_bar, steps
from drakesep.studies.worst_case.effort import StudyEffort
from drakesep.studies.worst_case.pace import Remaining
from drakesep.studies.worst_case.plan import Progress


EFFORT = StudyEffort(
    objectives=1,
    parameters=18,
    searches=("samples", "vertices", "sqp", "multistart"),
    settings=SearchSettings(),
    growth=True,
    seconds={"samples": 5.0, "vertices": 20.0},
    left_out=("multistart",),
)


def progress(search, done=0, total=None, *, share=0.0, left=25.0):
    return Progress(
        objectives=(OBJECTIVES["PM"],),
        box=ToleranceBox(()),
        search=SearchProgress(search=search, done=done, total=total, best={0: -1.15}),
        effort=EFFORT,
        remaining=Remaining(share, left),
    )


def test_plan_first_then_a_line_each_tenth_and_each_ten_seconds():
    lines, now = [], [0.0]
    log = _Log(lines.append, clock=lambda: now[0])
    log(progress("plan"))
    log(progress("samples", 10, 100, share=0.01))
    for percent in range(2, 35):
        log(progress("samples", percent, 100, share=percent / 100, left=60.0))
    now[0] = 11.0
    log(progress("samples", 35, 100, share=0.34))
    log(progress("samples", 36, 100, share=0.34))
    assert lines[0] == (
        "Worst cases of 1 objective over 18 parameters: 50 000 samples, 262 144 "
        "vertices, SQP from 8 starts, growth of tolerances; about 25 s; left out, to "
        "stay within 10 min: multistart"
    )
    assert lines[1] == "  1%, 25 s left: samples: 10 of 100, PM -1.15 m/s"
    assert [line[:4] for line in lines[2:]] == [" 10%", " 20%", " 30%", " 34%"]
    assert lines[2].startswith(" 10%, 60 s left")


def test_a_terminal_has_a_bar_and_the_plan():
    console = Console(file=io.StringIO(), force_terminal=True, width=200)
    with progress_bar(console) as tell:
        tell(progress("plan"))
        tell(progress("samples", 10, 100, share=0.4, left=7.0))
    shown = console.file.getvalue()
    assert "Worst cases of 1 objective over 18 parameters" in shown
    assert "7 s left" in shown


def test_without_a_terminal_it_goes_to_standard_error(capsys):
    with progress_bar(Console(file=io.StringIO())) as tell:
        tell(progress("plan"))
        tell(progress("samples", 10, 100, share=0.4, left=600.0))
    captured = capsys.readouterr()
    assert captured.out == ""
    plan, done = captured.err.splitlines()
    assert plan.startswith("Worst cases")
    assert done.startswith(" 40%, 10 min left: samples: 10 of")


def test_preparing_is_told_where_it_takes_long():
    lines, told = [], threading.Event()

    def say(line):
        lines.append(line)
        told.set()

    with _lines(say, patience=1e-3) as tell:
        assert told.wait(10.0)
        tell(progress("plan"))
    assert [line.split()[0] for line in lines] == ["Preparing;", "Worst"]
    with _lines(lines.append, patience=0.05) as tell:
        tell(progress("plan"))
        time.sleep(0.1)
    assert [line.split()[0] for line in lines[2:]] == ["Worst"]


@pytest.mark.parametrize("percent", [0, 50, 100])
def test_lines_are_few_whatever_the_pace(percent):
    lines = []
    log = _Log(lines.append, clock=lambda: 0.0)
    for i in range(10_000):
        log(progress("samples", i, 10_000, share=percent / 100))
    assert len(lines) == 1


def test_steps_that_take_long_are_said():
    """Where there is no terminal, ten seconds after the last; on a quiet one, none."""
    now, said = [0.0], []
    tell = _Steps(said.append, lambda: now[0])
    for step, seconds in (("cutting", 2.0), ("flying", 9.0), ("measuring", 4.0)):
        tell(step)
        now[0] += seconds
    tell("drawing")
    assert said == ["measuring"]
    with steps(Console(quiet=True)) as tell:
        tell("cutting")
