"""The case in the header: its name, whether it is saved and right; open, save, undo."""

from nicegui import ui

from drakesep.page import elements
from drakesep.page.workspace import Workspace


def build(workspace: Workspace) -> None:
    """Fill the header's part of the case."""
    name = ui.label().classes("page-case")
    elements.follow(workspace, lambda: name.set_text(workspace.name))
