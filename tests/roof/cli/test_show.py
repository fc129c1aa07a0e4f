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


def test_parameters(data, rows):
    """Each with its value and tolerance, in the unit of its name."""
    values = {
        "upper.mass_kg": 1200.0,
        "upper.cg_y_mm": -20.0,
        "upper.inertia_xz_kg_m2": 25.0,
        "lower.cg_x_mm": -800.0,
        "s1.force_max_N": 1200.0,
        "s2.stroke_mm": 110.0,
        "two.position_z_mm": 300.0,
        "two.release_time_s": 0.05,
        "gust.position_y_mm": -12.0,
        "gust.factor": 1.0,
        "before_separation.attitude_pitch_deg": -3.0,
        "before_separation.rate_y_deg_s": -0.4,
    }
    for name, value in values.items():
        [[got, tolerance]] = rows[name]
        assert float(got) == pytest.approx(value, rel=1e-4), name
        expected = data["dispersions"].get(name)
        if name == "lower.cg_x_mm":
            assert tolerance == "-10 +20"
            continue
        assert tolerance == ("" if expected is None else f"± {expected:g}"), name
    assert set(data["dispersions"]) <= set(rows)


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
    [[body, shape, role, *extents]] = rows["post"]
    assert (body, shape, role) == ("lower", "box", "guide")
    assert extents == ["370 to 470", "350 to 450", "-420 to 480"]
    [[_, shape, _, *extents]] = rows["ball"]
    assert shape == "sphere"
    assert extents[0].startswith("150 to 35")


def test_loads(rows):
    [gust] = [r for r in rows["gust"] if len(r) == 8]
    assert gust == ["upper", "11 -12 13", "world", "0.12", "0.3", "one", "5", "1.5"]


def test_requirements(rows):
    [[condition, sense, limit, *_]] = rows["longitudinal_speed_after_separation_m_s"]
    assert (condition, sense, float(limit)) == ("", ">=", 0.49)
    limits = {"x": 0.66, "y": 1.72, "z": 1.25}
    for axis, expected in limits.items():
        [[_, sense, limit, *_]] = rows[f"rate_after_separation_{axis}_deg_s"]
        assert (sense, float(limit)) == ("<=", expected)


def test_first_lines(shown):
    name, motion, *_ = shown.splitlines()
    assert name == "small: two bodies that let go"
    for text in (
        "upper leaves lower",
        "orbit: circular, 640 km",
        "attitude [2.0, -3.0, 4.0] deg",
        "rate [0.5, -0.4, 0.3] deg/s",
        "run: 0.8 s with runge_kutta3 at accuracy 1e-06",
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
