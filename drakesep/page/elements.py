"""What several tabs are made of."""

from collections.abc import Callable

from nicegui import context, ui

from drakesep.page.workspace import Workspace


def follow(workspace: Workspace, show: Callable[[], None]) -> None:
    """Show something now, and again after each change, as long as its page is there.

    Args:
        workspace: what is followed.
        show: called within the elements where it is followed.
    """
    slot, client = context.slot, context.client

    def again() -> None:
        with slot:
            show()

    client.on_delete(workspace.on_change(again))
    show()


def title(workspace: Workspace) -> None:
    """Let the browser's tab have the name of the case, and a dot if it is not saved."""

    def show() -> None:
        ui.page_title(
            f"{'' if workspace.is_saved else '• '}{workspace.name} – drakesep"
        )

    follow(workspace, show)


def placeholder(text: str) -> None:
    """Say what a tab would show, where it has nothing to show."""
    ui.label(text).classes("page-placeholder")
