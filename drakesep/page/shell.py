"""The frame of the page: a header with the case, tabs, and what they show.

A page has an address of its own, `/1`, `/2` and so on: to load it again shows the same
case with the same changes. Each tab is a module with one function, `build(workspace)`,
which is called when the tab is shown for the first time, within the element that it
fills.
"""

from collections.abc import Callable
from pathlib import Path

from fastapi.responses import RedirectResponse
from nicegui import app, context, ui

from drakesep.page import (
    campaign_view,
    case_files,
    case_view,
    elements,
    play_view,
    results_view,
    search_view,
)
from drakesep.page.workspace import Workspace
from drakesep.page.workspaces import Workspaces


TABS: dict[str, Callable[[Workspace], None]] = {
    "Case": case_view.build,
    "Play": play_view.build,
    "Search": search_view.build,
    "Campaign": campaign_view.build,
    "Results": results_view.build,
}
"""What each tab shows."""
_LATER = 1.0
"""After which what flies is started, s: the page comes first."""
_STYLE = Path(__file__).with_name("style.css")
_COLOURS = {"primary": "#0b62a4", "positive": "#00835c", "negative": "#b3261e"}


def add_pages(case: str | None, results: Path) -> None:
    """Make the pages known to the server.

    Args:
        case: that a new page opens; a new one if None.
        results: folder with results.
    """
    workspaces = Workspaces(case, results)

    def begin() -> RedirectResponse:
        return RedirectResponse(f"/{workspaces.begin()}", status_code=303)

    def show(key: str) -> RedirectResponse | None:
        place = workspaces.get(key)
        if place is None:
            return RedirectResponse("/", status_code=303)
        if wrong := place.open():
            elements.say_wrong(wrong)
        _build(place.workspace)
        place.enter()
        context.client.on_delete(lambda: workspaces.leave(key))
        return None

    app.on_shutdown(workspaces.rest)
    ui.page("/")(begin)
    ui.page("/{key}")(show)


def _build(workspace: Workspace) -> None:
    ui.colors(**_COLOURS)
    ui.add_head_html(f"<style>{_STYLE.read_text(encoding='utf-8')}</style>")
    dark = ui.dark_mode(value=workspace.dark)
    built: set[str] = set()
    panels: dict[str, ui.element] = {}

    def show(name: str) -> None:
        workspace.tab = name
        workspace.looks.tell()
        for other, panel in panels.items():
            panel.set_visibility(other == name)
        if name not in built:
            built.add(name)
            with panels[name]:
                TABS[name](workspace)

    with ui.header(elevated=False).classes("page-header"):
        ui.label("drakesep").classes("page-mark")
        with ui.tabs(value=workspace.tab, on_change=lambda e: show(e.value)) as tabs:
            tabs.props("dense no-caps inline-label shrink")
            for name in TABS:
                ui.tab(name)
        ui.space()
        case_files.build(workspace)
        _theme_button(workspace, dark)
    with ui.element("main").classes("page-main"):
        for name in TABS:
            panels[name] = ui.element("section").classes("page-panel")
            panels[name].props(f'role="tabpanel" aria-label="{name}"')
            panels[name].set_visibility(False)
    elements.title(workspace)
    show(workspace.tab)
    ui.timer(_LATER, workspace.flights.start, once=True)


def _theme_button(workspace: Workspace, dark: ui.dark_mode) -> None:
    """Let the page be light or dark; at first it is as the browser's user has it."""

    def turn(is_dark: bool) -> None:
        workspace.dark = is_dark
        dark.set_value(is_dark)
        workspace.looks.tell()

    if workspace.dark is None:
        ui.on("drakesep-dark", lambda event: turn(bool(event.args)))
        ui.run_javascript('emitEvent("drakesep-dark", Quasar.Dark.isActive)')
    button = ui.button(
        icon="contrast", color=None, on_click=lambda: turn(not workspace.dark)
    )
    button.props("flat dense round aria-label='Light or dark'").tooltip("Light or dark")
