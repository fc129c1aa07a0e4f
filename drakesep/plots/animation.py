"""An animation of separations as one HTML file, that a browser plays by itself.

Drake's Meshcat draws the geometry as seen from A, each body with its name. A panel
beside it says which run is shown, the time, and the smallest distance with its pair,
which a bar shows too. Time is stretched while springs push and while bodies are near
each other; the camera draws back as they leave.
"""

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.systems.arrays import Array
from drakesep.systems.geometry.bounding_tree import (
    support_point,
    tree_of,
)
from drakesep.systems.geometry.recording import Recording
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Body
from drakesep.systems.vectors import quaternion, rotation_matrix


_FRAMES = 30
"""In a second of the animation."""
_PUSH, _NEAR, _REST = 4.0, 5.0, 3.0
"""Seconds of the animation for a push, for bodies until they are well apart, and for
the rest."""
_MOST_PUSHES = 3
"""That are given as many seconds; more share them."""
_WELL_APART = 1.5
"""m."""
_ROOM = 1.5
"""Radius that the camera sees at first, in radii of the mated stack."""
_FARTHEST = 6.0
"""Times as far as at first, at most, that the camera draws back."""


class _Shown(NamedTuple):
    """What the panel says of a run, at each frame."""

    label: str
    time: list[float]
    distance: list[float]
    """mm."""
    pair: list[str]
    far: list[float]
    """How far the camera is, over the distance at first."""


class _Body(NamedTuple):
    """A body as its name follows it."""

    name: str
    centre: list[float]
    """(3,) of its parts, in the body, m."""
    radius: float
    """Of a sphere about that, which holds them, m."""


def animation(
    runs: Mapping[str, Run],
    pairs: Sequence[Sequence[str]] | None = None,
    *,
    touching: Sequence[Sequence[str]] = (),
    title: str = "",
) -> str:
    """Return an HTML page that animates completed runs of one separation.

    Args:
        runs: by their labels; the first is shown first.
        pairs: parts that are measured; all of different bodies if None.
        touching: those that touch while mated.
        title: of the page.

    Raises:
        ValueError: two bodies have no geometry.
        RuntimeError: a run failed.
    """
    separation = next(iter(runs.values())).separation
    analysis = ClearanceAnalysis(separation, pairs, touching=touching)
    recording = Recording(_FRAMES)
    least, most = _extent(separation.bodies, mated=True)
    centre, size = 0.5 * (least + most), float(np.linalg.norm(most - least))
    recording.look_at(centre, size)
    bodies = [_drawn(body) for body in separation.bodies if body.parts]
    shown = []
    for i, (label, run) in enumerate(runs.items()):
        one, reach = _animate(recording, f"/runs/{i}", label, run, analysis, centre)
        far = np.maximum.accumulate(reach) / (_ROOM * 0.5 * size)
        one.far.extend(np.clip(far, 1.0, _FARTHEST).round(4).tolist())
        shown.append(one)
    return _with_panel(recording.page(), shown, bodies, title)


def _drawn(body: Body) -> _Body:
    least, most = _extent([body], mated=False)
    centre = (0.5 * (least + most)).round(6).tolist()
    return _Body(body.name, centre, 0.5 * float(np.linalg.norm(most - least)))


def _animate(
    recording: Recording,
    root: str,
    label: str,
    run: Run,
    analysis: ClearanceAnalysis,
    about: Array,
) -> tuple[_Shown, list[float]]:
    """Draw a run below a path of its own.

    Returns:
        What is said of it; and how far from a point (3,), in A, all is that is drawn,
        at each frame, m.
    """
    separation = run.separation
    drawn = [_drawn(body) for body in separation.bodies if body.parts]
    recording.draw(root, separation)
    others = [body.name for body in separation.bodies if body.name != separation.A]
    trajectory = run.completed_trajectory
    paths = {
        name: RelativePath(trajectory, separation.A, name)
        for name in (separation.A, *others)
    }
    shown, reach = _Shown(label, [], [], [], []), []
    times = _times(run)
    for frame, (t, found) in enumerate(
        zip(times, analysis.nearest(run, times), strict=True)
    ):
        at = frame / _FRAMES
        poses = {name: path.at(t) for name, path in paths.items()}
        for name in others:
            recording.place(f"{root}/{name}", poses[name], at)
        points = (found.nearest.p_AoCa_A, found.nearest.p_BoCb_B)
        ends = [
            poses[body].R_AB @ point + poses[body].p_AoBo_A
            for body, point in zip(found.bodies, points, strict=True)
        ]
        recording.place_bar(root, ends, at)
        shown.time.append(round(t, 6))
        shown.distance.append(round(1e3 * found.nearest.distance, 4))
        shown.pair.append(" to ".join(found.names))
        ends_of = [
            (poses[one.name].R_AB @ one.centre + poses[one.name].p_AoBo_A, one.radius)
            for one in drawn
        ]
        reach.append(max(float(np.linalg.norm(p - about)) + r for p, r in ends_of))
    return shown, reach


def _extent(bodies: Sequence[Body], *, mated: bool) -> tuple[Array, Array]:
    """Return the least and the largest coordinates (3,) of all parts of bodies, m.

    Args:
        bodies: some of which have parts.
        mated: whether in A, as they are mated; else each in its own axes.
    """
    extents = []
    for body in bodies:
        R, p = np.eye(3), np.zeros(3)
        if mated:
            R = np.array(rotation_matrix(quaternion(body.rpy_AB, math))).reshape(3, 3)
            p = np.array(body.p_ABo)
        for leaf in (x for part in body.parts for x in tree_of(part).leaves):
            points = [
                R @ support_point(leaf, R.T @ n) for n in (*np.eye(3), *-np.eye(3))
            ]
            extents += [point + p for point in points]
    return np.min(extents, axis=0), np.max(extents, axis=0)


def _times(run: Run) -> list[float]:
    """Return the times of the frames, s: of pushes most, then of bodies that are near.

    A push takes a hundredth of the run at least.
    """
    separation, trajectory = run.separation, run.completed_trajectory
    duration = float(trajectory.time[-1])
    pushes, near = [], []
    for pair in separation.pairs:
        start, end = run.push_of(pair)
        end = max(end, start + 0.01 * duration)
        pushes.append((start, end))
        near.append((end, max(_apart(RelativePath(trajectory, pair.A, pair.B)), end)))
    knots = np.unique(np.clip([0.0, duration, *sum(pushes + near, ())], 0.0, duration))
    lengths = np.diff(knots)
    pushing = _within(pushes, knots)
    close = _within(near, knots) & np.logical_not(pushing)
    begun = np.diff(np.append(0, pushing.astype(int))) > 0
    several = min(int(begun.sum()), _MOST_PUSHES)
    shown = np.zeros(len(lengths))
    for stretches, seconds in (
        (pushing, _PUSH * several),
        (close, _NEAR),
        (np.logical_not(pushing | close), _REST),
    ):
        if stretches.any():
            shown[stretches] = seconds * lengths[stretches] / lengths[stretches].sum()
    ends = np.append(0.0, np.cumsum(shown))
    frames = np.arange(0.0, ends[-1] + 0.5 / _FRAMES, 1.0 / _FRAMES)
    return [float(t) for t in np.interp(frames, ends, knots)]


def _apart(path: RelativePath) -> float:
    """Return when a body is well apart, s: a metre and a half; or the end."""
    _, places = path.places(path.time)
    gone = np.linalg.norm(places - places[0], axis=1) > _WELL_APART
    return float(path.time[gone.argmax() if gone.any() else -1])


def _within(spans: Sequence[tuple[float, float]], knots: Array) -> NDArray[np.bool_]:
    """Return which stretches between knots lie within a span."""
    middle = 0.5 * (knots[:-1] + knots[1:])
    within = [(start < middle) & (middle < end) for start, end in spans]
    flags: NDArray[np.bool_] = np.any(within, axis=0)
    return flags


# The panel.


def _with_panel(
    page: str, shown: Sequence[_Shown], bodies: Sequence[_Body], title: str
) -> str:
    """Return Meshcat's page with a panel and names that follow its animation."""
    data = [one._asdict() for one in shown]
    options = "".join(
        f'<option value="{i}">{escape(one.label)}</option>'
        for i, one in enumerate(shown)
    )
    panel = (
        _PANEL.replace("@TITLE@", escape(title))
        .replace("@OPTIONS@", options)
        .replace("@RUNS@", _in_script(data))
        .replace("@BODIES@", _in_script([one._asdict() for one in bodies]))
        .replace("@FRAMES@", str(_FRAMES))
    )
    head, body, tail = page.rpartition("</body>")
    return head.replace(
        "<title>Drake MeshCat</title>", f"<title>{escape(title)}</title>"
    ) + (panel + body + tail)


def _in_script(data: object) -> str:
    return json.dumps(data).replace("</", "<\\/")


_PANEL = """
<div id="drakesep" style="position: fixed; left: 16px; top: 16px; padding: 12px 16px;
  background: rgba(255, 255, 255, 0.9); border: 1px solid #bbb; border-radius: 6px;
  font: 15px/1.5 sans-serif; color: #222; min-width: 19em">
  <b>@TITLE@</b><br>
  run <select id="drakesep-run">@OPTIONS@</select><br>
  time <b id="drakesep-time"></b> s, <span id="drakesep-speed"></span><br>
  nearest <b id="drakesep-distance"></b> mm<br>
  <span id="drakesep-pair"></span><br>
  <small>smallest of the frames <span id="drakesep-least"></span></small><br>
  <label><input type="checkbox" id="drakesep-named" checked> names of bodies</label>
</div>
<div id="drakesep-names" style="position: fixed; inset: 0; overflow: hidden;
  pointer-events: none; font: 13px/1.2 sans-serif; color: #222"></div>
<script>
(function () {
  const runs = @RUNS@, frames = @FRAMES@, bodies = @BODIES@;
  const find = (name) => document.getElementById("drakesep-" + name);
  const choose = find("run");
  function show() {
    for (let i = 0; i < runs.length; i++) {
      viewer.set_property(["runs", String(i)], "visible", String(i) === choose.value);
    }
    const run = runs[choose.value], least = Math.min(...run.distance);
    const k = run.distance.indexOf(least);
    find("least").textContent =
      least.toFixed(1) + " mm at " + run.time[k].toFixed(3) + " s, " + run.pair[k];
  }
  function follow() {
    const run = runs[choose.value], last = run.time.length - 1;
    const k = Math.max(0, Math.min(last, Math.round(viewer.animator.time * frames)));
    const j = Math.min(k, last - 1), step = run.time[j + 1] - run.time[j];
    find("time").textContent = run.time[k].toFixed(3);
    find("speed").textContent = "shown at 1/" + (1 / (step * frames)).toPrecision(2);
    find("distance").textContent = run.distance[k].toFixed(1);
    find("pair").textContent = run.pair[k];
    drawBack(run.far[k]);
    nameBodies();
    requestAnimationFrame(follow);
  }
  let far = 1.0;
  function drawBack(now) {  // about what is looked at, wherever it was turned to
    if (now === far) return;
    const target = viewer.controls.target;
    viewer.camera.position.sub(target).multiplyScalar(now / far).add(target);
    far = now;
    viewer.set_dirty();
  }
  const names = bodies.map((body) => {
    const name = document.createElement("span");
    name.textContent = body.name;
    name.style.cssText = "position: absolute; transform: translate(-50%, -50%);" +
      "padding: 0 3px; border-radius: 3px; background: rgba(255, 255, 255, 0.7)";
    find("names").appendChild(name);
    return name;
  });
  function nameBodies() {
    find("names").style.display = find("named").checked ? "" : "none";
    bodies.forEach((body, i) => {
      const drawn = viewer.scene_tree.find(["runs", choose.value, body.name]).object;
      const at = new drawn.position.constructor(...body.centre);
      drawn.localToWorld(at).project(viewer.camera);
      names[i].style.visibility = at.z < 1.0 ? "visible" : "hidden";
      names[i].style.left = 50 * (1 + at.x) + "%";
      names[i].style.top = 50 * (1 - at.y) + "%";
    });
  }
  choose.addEventListener("change", show);
  show();
  follow();
})();
</script>
"""
