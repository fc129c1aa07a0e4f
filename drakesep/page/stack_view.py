"""The mated stack in 3-D: parts, pads, springs, axes, centres of mass."""

from typing import Any

from nicegui import ui

from drakesep.page import elements
from drakesep.page.stack import Solid, Stack, stack_of
from drakesep.page.workspace import Workspace
from drakesep.systems.checks import InputError
from drakesep.systems.vectors import Vector, rotation_matrix


_PAD, _SPRING, _CENTRE = "#d81e3a", "#00a878", "#d99000"
_AXES = {"x": "#d0312d", "y": "#2e8b57", "z": "#2565ae"}
_SIDES = 48
"""Of what is round."""
_THROUGH = 0.6
"""Opacity of parts, at most: pads and springs are among them."""
_FROM = (-0.66, -0.74, 0.52)
"""Where the camera stands, for what has a radius of a metre, m."""
_SHOWN, _HIDDEN = 15, 1
"""Pictures in a second."""
_BEGIN = """(() => {
  const view = getElement(%d);
  view.renderer.setClearColor(0, 0);
  new ResizeObserver(() => {
    if (!view.$el.clientWidth) return;
    view.resize();
    view.camera.zoom = Math.min(1, view.camera.aspect);
    view.camera.updateProjectionMatrix();
  }).observe(view.$el);
})()"""
"""The ground of the page is seen through it. It is as large as its place, also after
the window became another while another tab was shown; a narrow one shows all."""
_BEFORE = "as it was before what is wrong now"
_NONE_YET = "drawn once the case is right"


class StackView:
    """Draws the stack of a workspace's case, and again when that changes."""

    def __init__(self, workspace: Workspace):
        self._workspace = workspace
        self._drawn: Any = None
        with ui.element("div").classes("stack"):
            self._scene = ui.scene(
                width=600,
                height=400,
                grid=False,
                background_color="#ffffff",
                fps=_SHOWN,
            ).classes("stack-scene")
            self._scene.on("init", self._begin)
            self._note = ui.label().classes("stack-note")
            with ui.row().classes("stack-legend"):
                for colour, words in (
                    (_PAD, "pad"),
                    (_SPRING, "spring, its stroke"),
                    (_CENTRE, "centre of mass"),
                ):
                    ui.html(
                        f'<i style="background:{colour}"></i>{words}', sanitize=False
                    )
                ui.label("drag: turn · right drag: move · wheel: nearer")
        elements.follow(workspace.changes, self._draw)
        elements.follow(workspace.looks, self._pace)

    def _begin(self) -> None:
        ui.run_javascript(_BEGIN % self._scene.id)

    def _pace(self) -> None:
        """Draw seldom while nobody looks."""
        fps = _SHOWN if self._workspace.tab == "Case" else _HIDDEN
        if self._scene.props["fps"] != fps:
            self._scene.props["fps"] = fps
            self._scene.update()

    def _draw(self) -> None:
        case = self._workspace.case
        if case is None:
            self._note.set_text(_BEFORE if self._drawn else _NONE_YET)
            return
        self._note.set_text("")
        try:
            stack = stack_of(case.separation)
        except InputError as error:
            self._note.set_text(str(error))
            return
        if stack == self._drawn:
            return
        first, self._drawn = self._drawn is None, stack
        self._scene.clear()
        with self._scene as scene:
            _draw(scene, stack)
        if first:
            self._look_at(stack)

    def _look_at(self, stack: Stack) -> None:
        middle, radius = stack.extent()
        x, y, z = (m + radius * f for m, f in zip(middle, _FROM, strict=True))
        self._scene.move_camera(x, y, z, *middle, duration=0.0)


def _draw(scene: Any, stack: Stack) -> None:
    _, radius = stack.extent()
    for solid in stack.solids:
        drawn = _solid(scene, solid)
        drawn.material(solid.colour, min(solid.opacity, _THROUGH), side="both")
        drawn.move(*solid.place.p_SBo)
        R = rotation_matrix(solid.place.q_SB)
        drawn.rotate_R([list(R[:3]), list(R[3:6]), list(R[6:])])
    for pad in stack.pads:
        scene.sphere(0.012 * radius, 16, 12).material(_PAD).move(*pad)
    for start, end in stack.springs:
        scene.line(list(start), list(end)).material(_SPRING)
        scene.sphere(0.007 * radius, 12, 8).material(_SPRING).move(*end)
    for name, centre in stack.centres.items():
        scene.sphere(0.015 * radius, 16, 12).material(_CENTRE).move(*centre)
        words = scene.text(name.replace("_", " "), "").move(*_above(centre, radius))
        words.with_name(name)
    for i, (axis, colour) in enumerate(_AXES.items()):
        tip = [0.0, 0.0, 0.0]
        tip[i] = 0.45 * radius
        scene.line([0.0, 0.0, 0.0], tip).material(colour)
        scene.text(axis, f"color: {colour}; font-weight: 600").move(*tip)


def _above(point: Vector, radius: float) -> tuple[float, float, float]:
    x, y, z = point
    return x, y, z + 0.06 * radius


def _solid(scene: Any, solid: Solid) -> Any:
    match solid.kind:
        case "box":
            return scene.box(*solid.sizes)
        case "sphere":
            return scene.sphere(*solid.sizes, _SIDES, _SIDES // 2)
        case "cylinder":
            return scene.cylinder(*solid.sizes, _SIDES)
    return scene.stl(solid.mesh).scale(*solid.sizes)
