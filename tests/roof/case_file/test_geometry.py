"""Geometry in case files, and the command that measures it."""

import copy

import pandas as pd
import pytest
import trimesh
from command_line import run
from ruamel.yaml import YAML

import drakesep
from drakesep import Case, CaseError, load_case
from drakesep.case_file.reader import builtin_cases
from drakesep.studies.background_process import BackgroundProcess
from drakesep.systems.model.parts import Box, Capsule, Cone, Mesh, Sphere


VEGA = YAML(typ="safe").load(builtin_cases()["vega"])


@pytest.fixture
def write(tmp_path):
    """Writes VEGA with other geometry, and returns the file."""

    def write(on_lv, on_payload, **clearance):
        data = copy.deepcopy(VEGA)
        del data["dispersions"], data["published"], data["requirements"]
        data["bodies"]["launch_vehicle"]["geometry"] = on_lv
        data["bodies"]["payload"]["geometry"] = on_payload
        data["clearance"] = clearance
        path = tmp_path / "case.yaml"
        with path.open("w") as file:
            YAML(typ="safe").dump(data, file)
        return path

    return write


@pytest.fixture
def clearance(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "200")

    def clearance(case, *arguments):
        folder = tmp_path / "results"
        return run(capsys, monkeypatch, "clearance", case, *arguments, "-o", folder)

    return clearance


POST = {"post": {"cylinder": {"radius_mm": 20, "length_mm": 200}}}
LUG = {"lug": {"sphere": {"radius_mm": 30}, "position_mm": [400, 0, 0]}}


def test_shapes(write, tmp_path):
    trimesh.creation.box().export(tmp_path / "part.stl")
    shapes = {
        "a": {"box": {"size_mm": [10, 20, 30]}, "role": "antenna"},
        "b": {"sphere": {"radius_mm": 5}},
        "c": {"capsule": {"radius_mm": 5, "length_mm": 9}, "attitude_deg": [0, 90, 0]},
        "d": {"cylinder": {"radius_mm": 5, "length_mm": 9, "thickness_mm": 1}},
        "e": {"cone": {"radius_aft_mm": 5, "radius_fore_mm": 0, "length_mm": 9}},
        "f": {"mesh": {"file": "part.stl", "scale": 0.001}},
    }
    body = load_case(write(shapes, LUG)).separation.body("launch_vehicle")
    assert [part.shape for part in body.parts] == [
        Box(size=(0.01, 0.02, 0.03)),
        Sphere(radius=0.005),
        Capsule(radius=0.005, length=0.009),
        Cone(radius_aft=0.005, radius_fore=0.005, length=0.009, thickness=0.001),
        Cone(radius_aft=0.005, radius_fore=0.0, length=0.009),
        Mesh(file=tmp_path / "part.stl", scale=0.001),
    ]
    assert body.parts[0].role == "antenna"
    assert body.parts[2].rpy_BG == pytest.approx((0.0, 1.5707963267948966, 0.0))


def test_clearance_that_ends_in_contact(write, clearance, tmp_path):
    """A hook of the launch vehicle stands in the payload's way."""
    hook = {"hook": {"box": {"size_mm": [20, 400, 400]}, "position_mm": [800, 0, 0]}}
    code, out, err = clearance(write(hook, LUG))
    assert code == 1
    assert "contact" in out
    assert "there is contact" in err
    [row] = (
        pd.read_csv(tmp_path / "results" / "clearance_summary.csv")
        .to_dict("index")
        .values()
    )
    # 360 mm of the payload's way, at about 1.16 m/s after the push
    assert row["contact_time_s"] == pytest.approx(0.37, abs=0.01)
    assert row["closing_speed_m_s"] == pytest.approx(1.16, abs=0.01)


def test_flange_on_its_ring(write, clearance):
    ring = {
        "ring": {
            "cylinder": {"radius_mm": 480, "length_mm": 60},
            "position_mm": [-30, 0, 0],
        }
    }
    flange = {
        "flange": {
            "cylinder": {"radius_mm": 480, "length_mm": 40},
            "position_mm": [20, 0, 0],
        }
    }
    code, _, err = clearance(write(ring, flange))
    assert code == 2
    assert "ring and flange must be apart while mated, or be listed as touching" in err
    code, out, _ = clearance(write(ring, flange, touching=[["flange", "ring"]]))
    assert code == 0
    assert "clear" in out


@pytest.mark.parametrize(
    ("clearance_", "message"),
    [
        (
            {"pairs": [["post", "lugs"]]},
            "clearance: pair: unknown part 'lugs'; did you",
        ),
        ({"pairs": [["post", "post"]]}, "parts of two bodies, got post and post"),
        ({"pairs": [["post"]]}, "must be two names of parts"),
        ({"pairs": ["post", "wall"]}, r"such as \[a, b\], got 'post'"),
        ({"pair": []}, "unknown key 'pair'; did you mean 'pairs'"),
    ],
)
def test_pairs_that_make_no_sense(write, clearance_, message):
    with pytest.raises(CaseError, match=message):
        load_case(write(POST, LUG, **clearance_))


def test_geometry_that_makes_no_sense(write):
    two = {"lug": {"sphere": {"radius_mm": 30}, "box": {"size_mm": [1, 1, 1]}}}
    with pytest.raises(
        CaseError, match=r"lug: must have one of box, .*got box and sphere"
    ):
        load_case(write(POST, two))
    with pytest.raises(CaseError, match="names must differ, got 'post' 2 times"):
        load_case(write(POST, POST))


def test_case_without_geometry(write, clearance):
    code, _, err = clearance(write({}, LUG))
    assert code == 2
    assert "bodies: a clearance needs geometry on two of them" in err


def test_requirement_on_clearance(write, tmp_path):
    path = write(POST, LUG)
    data = YAML(typ="safe").load(path)

    def load(**requirement):
        data["requirements"] = [{"quantity": "clearance_mm", **requirement}]
        with path.open("w") as file:
            YAML(typ="safe").dump(data, file)
        return load_case(path)

    case = load(at_least=30, until_separation_mm=500)
    [limit] = case.limits
    name = "clearance_until_0.5_m"
    assert (limit.metric, limit.sense, limit.limit) == (name, ">=", 0.03)
    assert [o.name for o in case.in_si().requirement_objectives] == [
        f"lowest_{name}",
        "lowest_longitudinal_displacement_at_end",  # whether the window ends
    ]
    with pytest.raises(CaseError, match=r"at_most must be none, .*, got 30"):
        load(at_most=30)
    with pytest.raises(CaseError, match="at_least must be > 0, got 0; that"):
        load(at_least=0)
    with pytest.raises(CaseError, match="until_separation_mm"):
        load(at_least=30, until_separation_mm=0)
    for value in (5e-324, 1e-12, 1e16):  # of no size that a length has
        with pytest.raises(CaseError, match="until_separation must be"):
            load(at_least=30, until_separation_mm=value)
    with pytest.raises(CaseError, match="must stand with clearance_mm or no_contact"):
        load(quantity="longitudinal_speed_after_separation_m_s", at_least=1, **UNTIL)
    data["bodies"]["payload"]["geometry"] = {}
    with pytest.raises(CaseError, match="clearance needs geometry on two bodies"):
        load(at_least=30)


def test_recontact(write, capsys, monkeypatch, tmp_path):
    """A lug that hits a post on its way out leaves its force behind."""
    lug = {"lug": {"sphere": {"radius_mm": 30}, "position_mm": [-400, 30, 0]}}
    post = {"post": {"sphere": {"radius_mm": 30}, "position_mm": [-100, 0, 0]}}
    path = write(post, lug)
    data = YAML(typ="safe").load(path)
    folder = tmp_path / "results"

    def simulate(**recontact):
        data["recontact"] = {"stiffness_N_m": 1.0e5, **recontact}
        with path.open("w") as file:
            YAML(typ="safe").dump(data, file)
        return run(capsys, monkeypatch, "simulate", path, "-o", folder)

    code, _, _ = simulate()
    assert code == 0
    [row] = pd.read_csv(folder / "contacts.csv").to_dict("records")
    contacts = pd.read_csv(folder / "contact_forces.csv")
    assert row["force_max_N"] == contacts["force_N"].max()
    # It rises and falls once.
    lasts = row["contact_end_s"] - row["contact_time_s"]
    assert 0.4 * row["force_max_N"] * lasts < row["impulse_N_s"]
    assert row["impulse_N_s"] < row["force_max_N"] * lasts
    # From the step before it to the step after it.
    assert (contacts["force_N"].iloc[[0, -1]] == 0.0).all()
    contacts = contacts[1:-1]
    assert set(contacts["first"]) == {"post"}
    assert (contacts["force_N"] > 0.0).all()
    # The lug is beside the post and comes from behind it.
    assert (contacts["force_y_N"] > 0.0).any()
    assert (contacts["force_x_N"] < 0.0).any()
    code, _, error = simulate(friction=-1)
    assert code == 2
    assert "recontact" in error
    data["bodies"]["payload"]["geometry"]["lug"]["position_mm"] = [-400, 300, 0]
    simulate()
    assert pd.read_csv(folder / "contacts.csv")["impulse_N_s"].empty
    assert pd.read_csv(folder / "contact_forces.csv")["force_N"].empty
    data["bodies"]["payload"]["geometry"]["lug"]["position_mm"] = [-100, 30, 0]
    code, _, error = simulate()
    assert code == 2
    assert "post and lug must be apart while mated" in error


def boom_in_guide():
    """VEGA with a boom in a guide, beside a gap of 13 mm that no tolerance changes."""
    data = copy.deepcopy(VEGA)
    del data["published"]
    data["bodies"]["launch_vehicle"]["geometry"] = {
        "guide": {
            "cylinder": {"radius_mm": 70, "length_mm": 400, "thickness_mm": 20},
            "position_mm": [-200, 0, 0],
        }
    }
    data["bodies"]["payload"]["geometry"] = {
        "boom": {
            "capsule": {"radius_mm": 35, "length_mm": 300},
            "position_mm": [-200, 0, 0],
        },
        "bus": {"box": {"size_mm": [1000, 900, 800]}, "position_mm": [513, 0, 0]},
    }
    tolerances = ("payload.cg_y_mm", "payload.cg_z_mm")
    data["dispersions"] = {name: VEGA["dispersions"][name] for name in tolerances}
    data["requirements"] = [
        {"quantity": "clearance_mm", "at_least": 12.5, "until_separation_mm": 390}
    ]
    return Case.model_validate(data)


@pytest.mark.slow
def test_a_gap_that_nothing_changes_does_not_hide_the_worst():
    """At the nominal it is the smallest, and has no slope; the boom comes nearer."""
    case = boom_in_guide()
    [nominal] = drakesep.clearance(case).summary["clearance_mm"].nsmallest(1)
    assert nominal == pytest.approx(13.0, abs=1e-6)
    study = drakesep.verify(case, growth=False, samples=100)
    assert study.completed
    assert not study.passed
    [row] = study.requirements.to_dict("records")
    assert row["which_run"] == "worst_lowest_clearance_until_0.39_m"
    corners = [
        drakesep.clearance(
            case, {"payload.cg_y_mm": 1.0 + y, "payload.cg_z_mm": 8.0 + z}
        )
        for y in (-tolerance(case, "y"), tolerance(case, "y"))
        for z in (-tolerance(case, "z"), tolerance(case, "z"))
    ]
    least = min(found.summary["clearance_mm"].min() for found in corners)
    assert least < 12.0
    assert row["worst"] == pytest.approx(least, abs=0.05)


def tolerance(case, axis):
    return case.dispersions[f"payload.cg_{axis}_mm"]


@pytest.mark.slow
def test_a_worst_case_that_another_beats_has_failed():
    """Up the slope from the nominal there is nothing; the worst of L1 is beyond it."""
    study = drakesep.verify(boom_in_guide(), growth=False, searches=["vertices", "sqp"])
    runs = {one.label: one for one in study.runs}
    status = runs["worst_lowest_clearance_until_0.39_m"].status
    assert status.startswith("failed: ")
    assert "comes nearer, to " in status
    evidence = study.evidence.set_index("objective")["beaten_by"]
    beaten_by = evidence["lowest_clearance_until_0.39_m"]
    assert status.startswith(f"failed: {beaten_by} comes nearer, ")
    assert not study.completed
    [row] = study.requirements.to_dict("records")
    assert row["worst"] < 12.0
    assert row["verdict"] == "not met"


@pytest.mark.slow
def test_same_study_with_a_process_beside_and_without(tmp_path, monkeypatch):
    """Measured and drawn in the process, from where the study is started."""
    aside = []
    submit = BackgroundProcess.submit

    def spy(background, *call):
        aside.append(background.is_another)
        return submit(background, *call)

    monkeypatch.setattr(BackgroundProcess, "submit", spy)
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    monkeypatch.chdir(tmp_path)
    here, beside = (
        drakesep.verify(boom_in_guide(), samples=100, output=folder, workers=workers)
        for folder, workers in (("here", 1), ("beside", None))
    )
    # The references are measured; runs are written twice, and there are two pictures.
    assert aside == [False] * 4 + [True] * 5
    pd.testing.assert_frame_equal(here.table, beside.table, check_exact=True)
    written, others = (left_in(tmp_path / of) for of in ("here", "beside"))
    assert {"rotation.png", "tornado.png", "worst_clearance.png"} <= set(written)
    assert [name for name in written if others.get(name) != written[name]] == []
    assert set(others) == set(written)


def left_in(folder):
    """The files of a study by their names, but for its record, which has its times."""
    files = (file for file in folder.rglob("*") if file.is_file())
    left = {str(file.relative_to(folder)): file.read_bytes() for file in files}
    return {name: left[name] for name in left if name != "study.json"}


def test_a_doubtful_mesh_is_warned_of_by_the_caller(tmp_path, monkeypatch):
    """Though it overlaps what it should not, and is measured in another process."""
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    trimesh.creation.box((300.0, 300.0, 300.0)).export(tmp_path / "box.stl")
    data = boom_in_guide().model_dump(by_alias=True, exclude_unset=True)
    data["bodies"]["payload"]["geometry"] = {
        "box_in_mm": {"mesh": {"file": str(tmp_path / "box.stl"), "scale": 1.0}}
    }
    case = Case.model_validate(data)
    with (
        pytest.warns(UserWarning, match="box_in_mm: mesh is 520 m across"),
        pytest.raises(ValueError, match="must be apart while mated"),
    ):
        drakesep.verify(case, samples=100)


@pytest.mark.slow
def test_pictures_that_fail_do_not_take_the_study_with_them(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr("drakesep.plots.tornado.save_tornado", fail)
    with pytest.raises(OSError, match="disk full"):
        drakesep.verify(boom_in_guide(), samples=100, output=tmp_path, workers=1)
    assert (tmp_path / "requirements.csv").exists()
    assert (tmp_path / "rotation.png").exists()


def test_worst_case_with_recontact(write):
    """How fast a lug that hits a post turns the payload, flown in Drake unasked."""
    lug = {"lug": {"sphere": {"radius_mm": 30}, "position_mm": [-400, 30, 0]}}
    post = {"post": {"sphere": {"radius_mm": 30}, "position_mm": [-100, 0, 0]}}
    path = write(post, lug)
    data = YAML(typ="safe").load(path)
    data["recontact"] = {"stiffness_N_m": 1.0e5, "dissipation_s_m": 0.3}
    data["dispersions"] = {"payload.cg_y_mm": 5.0}
    data["run"]["duration_s"] = 1.0
    turned = drakesep.worst_case(Case.model_validate(data), "highest_final_rate_z")
    assert turned.completed and turned.effort.drake_alone
    assert "flown run by run in Drake" in str(turned.effort)
    del data["recontact"]
    free = drakesep.worst_case(
        Case.model_validate(data), "highest_final_rate_z", searches=["drake"]
    )
    [hit], [missed] = turned.evidence["worst"], free.evidence["worst"]
    assert abs(hit - missed) > 0.1
    assert turned.evidence["difference"].abs().max() < 1e-3


UNTIL = {"until_separation_mm": 500}


def test_show_tells_where_parts_are(write, capsys, monkeypatch, tmp_path):
    """A mesh that is taken for one in metres is seen to be."""
    trimesh.creation.box((10.0, 20.0, 30.0)).export(tmp_path / "part.stl")
    path = write(POST, {"brick": {"mesh": {"file": "part.stl"}, "role": "antenna"}})
    monkeypatch.setenv("COLUMNS", "200")
    code, out, _ = run(capsys, monkeypatch, "show", path)
    assert code == 0
    [line] = [x for x in out.splitlines() if " brick " in x and " mesh " in x]
    for word in ("payload", "mesh", "antenna", "-5000 to 5000", "-1.5e+04 to 1.5e+04"):
        assert word in line
