"""The animation is one page that a browser draws by itself."""

import json
import re
import shutil
import subprocess

import matplotlib.image
import numpy as np
import pytest
from command_line import run

import drakesep
from drakesep import load_case
from drakesep.systems.checks import InputError
from drakesep.tables.run_tables import read_runs


@pytest.fixture(scope="module")
def page(vega, tmp_path_factory):
    file = tmp_path_factory.mktemp("animation") / "vega.html"
    drakesep.animate(vega, {"heavy": {"payload.mass_kg": 1880.0}}, output=file)
    return file


def test_page_says_what_it_shows(page, vega):
    text = page.read_text(encoding="utf-8")
    assert re.findall(r"<option[^>]*>(\w+)<", text) == ["nominal", "heavy"]
    shown = json.loads(re.search(r"const runs = (\[.*?\]), frames", text)[1])
    assert [one["label"] for one in shown] == ["nominal", "heavy"]
    nominal = shown[0]
    assert nominal["time"][0] == 0.0
    assert nominal["time"][-1] == pytest.approx(3.0)
    assert np.all(np.diff(nominal["time"]) > 0.0)
    # Slow while springs push: most of the frames are of the first second.
    assert nominal["time"][len(nominal["time"]) // 2] < 1.0
    nearest = min(c.minimum for c in drakesep.clearance(vega).found)
    # Between frames, in slow motion, it moves by less than this.
    assert min(nominal["distance"]) == pytest.approx(1e3 * nearest, abs=0.2)
    # Self-contained: nothing is fetched.
    assert not re.search(r"<(script|link)[^>]+(src|href)=", text)


def test_the_camera_draws_back_as_bodies_leave(page):
    """As far as the payload goes, from the end of the run and the geometry."""
    text = page.read_text(encoding="utf-8")
    shown = json.loads(re.search(r"const runs = (\[.*?\]), frames", text)[1])
    bodies = json.loads(re.search(r", bodies = (\[.*?\]);", text)[1])
    assert [body["name"] for body in bodies] == ["launch_vehicle", "payload"]
    for one in shown:
        assert one["far"][0] == 1.0
        assert np.all(np.diff(one["far"]) >= 0.0)
    # By hand: the payload, in a sphere of 1.57 m, leaves by 3.4 m; the stack fits in
    # one of 1.62 m, of which half as much again is seen at first.
    assert shown[0]["far"][-1] == pytest.approx((3.4 + 1.57) / (1.5 * 1.62), rel=0.03)


@pytest.mark.parametrize("moment", [1000, 20000])
def test_names_stand_at_their_bodies_within_the_view(page, moment):
    """From the first second to the end; the payload is before the vehicle."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("there is no chromium to draw the page")
    drawn = subprocess.run(
        [
            *(chromium, "--headless=new", "--no-sandbox", "--use-angle=swiftshader"),
            *("--enable-unsafe-swiftshader", "--window-size=1000,700"),
            *(f"--virtual-time-budget={moment}", "--dump-dom", page.as_uri()),
        ],
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    ).stdout
    places = {}
    for style, name in re.findall(r'<span style="([^"]*)">(\w+)</span>', drawn):
        assert "visibility: visible" in style
        left, top = (re.search(rf"{s}: ([\d.-]+)%", style)[1] for s in ("left", "top"))
        places[name] = float(left), float(top)
    assert set(places) == {"launch_vehicle", "payload"}
    for x, y in places.values():
        assert 10.0 < x < 90.0 and 10.0 < y < 90.0
    assert places["payload"][0] > places["launch_vehicle"][0]


def test_browser_draws_it(page, tmp_path):
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("there is no chromium to draw the page")
    picture = tmp_path / "page.png"
    subprocess.run(
        [
            *(chromium, "--headless=new", "--no-sandbox", "--use-angle=swiftshader"),
            *("--enable-unsafe-swiftshader", "--window-size=1000,700"),
            *("--virtual-time-budget=4000", f"--screenshot={picture}", page.as_uri()),
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    pixels = matplotlib.image.imread(picture)[..., :3]
    below_panel = pixels[250:]
    blue = (below_panel[..., 2] > below_panel[..., 0] + 0.2).mean()
    neutral = np.ptp(below_panel, axis=2) < 0.1
    grey = (neutral & (below_panel.max(axis=2) < 0.75)).mean()
    # The payload in blue, the launch vehicle in grey, on a white background; at
    # whichever frame the browser has come to.
    assert blue > 0.02
    assert grey > 0.01


def test_command(capsys, monkeypatch, tmp_path, vega_verification, vega_folder):
    table = vega_folder / "worst_cases.csv"
    file = tmp_path / "new" / "page.html"
    arguments = ("animate", "vega", "--runs", table, "--run", "worst_L1", "-o", file)
    code, out, _ = run(capsys, monkeypatch, *arguments)
    assert code == 0
    assert "The animation is" in out
    assert ">worst_L1</option>" in file.read_text(encoding="utf-8")


def test_runs_of_a_table(vega_verification, vega_folder, tmp_path):
    table = vega_folder / "worst_cases.csv"
    shown = ("L1", "L2", "Linf", "PM", "lowest_clearance_until_0.5_m")
    assert set(read_runs(table)) == {f"worst_{name}" for name in shown}
    with pytest.raises(InputError, match="unknown run 'worst_L3'; did you mean"):
        read_runs(table, ["worst_L3"])
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="a table of runs with a column label"):
        read_runs(tmp_path / "other.csv")


def test_case_without_geometry(tmp_path):
    with pytest.raises(InputError, match="needs geometry on two of them"):
        drakesep.animate(load_case("fairing"), output=tmp_path / "page.html")
