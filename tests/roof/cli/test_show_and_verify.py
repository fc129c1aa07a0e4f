"""What `verify` refuses, `show` refuses in the same words; nothing is flown for it."""

import copy

import pytest
from bad_cases import BAD
from command_line import run
from ruamel.yaml import YAML
from small_case import small_case, write_case

from drakesep.systems.simulation.simulation import Simulation


def with_part(role):
    """The small case, with a part of the upper body inside one of the lower."""
    data = small_case()
    part = {"sphere": {"radius_mm": 50.0}, "position_mm": [-150.0, -100.0, 50.0]}
    data["bodies"]["upper"]["geometry"]["inner"] = {**part, "role": role}
    limit = {"quantity": "clearance_mm", "at_least": 1.0}
    data["requirements"].append(limit)
    return data


def labelled(label):
    data = small_case()
    data["published"][0]["label"] = label
    return data


def doubly_limited():
    data = small_case()
    data["requirements"] *= 2
    return data


REFUSED = {
    "a part inside another": (
        with_part("probe"),
        "geometry: deck and inner must be apart while mated, or be listed as touching",
    ),
    "a published run with our label": (labelled("nominal"), "published: label"),
    "a requirement twice": (doubly_limited(), ": at_least must stand once"),
    "ellipsoid of what is not dispersed": (
        small_case(ellipsoids=[{"parameters": ["upper.mass_kg", "s1.stroke_mm"]}]),
        "ellipsoids:",
    ),
}


@pytest.fixture
def drakesep(capsys, monkeypatch, tmp_path):
    """Standard error and exit code of a command; a run that is flown is an error."""

    def flown(*_):
        raise AssertionError("a run was flown")

    monkeypatch.setattr(Simulation, "run", flown)

    def call(command, case):
        words = [command, case]
        if command != "show":
            words += ["-o", tmp_path / "out"]
        if command == "verify":
            words += ["--workers", 1]
        code, _, err = run(capsys, monkeypatch, *words)
        return code, err

    return call


def written(folder, data):
    path = folder / "case.yaml"
    with path.open("w") as file:
        YAML(typ="safe").dump(copy.deepcopy(data), file)
    return path


@pytest.mark.parametrize("name", BAD)
def test_mistakes_in_a_file(name, drakesep, tmp_path):
    case = written(tmp_path, BAD[name][0])
    told = drakesep("show", case)
    assert told == drakesep("verify", case)
    assert told[0] == 2


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_file_does_not_show(name, drakesep, tmp_path):
    data, message = REFUSED[name]
    case = write_case(tmp_path, data)
    told = drakesep("show", case)
    assert told == drakesep("verify", case)
    assert told[0] == 2
    assert message in told[1]
    assert len(told[1].splitlines()) == 1


@pytest.mark.parametrize("command", ["verify", "clearance", "worst-case"])
def test_parts_that_overlap_are_refused_before_the_folder_is_cleared(
    command, drakesep, tmp_path
):
    """Results of the last study stay, and no new folder is left."""
    import drakesep as package

    case = write_case(tmp_path, with_part("probe"))
    code, err = drakesep(command, case)
    assert code == 2
    assert "deck and inner must be apart while mated" in err
    assert not (tmp_path / "out").exists()
    good = package.load_case(write_case(tmp_path, small_case(), "good.yaml"))
    from drakesep.results.asked import Asked
    from drakesep.results.folder import ResultsFolder

    with ResultsFolder(tmp_path / "out", command) as folder:
        folder.begin(Asked.of(command, good))
        (folder.path / "requirements.csv").write_text("last")
        folder.end(verdict="met")
    before = {f.name: f.read_bytes() for f in (tmp_path / "out").glob("*.*")}
    assert drakesep(command, case)[0] == 2
    after = {f.name: f.read_bytes() for f in (tmp_path / "out").glob("*.*")}
    assert before == after


@pytest.mark.parametrize(
    ("data", "note"),
    [
        (small_case(requirements=None, objectives=None, published=None), "no require"),
        (small_case(dispersions=None, published=None), "There are no dispersions"),
        (small_case(), "no requirement of clearance_mm"),
        (
            small_case(recontact={"stiffness_N_m": 1e6}),
            "Parts push each other where they touch (recontact), which Drake alone",
        ),
        (
            small_case(
                requirements=[
                    {
                        "quantity": "rate_deg_s",
                        "when": {"at_s": 2.0},
                        "at_most": [9] * 3,
                    }
                ]
            ),
            "Of rate_at_2_s_y_deg_s <= 9 there is no verdict: it looks beyond the end "
            "of the run, 0.8 s.",
        ),
    ],
)
def test_what_is_no_mistake_is_noted(data, note, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    case = write_case(tmp_path, data)
    code, out, err = run(capsys, monkeypatch, "show", case)
    assert (code, err) == (0, "")
    notes = [line for line in out.splitlines() if line.startswith("Note: ")]
    assert any(note in line for line in notes), notes


def test_a_case_without_requirements_is_refused_by_verify_alone(drakesep, tmp_path):
    case = write_case(
        tmp_path, small_case(requirements=None, objectives=None, published=None)
    )
    assert drakesep("show", case) == (0, "")
    code, err = drakesep("verify", case)
    assert (code, err) == (
        2,
        "drakesep: requirements: a case to verify must have some, got none\n",
    )
