"""From a folder alone: runs, plots, tables and animations are what they were."""

import dataclasses
import gzip
import json
import shutil

import numpy as np
import pytest
from one_pair import one_pair

import drakesep
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.plots.motion import save_motion
from drakesep.plots.pictures import Tornado
from drakesep.plots.swept_volume import save_swept
from drakesep.results.case_json import from_json, to_json
from drakesep.studies.animate import animate_results
from drakesep.systems.checks import InputError
from drakesep.tables.columns import write_csv
from drakesep.tables.run_tables import runs_table


@pytest.fixture(autouse=True)
def figures_stay_blank():
    """They are looked at here."""


@pytest.fixture(scope="module")
def verified(tmp_path_factory):
    """VEGA's verification over two parameters, and its folder.

    Without the requirement on clearance, which takes most of the time.
    """
    case = one_pair(
        dispersions={"payload.mass_kg": 20, "payload.cg_y_mm": 13},
        requirements=drakesep.load_case("vega").requirements[:1],
        published=[],
    )
    folder = tmp_path_factory.mktemp("verified")
    study = drakesep.verify(case, searches=["drake"], workers=1, output=folder)
    return study, folder


def same(one, other):
    """Whether two runs are the same, bit for bit."""
    assert dataclasses.fields(one) == dataclasses.fields(other)
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if field.name in ("motion", "trajectory"):
            for part in dataclasses.fields(a):
                np.testing.assert_array_equal(
                    getattr(a, part.name), getattr(b, part.name), err_msg=part.name
                )
        else:
            assert a == b, field.name


def test_runs_are_read_as_they_were(verified):
    study, folder = verified
    results = drakesep.read_results(folder)
    assert set(results.labels) == {one.label for one in study.runs}
    for one in study.runs:
        read = results.run(one.label)
        same(read.run, one.run)
        for name in ("role", "metrics", "outcome", "nearest", "objective_in_drake"):
            assert getattr(read, name) == getattr(one, name), name


def test_case_is_read_as_it_was(verified):
    study, folder = verified
    read = drakesep.read_results(folder).case
    assert read == study.case
    assert read.separation.body("payload").parts  # with its geometry


@pytest.mark.parametrize("name", ["vega", "dual_launch", "fairing"])
def test_records_go_through_json(name):
    case = drakesep.load_case(name).in_si()
    text = json.dumps(to_json(case), allow_nan=False)
    assert from_json(json.loads(text)) == case


def test_plots_are_made_again(verified, tmp_path):
    """The paper's figures and the tornado: equal to the byte."""
    study, folder = verified
    results = drakesep.read_results(folder)
    save_motion(results.runs, results.case, tmp_path)
    names = study.nearest_sensitivities["objective"].unique()
    table = results.table("sensitivities.csv").fillna({"at_worst": ""})
    Tornado(table[table["objective"].isin(names)]).save(tmp_path)
    for plot in ("translation.png", "rotation.png", "tornado.png"):
        assert (tmp_path / plot).read_bytes() == (folder / plot).read_bytes(), plot


def test_a_table_is_made_again(verified, tmp_path):
    study, folder = verified
    results = drakesep.read_results(folder)
    runs = [results.run(one.label) for one in study.runs]
    write_csv(runs_table(runs, results.case.box.names), tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == (
        folder / "worst_cases.csv"
    ).read_bytes()


def test_clearance_is_measured_again(tmp_path):
    """Distances of the run that the folder keeps; the picture of what it sweeps."""
    drakesep.clearance(one_pair(), output=tmp_path)
    results = drakesep.read_results(tmp_path)
    run, of = results.run("nominal").run, results.case.clearance
    analysis = ClearanceAnalysis(run.separation, of.pairs, touching=of.touching)
    smallest = min(one.minimum for one in analysis.of(run))
    summary = results.table("clearance_summary.csv")
    # In mm, through a decimal of full length.
    assert 1e3 * smallest == pytest.approx(summary["clearance_mm"].min(), rel=1e-12)
    before = (tmp_path / "swept.png").read_bytes()
    save_swept(run, analysis.names, tmp_path)
    assert (tmp_path / "swept.png").read_bytes() == before


def test_animation_is_that_of_the_runs_flown(verified, tmp_path):
    """The page of the folder is that of `animate`, which flies; to the byte."""
    study, folder = verified
    results = drakesep.read_results(folder)
    shown = animate_results(results, output=tmp_path / "read.html")
    assert shown[0] == "nominal" and "worst_PM" in shown
    names = study.case.box.names
    [worst] = [one for one in study.worst if one.name == "PM"]
    assert set(worst.values) == set(names)
    animate_results(results, ["nominal", "worst_PM"], output=tmp_path / "two.html")
    values = {
        "payload.mass_kg": worst.values["payload.mass"],
        "payload.cg_y_mm": 1e3 * worst.values["payload.cg_y"],
    }
    drakesep.animate(study.case, {"worst_PM": values}, output=tmp_path / "flown.html")
    assert len((tmp_path / "two.html").read_bytes()) > 100_000
    assert (tmp_path / "two.html").read_bytes() == (
        tmp_path / "flown.html"
    ).read_bytes()


def test_an_animation_reads_the_runs_that_it_shows(verified, tmp_path):
    """Not the motion of others, which takes longer than to draw it."""
    _, folder = verified
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    shown = animate_results(drakesep.read_results(folder), output=tmp_path / "a.html")
    left = {*drakesep.read_results(folder).labels} - {*shown}
    assert left
    for label in left:
        (copy / "runs" / f"{label}.csv.gz").write_text("not a table")
    read = drakesep.read_results(copy)
    assert animate_results(read, output=tmp_path / "b.html") == shown
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()
    animate_results(read, ["nominal"], output=tmp_path / "c.html")
    with pytest.raises(InputError, match="must be that of a run"):
        animate_results(read, [left.pop()], output=tmp_path / "d.html")


def test_command_animates_a_folder(verified, tmp_path, capsys, monkeypatch):
    from command_line import run

    _, folder = verified
    page = tmp_path / "page.html"
    code, out, _ = run(capsys, monkeypatch, "animate", folder, "-o", page)
    assert code == 0
    assert "nominal, " in out
    assert page.stat().st_size > 100_000
    code, _, err = run(capsys, monkeypatch, "animate", folder, "--run", "worst_XY")
    assert code == 2
    assert "unknown run 'worst_XY'" in err
    code, _, err = run(capsys, monkeypatch, "animate", tmp_path)
    assert code == 2
    assert "must be a folder of results, got no study.json" in err


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("study.json", "{"),
        ("study.json", '{"study": "verify"}'),
        ("case.json", '{"record": "Bodyy"}'),
        ("case.json", '{"record": "Body", "mass": 1.0}'),
        ("case.json", "[]"),
        ("runs/nominal.json", "{}"),
        ("runs/nominal.csv.gz", "time_s\n0\n"),
        ("runs/nominal.csv.gz", gzip.compress(b"time_s\n0\n", mtime=0)),
        ("runs/nominal.csv.gz", gzip.compress(b"time_s\n0\n" * 9, mtime=0)[:-12]),
    ],
)
def test_broken_folders_are_refused_by_name(verified, file, text, tmp_path):
    import shutil

    _, folder = verified
    broken = tmp_path / "broken"
    shutil.copytree(folder, broken)
    raw = text if isinstance(text, bytes) else text.encode()
    (broken / file).write_bytes(raw)
    with pytest.raises(InputError, match=file.rpartition("/")[2]):
        drakesep.read_results(broken).run("nominal")


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """The folder of a run."""
    folder = tmp_path_factory.mktemp("simulated")
    drakesep.simulate(one_pair(run={"duration_s": 0.2}), output=folder)
    return folder


def places(value, place=()):
    """Where values stand in what JSON holds, the first of each list."""
    yield place
    match value:
        case dict():
            for key, entry in value.items():
                yield from places(entry, (*place, key))
        case list():
            for i, entry in enumerate(value[:1]):
                yield from places(entry, (*place, i))


def replaced(value, place, other):
    if not place:
        return other
    key, *rest = place
    copied = value.copy()
    copied[key] = replaced(value[key], rest, other)
    return copied


@pytest.mark.parametrize("name", ["study.json", "case.json", "runs/nominal.json"])
def test_whatever_stands_in_a_folder_is_read_or_refused(name, simulated, tmp_path):
    """Each value of its files in turn, changed by hand into something else."""
    folder = shutil.copytree(simulated, tmp_path / "changed")
    file = folder / name
    written = json.loads(file.read_text(encoding="utf-8"))
    refused = 0
    for place in places(written):
        for other in (5, "other", [1]):
            changed = json.dumps(replaced(written, place, other))
            file.write_text(changed, encoding="utf-8")
            try:
                results = drakesep.read_results(folder)
                assert results.case and results.roles
                if name != "case.json":  # read anew for each run
                    assert results.runs and len(results.table("summary.csv")) == 1
            except InputError:
                refused += 1
    assert refused > 10


@pytest.mark.parametrize(
    ("key", "value", "why"),
    [
        ("files", [{"what": "a file"}], r"files \(entry 1\)\.name: must be text"),
        ("files", [3], r"files \(entry 1\): must be a mapping"),
        ("runs", "nominal", "runs: "),
        ("other", 1, "other: unknown key"),
    ],
)
def test_a_record_changed_by_hand_is_refused_by_its_key(
    key, value, why, simulated, tmp_path
):
    """By the reader and by the next study, which leaves the folder as it is."""
    folder = shutil.copytree(simulated, tmp_path / "changed")
    file = folder / "study.json"
    said = {**json.loads(file.read_text(encoding="utf-8")), key: value}
    file.write_text(json.dumps(said), encoding="utf-8")
    before = {f: f.read_bytes() for f in folder.rglob("*.*")}
    with pytest.raises(InputError, match=rf"study\.json: {why}"):
        drakesep.read_results(folder)
    with pytest.raises(InputError, match=rf"study\.json: {why}"):
        drakesep.simulate(one_pair(), output=folder)
    assert {f: f.read_bytes() for f in folder.rglob("*.*")} == before


def test_tables_of_a_folder_are_asked_for_by_name(verified):
    study, folder = verified
    results = drakesep.read_results(folder)
    read = results.table("requirements.csv")
    assert read["verdict"].tolist() == study.requirements["verdict"].tolist()
    assert read["worst"].tolist() == study.requirements["worst"].tolist()
    with pytest.raises(InputError, match=r"unknown table 'requirement\.csv'"):
        results.table("requirement.csv")
