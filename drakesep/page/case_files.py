"""The case in the header: its name, whether it is saved and right; open, save, undo."""

import os
from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from drakesep.case_file.reader import builtin_cases
from drakesep.page import elements
from drakesep.page.workspace import ChangedMeanwhile, Workspace


_MOST_LISTED = 200
"""Case files of the folder that are listed."""


def build(workspace: Workspace) -> None:
    """Fill the header's part of the case."""
    with ui.element("div").classes("case-name"):
        name = ui.label().classes("case-name-words")
        state = ui.label().classes("case-state")
    undo = _button("undo", "Undo (Ctrl Z)", workspace.undo)
    redo = _button("redo", "Redo (Ctrl Shift Z)", workspace.redo)
    _button("folder_open", "Open (Ctrl O)", lambda: _open(workspace))
    save = _button("save", "Save (Ctrl S)", lambda: _save(workspace))

    def show() -> None:
        name.set_text(workspace.name)
        wrong = len(workspace.problems)
        words = "not saved" if not workspace.is_saved else _where(workspace)
        state.set_text(f"{wrong} wrong" if wrong else words)
        state.classes(add="wrong" if wrong else "", remove="" if wrong else "wrong")
        undo.set_enabled(workspace.can_undo)
        redo.set_enabled(workspace.can_redo)
        save.set_enabled(not workspace.is_saved or workspace.path is None)

    elements.follow(workspace.changes, show)
    _keys(workspace)


def _where(workspace: Workspace) -> str:
    if workspace.path is None:
        return "built in" if workspace.is_builtin else "new, not saved"
    return workspace.path.name


def _button(icon: str, words: str, action: Callable[[], None]) -> ui.button:
    button = ui.button(icon=icon, on_click=action, color=None).props("flat dense round")
    button.props(f'aria-label="{words}"').tooltip(words)
    return button


def _keys(workspace: Workspace) -> None:
    """Let the keys of a desktop do what they do there.

    In a field undo is the field's own.
    """
    ui.add_body_html(_SCRIPT)
    actions: dict[str, Callable[[], None]] = {
        "undo": workspace.undo,
        "redo": workspace.redo,
        "open": lambda: _open(workspace),
        "save": lambda: _save(workspace),
    }
    ui.on("drakesep-key", lambda event: actions[event.args]())


_SCRIPT = """<script>
document.addEventListener("keydown", (e) => {
  if (!(e.ctrlKey || e.metaKey) || e.altKey) return;
  const typing = e.target.closest?.("input, textarea, [contenteditable=true]");
  const key = e.key.toLowerCase();
  const z = e.shiftKey ? "redo" : "undo";
  const action = {s: "save", o: "open", z, y: "redo"}[key];
  if (!action || (typing && "zy".includes(key))) return;
  e.preventDefault();
  if (document.querySelector(".q-dialog")) return;  // it is to be answered first
  document.activeElement?.blur?.();
  setTimeout(() => emitEvent("drakesep-key", action), 50);
});
</script>"""


def _open(workspace: Workspace) -> None:
    files = _files()
    with elements.dialog("Open a case") as dialog:
        if not workspace.is_saved:
            ui.label(
                f"Changes to {workspace.name} that are not saved are lost."
            ).classes("dialog-warning")
        chosen = ui.input(
            "file, or the name of a built-in case",
            autocomplete=[*builtin_cases(), *files],
        ).props("autofocus outlined dense")

        def go(source: str) -> None:
            if elements.attempt(lambda: workspace.open(os.path.expanduser(source))):
                dialog.close()

        chosen.on("keydown.enter", lambda: go(str(chosen.value)))
        for title, names in (("Built in", [*builtin_cases()]), ("Here", files)):
            if names:
                ui.label(title).classes("dialog-part")
                with ui.element("div").classes("dialog-list"):
                    for each in names:
                        ui.button(each, on_click=lambda _, e=each: go(e)).props(
                            "flat no-caps align=left dense"
                        )
        with ui.row().classes("dialog-buttons"):
            ui.button("New", on_click=lambda: _begin(workspace, dialog)).props(
                "flat no-caps"
            )
            ui.space()
            ui.button("Cancel", on_click=dialog.close).props("flat no-caps")
            ui.button("Open", on_click=lambda: go(str(chosen.value))).props(
                "no-caps unelevated"
            )


def _begin(workspace: Workspace, dialog: ui.dialog) -> None:
    workspace.begin()
    dialog.close()


def _files() -> list[str]:
    """Return the YAML files of the folder where the command was given."""
    found = (path.name for path in sorted(Path.cwd().glob("*.y*ml")))
    return [name for _, name in zip(range(_MOST_LISTED), found, strict=False)]


def _save(workspace: Workspace) -> None:
    if workspace.path is None:
        _save_as(workspace)
        return
    try:
        workspace.save()
    except ChangedMeanwhile as error:
        _ask_to_replace(workspace, workspace.path, str(error))
    except ValueError as error:
        elements.say_wrong(str(error))


def _save_as(workspace: Workspace) -> None:
    with elements.dialog("Save the case as a file") as dialog:
        chosen = ui.input("file", value=f"{workspace.name}.yaml")
        chosen.props("autofocus outlined dense")
        ui.label(f"In {Path.cwd()}").classes("dialog-note")

        def go() -> None:
            path = Path(str(chosen.value)).expanduser()
            try:
                workspace.save(path)
            except ChangedMeanwhile as error:
                dialog.close()
                _ask_to_replace(workspace, path, str(error))
            except ValueError as error:
                elements.say_wrong(str(error))
            else:
                dialog.close()

        chosen.on("keydown.enter", go)
        with ui.row().classes("dialog-buttons"):
            ui.button("Cancel", on_click=dialog.close).props("flat no-caps")
            ui.button("Save", on_click=go).props("no-caps unelevated")


def _ask_to_replace(workspace: Workspace, path: Path, why: str) -> None:
    """Ask what to do with a file that somebody else has written."""
    with elements.dialog("The file is another") as dialog:
        ui.label(f"{why}. What is in it would be lost.")

        def replace() -> None:
            dialog.close()
            elements.attempt(lambda: workspace.save(path, replaces=True))

        def other() -> None:
            dialog.close()
            _save_as(workspace)

        with ui.row().classes("dialog-buttons"):
            ui.button("Cancel", on_click=dialog.close).props("flat no-caps autofocus")
            ui.button("Save as another", on_click=other).props("flat no-caps")
            ui.button("Replace it", on_click=replace, color="negative").props(
                "no-caps unelevated"
            )
