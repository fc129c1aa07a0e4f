"""Swept space and animation show every body that leaves, each as it does."""

import json
import re

import numpy as np
import pytest
from pictures import is_drawn
from trade import JOINT, symmetric_design

import drakesep
from drakesep.plots import animation as animations
from drakesep.plots.swept_volume import swept_figure


LATER = 1.2
"""When the second lets go, s."""


def sideways(axis, name, release):
    """A payload of 100 kg on a side of the launcher, a spring and a box."""
    y = 300.0 * axis
    body = {
        "mass_kg": 100.0,
        "cg_mm": [0.0, 200.0 * axis, 0.0],
        "inertia_kg_m2": {"xx": 8.0, "yy": 8.0, "zz": 8.0},
        "mated": {"position_mm": [0.0, y, 0.0]},
        "geometry": {
            f"box_of_{name}": {
                "box": {"size_mm": [400, 380, 400]},
                "position_mm": [0.0, 200.0 * axis, 0.0],
            }
        },
    }
    attachment = {
        "A": "lv",
        "B": name,
        "position_mm": [0.0, y, 0.0],
        "joint": JOINT,
        "spring": {
            "name": f"spring_of_{name}",
            "law": "displacement",
            "force_max_N": 1500.0,
            "stroke_mm": 60.0,
            "axis": [0.0, axis, 0.0],
        },
        "release_time_s": release,
    }
    return body, attachment


def two_to_the_sides():
    bodies = symmetric_design().model_dump(mode="json", exclude_none=True)["bodies"]
    del bodies["sc"]
    bodies["lv"]["geometry"] = {"drum": {"box": {"size_mm": [900, 560, 560]}}}
    bodies["left"], left = sideways(1.0, "left", 0.0)
    bodies["right"], right = sideways(-1.0, "right", LATER)
    return symmetric_design(
        pair=None,
        pairs=[
            {"A": "lv", "B": "left", "direction": [0.0, 1.0, 0.0]},
            {"A": "lv", "B": "right", "direction": [0.0, -1.0, 0.0]},
        ],
        bodies=bodies,
        attachments={"a_left": left, "a_right": right},
        run={"duration_s": 3.0, "accuracy": 1e-7},
    )


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clearance")
    return drakesep.clearance(two_to_the_sides(), output=folder), folder


def test_each_sweeps_its_own_space(measured):
    """Each is drawn to its side: what it sweeps is where it goes, and only there."""
    study, folder = measured
    for name in ("swept.png", "swept_right.png"):
        assert is_drawn(folder / name)
    for pair, side in zip(study.run.separation.pairs, (1.0, -1.0), strict=True):
        figure = swept_figure(study.run, pair, study.analysis.names)
        [labels] = [[t.get_text() for t in x.get_texts()] for x in figure.legends]
        assert labels == [f"box_of_{pair.B}", "lv"]
        assert pair.B in figure._suptitle.get_text()
        across = figure.axes[1]  # x and y
        swept, _ = (patch.get_path() for patch in across.patches)
        outward = side * swept.vertices[:, 1]
        # From its inner face, 0.3 + 0.2 - 0.19 m, until it is clear.
        assert outward.min() == pytest.approx(310.0, abs=1.0)
        assert outward.max() > 690.0


def test_each_push_is_shown_slowly(monkeypatch):
    """Frames of a push are closer in time than those between pushes and after."""
    made = []

    class Noted:
        def __init__(self, frames_per_second):
            self.places, self.frames = [], frames_per_second
            made.append(self)

        def look_at(self, centre, size):
            self.seen = centre, size

        def place(self, path, pose, at):
            self.places.append((path, pose, at))

        def page(self):
            return "<html><body></body></html>"

        draw = place_bar = lambda self, *_: None

    monkeypatch.setattr(animations, "Recording", Noted)
    run = drakesep.simulate(two_to_the_sides()).run
    page = animations.animation({"nominal": run})
    [shown] = json.loads(re.search(r"const runs = (\[.*?\]), frames", page)[1])
    time = np.array(shown["time"])
    assert time[0] == 0.0 and time[-1] == pytest.approx(3.0)
    pushes = [(0.0, run.stroke_ends["spring_of_left"])]
    pushes.append((LATER, run.stroke_ends["spring_of_right"]))
    seconds = [
        ((start <= time) & (time <= end)).sum() / made[0].frames
        for start, end in pushes
    ]
    assert seconds == pytest.approx([4.0, 4.0], abs=0.5)
    # Both move, each to its side.
    for name, side in (("left", 1.0), ("right", -1.0)):
        ys = [p.p_AoBo_A[1] for path, p, _ in made[0].places if path.endswith(name)]
        assert len(ys) == len(time)
        assert side * ys[0] == pytest.approx(0.3)
        assert side * ys[-1] > 1.0
    # All of them are in view: 0.9 m by 1.38 m by 0.56 m.
    centre, size = made[0].seen
    assert centre == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert size == pytest.approx(np.linalg.norm([0.9, 1.38, 0.56]))


def test_the_page_names_every_body(tmp_path):
    file = tmp_path / "page.html"
    drakesep.animate(two_to_the_sides(), output=file)
    title = "symmetric: separation of left, right from lv"
    assert f"<title>{title}</title>" in file.read_text(encoding="utf-8")
