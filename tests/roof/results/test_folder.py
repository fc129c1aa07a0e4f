"""The folder that a study writes: whose it is, what goes and stays, how it ended."""

import contextlib
import dataclasses
import hashlib
import json
import os
import shlex
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import Future
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import trimesh
from one_pair import one_pair
from separations import generic_pair, vega

import drakesep
from drakesep.files import PREFIX, written
from drakesep.results.asked import Asked
from drakesep.results.campaign_files import RecordedPlan
from drakesep.results.folder import ResultsFolder
from drakesep.studies.worst_case.session import Session
from drakesep.systems.checks import InputError
from drakesep.systems.model.parts import Mesh, Part
from drakesep.systems.simulation.simulation import Simulation


def record(folder):
    return json.loads((folder / "study.json").read_text(encoding="utf-8"))


def names(folder):
    files = (file for file in folder.rglob("*") if file.is_file())
    return {str(file.relative_to(folder)) for file in files}


@pytest.fixture(autouse=True)
def short_patience(monkeypatch):
    """VEGA takes 63 steps."""
    monkeypatch.setattr("drakesep.systems.simulation.simulation._MOST_STEPS", 1000)


def overflowing():
    """A change of VEGA with which the run fails, for it would take for ever."""
    return {"spring_1.force_max_N": 1e12}


def test_a_failed_run_leaves_nothing_of_the_run_before(tmp_path):
    drakesep.simulate("vega", output=tmp_path)
    assert {"motion.csv", "rotation.png", "runs/nominal.csv.gz"} <= names(tmp_path)
    mine = {"notes.txt", "motion_mine.csv", "contacts.csv", "geometry/mine.stl"}
    mine |= {"runs/mine.json", "runs/mine.csv.gz"}
    (tmp_path / "geometry").mkdir()
    for name in mine:
        (tmp_path / name).write_text("mine")
    failed = drakesep.simulate("vega", overflowing(), output=tmp_path)
    assert not failed.completed
    assert names(tmp_path) == {
        *("summary.csv", "study.json", "case.json", "runs/run.json"),
        *mine,
    }
    assert {(tmp_path / name).read_text() for name in mine} == {"mine"}
    listed = {file["name"] for file in record(tmp_path)["files"]}
    assert listed == names(tmp_path) - mine
    assert record(tmp_path)["runs"] == ["run"]
    assert record(tmp_path)["ended"] == "failed"
    assert record(tmp_path)["message"] == failed.run.message != ""


def test_names_that_no_file_may_have():
    with pytest.raises(InputError, match=r"output: must be a folder .*null"):
        drakesep.simulate("vega", output="a\0b")


@pytest.mark.parametrize(
    "study",
    [
        lambda: drakesep.simulate("vega", output=""),
        lambda: drakesep.worst_case("vega", output=""),
        lambda: drakesep.animate("vega", output=""),
        lambda: drakesep.sweep("vega", {"payload.mass_kg": [1870.0]}, output=""),
    ],
)
def test_an_empty_path_is_not_the_working_directory(study, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="output: must be a path, got ''"):
        study()
    assert not [*tmp_path.iterdir()]


def test_threads_write_files_of_their_own(tmp_path):
    """Of one name at once, the last that is whole stays."""
    file = tmp_path / "table.csv"
    with written(file) as one, written(file) as other:
        one.write_text("one")
        other.write_text("other")
    assert file.read_text() == "one" and names(tmp_path) == {"table.csv"}
    with pytest.raises(InputError, match=r"must be a readable case file .*null"):
        drakesep.load_case("a\0b")
    with pytest.raises(InputError, match=r"mesh: file must be a path"):
        Mesh(file=Path("a\0b.stl"))
    with pytest.raises(InputError, match=r"must be the plan of a campaign.*null"):
        RecordedPlan.read(Path("a\0b"))


def test_one_run_that_does_not_separate_is_a_result_with_a_note(tmp_path):
    brief = drakesep.load_case("fairing").replaced(run={"duration_s": 0.5})
    study = drakesep.simulate(brief, output=tmp_path)
    assert study.completed and study.run.not_separated != ""
    assert record(tmp_path)["ended"] == "completed"
    remarks = pd.read_csv(tmp_path / "remarks.csv")["remark"]
    assert remarks.str.contains("not separate").any()


def test_study_that_raises_is_recorded_as_failed(tmp_path):
    drakesep.clearance(one_pair(), output=tmp_path)
    with pytest.raises(RuntimeError, match="the run failed"):
        drakesep.clearance(one_pair(), overflowing(), output=tmp_path)
    assert names(tmp_path) == {"study.json", "case.json"}
    assert record(tmp_path)["ended"] == "failed"
    assert "the run failed" in record(tmp_path)["message"]


def test_interrupted_study_says_so(tmp_path):
    def interrupt(_):
        raise KeyboardInterrupt

    requirements = drakesep.load_case("vega").requirements[:1]
    case = one_pair(
        dispersions={"payload.mass_kg": 20}, published=[], requirements=requirements
    )
    with pytest.raises(KeyboardInterrupt):
        drakesep.verify(
            case,
            searches=["drake"],
            workers=1,
            output=tmp_path,
            on_progress=interrupt,
        )
    assert record(tmp_path)["ended"] == "interrupted"
    assert record(tmp_path)["runs"] == ["nominal"]
    assert "requirements.csv" not in names(tmp_path)


def test_what_is_refused_leaves_the_folder_alone(tmp_path):
    drakesep.simulate("vega", output=tmp_path)
    before = {name: (tmp_path / name).read_bytes() for name in names(tmp_path)}
    for wrong in ({"payload.mas_kg": 1.0}, {"payload.mass_kg": -1.0}):
        with pytest.raises(ValueError, match="mas"):
            drakesep.simulate("vega", wrong, output=tmp_path)
    with pytest.raises(InputError, match="with those of 'simulate'; give 'clearance'"):
        drakesep.clearance("vega", output=tmp_path)
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == before


def test_two_studies_at_once_are_refused(tmp_path):
    """Of one process as of two; the lock is gone when the first has left."""
    with (
        ResultsFolder(tmp_path, "simulate"),
        pytest.raises(InputError, match=f"process {os.getpid()} is"),
    ):
        drakesep.simulate("vega", output=tmp_path)
    with ResultsFolder(tmp_path, "simulate"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_lock_dies_with_its_process(tmp_path):
    """Killed in the midst of a study: the next one is let in, and clears up."""
    script = textwrap.dedent(f"""
        import sys, time, drakesep
        from drakesep.files import written
        from drakesep.results.asked import Asked
        from drakesep.results.folder import ResultsFolder

        with ResultsFolder({str(tmp_path)!r}, "simulate") as folder:
            folder.begin(Asked.of("simulate", "vega"))
            (folder.path / "contacts.csv").write_text("of the killed")
            folder.keep()
            with written(folder.path / "summary.csv") as half:
                half.write_text("half")
                print("writing", flush=True)
                time.sleep(60)
    """)
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "writing\n"
    with pytest.raises(InputError, match=f"process {process.pid} is"):
        drakesep.simulate("vega", output=tmp_path)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert record(tmp_path)["ended"] == "under way"
    assert not (tmp_path / "summary.csv").exists()
    assert any(name.startswith(PREFIX) for name in names(tmp_path))
    drakesep.simulate("vega", output=tmp_path)
    assert record(tmp_path)["ended"] == "completed"
    assert not any(name.startswith(PREFIX) for name in names(tmp_path))
    assert "contacts.csv" not in names(tmp_path)


def test_what_is_drawn_beside_a_study_is_listed_when_it_is_there(tmp_path):
    """Not at the study's next step: of one that is killed until then, it would stay."""
    drawn = Future()
    background = SimpleNamespace(submit=lambda save, folder: drawn)
    with ResultsFolder(tmp_path, "worst-case") as folder:
        folder.begin(Asked.of("worst-case", "vega"))
        session = Session(
            plan=SimpleNamespace(folder=folder),
            background=background,
            **dict.fromkeys(
                ("nominal", "drake", "published", "pool", "evaluator", "batch")
            ),
        )
        session.draw(lambda path: None)
        folder.keep(["nominal"])
        (tmp_path / "runs").mkdir()
        made = {"tornado.png", "runs/nominal.json"}
        for name in made:
            (tmp_path / name).write_text("drawn")
        thread = threading.Thread(target=drawn.set_result, args=(None,))
        thread.start()
        thread.join()
        listed = {file["name"] for file in record(tmp_path)["files"]}
        assert listed == made | {"study.json", "case.json"}
        assert record(tmp_path)["runs"] == ["nominal"]
        folder.end()
    folder.keep()  # of a drawing that comes late
    assert record(tmp_path)["ended"] == "completed"


def test_a_file_that_fails_leaves_the_one_before(tmp_path):
    file = tmp_path / "table.csv"
    file.write_text("before")
    with pytest.raises(RuntimeError), written(file) as beside:
        beside.write_text("hal")
        raise RuntimeError
    assert file.read_text() == "before"
    assert names(tmp_path) == {"table.csv"}


def test_record_says_what_was_asked(tmp_path):
    """The case as text, hashes, versions, and the files that there are."""
    mesh = tmp_path / "box.obj"
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {f}" for f in faces]
    mesh.write_text("\n".join(lines))
    text = builtin_text().replace(
        "box: {size_mm: [1840, 1400, 1100]}", "mesh: {file: box.obj, scale: 0.5}"
    )
    text += "\nclearance: {pairs: [[bus, adapter_ring]]}\n"
    case = tmp_path / "mine.yaml"
    case.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    begun = time.time()
    drakesep.clearance(case, {"payload.mass_kg": 1870.0}, output=out)
    said = record(out)
    assert said["study"] == "clearance"
    assert said["arguments"] == {"values": {"payload.mass_kg": 1870.0}}
    assert said["case"]["text"] == text
    assert said["case"]["sha256"] == hashlib.sha256(text.encode()).hexdigest()
    assert said["case"]["source"] == str(case)
    digest = hashlib.sha256(mesh.read_bytes()).hexdigest()
    assert said["named_files"] == {str(mesh.resolve()): digest}
    assert (out / "geometry" / "bus.obj").read_bytes() == mesh.read_bytes()
    assert said["versions"]["drakesep"] == drakesep.__version__
    assert {"drake", "jax", "numpy", "scipy"} <= set(said["versions"])
    assert 0.0 < said["seconds"] < time.time() - begun + 1.0
    listed = {file["name"] for file in said["files"]}
    assert listed == names(out)  # study.json itself among them
    # The mesh of the folder is measured, wherever the first has gone: of the nominal,
    # whose mass does not change the geometry while mated.
    first = drakesep.clearance(case).summary["clearance_mm"].tolist()
    mesh.unlink()
    again = drakesep.clearance(drakesep.read_results(out).case, output=out)
    assert again.summary["clearance_mm"].tolist() == first
    assert (out / "geometry" / "bus.obj").exists()
    assert record(out)["ended"] == "completed"


def builtin_text():
    from drakesep.case_file.reader import builtin_cases

    return builtin_cases()["vega"].read_text(encoding="utf-8")


def test_case_made_in_python_is_written_too(tmp_path):
    """Changed, its text is that of a case file which gives the same case."""
    case = drakesep.load_case("vega").replaced(
        dispersions={"payload.mass_kg": 7.0}, published=[]
    )
    drakesep.simulate(case, output=tmp_path / "a")
    text = record(tmp_path / "a")["case"]["text"]
    (tmp_path / "again.yaml").write_text(text, encoding="utf-8")
    assert drakesep.load_case(tmp_path / "again.yaml").in_si() == case.in_si()
    drakesep.simulate(case.in_si(), output=tmp_path / "b")
    assert record(tmp_path / "b")["case"]["text"] is None
    assert drakesep.read_results(tmp_path / "b").case == case.in_si()


@pytest.mark.parametrize(
    "ask",
    [
        lambda out: drakesep.simulate("vega", {"payload.mass_kg": 1.87e3}, output=out),
        lambda out: drakesep.simulate(
            drakesep.AnalysisCase(separation=vega()), output=out
        ),
    ],
    ids=["by name", "in SI"],
)
def test_the_command_that_does_it_again_does(ask, tmp_path):
    """The same tables, to the byte."""
    ask(tmp_path / "out")
    tables = ("summary.csv", "motion.csv", "runs/nominal.csv.gz", "runs/run.csv.gz")
    files = [tmp_path / "out" / t for t in tables if (tmp_path / "out" / t).exists()]
    before = {file: file.read_bytes() for file in files}
    assert len(before) == 3
    again = record(tmp_path / "out")["again"]
    again = again.replace("python ", f"{sys.executable} ", 1)
    subprocess.run(again, shell=True, check=True, capture_output=True)
    assert {file: file.read_bytes() for file in before} == before
    assert record(tmp_path / "out")["ended"] == "completed"


def test_command_line_is_what_does_it_again(tmp_path, capsys, monkeypatch):
    from command_line import run

    out = tmp_path / "a folder"
    arguments = ("simulate", "vega", "--set", "payload.mass_kg=1880", "-o", out)
    code, _, _ = run(capsys, monkeypatch, *arguments)
    assert code == 0
    assert record(out)["again"] == (
        f"cd {Path.cwd()} && "
        f"drakesep simulate vega --set payload.mass_kg=1880 -o '{out}'"
    )


@pytest.mark.parametrize("error", [MemoryError(), RuntimeError("why"), None])
def test_what_does_not_end_has_failed(error, tmp_path):
    """Whether its error has words or not, or there is none."""
    with contextlib.suppress(MemoryError, RuntimeError):
        with ResultsFolder(tmp_path, "simulate") as folder:
            folder.begin(Asked.of("simulate", "vega"))
            if error is not None:
                raise error
    assert record(tmp_path)["ended"] == "failed"
    assert record(tmp_path)["message"] == (
        str(error) or type(error).__name__ if error else "left before its end"
    )


def test_numbers_of_numpy_are_numbers():
    values = {"payload.mass_kg": np.float32(1870), "payload.cg_x_mm": np.float64(1.5)}
    asked = Asked.of(
        "simulate", "vega", {"values": values, "none": None}, seed=np.int64(3)
    )
    assert asked.plain_arguments == {
        "values": {"payload.mass_kg": 1870.0, "payload.cg_x_mm": 1.5}
    }
    assert type(asked.seed) is int
    _, _, script = shlex.split(asked.again(Path("/d"), None))
    assert "values={'payload.mass_kg': 1870.0, 'payload.cg_x_mm': 1.5}" in script


def test_what_no_text_holds_has_no_command():
    asked = Asked.of("worst-case", "vega", {"objectives": [max]})
    assert asked.again(Path("/d"), None) is None
    assert asked.plain_arguments == {"objectives": ["max"]}


def test_refused_study_makes_no_folder(tmp_path):
    # As the command line opens it, before the check.
    from drakesep.cli.results_folder import results_folder

    with (
        pytest.raises(ValueError, match="mas_kg"),
        results_folder(tmp_path / "new", "vega", "simulate") as folder,
    ):
        drakesep.simulate("vega", {"payload.mas_kg": 1.0}, output=folder)
    assert not (tmp_path / "new").exists()


def test_study_may_change_the_working_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with ResultsFolder("out", "simulate") as folder:
        folder.begin(Asked.of("simulate", "vega"))
        monkeypatch.chdir("/")
        folder.end()
    assert record(tmp_path / "out")["ended"] == "completed"
    assert names(tmp_path / "out") == {"study.json", "case.json"}


def with_a_box(mesh):
    trimesh.creation.box((1.0, 1.0, 1.0)).export(mesh)
    part = Part(name="box", shape=Mesh(file=mesh))
    pair = generic_pair(duration=0.5)
    lower, upper = pair.bodies
    lower = dataclasses.replace(lower, parts=(part,))
    separation = dataclasses.replace(pair, bodies=(lower, upper))
    return drakesep.AnalysisCase(separation=separation)


def test_folder_has_the_mesh_that_was_measured(tmp_path):
    """Whatever the file holds when the study is saved."""
    mesh = tmp_path / "box.stl"
    study = drakesep.simulate(with_a_box(mesh))
    measured = mesh.read_bytes()
    trimesh.creation.box((1.0, 1.0, 2.0)).export(mesh)
    study.save(tmp_path / "out")
    assert (tmp_path / "out/geometry/box.stl").read_bytes() == measured


def test_mesh_that_changes_while_it_is_measured_fails_the_study(tmp_path, monkeypatch):
    """The run is flown, but nobody can say beside which mesh."""
    mesh = tmp_path / "box.stl"
    case = with_a_box(mesh)
    fly = Simulation.run

    def changing(*args):
        trimesh.creation.box((1.0, 1.0, 2.0)).export(mesh)
        return fly(*args)

    monkeypatch.setattr(Simulation, "run", changing)
    with pytest.raises(ValueError, match=r"box\.stl: must stay as it is while"):
        drakesep.simulate(case, output=tmp_path / "out")
    assert record(tmp_path / "out")["ended"] == "failed"
    assert "box.stl: must stay" in record(tmp_path / "out")["message"]
    assert "motion.csv" not in names(tmp_path / "out")
