"""What a study has found, as its folder says it; the three answers side by side."""

import pandas as pd
import pytest
from command_line import run
from small_case import small_case, write_case

from drakesep.page.found import read_found
from drakesep.page.study_files import export


def parts_of(folder):
    found = read_found(folder)
    assert not found.wrong
    return {part.file: part for part in found.parts}, found


@pytest.fixture
def asked(tmp_path, capsys, monkeypatch):
    """What runs a command on a small case, and returns its folder."""
    monkeypatch.chdir(tmp_path)
    data = small_case(published=None, objectives=None)
    file = write_case(tmp_path, data)

    def run_it(command, *options):
        code, *_ = run(
            *(capsys, monkeypatch, command, file, *options),
            *("--workers", 1, "-o", tmp_path / command),
        )
        assert code in (0, 1)
        return tmp_path / command

    return run_it


def test_a_study_without_an_answer_shows_its_short_tables(asked):
    folder = asked("sweep", "upper.mass_kg=1190,1210")
    parts, found = parts_of(folder)
    assert {*parts} == {"sweep.csv", "remarks.csv"} and not found.worst
    assert len(parts["sweep.csv"].table) == 2
    (folder / "study.json").write_text("{")
    assert "study.json" in read_found(folder).wrong


@pytest.mark.slow
def test_found_statistical_and_proven_stand_side_by_side(asked):
    """As requirements.csv, campaign.csv and proofs.csv say them, each by itself."""
    folder = asked(
        *("verify", "--prove", "--proof-seconds", "2", "--campaign", "300"),
        *("--share", "0.9", "--search", "sqp", "--no-growth"),
    )
    parts, found = parts_of(folder)
    answers = parts["answers.csv"]
    assert {"worst_case_found", "bound", "proven_bound"} <= {*answers.columns}
    key = ["requirement", "axis", "sense", "limit"]
    table = answers.table.set_index(key)
    for file, column, mine in (
        ("requirements.csv", "worst", "worst_case_found"),
        ("campaign.csv", "bound", "bound"),
        ("proofs.csv", "proven_bound", "proven_bound"),
    ):
        own = pd.read_csv(folder / file).dropna(subset=["limit"]).set_index(key)
        pd.testing.assert_series_equal(
            table[mine].reindex(own.index), own[column], check_names=False
        )
        assert own[column].notna().any()
    assert found.worst
    command = export(folder, folder.with_name("handed"))
    assert " --prove " in command and "--no-prove" not in command
