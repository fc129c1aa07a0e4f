"""What is asked where a table gets one more row: a tolerance, a requirement."""

from collections.abc import Callable

from nicegui import ui

from drakesep.page import case_edit, elements
from drakesep.page.workspace import Workspace


def ask(workspace: Workspace, table: str) -> None:
    """Ask for a new row of a table, and add it."""
    {"dispersions": _tolerance, "requirements": _requirement}[table](workspace)


def _tolerance(workspace: Workspace) -> None:
    with ui.dialog(value=True) as dialog, ui.card().classes("dialog"):
        ui.label("A parameter with a tolerance").classes("dialog-title")
        name = ui.select(
            case_edit.parameters_left(workspace.case),
            label="parameter",
            with_input=True,
        ).props("autofocus outlined dense")
        size = ui.input("tolerance: a number, or a share such as 5 %")
        size.props("outlined dense")

        def add() -> str:
            return case_edit.with_tolerance(
                workspace.text, str(name.value), str(size.value)
            )

        size.on("keydown.enter", lambda: _done(workspace, dialog, add))
        _buttons(workspace, dialog, add)


def _requirement(workspace: Workspace) -> None:
    with ui.dialog(value=True) as dialog, ui.card().classes("dialog"):
        ui.label("A requirement").classes("dialog-title")
        quantity = ui.select(
            case_edit.quantities(), label="quantity", with_input=True
        ).props("autofocus outlined dense")
        when = ui.select(
            ["", *case_edit.moments()], label="when; the whole run if empty", value=""
        ).props("outlined dense")
        with ui.row().classes("dialog-row"):
            least = ui.input("at least").props("outlined dense")
            most = ui.input("at most; [x, y, z] of a vector").props("outlined dense")

        def add() -> str:
            return case_edit.with_requirement(
                workspace.text,
                quantity=str(quantity.value),
                when=str(when.value),
                at_least=str(least.value),
                at_most=str(most.value),
            )

        _buttons(workspace, dialog, add)


def _buttons(workspace: Workspace, dialog: ui.dialog, add: Callable[[], str]) -> None:
    with ui.row().classes("dialog-buttons"):
        ui.button("Cancel", on_click=dialog.close).props("flat no-caps")
        ui.button("Add", on_click=lambda: _done(workspace, dialog, add)).props(
            "no-caps unelevated"
        )


def _done(workspace: Workspace, dialog: ui.dialog, add: Callable[[], str]) -> None:
    if elements.attempt(lambda: workspace.change(add())):
        dialog.close()
