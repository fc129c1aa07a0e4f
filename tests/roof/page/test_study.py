"""How a study of the page stands by what its process tells."""

import pytest

from drakesep.page import study
from drakesep.page.study import SPARE, State, Study


class Process:
    """Tells what it is given, in place of one that runs a command."""

    def __init__(self):
        self.told, self.asked = [], []

    def run(self, arguments, **where):
        self.asked.append(arguments)

    def events(self):
        told, self.told = self.told, []
        return told


@pytest.fixture
def process(monkeypatch):
    process = Process()
    monkeypatch.setattr(study, "SPARE", Spare(process))
    return process


class Spare:
    def __init__(self, process):
        self.take = self.ready = lambda: process


@pytest.fixture
def begun(process, tmp_path):
    (tmp_path / "verify-1").mkdir()
    return Study.begin(("verify", "vega"), tmp_path, tmp_path / "verify-1", None)


def iterate(objective, value, *, falls):
    row = {"objective": objective, "search": "sqp", "start": 0, "value": value}
    return {"event": "iterate", "row": row, "falls": falls}


def test_the_worst_iterate_is_the_least_of_what_falls(process, begun):
    for name, falls in (("highest", False), ("lowest", True)):
        for i, value in enumerate((3.0, 5.0, 1.0)):
            told = iterate(name, value, falls=falls)
            told["row"]["iteration"] = i
            process.told.append(told)
    begun.hear()
    assert begun.worst_of("highest")["value"] == 5.0
    assert begun.worst_of("lowest")["value"] == 1.0
    assert len(begun.rows_of("lowest")) == 3


def test_draws_are_of_those_that_are_flown_since_it_goes_on(process, begun):
    process.told = [{"event": "draws", "draws": 256}, {"event": "stopped"}]
    begun.hear()
    assert begun.can_go_on and len(begun.draws) == 1
    begun.go_on()
    assert begun.is_running and not begun.draws
    assert "--resume" in process.asked[-1]


@pytest.mark.parametrize(("code", "is_there"), [(0, True), (1, True), (2, False)])
def test_what_is_refused_leaves_no_folder(process, begun, code, is_there):
    summary = {"error": "wrong"} if code == 2 else {}
    process.told = [{"event": "ended", "exit_code": code, "summary": summary}]
    begun.hear()
    assert begun.folder.exists() is is_there
    assert (begun.state is State.ENDED) is is_there


def test_a_spare_process_is_taken_once(monkeypatch):
    made = []

    class Alive(Process):
        is_alive = True

        def __init__(self):
            super().__init__()
            made.append(self)

    monkeypatch.setattr(study, "StudyProcess", Alive)
    monkeypatch.setattr(SPARE, "_process", None)
    assert SPARE.ready() is SPARE.ready() is SPARE.take()
    assert SPARE.take() is made[1]
    made[-1].is_alive = False
    assert SPARE.ready() is made[-1] and len(made) == 3
