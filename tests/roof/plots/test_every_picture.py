"""Every curve, bar, outline and frame shows what its title says.

Of motions that are written down, so that what is drawn is known without the code.
"""

import dataclasses
import itertools
import json
import math
import re

import numpy as np
import pandas as pd
import pytest
from drawn import curves_of, drawn, titles_of
from flights import run_of, trajectory
from runs import made_up_run
from scipy.spatial.transform import Rotation
from tumbling import Tumbling

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.clearance.of_pair import Clearance
from drakesep.analysis.metrics.requirements import Requirement
from drakesep.case_file.reader import load_case
from drakesep.plots import animation as animations
from drakesep.plots.approach import Approach, Curve
from drakesep.plots.clearance_plots import approaches_figure, clearance_figure
from drakesep.plots.panels import ROTATION, TRANSLATION
from drakesep.plots.swept_volume import swept_figure
from drakesep.plots.tornado import tornado_figure
from drakesep.systems.geometry.colours import colour_of
from drakesep.systems.geometry.illustration import illustration_of
from drakesep.systems.model.parts import Box, Capsule, Cone, Part, Sphere
from drakesep.tables.labelled_run import LabelledRun
from drakesep.tables.roles import Nominal, Worst


DEG, MM = 180.0 / math.pi, 1000.0
XYZ, ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
PANELS = {
    TRANSLATION: [
        ("relative velocity", "relative_velocity", XYZ, "m/s", 1.0),
        ("acceleration of the CG", "acceleration", XYZ, "m/s²", 1.0),
        ("linear momentum change", "linear_momentum_change", XYZ, "N s", 1.0),
    ],
    ROTATION: [
        ("angle", "angle", ANGLES, "deg", DEG),
        ("rate", "rate", XYZ, "deg/s", DEG),
        ("angular momentum change", "angular_momentum_change", XYZ, "N m s", 1.0),
    ],
}


def ramps(start):
    """Three signals, unlike each other and unlike those of another start."""
    return lambda t: tuple(start + 0.1 * i + (i + 1) * t for i in range(3))


@pytest.mark.parametrize("topic", PANELS)
def test_motion(topic):
    quantities = [panel[1] for panels in PANELS.values() for panel in panels]
    runs = [
        LabelledRun(
            role=role,
            run=made_up_run(
                **{name: ramps(k + 10 * n) for k, name in enumerate(quantities)}
            ),
            metrics={},
        )
        for n, role in enumerate((Nominal(), Worst("of_mine")))
    ]
    figure = drawn(topic, runs, AnalysisCase(separation=runs[0].run.separation))
    assert len(titles_of(figure)) == 9
    time = runs[0].run.motion.time
    for title, quantity, names, unit, scale in PANELS[topic]:
        for i, name in enumerate(names):
            push = curves_of(figure, f"{title}, {name}", "push")
            [axes] = {line.axes for line in push.runs.values()}
            assert axes.get_ylabel() == unit
            whole = curves_of(figure, f"{title}, {name}")
            for curves in (push, whole):
                assert list(curves.runs) == ["nominal", "worst_of_mine"]
                for n, line in enumerate(curves.runs.values()):
                    start = quantities.index(quantity) + 10 * n
                    expected = scale * (start + 0.1 * i + (i + 1) * time)
                    assert line.get_xdata() == pytest.approx(time)
                    assert line.get_ydata() == pytest.approx(expected)
                end = curves.end.get_xdata()
                assert list(end) == [runs[0].run.separation_end] * 2


def test_tornado():
    rows = [("L1", "deg", *row) for row in (("a", 3, -1, 1, -2), ("b", -2, 0, 4, -3))]
    rows += [("PM", "m/s", *row) for row in (("b", 7, -7, 5, -5), ("a", 6, -4, 8, -6))]
    names = ["objective", "unit", "parameter"]
    names += ["upward_at_worst", "downward_at_worst"]
    names += ["upward_at_nominal", "downward_at_nominal"]
    frame = pd.DataFrame(rows, columns=names).assign(at_worst=["M", "m", "", "M"])
    figure = tornado_figure(frame)
    for axes, objective in zip(figure.axes, ("L1", "PM"), strict=True):
        mine = frame[frame["objective"] == objective]
        assert axes.get_title("right") == objective
        assert axes.get_xlabel() == mine["unit"].iloc[0]
        wide, _, narrow, _ = axes.containers
        for bars, column in zip(axes.containers, names[3:], strict=True):
            way, _, at = column.split("_")
            label = bars.get_label()
            assert label.startswith(f"{way}, ")
            assert label.endswith(at.replace("worst", "case"))
            assert [bar.get_width() for bar in bars] == mine[column].tolist()
        assert wide[0].get_height() > narrow[0].get_height()
        labels = [text.get_text().split() for text in axes.get_yticklabels()]
        assert labels == [
            [name, mark] if mark else [name]
            for name, mark in zip(mine["parameter"], mine["at_worst"], strict=True)
        ]
        assert axes.yaxis_inverted()  # the largest on top


def smallest(**values):
    points = {"p_AoCa_A": (0.0,) * 3, "p_BoCb_B": (0.0,) * 3}
    return Clearance(first="one", second="two", **values, **points)


def test_clearances():
    time = np.linspace(0.0, 2.0, 21)
    moved, distances = 0.3 * time, 0.05 + 0.02 * (time - 1.0) ** 2
    found = smallest(minimum=0.05, time=1.0)
    figure = clearance_figure(time, {"one to two": Curve(moved, distances, found)})
    for axes, x, label, at in zip(
        figure.axes,
        (time, MM * moved),
        ("time (s)", "separation (mm)"),
        (1.0, 300.0),
        strict=True,
    ):
        curve, dot = axes.get_lines()
        assert axes.get_xlabel() == label
        assert curve.get_xdata() == pytest.approx(x)
        assert curve.get_ydata() == pytest.approx(MM * distances)
        assert [*dot.get_xdata(), *dot.get_ydata()] == pytest.approx([at, 50.0])
    assert figure.axes[0].get_ylabel() == "distance (mm)"


def test_approaches():
    x = np.linspace(0.0, 0.4, 9)
    distances = 0.08 + (x - 0.2) ** 2
    one = Approach("clearance", "worst", "one to two", x, distances)
    required = (
        Requirement(metric="clearance", sense=">=", limit=0.03, id="UM-7"),
        Requirement(metric="clearance", sense=">", limit=0.0),
        Requirement(metric="clearance_to", sense=">=", limit=0.05),  # of another
    )
    figure = approaches_figure([one], required)
    [axes] = figure.axes
    curve, dot, limit, contact = axes.get_lines()
    assert curve.get_xdata() == pytest.approx(MM * x)
    assert curve.get_ydata() == pytest.approx(MM * distances)
    assert [*dot.get_xdata(), *dot.get_ydata()] == pytest.approx([200.0, 80.0])
    assert list(limit.get_ydata()) == [30.0, 30.0]
    assert list(contact.get_ydata()) == [0.0, 0.0]
    assert limit.get_label() == "UM-7: ≥ 30 mm"
    assert contact.get_label() == "no contact"
    assert curve.get_label() == "worst: one to two, 80.00 mm"


BALL = Part(name="ball", shape=Sphere(radius=0.07), p_BoGo_B=(0.1, -0.05, 0.2))
POST = Part(
    name="post",
    shape=Box(size=(0.1, 0.2, 0.3)),
    p_BoGo_B=(0.3, -0.2, 0.1),
    rpy_BG=(0.0, 0.0, 0.5),
)


@pytest.fixture(scope="module")
def tumbling():
    motion = Tumbling(1, distance=2.0)
    return motion, run_of(motion.trajectory(np.linspace(0.0, 1.0, 401)), [POST], [BALL])


def test_swept():
    """The ball as it is at first, and that is filled where it comes by; the post."""
    time = np.linspace(0.0, 1.0, 201)
    place = np.stack([1.5 * time - 0.8, 0.1 + 0.0 * time, 0.05 + 0.0 * time], axis=1)
    moving = trajectory(
        time,
        place,
        np.tile([1.5, 0.0, 0.0], (len(time), 1)),
        angle=0.6 + 0.8 * time,
        rate=np.full(len(time), 0.8),
        axis=(0.0, 0.0, 1.0),
    )
    run = run_of(moving, [POST], [BALL])
    figure = swept_figure(run, run.separation.pairs[0], [("post", "ball")])
    turns = np.outer(0.6 + 0.8 * time, [0.0, 0.0, 1.0])
    turned = Rotation.from_rotvec(turns).apply(BALL.p_BoGo_B)
    start, *_, later = MM * (turned + place)[:100]  # well before it is clear
    views = (("x", 0, "z", 2), ("x", 0, "y", 1), ("y", 1, "z", 2))
    for axes, (across, i, up, j) in zip(figure.axes, views, strict=True):
        assert (axes.get_xlabel(), axes.get_ylabel()) == (
            f"{across} (mm)",
            f"{up} (mm)",
        )
        [outline] = axes.get_lines()
        points = np.stack(outline.get_data(), axis=1)
        from_centre = np.linalg.norm(points - start[[i, j]], axis=1)
        assert from_centre == pytest.approx(np.full(len(points), 70.0), abs=1e-6)
        swept, stays = axes.patches
        for centre in (start, later):
            assert swept.get_path().contains_point(centre[[i, j]])
        # Its post, turned about z, stands where it is in A.
        corners = [
            (x, y, z) for x in (-50, 50) for y in (-100, 100) for z in (-150, 150)
        ]
        corners = Rotation.from_euler("z", 0.5).apply(corners)
        corners += np.array([300.0, -200.0, 100.0])
        drawn = stays.get_path().vertices
        for k, axis in enumerate((i, j)):
            assert drawn[:, k].min() == pytest.approx(corners[:, axis].min(), abs=1e-6)
            assert drawn[:, k].max() == pytest.approx(corners[:, axis].max(), abs=1e-6)


class Noted:
    """In place of a recording: what is drawn, and where it is put at which frame."""

    def __init__(self, frames_per_second):
        self.frames, self.drawn, self.places, self.bars = frames_per_second, [], [], []
        made.append(self)

    def look_at(self, centre, size):
        self.centre, self.size = centre, size

    def draw(self, root, separation):
        self.drawn.append((root, separation))

    def place(self, path, pose, at):
        self.places.append((path, pose, at))

    def place_bar(self, root, ends, at):
        self.bars.append((root, ends, at))

    def page(self):
        return "<html><title>Drake MeshCat</title><body></body></html>"


made: list[Noted] = []


def test_frames_of_an_animation(tumbling, monkeypatch):
    """B is where it is in A at the time that is told, and the bar spans the gap."""
    motion, run = tumbling
    monkeypatch.setattr(animations, "Recording", Noted)
    names = {a.name: a.spring.name for a in run.separation.attachments}
    run = dataclasses.replace(  # slow while springs push
        run,
        releases=dict.fromkeys(names, 0.0),
        stroke_ends=dict.fromkeys(names.values(), 0.1),
    )
    page = animations.animation({"first": run, "second": run}, title="Of both")
    recording = made.pop()
    assert [root for root, _ in recording.drawn] == ["/runs/0", "/runs/1"]
    assert "<title>Of both</title>" in page
    shown = json.loads(re.search(r"const runs = (\[.*?\]), frames = (\d+)", page)[1])
    assert [one["label"] for one in shown] == ["first", "second"]
    frames = len(shown[0]["time"])
    for i, one in enumerate(shown):
        times = np.array(one["time"])
        mine = [p for p in recording.places if p[0].startswith(f"/runs/{i}")]
        assert {path for path, _, _ in mine} == {f"/runs/{i}/upper"}
        assert [at for _, _, at in mine] == pytest.approx(
            np.arange(frames) / recording.frames
        )
        # Times are told to a microsecond, in which it moves by as many micrometres.
        assert np.array([pose.p_AoBo_A for _, pose, _ in mine]) == pytest.approx(
            motion.place(times), abs=2e-5
        )
        turned = motion.turn(times).as_matrix()
        assert np.array([pose.R_AB for _, pose, _ in mine]) == pytest.approx(
            turned, abs=2e-5
        )
        bars = [ends for root, ends, _ in recording.bars if root == f"/runs/{i}"]
        lengths = [MM * np.linalg.norm(b - a) for a, b in bars]
        # To four decimals of a millimetre, by Drake to micrometres.
        assert lengths == pytest.approx(one["distance"], abs=0.01)
        balls = motion.points(times, np.array(BALL.p_BoGo_B))
        surface = [np.linalg.norm(b - c) for (_, b), c in zip(bars, balls, strict=True)]
        assert surface == pytest.approx(np.full(frames, 0.07), abs=1e-4)
        assert set(one["pair"]) == {"post to ball"}


def test_colours_of_bodies():
    """None has that of the first; through what several leave, all are seen."""
    rideshare = load_case("rideshare").separation
    first, *others = rideshare.bodies

    def colour(body, separation=rideshare):
        return colour_of(body.parts[0], body, separation)

    assert colour(first)[3] < 1.0
    assert {colour(body)[3] for body in others} == {1.0}
    assert colour(first)[:3] not in {colour(body)[:3] for body in others}
    alone = dataclasses.replace(rideshare, others=())
    assert colour(first, alone)[3] == 1.0


def test_ten_bodies_are_told_apart():
    """By a fifth of the range of a primary at least, also from nearest points' red."""
    bodies = load_case("rideshare").separation.bodies
    separation = load_case("rideshare").separation
    colours = [colour_of(body.parts[0], body, separation)[:3] for body in bodies]
    colours.append((0.84, 0.1, 0.1))
    assert len(colours) == 12
    for a, b in itertools.combinations(colours, 2):
        assert max(abs(x - y) for x, y in zip(a, b, strict=True)) >= 0.2, (a, b)


@pytest.mark.parametrize(
    ("shape", "axis"),
    [
        (Box(size=(0.1, 0.2, 0.3)), (0.0, 0.0, 1.0)),
        (Sphere(radius=0.1), (0.0, 0.0, 1.0)),
        (Capsule(radius=0.1, length=0.4), (1.0, 0.0, 0.0)),  # along x, Drake's along z
        (Cone(radius_aft=0.3, radius_fore=0.1, length=0.4), (1.0, 0.0, 0.0)),
    ],
)
def test_where_a_part_is_drawn(shape, axis):
    rpy, place = (0.4, -0.7, 1.1), (0.3, -0.2, 0.1)
    part = Part(name="part", shape=shape, p_BoGo_B=place, rpy_BG=rpy)
    _, X_BG = illustration_of(part)
    R = Rotation.from_euler("xyz", rpy)
    assert X_BG.translation() == pytest.approx(place)
    drawn = X_BG.rotation().matrix() @ [0.0, 0.0, 1.0]
    assert drawn == pytest.approx(R.apply(axis), abs=1e-12)
