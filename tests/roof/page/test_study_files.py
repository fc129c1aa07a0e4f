"""What studies of a page read and write, and what reproduces them."""

import shlex

import pytest
from command_line import run
from small_case import small_case, write_case

import drakesep
from drakesep.page.past_results import past_results
from drakesep.page.study_files import as_typed, case_argument, export, next_folder
from drakesep.page.workspace import Workspace
from drakesep.systems.checks import InputError


@pytest.fixture
def workspace(tmp_path):
    opened = Workspace(tmp_path / "results")
    opened.open("vega")
    return opened


def test_what_is_saved_is_named_and_what_is_not_is_kept(workspace, tmp_path):
    assert case_argument(workspace) == "vega"
    workspace.change(workspace.text.replace("mass_kg: 750", "mass_kg: 751"))
    kept = case_argument(workspace)
    assert drakesep.load_case(kept).text == workspace.text
    assert case_argument(workspace) == kept  # not another for the same
    workspace.change(workspace.text.replace("mass_kg: 751", "mass_kg: 752"))
    assert case_argument(workspace) != kept
    assert drakesep.load_case(kept).in_si().separation.bodies[0].mass == 751.0
    workspace.save(tmp_path / "mine.yaml")
    file = tmp_path / "mine.yaml"
    assert case_argument(workspace) == str(file)
    for_it = workspace.text
    file.write_text("name: another")  # beneath the page, which shows what was
    assert drakesep.load_case(case_argument(workspace)).text == for_it
    file.unlink()
    assert drakesep.load_case(case_argument(workspace)).text == for_it
    workspace.change("bodies: 3")
    with pytest.raises(InputError, match="not right"):
        case_argument(workspace)


def test_no_study_writes_over_another(workspace, tmp_path):
    first = next_folder(workspace, "verify")
    assert first == tmp_path / "results" / "vega" / "verify-1"
    assert next_folder(workspace, "verify").name == "verify-2"
    assert next_folder(workspace, "campaign").name == "campaign-1"


@pytest.mark.parametrize("number", [0.9986501, 1234567, 2.0, 0.1, 1e-7, 12345678.5])
def test_a_number_of_a_field_loses_no_digit(number):
    words = as_typed(number)
    assert float(words) == number
    if number == int(number):
        assert int(words) == number  # as options of whole numbers are read


def test_an_export_reproduces_every_byte(tmp_path, capsys, monkeypatch):
    """On the command line, from the exported folder; and the list has both."""
    monkeypatch.chdir(tmp_path)
    file = write_case(tmp_path, small_case(published=None))
    folder = tmp_path / "results" / "small" / "worst-case-1"
    asked = ("worst-case", file, "--objective", "L2", "--search", "drake")
    code, *_ = run(capsys, monkeypatch, *asked, "--workers", 1, "-o", folder)
    assert code == 0
    target = tmp_path / "handed on"
    command = export(folder, target)
    assert export(folder, target) == command  # once more: it is there
    file.unlink()
    cd, _, line = command.partition(" && ")
    monkeypatch.chdir(shlex.split(cd)[1])
    _, *words = shlex.split(line)
    code, *_ = run(capsys, monkeypatch, *words)
    assert code == 0
    first, again = (
        {f.name: f.read_bytes() for f in one.glob("*.csv")}
        for one in (folder, target / "again")
    )
    assert first == again
    assert "iterates.csv" in first
    assert line in (target / "command.sh").read_text()
    with pytest.raises(InputError, match="there already"):
        export(folder, folder)
    (folder.parent / "broken").mkdir()
    (folder.parent / "broken" / "study.json").write_text("{")
    listed = {one.name: one for one in past_results(tmp_path / "results")}
    assert listed["small/worst-case-1"].ended == "completed"
    assert listed["small/worst-case-1"].study == "worst-case"
    assert listed["small/broken"].unreadable


def test_what_names_files_is_saved_where_they_are(tmp_path):
    data = small_case()
    (tmp_path / "cube.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\n")
    data["bodies"]["upper"]["geometry"]["ball"] = {"mesh": {"file": "cube.obj"}}
    file = write_case(tmp_path, data)
    opened = Workspace(tmp_path / "results")
    opened.open(str(file))
    opened.change(opened.text.replace("mass_kg: 700", "mass_kg: 701"))
    if opened.case is not None:
        with pytest.raises(InputError, match="save it"):
            case_argument(opened)
