"""What a page works on: texts, what they say, undo, and files that nobody spoils."""

from types import SimpleNamespace

import pytest
from small_case import small_case, write_case

from drakesep.page.workspace import ChangedMeanwhile, Workspace
from drakesep.page.workspaces import Workspaces
from drakesep.systems.checks import InputError


@pytest.fixture
def file(tmp_path):
    return write_case(tmp_path, small_case())


def opened(file):
    workspace = Workspace()
    workspace.open(str(file))
    return workspace


def test_a_text_is_a_case_or_says_what_is_wrong(file):
    workspace = opened(file)
    assert workspace.case.name == workspace.name == "small"
    assert workspace.is_saved and workspace.path == file
    assert workspace.case.source == str(file)
    told = []
    end = workspace.changes.add(lambda: told.append(workspace.problems))
    workspace.change(workspace.text.replace("mass_kg: 700.0", "mass_kg: -7"))
    assert workspace.case is None and not workspace.is_saved
    assert workspace.problems == ("bodies.lower.mass_kg: must be > 0, got -7",)
    assert workspace.name == "small"
    workspace.change("a: [")
    assert workspace.problems[0].startswith("must be YAML")
    end()
    workspace.undo()
    assert [len(each) for each in told] == [1, 1]


def test_undo_and_redo(file):
    workspace = opened(file)
    texts = [workspace.text, workspace.text + "# a\n", workspace.text + "# b\n"]
    for text in texts[1:]:
        workspace.change(text)
    workspace.change(texts[2])  # no change
    seen = []
    while workspace.can_undo:
        workspace.undo()
        seen.append(workspace.text)
    assert seen == [texts[1], texts[0]] and workspace.is_saved
    workspace.redo()
    assert workspace.text == texts[1] and workspace.can_redo
    workspace.change(texts[2])
    assert not workspace.can_redo
    workspace.undo()
    assert workspace.text == texts[1]


def test_what_is_changed_here_comes_from_no_file(file):
    workspace = opened(file)
    workspace.change(workspace.text.replace("1200.0", "1201.0"))
    assert workspace.case.source is None
    workspace.save()
    assert workspace.case.source == str(file) and workspace.is_saved
    assert file.read_text() == workspace.text


def test_two_pages_on_one_file_do_not_spoil_it(file):
    one, other = opened(file), opened(file)
    one.change(one.text + "# one\n")
    other.change(other.text + "# other\n")
    one.save()
    with pytest.raises(ChangedMeanwhile, match="by somebody else"):
        other.save()
    assert file.read_text() == one.text
    other.save(replaces=True)
    assert file.read_text() == other.text
    with pytest.raises(ChangedMeanwhile):
        one.save()
    one.save(file.with_name("another.yaml"))
    one.change(one.text + "# more\n")
    one.save()  # it is its own now
    assert file.read_text() == other.text


def test_a_file_that_is_there_is_not_overwritten(file, tmp_path):
    workspace = Workspace()
    workspace.open("vega")
    assert workspace.path is None
    with pytest.raises(InputError, match="needs a file"):
        workspace.save()
    with pytest.raises(ChangedMeanwhile, match="is there already"):
        workspace.save(file)
    with pytest.raises(InputError, match="No such file"):
        workspace.save(tmp_path / "nowhere" / "a.yaml")
    workspace.save(tmp_path / "mine.yaml")
    assert workspace.path == tmp_path / "mine.yaml" and workspace.case is not None
    assert {p.name for p in tmp_path.iterdir()} == {file.name, "mine.yaml"}


def test_a_file_that_has_gone_is_written_again(file):
    workspace = opened(file)
    file.unlink()
    workspace.save()
    assert file.read_text() == workspace.text


def test_a_new_case_can_be_flown():
    workspace = Workspace()
    workspace.begin("mine")
    assert workspace.case is not None and workspace.name == "mine"


def test_what_cannot_be_read_leaves_what_is_open(file, tmp_path):
    workspace = opened(file)
    with pytest.raises(InputError, match="readable case file"):
        workspace.open(str(tmp_path / "nowhere.yaml"))
    assert workspace.path == file and workspace.case is not None


HOUR = 3600.0


@pytest.fixture
def hours(tmp_path):
    """Workspaces of a server, and a clock that is put on by hand."""
    clock = SimpleNamespace(now=0.0)
    clock.all = Workspaces(None, tmp_path, lambda: clock.now)
    return clock


def left_open(hours, file):
    """The address of a page that has shown a file, and is gone."""
    key = hours.all.begin()
    place = hours.all.get(key)
    assert place.open() == ""
    place.enter()
    place.workspace.open(str(file))
    hours.all.leave(key)
    return key


def dropped(hours, key):
    """Whether another page that begins has it dropped."""
    before = hours.all.get(key).workspace
    hours.all.begin()
    return hours.all.get(key).workspace is not before


def test_what_nobody_looks_at_is_dropped_and_opened_again(hours, file):
    key = left_open(hours, file)
    hours.now = 0.9 * HOUR
    assert not dropped(hours, key)
    hours.now = 1.1 * HOUR
    assert dropped(hours, key)
    file.write_text(file.read_text() + "# meanwhile\n")
    assert hours.all.get(key).open() == ""
    assert hours.all.get(key).workspace.text == file.read_text()
    file.unlink()
    hours.now = 3.0 * HOUR
    assert not dropped(hours, key)  # its text is nowhere else now


KEPT = {
    "a page shows it": lambda place, file: place.enter(),
    "it is not saved": lambda place, file: place.workspace.change("a: 1"),
    "its file is another": lambda place, file: file.write_text("a: 1"),
    "a study runs": lambda place, file: place.workspace.studies.update(
        Search=SimpleNamespace(is_running=True)
    ),
}


@pytest.mark.parametrize("happens", KEPT.values(), ids=KEPT)
def test_what_would_be_lost_is_kept(hours, file, happens):
    key = left_open(hours, file)
    happens(hours.all.get(key), file)
    hours.now = 5.0 * HOUR
    assert not dropped(hours, key)


def test_what_cannot_be_opened_again_is_told(hours, file):
    key = left_open(hours, file)
    hours.now = 2.0 * HOUR
    assert dropped(hours, key)
    file.unlink()
    assert "readable case file" in hours.all.get(key).open()
    assert hours.all.get(key).workspace.case is not None  # a new one
