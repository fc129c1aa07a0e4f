"""What `show` prints of a case, cell by cell, against the file."""

import json

import pytest
from command_line import run
from small_case import small_case, write_case


@pytest.fixture(scope="module")
def data():
    loads = {
        "gust": {
            "body": "upper",
            "axes": "world",
            "position_mm": [11.0, -12.0, 13.0],
            "start_s": 0.1,
            "after": "one",
            "times_s": [0.02, 0.2],
            "forces_N": [[3.0, 4.0, 0.0], [0.0, 0.0, 2.0]],
            "torques_N_m": [[0.0, 0.0, 1.5], [0.0, 0.0, 0.0]],
        }
    }
    data = small_case(loads=loads, orbit={"altitude_km": 640.0})
    data["description"] = "two bodies that let go"
    data["dispersions"]["before_separation.rate_y_deg_s"] = 0.05
    data["dispersions"]["two.release_time_s"] = 0.004
    data["attachments"]["two"]["release_time_s"] = 0.05
    data["dispersions"]["lower.cg_x_mm"] = {"lower": -810, "upper": -780}
    return data


@pytest.fixture
def shown(data, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    code, out, _ = run(capsys, monkeypatch, "show", write_case(tmp_path, data))
    assert code == 0
    return out


@pytest.fixture
def rows(shown):
    """The cells of all rows, by the first, and a list where it is in several."""
    found = {}
    for line in shown.splitlines():
        cells = [cell.strip() for cell in line.replace("┃", "│").split("│")[1:-1]]
        if cells:
            found.setdefault(cells[0], []).append(cells[1:])
    return found


def test_dispersed_parameters(data, rows):
    """Each with its value and tolerance, in the unit of its name."""
    values = {
        "upper.mass_kg": 1200.0,
        "upper.cg_y_mm": -20.0,
        "lower.cg_x_mm": -800.0,
        "s1.force_max_N": 1200.0,
        "two.release_time_s": 0.05,
        "before_separation.rate_y_deg_s": -0.4,
    }
    assert set(values) == set(data["dispersions"])
    for name, value in values.items():
        [[got, tolerance, distribution]] = rows[name]
        assert float(got) == pytest.approx(value, rel=1e-4), name
        expected = data["dispersions"][name]
        if name == "lower.cg_x_mm":
            assert tolerance == "-10 +20"
        else:
            assert tolerance == f"± {expected:g}", name
        assert distribution == "uniform", name


def test_every_other_parameter_stands_beside_its_owner(
    data, shown, tmp_path, capsys, monkeypatch
):
    """Those that `--json` has, with their values; a row may go on in the next lines."""
    _, table = shown.split("Other parameters")
    owner, told = "", {}
    for line in table.split("Requirements")[0].splitlines():
        if not line.startswith("│"):
            continue
        first, values, zeros = (cell.strip() for cell in line.split("│")[1:-1])
        owner = first or owner
        texts = told.setdefault(owner, ["", ""])
        texts[0] += f" {values}"
        texts[1] += f" {zeros}"
    found = {}
    for owner, (values, zeros) in told.items():
        for entry in filter(None, values.strip().split(",")):
            name, value = entry.split()
            found[f"{owner}.{name}"] = float(value)
        for name in filter(None, zeros.strip().split(",")):
            found[f"{owner}.{name.strip()}"] = 0.0
    case = write_case(tmp_path, data)
    _, out, _ = run(capsys, monkeypatch, "show", case, "--json")
    every = {r["parameter"]: r["value"] for r in json.loads(out)["parameters"]}
    others = {k: x for k, x in every.items() if k not in data["dispersions"]}
    assert found == pytest.approx(others, rel=1e-4)
    assert found["gust.factor"] == 1.0
    assert found["two.position_z_mm"] == 300.0
    assert found["before_separation.attitude_pitch_deg"] == -3.0


@pytest.mark.parametrize(
    ("part", "said"),
    [
        ({"cylinder": {"radius_mm": 50, "length_mm": 90}}, "cylinder"),
        (
            {"cylinder": {"radius_mm": 50, "length_mm": 90, "thickness_mm": 5}},
            "hollow cylinder",
        ),
        (
            {"cone": {"radius_aft_mm": 50, "radius_fore_mm": 20, "length_mm": 90}},
            "cone",
        ),
    ],
)
def test_round_parts_by_their_names(part, said, tmp_path, capsys, monkeypatch):
    data = small_case()
    data["bodies"]["upper"]["geometry"]["ball"] = {
        **part,
        "position_mm": [250.0, 200.0, -80.0],
    }
    code, out, _ = run(capsys, monkeypatch, "show", write_case(tmp_path, data))
    assert code == 0
    [line] = [x for x in out.splitlines() if x.startswith("│ ball ") and " upper " in x]
    assert line.split("│")[3].strip() == said


def test_bodies_and_attachments(rows):
    [[mass, cg, moments, products]] = [r for r in rows["lower"] if len(r) == 4]
    assert (mass, cg) == ("700", "-800 50 -30")
    assert (moments, products) == ("300 420 380", "12 -15 8")
    [one] = [r for r in rows["one"] if len(r) == 7]
    assert one == ["lower", "upper", "0 500 0", "fixed", "0 s", "s1", "time"]
    [two] = [r for r in rows["two"] if len(r) == 7]
    assert two[4] == "0.05 s"


def test_geometry(rows):
    """Where the boxes around parts stand, in their bodies."""
    [[body, shape, role, *extents]] = [r for r in rows["post"] if len(r) > 2]
    assert (body, shape, role) == ("lower", "box", "guide")
    assert extents == ["370 to 470", "350 to 450", "-420 to 480"]
    [[_, shape, _, *extents]] = [r for r in rows["ball"] if len(r) > 2]
    assert shape == "sphere"
    assert extents[0].startswith("150 to 35")


def test_loads(rows):
    [gust] = [r for r in rows["gust"] if len(r) == 8]
    assert gust == ["upper", "11 -12 13", "world", "0.12", "0.3", "one", "5", "1.5"]


def test_requirements(rows):
    assert rows["longitudinal speed after separation"] == [[">= 0.49 m/s"]]
    limits = {"x": 0.66, "y": 1.72, "z": 1.25}
    for axis, expected in limits.items():
        assert rows[f"rate after separation {axis}"] == [[f"<= {expected} deg/s"]]


def test_first_lines(shown):
    name, motion, *_ = shown.splitlines()
    assert name == "small: two bodies that let go"
    for text in (
        "upper leaves lower",
        "orbit: circular, 640 km",
        "attitude [2.0, -3.0, 4.0] deg",
        "rate [0.5, -0.4, 0.3] deg/s",
        "run: 0.8 s with runge_kutta5 at accuracy 1e-06",
    ):
        assert text in motion


def test_sides_of_a_tolerance_in_json(data, tmp_path, capsys, monkeypatch):
    case = write_case(tmp_path, data)
    code, out, _ = run(capsys, monkeypatch, "show", case, "--json")
    assert code == 0
    rows = {row["parameter"]: row for row in json.loads(out)["parameters"]}
    sides = {"minus": pytest.approx(10.0), "plus": pytest.approx(20.0)}
    assert rows["lower.cg_x_mm"]["tolerance"] == sides
    assert rows["two.release_time_s"]["tolerance"] == pytest.approx(0.004)
    assert rows["lower.mass_kg"]["tolerance"] is None


def test_failure_cases(rows):
    assert rows["s1_worn"] == [["s1.force_max_N 1180"]]


def test_what_campaigns_look_at(tmp_path, capsys, monkeypatch):
    """Distributions, correlations and probabilities; the same by `--json`."""
    data = small_case(
        dispersions={
            "upper.mass_kg": {"tolerance": 12, "distribution": "normal"},
            "upper.cg_y_mm": {"uniform": {"minus": 1, "plus": 2}, "within": 0.5},
            "s1.force_max_N": {"table": {"values": [1190, 1205, 1230]}},
        },
        correlations=[{"of": ["upper.mass_kg", "s1.force_max_N"], "rank": 0.25}],
        failure_cases={"heavy": {"upper.mass_kg": 1250}, "out": {"s1.force_max_N": 0}},
        failures={"out": 0.0625},
    )
    case = write_case(tmp_path, data)
    monkeypatch.setenv("COLUMNS", "200")
    _, out, _ = run(capsys, monkeypatch, "show", case)
    lines = [" ".join(line.replace("│", " ").split()) for line in out.splitlines()]
    assert "upper.mass_kg 1200 ± 12 normal, sigma 4" in lines
    assert "upper.cg_y_mm -20 ± 0.5 uniform, over -1 +2" in lines
    assert "s1.force_max_N 1200 -10 +30 table, 3 values" in lines
    assert "Of rank correlation 0.25 in a campaign: upper.mass_kg, s1.force_max_N" in (
        lines
    )
    [line] = [line for line in lines if line.startswith("out ")]
    assert line.endswith(" 0.0625")
    [line] = [line for line in lines if line.startswith("heavy ")]
    assert line.endswith("1250")
    _, out, _ = run(capsys, monkeypatch, "show", case, "--json")
    told = json.loads(out)
    rows = {row["parameter"]: row for row in told["parameters"]}
    assert rows["upper.mass_kg"]["distribution"] == "normal, sigma 4"
    assert rows["lower.mass_kg"]["distribution"] is None
    assert told["correlations"] == [
        {"of": ["upper.mass_kg", "s1.force_max_N"], "rank": 0.25}
    ]
    assert [row["probability"] for row in told["failure_cases"]] == [None, 0.0625]
