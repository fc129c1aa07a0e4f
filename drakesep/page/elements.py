"""What several tabs are made of."""

import contextlib
from collections.abc import Callable, Iterator, Mapping
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
    except InputError as error:
        say_wrong(str(error))
        return False
    except OSError as error:
        say_wrong(f"{error.filename}: {error.strerror}")
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


@contextlib.contextmanager
def dialog(title: str) -> Iterator[ui.dialog]:
    """Open a dialog, to be filled; once it is closed it is gone.

    Args:
        title: of the dialog.
    """
    # Not within another, from which it may be opened, and which closes.
    with (
        context.client.content,
        ui.dialog(value=True) as opened,
        ui.card().classes("dialog"),
    ):
        opened.on("hide", opened.delete)
        ui.label(title).classes("dialog-title")
        yield opened


def title(workspace: Workspace) -> None:
    """Let the browser's tab have the name of the case, and a dot if it is not saved."""

    def show() -> None:
        ui.page_title(
            f"{'' if workspace.is_saved else '• '}{workspace.name} - drakesep"
        )

    follow(workspace.changes, show)


def chosen_by_typing(
    options: list[str] | dict[str, str], label: str, **more: Any
) -> ui.select:
    """Let some of a list be chosen: what is typed finds them, Enter takes the first.

    Args:
        options: that there are.
        label: of the field.
        more: what `ui.select` takes.
    """
    field = ui.select(options, label=label, with_input=True, **more)
    field.props("outlined dense")
    # Quasar takes none by Enter before an arrow has been pressed.
    field.on("input-value", js_handler=_FIRST_FOUND % field.id)
    return field


_FIRST_FOUND = """(typed) => setTimeout(() => {
  const list = getElement(%d)?.$refs.qRef;
  list?.setOptionIndex(-1);
  if (typed) list?.moveOptionSelection(1, true);
}, 50)"""
"""When the list has been cut to what was typed."""


def placeholder(text: str) -> ui.label:
    """Say what a tab would show, where it has nothing to show."""
    return ui.label(text).classes("page-placeholder")
