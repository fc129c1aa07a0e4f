"""The tab Case: tables that are edited, the YAML beside them, the stack in 3-D."""

from nicegui import ui

from drakesep.page import adding, case_edit, elements
from drakesep.page.stack_view import StackView
from drakesep.page.tables import Tables
from drakesep.page.workspace import Workspace
from drakesep.page.yaml_edit import Path, YamlText
from drakesep.systems.checks import InputError


_LATER = 0.4
"""After which what is typed into the YAML is read, s."""


def build(workspace: Workspace) -> None:
    """Fill the tab."""
    with ui.element("div").classes("case"):
        with ui.element("div").classes("case-tables"):
            _problems(workspace)
            _tables(workspace)
        with ui.element("div").classes("case-side"):
            with ui.element("div").classes("case-stack"):
                StackView(workspace)
            with ui.element("div").classes("case-text"):
                _yaml(workspace)


def _problems(workspace: Workspace) -> None:
    """Say what is wrong with the case, a line for each mistake."""
    told = ui.element("div").classes("problems").props('role="alert"')

    def show() -> None:
        told.clear()
        told.set_visibility(bool(workspace.problems))
        with told:
            for line in workspace.problems:
                ui.label(line)

    elements.follow(workspace.changes, show)


def _tables(workspace: Workspace) -> None:
    def edit(path: Path, typed: str) -> None:
        workspace.change(case_edit.changed(workspace.text, path, typed))

    def remove(path: Path) -> None:
        elements.attempt(
            lambda: workspace.change(case_edit.without(workspace.text, path))
        )

    def add(table: str) -> None:
        adding.ask(workspace, table)

    tables = Tables(edit, add, remove)

    def show() -> None:
        try:
            text = YamlText(workspace.text)
        except InputError:  # the tables stay as they were
            tables.classes(add="stale")
            return
        tables.classes(remove="stale")
        tables.show(case_edit.tables(text, workspace.case, workspace.problems))

    elements.follow(workspace.changes, show)


def _yaml(workspace: Workspace) -> None:
    editor = ui.codemirror(language="YAML", indent="  ").classes("yaml")
    editor.props('aria-label="The case as YAML"')

    def show() -> None:
        if editor.value != workspace.text:
            editor.set_value(workspace.text)

    def look() -> None:
        editor.set_theme("githubDark" if workspace.dark else "githubLight")

    # Typing sends each change; it is read when there is a pause, or at once when the
    # editor is left: for a button that is pressed, or to be saved.
    def read() -> None:
        pause.deactivate()
        workspace.change(editor.value)

    pause = ui.timer(_LATER, read, active=False)

    def typed() -> None:
        pause.deactivate()
        if editor.value != workspace.text:
            pause.activate()

    editor.on_value_change(typed)
    editor.on("focusout", read)
    elements.follow(workspace.changes, show)
    elements.follow(workspace.looks, look)
