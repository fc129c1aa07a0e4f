"""What several tabs are made of."""

from collections.abc import Callable, Mapping
from typing import Any

from nicegui import context, ui

from drakesep.page.workspace import Listeners, Workspace
from drakesep.systems.checks import InputError


def follow(listeners: Listeners, show: Callable[[], None]) -> None:
    """Show something now, and again each time, as long as its page is there.

    Args:
        listeners: such as a workspace's `changes`.
        show: called within the elements where it is followed.
    """
    slot, client = context.slot, context.client

    def again() -> None:
        with slot:
            show()

    client.on_delete(listeners.add(again))
    show()


def attempt(action: Callable[[], None]) -> bool:
    """Do something; say what is wrong with it where it is refused.

    Returns:
        Whether it was done.
    """
    try:
        action()
    except (InputError, OSError) as error:
        say_wrong(str(error))
        return False
    return True


def say_wrong(words: str) -> None:
    """Say what is wrong, until it is closed."""
    ui.notify(words, type="negative", timeout=0, close_button="Close", multi_line=True)


def warn(words: str) -> None:
    """Say what the page gets over by itself, for a while."""
    ui.notify(words, type="warning")


def redraw(chart: ui.echart, options: Mapping[str, Any]) -> None:
    """Let a chart show something else."""
    chart.options.clear()
    chart.options.update(options)
    chart.update()


def title(workspace: Workspace) -> None:
    """Let the browser's tab have the name of the case, and a dot if it is not saved."""

    def show() -> None:
        ui.page_title(
            f"{'' if workspace.is_saved else '• '}{workspace.name} - drakesep"
        )

    follow(workspace.changes, show)


def placeholder(text: str) -> ui.label:
    """Say what a tab would show, where it has nothing to show."""
    return ui.label(text).classes("page-placeholder")
