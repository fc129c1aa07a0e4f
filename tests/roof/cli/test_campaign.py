"""The commands of campaigns: planned, flown chunk by chunk, and merged."""

import json
import subprocess

import pytest
from batches import compiled_once
from command_line import run
from small_case import small_case, write_case

import drakesep
from drakesep.results.campaign_files import chunk_file
from drakesep.studies.campaign.slurm import array_script
from drakesep.systems.checks import InputError


@pytest.fixture(scope="module", autouse=True)
def quick():
    with pytest.MonkeyPatch.context() as patch:
        compiled_once(patch, "drakesep.analysis.campaigns.flights")
        patch.setattr("drakesep.plots.campaign.save_campaign", lambda *_: None)
        yield


@pytest.fixture
def drakesep_(capsys, monkeypatch):
    def call(*words):
        code, out, err = run(capsys, monkeypatch, "campaign", *words)
        return code, out, err

    call.patches = capsys, monkeypatch
    return call


@pytest.fixture
def case(tmp_path):
    data = small_case(published=None, objectives=None, failure_cases=None)
    data["requirements"] = data["requirements"][:1]
    return write_case(tmp_path, data)


SHOWN = ("--runs", 250, "--share", 0.99, "--confidence", 0.9)


def test_in_parts_it_is_as_at_once(case, tmp_path, drakesep_):
    parts, once = tmp_path / "parts", tmp_path / "once"
    assert drakesep_(case, *SHOWN, "-o", once, "--workers", 1)[0] == 0
    code, out, _ = drakesep_("plan", case, *SHOWN, "-o", parts, "--json")
    told = json.loads(out)
    assert (code, told["runs"], told["chunks"]) == (0, 250, 1)
    code, _, err = drakesep_("merge", parts)
    assert code == 4
    assert err.startswith(f"drakesep: {parts}: of 1 chunks 1 are not there, or damaged")
    assert drakesep_("run-chunk", parts, 0)[0] == 0
    code, out, _ = drakesep_("run-chunk", parts, 0, "--json")
    assert (code, json.loads(out)["chunks"]) == (0, [])  # it is there
    code, _, err = drakesep_("run-chunk", parts, 1)
    assert (code, err) == (2, "drakesep: chunk: must be from 0 to 0, got 1\n")
    chunk_file(parts, 0).write_bytes(b"PK")
    assert drakesep_("merge", parts, "--workers", 1)[0] == 4
    assert drakesep_("run-chunk", parts, 0)[0] == 0
    code, out, _ = drakesep_("merge", parts, "--workers", 1)
    assert code == 0
    assert "The share is shown of every requirement" in out.replace("\n", " ")
    for name in ("campaign.csv", "campaign_runs.npz", "plan.json"):
        assert (parts / name).read_bytes() == (once / name).read_bytes()
    assert drakesep_("merge", parts)[0] == 2


def test_chunks_of_as_many_draws_as_one_asks_for(case, tmp_path, drakesep_):
    parts = tmp_path / "parts"
    asked = ("plan", case, *SHOWN, "-o", parts, "--chunk", 100, "--json")
    code, out, _ = drakesep_(*asked)
    assert (code, json.loads(out)["chunks"]) == (0, 3)  # 100, 100 and 50
    assert json.loads((parts / "plan.json").read_text())["chunk"] == 100


def test_arguments_of_a_script_for_slurm(tmp_path):
    with pytest.raises(InputError, match="tasks: must be 1 or more, got 0"):
        array_script(tmp_path, 0)
    with pytest.raises(InputError, match="directory must be text or a Path"):
        array_script(None, 3)


def test_script_for_slurm(case, tmp_path, drakesep_):
    """Its tasks together fly each chunk once."""
    folder = tmp_path / "it's"
    how = {"share": 0.99, "confidence": 0.9}
    drakesep.plan_campaign(case, 250, output=folder, chunk=25, **how)
    code, out, _ = drakesep_("slurm", folder, "--tasks", 3)
    assert code == 0
    assert out.startswith(
        "#!/bin/bash\n#SBATCH --job-name=small\n#SBATCH --array=0-2\n"
    )
    script, flown = out.replace("drakesep campaign run-chunk", "echo"), []
    for task in range(3):
        said = subprocess.run(
            ["bash", "-c", script],
            env={"SLURM_ARRAY_TASK_ID": str(task)},
            capture_output=True,
            text=True,
            check=True,
        )
        [line] = said.stdout.splitlines()
        assert line.startswith(f"{folder} ")
        flown += line.removeprefix(f"{folder} ").removesuffix(" --quiet").split()
    assert sorted(map(int, flown)) == list(range(10))
    assert drakesep_("slurm", tmp_path)[0] == 2


def test_every_run_must_exits_with_1_and_says_how_to_ask(case, tmp_path, drakesep_):
    code, out, _ = drakesep_(case, "--runs", 250, "-o", tmp_path / "out")
    assert code == 1
    said = " ".join(out.split())
    assert "Of every run are 1 of 1 requirements, which no campaign shows" in said
    assert "--share 0.99865 --confidence 0.9 asks for three sigma" in said


def test_a_case_that_bears_the_name_of_a_command(tmp_path, drakesep_):
    """Is flown by `campaign run`."""
    code, _, err = drakesep_("run", "plan", "-o", tmp_path / "out")
    assert code == 2
    assert "plan" in err


def test_dask_without_dask_or_scheduler(case, tmp_path, drakesep_):
    words = (case, *SHOWN, "-o", tmp_path / "out", "--dask", "nowhere")
    code, _, err = drakesep_(*words)
    assert code == 2
    assert err.splitlines()[-1].startswith("drakesep: dask: ")


def test_a_draw_is_flown_again_by_its_number(case, tmp_path, drakesep_, monkeypatch):
    """In Drake, as the batch engine has flown it; with its motion and a page."""
    folder, again = tmp_path / "out", tmp_path / "again"
    monkeypatch.setattr("drakesep.plots.motion.save_motion", lambda *_: None)
    assert drakesep_(case, *SHOWN, "-o", folder, "--workers", 1)[0] == 0
    rows = drakesep.read_results(folder).table("campaign_runs.csv.gz")
    result = drakesep.replay(folder, 123)
    assert result.values == pytest.approx(
        {name: rows.loc[123, name] for name in result.values}, rel=1e-14
    )
    speed = result.labelled.metrics["longitudinal_speed_after_separation"]
    told = rows.loc[123, "longitudinal_speed_after_separation_m_s"]
    assert speed == pytest.approx(told, rel=1e-5)
    words = ("replay", folder, "--run", 123, "-o", again, "--json")
    code, out, _ = run(*drakesep_.patches, *words)
    assert (code, json.loads(out)["command"]) == (0, "replay")
    assert (again / "motion.csv").exists()
    assert "<html" in (tmp_path / "again.html").read_text()
    table = drakesep.read_results(again).table("summary.csv")
    assert table["upper.mass_kg"][0] == pytest.approx(
        rows.loc[123, "upper.mass_kg"], rel=1e-14
    )
    with pytest.raises(ValueError, match="run: must be from 0 to 249, got 250"):
        drakesep.replay(folder, 250)
