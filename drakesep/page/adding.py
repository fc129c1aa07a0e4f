"""What is asked where a table gets one more row: a tolerance, a requirement, a body."""

from collections.abc import Callable

from nicegui import ui

from drakesep.page import case_edit, elements
from drakesep.page.workspace import Workspace
from drakesep.systems.checks import InputError


def ask(workspace: Workspace, table: str) -> None:
    """Ask for a new row of a table, and add it."""
    if table == "dispersions":
        _tolerance(workspace)
    elif table == "requirements":
        _requirement(workspace)
    else:
        _another(workspace, table)


def _tolerance(workspace: Workspace) -> None:
    with elements.dialog("A parameter with a tolerance") as dialog:
        name = elements.chosen_by_typing(
            case_edit.parameters_left(workspace.case), "parameter"
        ).props("autofocus")
        size = ui.input("tolerance: a number, or a share such as 5 %")
        size.props("outlined dense")

        def add() -> str:
            parameter = _chosen("parameter", name)
            return case_edit.with_tolerance(workspace.text, parameter, str(size.value))

        size.on("keydown.enter", lambda: _done(workspace, dialog, add))
        _buttons(workspace, dialog, add)


def _another(workspace: Workspace, table: str) -> None:
    rows = case_edit.rows_of(workspace.text, table)
    with elements.dialog("One more, like one that is there") as dialog:
        name = ui.input("name").props("autofocus outlined dense")
        like = ui.select([*rows], label="like", value=[*rows][-1])
        like.props("outlined dense")

        def add() -> str:
            path = rows[_chosen("like", like)]
            return case_edit.with_another(workspace.text, path, str(name.value))

        name.on("keydown.enter", lambda: _done(workspace, dialog, add))
        _buttons(workspace, dialog, add)


def _requirement(workspace: Workspace) -> None:
    with elements.dialog("A requirement") as dialog:
        quantity = elements.chosen_by_typing(case_edit.quantities(), "quantity").props(
            "autofocus"
        )
        when = ui.select(
            ["", *case_edit.moments()], label="when; the whole run if empty", value=""
        ).props("outlined dense")
        with ui.row().classes("dialog-row"):
            least = ui.input("at least").props("outlined dense")
            most = ui.input("at most; [x, y, z] of a vector").props("outlined dense")
        with ui.row().classes("dialog-row"):
            share = ui.input("share of launches; all if empty").props("outlined dense")
            confidence = ui.input("confidence in it").props("outlined dense")

        def add() -> str:
            return case_edit.with_requirement(
                workspace.text,
                quantity=_chosen("quantity", quantity),
                when=str(when.value),
                at_least=str(least.value),
                at_most=str(most.value),
                share=str(share.value),
                confidence=str(confidence.value),
            )

        for field in (least, most, share, confidence):
            field.on("keydown.enter", lambda: _done(workspace, dialog, add))
        _buttons(workspace, dialog, add)


def _chosen(what: str, among: ui.select) -> str:
    """Return what is chosen.

    Raises:
        ValueError: nothing is.
    """
    if not among.value:
        raise InputError(f"{what}: must be one of the list, got none")
    return str(among.value)


def _buttons(workspace: Workspace, dialog: ui.dialog, add: Callable[[], str]) -> None:
    with ui.row().classes("dialog-buttons"):
        ui.button("Cancel", on_click=dialog.close).props("flat no-caps")
        ui.button("Add", on_click=lambda: _done(workspace, dialog, add)).props(
            "no-caps unelevated"
        )


def _done(workspace: Workspace, dialog: ui.dialog, add: Callable[[], str]) -> None:
    if elements.attempt(lambda: workspace.change(add())):
        dialog.close()
