"""An animation of separations as one HTML file, that a browser plays by itself.

Drake's Meshcat draws the geometry as seen from A. A panel beside it says which run is
shown, the time, and the smallest distance with its pair, which a bar shows too.
Time is stretched while springs push and while bodies are near each other.
"""

import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

import numpy as np

from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.systems.geometry.recording import Recording
from drakesep.systems.geometry.relative_path import RelativePath
from drakesep.systems.model.run import Run


_FRAMES = 30
"""In a second of the animation."""
_PUSH, _NEAR, _REST = 4.0, 5.0, 3.0
"""Seconds of the animation for the push, until bodies are well apart, and after."""


class _Shown(NamedTuple):
    """What the panel says of a run, at each frame."""

    label: str
    time: list[float]
    distance: list[float]
    """mm."""
    pair: list[str]


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
    shown = [
        _animate(recording, f"/runs/{i}", label, run, analysis)
        for i, (label, run) in enumerate(runs.items())
    ]
    return _with_panel(recording.page(), shown, title)


def _animate(
    recording: Recording, root: str, label: str, run: Run, analysis: ClearanceAnalysis
) -> _Shown:
    """Draw a run below a path of its own, and return what is said of it."""
    separation = run.separation
    recording.draw(root, separation)
    others = [body.name for body in separation.bodies if body.name != separation.A]
    trajectory = run.completed_trajectory
    paths = {
        name: RelativePath(trajectory, separation.A, name)
        for name in (separation.A, *others)
    }
    shown = _Shown(label, [], [], [])
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
    return shown


def _times(run: Run) -> list[float]:
    """Return the times of the frames, s."""
    path = RelativePath(run.completed_trajectory, run.separation.A, run.separation.B)
    start = path.at(0.0).p_AoBo_A
    gone = [float(np.linalg.norm(path.at(t).p_AoBo_A - start)) for t in path.time]
    duration = float(path.time[-1])
    push = min(max(run.separation_end, 0.01 * duration), 0.5 * duration)
    # Well apart: a metre and a half.
    apart = next((t for t, x in zip(path.time, gone, strict=True) if x > 1.5), duration)
    near = min(max(float(apart), 1.5 * push), duration)
    shown, ends = [0.0, _PUSH, _NEAR, _REST], [0.0, push, near, duration]
    if near >= duration:  # nothing comes after
        del shown[-1], ends[-1]
    shown = np.cumsum(shown).tolist()
    frames = np.arange(0.0, shown[-1] + 0.5 / _FRAMES, 1.0 / _FRAMES)
    times = np.interp(frames, shown, ends)
    return [float(t) for t in times]


# The panel.


def _with_panel(page: str, shown: Sequence[_Shown], title: str) -> str:
    """Return Meshcat's page with a panel that follows its animation."""
    data = [one._asdict() for one in shown]
    options = "".join(
        f'<option value="{i}">{escape(one.label)}</option>'
        for i, one in enumerate(shown)
    )
    panel = (
        _PANEL.replace("@TITLE@", escape(title))
        .replace("@OPTIONS@", options)
        .replace("@RUNS@", json.dumps(data).replace("</", "<\\/"))
        .replace("@FRAMES@", str(_FRAMES))
    )
    head, body, tail = page.rpartition("</body>")
    return head.replace(
        "<title>Drake MeshCat</title>", f"<title>{escape(title)}</title>"
    ) + (panel + body + tail)


_PANEL = """
<div id="drakesep" style="position: fixed; left: 16px; top: 16px; padding: 12px 16px;
  background: rgba(255, 255, 255, 0.9); border: 1px solid #bbb; border-radius: 6px;
  font: 15px/1.5 sans-serif; color: #222; min-width: 19em">
  <b>@TITLE@</b><br>
  run <select id="drakesep-run">@OPTIONS@</select><br>
  time <b id="drakesep-time"></b> s, <span id="drakesep-speed"></span><br>
  nearest <b id="drakesep-distance"></b> mm<br>
  <span id="drakesep-pair"></span><br>
  <small>smallest of the frames <span id="drakesep-least"></span></small>
</div>
<script>
(function () {
  const runs = @RUNS@, frames = @FRAMES@;
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
    requestAnimationFrame(follow);
  }
  choose.addEventListener("change", show);
  show();
  follow();
})();
</script>
"""
